// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Whether scalar fields stay between the values that are given.

#pragma once

#include <dovetail/run/given_values.h>
#include <dovetail/scene/note.h>
#include <dovetail/system/vector.h>

#include <nlohmann/json.hpp>

#include <map>
#include <string>
#include <vector>

namespace dovetail {

/// What conducts or diffuses, and has no source, is nowhere larger or smaller than what conditions prescribe
/// or hold against it; in a transient scene than all of that since the beginning, the initial state included
/// (the maximum principle). Discrete solutions may leave this range: by an error of the mesh, or where a step
/// is short for the cells and storage is not lumped (doc/theory/time.md). All functions are collective.
template <int dim>
class RangeWatch
{
public:
  /// On the present meshes. @param given kept by reference
  RangeWatch(const Model<dim> &model, const GivenValues<dim> &given) : model(model), given(given) {}

  /// A transient scene begins at the state @p x.
  void start(const Vector &x);
  /// What has been so far, for a run that goes on from there.
  nlohmann::ordered_json save() const;
  void restore(const nlohmann::ordered_json &saved);
  /// A transient step of this size has led to @p x at time @p t.
  void add(double t, double size, const Vector &x);
  /// Whether a transient step to @p x at time @p t leaves the history of a range by more than rounding.
  bool leaves(double t, const Vector &x) const;
  /// About fields that have left the history of their range by more than 1 % of its width: the worst step of
  /// each.
  NoteList explain_history() const;

  /// About a static solution that leaves its range by more than the width: a mesh that is too coarse may
  /// overshoot, but not so far.
  NoteList explain(double t, const Vector &x) const;

private:
  struct Worst
  {
    double share = 0, t = 0, size = 0, smallest = 0, largest = 0;
    ValueRange allowed{};
    unsigned int block = 0;
  };
  struct History
  {
    ValueRange range;
    bool is_open = false; ///< since something has led out of any range
    Worst worst;
  };
  template <typename Visit>
  void for_each_scalar(const Visit &visit) const;
  History at(const std::string &field, double t) const;
  std::string in_words(const Worst &worst) const;

  const Model<dim> &model;
  const GivenValues<dim> &given;
  std::map<std::string, History> histories; ///< by field
};

} // namespace dovetail
