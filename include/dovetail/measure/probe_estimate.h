// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The error of probes, by the dual-weighted residual.

#pragma once

#include <dovetail/measure/error_estimate.h>
#include <dovetail/measure/probes.h>
#include <dovetail/system/block_system.h>

#include <map>
#include <string>
#include <vector>

namespace dovetail {

/// Of probes with a Tolerance, on the mesh before; none on the first mesh.
using CorrectedValues = std::map<std::string, std::vector<double>>;

/// What is known of the error of one probe.
struct ProbeError
{
  std::string name;
  double tolerance;                         ///< relative
  std::vector<double> values;               ///< of the probe, J(B_h)
  std::vector<double> errors;               ///< J(B) - J(B_h), estimated, of each number
  double change = 0;                        ///< of the corrected values since the mesh before, in size
  double relative = 0;                      ///< max(|errors|, change) / |values|; zero if all are
  std::map<std::string, double> interfaces; ///< share of each in the sum of the sizes of all contributions
  std::vector<double> corrected_values() const; ///< values + errors
  bool is_reached() const { return relative <= tolerance; }
};

/// All probes that have a Tolerance. Where they are not reached, `cells.squares` says where refinement helps:
/// sums of the contributions' sizes in units of the tolerances, in place of squares.
struct ProbeErrors
{
  std::vector<ProbeError> probes;
  ErrorEstimate cells;
  std::string failure; ///< why there is no estimate; empty if there is

  bool are_reached() const;
  CorrectedValues corrected_values() const;
  nlohmann::ordered_json errors() const;    ///< by name of the probe, in the shape of its value
  nlohmann::ordered_json estimates() const; ///< what the report tells of each
};

/// With the solution B_h = @p x of degree p and the spaces V of degree p + 1 on the same meshes, and all
/// terms and constraints as the scene has them for that degree (Becker & Rannacher 2001):
/// @f[ K(B_h)^T z = J'(B_h), \qquad J(B) - J(B_h) \approx -R(B_h)(z) + (J' - K^T z)(d), @f]
/// where d moves B_h to the constraints of V: prescribed values and ties by constraints that degree p does
/// not meet. In a linear scene with a linear probe this is J of the solution in V, less J(B_h), exactly. The
/// contributions of the nodes of V, -R_i (z - I_h z)_i and (J' - K^T z)_i d_i, are shared by the cells around
/// them (Richter & Wick 2015).
///
/// Degree p + 1 may err as much as degree p where the solution is singular, and B_h may be right by chance.
/// The corrected value shows it: its change since the mesh before, @p earlier, is an error, too.
///
/// @p system has begun the step to time @p t. @p linear_solver: the section of the scene. Collective.
template <int dim>
ProbeErrors estimate_probe_errors(const Model<dim> &model, BlockSystem<dim> &system,
                                  const Probes<dim> &probes, const Section &linear_solver, const Vector &x,
                                  double t, const CorrectedValues &earlier);

} // namespace dovetail
