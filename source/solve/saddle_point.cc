// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "saddle_point.h"

#include <Epetra_Comm.h>
#include <Epetra_Import.h>
#include <Epetra_Vector.h>

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

SaddlePoint::SaddlePoint(const BlockMatrix &matrix, const MergedMatrix &all,
                         const std::vector<unsigned int> &bodies,
                         const std::vector<unsigned int> &multipliers, std::vector<bool> dropped)
    : matrix(matrix), all(all), body_operator(matrix, bodies), body_part(matrix.part_of(bodies[0])),
      multiplier_part(matrix.part_of(multipliers[0])), dropped(std::move(dropped))
{
}

void SaddlePoint::update()
{
  const Epetra_CrsMatrix &A = matrix.part(body_part, body_part).trilinos_matrix(),
                         &minus_C = matrix.part(multiplier_part, multiplier_part).trilinos_matrix();
  Epetra_Vector diagonal(A.RowMap()), schur_diagonal(minus_C.RowMap());
  A.ExtractDiagonalCopy(diagonal);
  double sum_of_A = 0;
  diagonal.Norm1(&sum_of_A);
  const double mean = sum_of_A / A.NumGlobalRows();

  minus_C.ExtractDiagonalCopy(schur_diagonal);
  schur_diagonal.Scale(-1.);
  if (matrix.has_part(multiplier_part, body_part))
    add_schur_complement(matrix.part(multiplier_part, body_part).trilinos_matrix(), diagonal, schur_diagonal);
  scale.assign(dropped.size(), 1.);
  schur.assign(dropped.size(), -1.);
  for (unsigned int i = 0; i < dropped.size(); ++i)
    if (!dropped[i] && schur_diagonal[i] > 0) {
      scale[i] = std::sqrt(mean / schur_diagonal[i]);
      schur[i] = mean;
    }
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
