// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A toggle that looks at fields, at the points of an interface.

#pragma once

#include <dovetail/interface/side_points.h>
#include <dovetail/scene/expression.h>

#include <optional>
#include <string>
#include <vector>

namespace dovetail {

/// At which points an interface is tied in a step: where the formula of its toggle is not zero at the last
/// good state, in the means of the scalars of both sides (of one side if the other has no such field), at the
/// source and at the time of the step. So during a step nothing switches, and its equations are as smooth as
/// before.
template <int dim>
class PointToggle
{
public:
  explicit PointToggle(const Section &section); ///< of the interface, with the entry Toggle

  bool is_given() const { return formula.has_value(); }
  bool is_on(const unsigned int q) const { return on.empty() || on[q] != 0; }
  bool has_switched() const { return is_new; }
  /// At the beginning of a step to time @p t from the last good state. A step that ends at the time of the
  /// last good one is that step again, with the points that it had. Collective.
  void look(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
            const MPI_Comm &communicator);

  /// For a checkpoint: one more number at each point.
  std::vector<double> pack(unsigned int n_points, const std::vector<double> &others) const;
  /// @return the others
  std::vector<double> unpack(unsigned int n_points, const std::vector<double> &numbers);

private:
  using Component = std::optional<unsigned int>;
  std::vector<std::array<Component, 2>> components_of_names(const Interface<dim> &interface) const;
  std::vector<double> find(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
                           const MPI_Comm &communicator) const;

  const Section section;
  std::vector<std::string> names;
  std::optional<Expression> formula;
  std::vector<double> on, on_before; ///< by point: 1 or 0; in this step, and in the last good one before it
  std::optional<double> time, time_before;
  bool is_new = false; ///< on is not on_before
};

} // namespace dovetail
