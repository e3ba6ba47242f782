// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The only place that asks for the version of deal.II (9.4 to 9.7).

#pragma once

#include <deal.II/base/config.h>
#include <deal.II/base/index_set.h>
#include <deal.II/lac/affine_constraints.h>
#if DEAL_II_VERSION_GTE(9, 7, 0)
#include <deal.II/numerics/solution_transfer.h>
#else
#include <deal.II/distributed/solution_transfer.h>
#endif

namespace dovetail {

/// Constraints that store the lines of @p stored unknowns, of which this rank owns @p owned.
inline dealii::AffineConstraints<double> make_affine_constraints(const dealii::IndexSet &owned,
                                                                 const dealii::IndexSet &stored)
{
#if DEAL_II_VERSION_GTE(9, 6, 0)
  return dealii::AffineConstraints<double>(owned, stored);
#else
  (void)owned;
  return dealii::AffineConstraints<double>(stored);
#endif
}

/// Of the Lagrange elements on triangles and tetrahedra.
constexpr unsigned int largest_degree_of_simplices = DEAL_II_VERSION_GTE(9, 6, 0) ? 3 : 2;

/// Of Lagrange hexahedra: version 2.2 of .vtu files exchanged the last two edges in the direction of z.
constexpr bool has_old_order_of_edges = !DEAL_II_VERSION_GTE(9, 5, 0);

/// From one mesh to the next, serial and parallel.
#if DEAL_II_VERSION_GTE(9, 7, 0)
template <int dim, typename VectorType>
using SolutionTransfer = dealii::SolutionTransfer<dim, VectorType>;
#else
template <int dim, typename VectorType>
using SolutionTransfer = dealii::parallel::distributed::SolutionTransfer<dim, VectorType>;
#endif

} // namespace dovetail
