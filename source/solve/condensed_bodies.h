// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A group with the multipliers of ties, without these: the destination follows the source.

#pragma once

#include "factors.h"
#include "iterated_form.h"
#include "merged_matrix.h"

#include <dovetail/solve/row_sums.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Vector.h>

#include <functional>
#include <memory>
#include <vector>

namespace dovetail {

/// Of [A B^T; B 0] x = b with one unknown of a destination for each multiplier, so that B = [M D] with the
/// square matrix D of these unknowns: they follow the others, u_d = D^-1 (g - M u), and
/// @f[ Z^T A Z u = Z^T (f - A u_g),  Z = \begin{pmatrix} 1 \\ -D^{-1} M \end{pmatrix},
///     D^T \lambda = (f - A u)_d. @f]
/// D is the mass matrix of a surface, and is factorised. Products are exact. What levels are made of are
/// entries() and cells(), Z'^T A Z' with weights Z' of a few cells around each unknown: D^-1 decays from cell
/// to cell. Sums over cells further away are made up for: Z' moves as Z does where the source moves as a
/// rigid body. Otherwise a stiff destination would resist what costs nothing.
///
/// Unknowns that follow are alone in their rows, as those of constraints are.
class CondensedBodies : public IteratedForm
{
public:
  using Modes = std::vector<std::vector<double>>; ///< [mode][own row]
  /// The unknown that belongs to a multiplier.
  struct Follower
  {
    int row;          ///< own one of the bodies; -1: the multiplier was dropped
    unsigned int tie; ///< from 0
  };

  /// @p bodies and @p multipliers: their blocks, a part each; @p degree: of the bodies; @p followers: of each
  /// own multiplier. @p modes: what bodies hardly resist, asked for with the weights. Collective.
  CondensedBodies(const BlockMatrix &matrix, const std::vector<unsigned int> &bodies,
                  const std::vector<unsigned int> &multipliers, unsigned int degree,
                  const std::vector<Follower> &followers, std::function<Modes()> modes);
  /// The matrix has new values. @p stiffness: of each own row of the bodies. @return whether it suits an
  /// iteration: D has an inverse, and where unknowns of a tie follow much softer ones, they are not fewer.
  /// Else functions of the soft side that Z does not see, and Z' does, would be stiff. Collective.
  bool update(const std::vector<double> &stiffness);

  /// Of the rows of the bodies: those that follow become sums. Collective.
  RowSums with_followers(const RowSums &sums) const;

  GroupVector right_hand_side(const GroupVector &b) const override;
  GroupVector solution(const GroupVector &x, const GroupVector &b) const override;
  GroupVector sizes_of_residual(const GroupVector &sizes) const override { return of_bodies(sizes); }
  GroupVector vector() const override { return body_operator.vector(); }
  void vmult(GroupVector &destination, const GroupVector &source) const override;
  void diagonal(GroupVector &destination) const override;
  /// Of the present values. Before, what was made of the last ones stays: levels that are kept refer to it.
  /// Collective.
  const Epetra_CrsMatrix *matrix() const override { return has_cells() ? nullptr : entries(); }
  const PartOperator *cells() const override;
  const Epetra_CrsMatrix *entries() const override;

private:
  const Epetra_CrsMatrix &A() const { return block_matrix.part(body_part, body_part).trilinos_matrix(); }
  bool has_cells() const { return body_operator.has_products(); } ///< and A() is what has entries
  void make_condensed() const;
  bool has_new_ties(const Epetra_CrsMatrix &B);
  bool split(const Epetra_CrsMatrix &B);
  bool are_enough(const std::vector<double> &stiffness);
  double small_weight(const Epetra_Vector &diagonal_of_A) const;
  void find_columns_that_follow();
  std::unique_ptr<Epetra_CrsMatrix> about_inverse_of_D() const;
  void make_weights() const;
  void add_what_is_missing(Epetra_CrsMatrix &W) const;
  std::unique_ptr<Epetra_CrsMatrix> sum_of_followers() const;
  std::unique_ptr<Epetra_CrsMatrix> sum_with(const Epetra_CrsMatrix &others) const;
  GroupVector of_bodies(const GroupVector &b) const;
  Epetra_Vector of_followers(const GroupVector &x) const;
  Epetra_Vector of_acting(const GroupVector &b) const;
  void let_follow(GroupVector &u, const Epetra_Vector *g) const;
  void gather_forces(GroupVector &r) const;
  void balance_leaders(Epetra_Vector &lambda, const GroupVector &rest) const;

  const BlockMatrix &block_matrix;
  MergedMatrix body_operator;
  const unsigned int body_part, multiplier_part, degree;
  const std::function<Modes()> modes;
  std::vector<int> acting, followers; ///< own multipliers, and the own row of each of these that follows
  std::vector<unsigned int> tie_of_follower;
  unsigned int n_ties = 0;          ///< on all ranks
  std::vector<int> place_of_row;    ///< by own row of the bodies, the place among these; -1: it leads
  std::vector<bool> column_follows; ///< by column of A
  std::vector<double> entries_of_B; ///< that D and M are made of
  std::unique_ptr<Epetra_CrsMatrix> D, M;
  std::unique_ptr<Factors> factors; ///< of D
  double diagonal_of_followers = 1;
  std::vector<int> soft_leaders;                     ///< own rows that much stiffer ones follow
  double small = 0;                                  ///< weights, beside the largest one of a row
  mutable std::unique_ptr<Epetra_CrsMatrix> weights; ///< rows of Z' that follow
  mutable std::unique_ptr<Epetra_CrsMatrix> condensed;
  mutable std::shared_ptr<PartOperator> condensed_cells;
  mutable bool is_outdated = true; ///< condensed
};

} // namespace dovetail
