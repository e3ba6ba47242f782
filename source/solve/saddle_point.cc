// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "saddle_point.h"

#include <deal.II/base/mpi.h>
#include <deal.II/lac/full_matrix.h>

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

/// Rows of one cell have the same columns, which follow each other: one product for all of them.
void AugmentedBodies::update(const BlockMatrix::Part &A_values, const Epetra_CrsMatrix &B,
                             const std::vector<double> &W)
{
  sum.copy_from(A_values);
  std::vector<dealii::types::global_dof_index> unknowns;
  std::vector<int> last_columns;
  dealii::FullMatrix<double> product;
  const auto add_cell = [&]() {
    unknowns.clear();
    for (const int column : last_columns)
      unknowns.push_back(B.GCID(column));
    if (!unknowns.empty())
      sum.add(unknowns, product);
  };
  for (int i = 0; i < B.NumMyRows(); ++i) {
    if (W[i] == 0)
      continue;
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    B.ExtractMyRowView(i, n, values, columns);
    if (!std::equal(columns, columns + n, last_columns.begin(), last_columns.end())) {
      add_cell();
      last_columns.assign(columns, columns + n);
      product.reinit(n, n);
    }
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        product(j, k) += W[i] * values[j] * values[k];
  }
  add_cell();
  sum.compress(dealii::VectorOperation::add);
}

void AugmentedBodies::vmult(GroupVector &destination, const GroupVector &source) const
{
  sum.vmult(destination, source);
}

void AugmentedBodies::diagonal(GroupVector &destination) const
{
  Epetra_Vector values(View, sum.trilinos_matrix().RowMap(), destination.trilinos_vector()[0]);
  sum.trilinos_matrix().ExtractDiagonalCopy(values);
}

SaddlePoint::SaddlePoint(const BlockMatrix &matrix, const MergedMatrix &all,
                         const std::vector<unsigned int> &bodies,
                         const std::vector<unsigned int> &multipliers,
                         std::vector<MultiplierTraits> given_traits)
    : matrix(matrix), all(all), body_operator(matrix, bodies), body_part(matrix.part_of(bodies[0])),
      multiplier_part(matrix.part_of(multipliers[0])), traits(std::move(given_traits))
{
  const bool is_any_of_cell = std::any_of(
      traits.begin(), traits.end(), [](const MultiplierTraits &multiplier) { return multiplier.is_of_cell; });
  if (dealii::Utilities::MPI::max(static_cast<int>(is_any_of_cell), matrix.get_mpi_communicator()) != 0)
    augmented = std::make_unique<AugmentedBodies>(body_operator);
}

const GroupOperator &SaddlePoint::bodies() const
{
  return augmented ? static_cast<const GroupOperator &>(*augmented) : body_operator;
}

/// d and, with W = w / d for multipliers of cells, about the Schur complement of the augmented system,
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
      const double share = traits[i].is_of_cell ? w : 0;
      scale[i] = std::sqrt(mean / d[i]);
      schur[i] = mean / (1 + share * (1 - C[i] / d[i]));
      weight[i] = share / d[i];
    }
  if (!augmented)
    return;
  augmented->update(matrix.part(body_part, body_part),
                    matrix.part(multiplier_part, body_part).trilinos_matrix(), weight);
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
