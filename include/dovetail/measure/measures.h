// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a solution is like: the numbers of the report about domains and interfaces.

#pragma once

#include <dovetail/measure/reactions.h>
#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <nlohmann/json.hpp>

namespace dovetail {

/// For each domain its size, the largest and smallest value of each field at the nodes (vectors: of the
/// magnitude) and, for the fields of its `Exact`, error and norm of the exact solution in L2 and of the
/// gradient ("H1"). Collective; @p solution is ghosted.
template <int dim>
nlohmann::ordered_json measure_domains(const Model<dim> &model, const Vector &solution, double t);

/// For each interface its coverage and, for each tied field, L2 norms over its points of the jump [B], of
/// A_src.N_src + A_dst.N_dst ("flux jump") and of the tie's numerical flux minus the exact one ("flux error",
/// with `Exact` of the source's domain or else of the destination's), what the tie gives to both sides, and
/// what the tie says of its penalty. Collective; @p solution is ghosted and holds the partners' unknowns.
///
/// @pre The model is paired, and the ties of active interfaces have begun a step.
template <int dim>
nlohmann::ordered_json measure_interfaces(const Model<dim> &model, const Vector &solution,
                                          const Reactions<dim> &reactions);

} // namespace dovetail
