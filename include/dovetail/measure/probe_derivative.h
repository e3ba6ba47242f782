// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How a probe changes with the solution: the load of its dual problem.

#pragma once

#include <dovetail/measure/probes.h>
#include <dovetail/system/enrichment.h>

#include <vector>

namespace dovetail {

/// Whether its value is the resultant of a flux on a boundary.
template <int dim>
bool is_resultant(const typename Probes<dim>::Probe &probe)
{
  return !probe.X && !probe.reduce;
}

/// By number of a probe.
struct ProbeDerivative
{
  std::vector<Vector> loads; ///< J'
  std::vector<double> lacks; ///< J(B) in the enriched model, less the value that has been reported
};

/// J'(B) has an entry at each unknown of the enriched model, before constraints: J'(B) v is the sum of the
/// products with those of v.
///
/// A value at a point or a reduction has J' = sum_q w_q (q_B phi_i + q_grad . grad phi_i), where the
/// derivatives of the quantity q by value and gradient are central differences. The resultant of a flux is
/// J(B) = R(B)(w) + integrals of A.N g with the functions of Reactions::lift(), plus the influxes h(B) that
/// conditions give, so that J' = K^T w + integrals of A'.N g and h'.
///
/// The ties of both models differ by their penalties or types, sources by their points, and w, which is 1 at
/// nodes of the boundary and zero at others, by its support. So J(B) is not what has been reported.
///
/// @p coarse, @p fine: the reactions of the solution in both models; for resultants only. Collective.
/// @return nothing, on all ranks alike, if a law is not defined somewhere.
template <int dim>
std::optional<ProbeDerivative> probe_derivative(const typename Probes<dim>::Probe &probe,
                                                const Enrichment<dim> &enriched, const Reactions<dim> &coarse,
                                                const Reactions<dim> *fine);

} // namespace dovetail
