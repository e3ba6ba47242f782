// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A group with multipliers, for iterations.

#pragma once

#include "factors.h"
#include "iterated_form.h"
#include "merged_matrix.h"

#include <Epetra_CrsMatrix.h>
#include <Epetra_Vector.h>

#include <memory>
#include <vector>

namespace dovetail {

/// Of a multiplier: it was dropped, and C may well have a diagonal; it is a pressure, not of a tie.
struct MultiplierTraits
{
  bool is_dropped, is_of_body;
};

/// A + B^T W B by products: B^T W B = R^T R has more entries than A where a pressure is continuous.
class AugmentedBodies : public GroupOperator
{
public:
  explicit AugmentedBodies(const MergedMatrix &A) : A(A) {}
  /// R = W^1/2 B. Collective.
  void update(const Epetra_CrsMatrix &B, const std::vector<double> &W);

  GroupVector vector() const override { return A.vector(); }
  void vmult(GroupVector &destination, const GroupVector &source) const override;
  void diagonal(GroupVector &destination) const override;
  const Epetra_CrsMatrix *matrix() const override { return A.matrix(); }
  const Epetra_CrsMatrix *added_rows() const override { return R.get(); }

private:
  const MergedMatrix &A;
  std::unique_ptr<Epetra_CrsMatrix> R;
};

/// [A B^T; B -C] with the multipliers scaled: the diagonal d of the Schur complement C + B diag(A)^-1 B^T
/// becomes the mean diagonal entry of A. Then all unknowns, and all residuals, have one unit. With D the
/// scale it is D K D, its unknowns D^-1 x, its right-hand side D b.
///
/// A is augmented with W = w / d: where a pressure takes all of the resistance to a change of volume, or the
/// multipliers of a tie all that holds a body, A has none, which multigrid does not like (M. Benzi, M. A.
/// Olshanskii: An augmented Lagrangian-based approach to the Oseen problem, 2006).
class SaddlePoint : public IteratedForm
{
public:
  /// @p all: with the multipliers, last; @p bodies and @p multipliers: their blocks, a part each;
  /// @p traits: of each own multiplier. Collective.
  SaddlePoint(const BlockMatrix &matrix, const MergedMatrix &all, const std::vector<unsigned int> &bodies,
              const std::vector<unsigned int> &multipliers, std::vector<MultiplierTraits> traits);
  /// The matrix has new values. Collective.
  void update();

  GroupVector right_hand_side(const GroupVector &b) const override { return scaled(b); }
  GroupVector solution(const GroupVector &x, const GroupVector &) const override { return scaled(x); }
  GroupVector sizes_of_residual(const GroupVector &sizes) const override { return scaled(sizes); }
  GroupVector vector() const override { return all.vector(); }
  void vmult(GroupVector &destination, const GroupVector &source) const override;
  void diagonal(GroupVector &destination) const override;
  const GroupOperator &bodies() const override;
  void solve_schur_complement(double *z, const double *r) const override;
  const std::vector<double> *augmentation() const override { return is_augmented() ? &weight : nullptr; }

private:
  void scale_multipliers(GroupVector &x) const; ///< x = D x
  GroupVector scaled(const GroupVector &x) const
  {
    GroupVector result(x);
    scale_multipliers(result);
    return result;
  }
  bool is_augmented() const { return augmented.added_rows() != nullptr; } ///< there is B
  void factorise_ties(const Epetra_CrsMatrix &B, const Epetra_Vector &diagonal_of_A, const Epetra_Vector &C);
  void scale_ties(const Epetra_CrsMatrix &B, const Epetra_Map &rows);
  void complete_C(const Epetra_Vector &C, const Epetra_Vector &stiffness);

  const BlockMatrix &matrix;
  const MergedMatrix &all;
  MergedMatrix body_operator;
  AugmentedBodies augmented;
  const unsigned int body_part, multiplier_part;
  const std::vector<MultiplierTraits> traits;
  std::vector<double> scale, schur, weight;         ///< of the own multipliers; the latter two scaled
  std::vector<unsigned int> of_ties;                ///< own multipliers whose S is factorised
  std::vector<double> share_of_ties, added_to_ties; ///< of these: 1 - C W, and scaled C with a shift
  std::unique_ptr<Epetra_Vector> root_of_D;         ///< D^-1/2
  std::unique_ptr<Epetra_CrsMatrix> scaled_ties;    ///< rows of B, scaled, times that and a^1/2
  std::unique_ptr<Epetra_CrsMatrix> extension;      ///< E^T
  std::unique_ptr<Factors> factors;                 ///< of S_D, scaled
};

} // namespace dovetail
