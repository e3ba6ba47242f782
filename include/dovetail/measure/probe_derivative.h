// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How a probe changes with the solution: the load of its dual problem.

#pragma once

#include <dovetail/measure/probes.h>
#include <dovetail/system/enrichment.h>

#include <vector>

namespace dovetail {

/// J'(B), one vector per number of the probe, with an entry at each unknown of the enriched model, before
/// constraints: J'(B) v is the sum of the products with those of v.
///
/// A value at a point or a reduction has J' = sum_q w_q (q_B phi_i + q_grad . grad phi_i), where the
/// derivatives of the quantity q by value and gradient are central differences. The resultant of a flux is
/// J(B) = R(B)(w) + integrals of A.N g with the functions of Reactions::lift(), plus the influxes h(B) that
/// conditions give, so that J' = K^T w + integrals of A'.N g and h'.
///
/// @p reactions: those of the solution of the coarse model. Collective. @return nothing, on all ranks alike,
/// if a law is not defined somewhere.
template <int dim>
std::optional<std::vector<Vector>> probe_derivative(const typename Probes<dim>::Probe &probe,
                                                    const Enrichment<dim> &enriched,
                                                    const Reactions<dim> &reactions);

} // namespace dovetail
