// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Whether what the scene gives by formulas is asked only where it means something.

#pragma once

#include <dovetail/scene/note.h>
#include <dovetail/scene/scene_text.h>
#include <dovetail/system/model.h>

#include <nlohmann/json.hpp>

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace dovetail {

/// What the steps of a run ask of tables and film coefficients.
template <int dim>
class UsedRanges
{
public:
  UsedRanges(const Model<dim> &model, const SceneText &text) : model(model), text(text) {}

  /// Whether there is anything to look at.
  bool has_any() const;
  /// The state at the time @p t. Collective; @p solution is ghosted.
  void add(const Vector &solution, double t);

  /// About tables of a material or a condition that a field looked up beyond their ends by more than 1 % of
  /// their width, where they stay constant, and about coefficients of conditions that were negative
  /// somewhere.
  NoteList explain() const;

  /// What has been added so far, for a run that goes on. Collective.
  nlohmann::ordered_json save() const;
  void restore(const nlohmann::ordered_json &saved);

private:
  /// Of the values of a field in the part of a body for which an entry holds.
  struct Range
  {
    const FormulaWithTables *entry;
    unsigned int scalar; ///< of those of the formula
    double smallest, largest;
  };
  struct LeastCoefficient
  {
    double smallest = 0, t = 0;
    dealii::Point<dim> X;

    template <typename Archive>
    void serialize(Archive &archive, const unsigned int)
    {
      archive &smallest &t &X;
    }
  };

  void add_tables(const Vector &solution);
  void add_coefficients(const Vector &solution, double t);
  NoteList explain_tables() const;
  LeastCoefficient least_of_all_ranks(const Condition<dim> &condition) const;

  const Model<dim> &model;
  const SceneText &text;
  std::map<std::pair<const Domain<dim> *, std::string>, std::vector<Range>> ranges; ///< by body and field
  std::map<const Condition<dim> *, LeastCoefficient> coefficients;
};

} // namespace dovetail
