// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How large the forces are that cancel in a residual, and what rounding leaves of them.

#pragma once

#include <dovetail/domain/numbering.h>

#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/full_matrix.h>

#include <functional>
#include <vector>

namespace dovetail {

/// Sums of squares over cells and ties, by block of unknowns (doc/theory/convergence.md). A force on an
/// unknown that follows others acts on them; on one that is prescribed it is a reaction, in which nothing
/// needs to cancel.
class ForceSizes
{
public:
  using Dofs = std::vector<dealii::types::global_dof_index>;
  using Constraints = dealii::AffineConstraints<double>;

  /// @param numbering by reference
  explicit ForceSizes(const Numbering &numbering);

  /// Of another assembly. What is known of tangents stays until a tangent is assembled.
  void begin();
  /// Of one cell or group of points: its @p forces, each a sum of so many terms, and the local tangent, if
  /// one has been assembled, at these @p unknowns.
  void add(const Dofs &dofs, const std::vector<double> &forces, const std::vector<double> &unknowns,
           unsigned int longest_sum, const Constraints &constraints,
           const dealii::FullMatrix<double> *local_tangent);
  /// Likewise of a tangent without entries: sum_j |K_ij x_j| of each unknown.
  void add_products(const Dofs &dofs, const std::vector<double> &products, unsigned int longest_sum,
                    const Constraints &constraints);
  /// Sums over all ranks. @param has_tangent by block, whether one has been assembled. Collective.
  void finish(const std::function<bool(unsigned int)> &has_tangent, const MPI_Comm &communicator);
  /// In place of an assembly: squares of the forces, summed over this rank. Collective.
  void set_forces(std::vector<double> squares, unsigned int longest_sum, const MPI_Comm &communicator);
  /// In place of an assembled tangent: sum_j |K_ij x_j| as norms of blocks.
  void set_tangent(const std::vector<double> &products, unsigned int longest_sum);

  /// As Euclidean norms, by block. Nothing is at work in the equations of a constraint of a body, as one on
  /// its volume, but the terms that cancel.
  std::vector<double> forces() const;
  /// Bound of the standard deviation of what rounding leaves. The errors of n terms, each of relative size u,
  /// add up like a random walk: u n^(1/2) times the sum of the sizes (Higham and Mary 2019); likewise those
  /// of different cells.
  std::vector<double> rounding() const;

private:
  const Numbering *numbering;
  /// Of the forces; of those on free unknowns, and of sum_j |K_ij x_j| there, times the number of terms; of
  /// the latter as it is.
  std::vector<double> of_forces, on_free, of_tangents, of_products;
  std::vector<double> tangent_at_x, products_at_x; ///< of the last tangent
};

} // namespace dovetail
