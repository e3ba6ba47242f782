// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "saddle_point.h"

#include "level_operator.h"

#include <deal.II/base/mpi.h>

#include <Epetra_Comm.h>
#include <Epetra_Import.h>
#include <Epetra_Vector.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

/// diag(B diag(A)^-1 B^T)
void add_schur_complement(const Epetra_CrsMatrix &B, const Epetra_Vector &diagonal_of_A,
                          Epetra_Vector &schur_diagonal)
{
  Epetra_Vector diagonal(B.ColMap());
  if (B.Importer() != nullptr)
    diagonal.Import(diagonal_of_A, *B.Importer(), Insert);
  else
    diagonal = diagonal_of_A;
  for (int i = 0; i < B.NumMyRows(); ++i) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    B.ExtractMyRowView(i, n, values, columns);
    for (int k = 0; k < n; ++k)
      if (diagonal[columns[k]] > 0)
        schur_diagonal[i] += values[k] * values[k] / diagonal[columns[k]];
  }
}

} // namespace

void AugmentedBodies::update(const Epetra_CrsMatrix &B, const std::vector<double> &W)
{
  if (R)
    *R = B; // levels that are kept refer to it
  else
    R = std::make_unique<Epetra_CrsMatrix>(B);
  Epetra_Vector root(B.RowMap());
  for (int i = 0; i < root.MyLength(); ++i)
    root[i] = std::sqrt(W[i]);
  R->LeftScale(root);
}

void AugmentedBodies::vmult(GroupVector &destination, const GroupVector &source) const
{
  A.vmult(destination, source);
  Epetra_Vector y(View, destination.trilinos_vector(), 0);
  add_product(*R, Epetra_Vector(View, source.trilinos_vector(), 0), y);
}

void AugmentedBodies::diagonal(GroupVector &destination) const
{
  A.diagonal(destination);
  Epetra_Vector values(View, destination.trilinos_vector(), 0);
  add_diagonal(*R, values);
}

SaddlePoint::SaddlePoint(const BlockMatrix &matrix, const MergedMatrix &all,
                         const std::vector<unsigned int> &bodies,
                         const std::vector<unsigned int> &multipliers,
                         std::vector<MultiplierTraits> given_traits)
    : matrix(matrix), all(all), body_operator(matrix, bodies), body_part(matrix.part_of(bodies[0])),
      multiplier_part(matrix.part_of(multipliers[0])), traits(std::move(given_traits))
{
  const bool is_any_of_body = std::any_of(
      traits.begin(), traits.end(), [](const MultiplierTraits &multiplier) { return multiplier.is_of_body; });
  if (dealii::Utilities::MPI::max(static_cast<int>(is_any_of_body), matrix.get_mpi_communicator()) != 0)
    augmented = std::make_unique<AugmentedBodies>(body_operator);
}

const GroupOperator &SaddlePoint::bodies() const
{
  return augmented ? static_cast<const GroupOperator &>(*augmented) : body_operator;
}

/// d and, with W = w / d for pressures, about the Schur complement of the augmented system,
/// @f[ S'^{-1} = S^{-1} + W - S^{-1} C W \approx (1 + w (1 - C / d)) / d. @f]
void SaddlePoint::update()
{
  const double w = 2; // measured: 0.5 to 4 differ little, 0 doubles the iterations
  const Epetra_CrsMatrix &A = matrix.part(body_part, body_part).trilinos_matrix(),
                         &minus_C = matrix.part(multiplier_part, multiplier_part).trilinos_matrix();
  Epetra_Vector diagonal(A.RowMap()), C(minus_C.RowMap());
  A.ExtractDiagonalCopy(diagonal);
  double sum_of_A = 0;
  diagonal.Norm1(&sum_of_A);
  const double mean = sum_of_A / A.NumGlobalRows();

  minus_C.ExtractDiagonalCopy(C);
  C.Scale(-1.);
  Epetra_Vector d(C);
  if (matrix.has_part(multiplier_part, body_part))
    add_schur_complement(matrix.part(multiplier_part, body_part).trilinos_matrix(), diagonal, d);
  scale.assign(traits.size(), 1.);
  schur.assign(traits.size(), -1.);
  weight.assign(traits.size(), 0.);
  for (unsigned int i = 0; i < traits.size(); ++i)
    if (!traits[i].is_dropped && d[i] > 0) {
      const double share = traits[i].is_of_body ? w : 0;
      scale[i] = std::sqrt(mean / d[i]);
      schur[i] = mean / (1 + share * (1 - C[i] / d[i]));
      weight[i] = share / d[i];
    }
  if (!augmented)
    return;
  augmented->update(matrix.part(multiplier_part, body_part).trilinos_matrix(), weight);
  for (unsigned int i = 0; i < traits.size(); ++i)
    weight[i] /= scale[i] * scale[i];
}

void SaddlePoint::scale_multipliers(GroupVector &x) const
{
  double *values = x.trilinos_vector()[0] + body_operator.numbering().n_local();
  for (unsigned int i = 0; i < scale.size(); ++i)
    values[i] *= scale[i];
}

void SaddlePoint::vmult(GroupVector &destination, const GroupVector &source) const
{
  GroupVector scaled(source);
  scale_multipliers(scaled);
  all.vmult(destination, scaled);
  scale_multipliers(destination);
}

void SaddlePoint::diagonal(GroupVector &destination) const
{
  all.diagonal(destination);
  scale_multipliers(destination);
  scale_multipliers(destination);
}

} // namespace dovetail
