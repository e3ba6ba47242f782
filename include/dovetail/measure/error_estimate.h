// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where the meshes are too coarse.

#pragma once

#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <vector>

namespace dovetail {

/// Squares of the estimated error of the cells, relative to the square of the energy norm of each field and
/// summed over the fields.
struct ErrorEstimate
{
  std::vector<std::vector<double>> squares; ///< by domain and active cell index; zero for others' cells
  double relative = 0;                      ///< the root of their sum over all ranks

  bool is_rounding() const { return relative <= 1e-10; }
};

/// For each cell K and field (Kelly, Gago, Zienkiewicz & Babuska 1983)
/// @f[ \eta_K^2 = \kappa \frac{h}{24} \int_{\partial K\setminus\partial\Omega} |[\nabla B \cdot N]|^2
///   + \frac{h}{24\kappa} \int_{\partial K\cap\Gamma} |A\cdot N - \hat A|^2 @f]
/// with the stiffness kappa = dA/d(grad B) of the domain at rest and the tie's numerical flux A^ on an
/// interface, which holds the jump, too. A tie without terms of its own adds kappa/h |[B]|^2 (half to each
/// side, with the harmonic mean of the two kappa). Divided by the energy sum kappa |grad B|^2 of all domains.
///
/// Collective; @p ghosted holds the partners' unknowns. @pre The ties of active interfaces have begun a step.
template <int dim>
ErrorEstimate estimate_error(const Model<dim> &model, const Vector &ghosted, double t);

/// The largest threshold above which @p squares of all ranks hold this share of their sum (Doerfler 1996).
/// Where squares are equal to 1e-5, all or none of them lie above it, so that symmetric solutions stay
/// symmetric, whatever the ranks. Collective.
double marking_threshold(const std::vector<double> &squares, double share, const MPI_Comm &communicator);

/// Whether a cell with an estimated error can be divided: cells of quadrilaterals or hexahedra can, down to
/// the finest level of p4est. Collective.
template <int dim>
bool can_refine(const Model<dim> &model, const ErrorEstimate &estimate);

/// The cells above that threshold, of all domains that can be refined. Collective.
template <int dim>
std::vector<std::vector<bool>> mark_cells(const Model<dim> &model, const ErrorEstimate &estimate,
                                          double share);

} // namespace dovetail
