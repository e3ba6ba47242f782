// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What flows into the bodies and out of them.

#pragma once

#include <dovetail/measure/reactions.h>
#include <dovetail/scene/note.h>

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace dovetail {

struct Balance
{
  nlohmann::ordered_json report;
  double worst = 0;    ///< imbalance of all fields, relative to what flows or is stored; 0 if it is rounding
  double rounding = 0; ///< likewise, what it can hide where more is missing than allowed
};

/// For each domain and field "stored", "in", "out" and "imbalance" = in - out - stored, by component: the
/// sums of what is put into the body and of what is taken out, by prescribed unknowns, by cells with sources
/// or given influxes, and by the pairs of faces, followers and multipliers of the interfaces; and what the
/// cells store more of than before, in transient scenes, all of them per time. "rounding" is what rounding
/// alone makes of them; only where the imbalance is more than largest_imbalance, or @p expected, times the
/// others, since it costs as much as an assembly. Collective.
/// @param expected what Newton's method leaves, relative
/// @param allowed more than that has a sentence if rounding does not explain it
/// @param notes gets a sentence for each field whose balance does not hold; nullptr: no sentences are asked
/// for
template <int dim>
Balance measure_balance(const Model<dim> &model, const Reactions<dim> &reactions, const Vector &solution,
                        double expected, double allowed, NoteList *notes);

/// Of the largest one of in, out and what some cells gain or others lose, over the components.
inline constexpr double largest_imbalance = 1e-10;

} // namespace dovetail
