// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "saddle_point.h"

#include <Epetra_Comm.h>
#include <Epetra_Import.h>
#include <Epetra_Vector.h>

#include <array>
#include <cmath>

namespace dovetail {

SaddlePoint::SaddlePoint(const BlockMatrix &matrix, const MergedMatrix &all,
                         const std::vector<unsigned int> &blocks, std::vector<bool> dropped)
    : all(all), body_operator(matrix, blocks), dropped(std::move(dropped))
{
}

void SaddlePoint::update(const BlockMatrix &block_matrix)
{
  body_operator.copy_values(block_matrix);
  const Epetra_CrsMatrix &matrix = *all.matrix();
  Epetra_Vector diagonal(matrix.RowMap()), column_diagonal(matrix.ColMap());
  matrix.ExtractDiagonalCopy(diagonal);
  const unsigned int n_of_bodies = body_operator.n_local(), n_own = all.n_local();
  std::array<double, 2> own = {{0, static_cast<double>(n_of_bodies)}}, sums;
  for (unsigned int i = 0; i < n_of_bodies; ++i)
    own[0] += std::abs(diagonal[i]);
  matrix.Comm().SumAll(own.data(), sums.data(), 2);
  const double mean = sums[0] / sums[1];

  std::vector<double> sums_of_rows;
  for (unsigned int i = n_of_bodies; i < n_own; ++i) {
    sums_of_rows.push_back(-diagonal[i]);
    diagonal[i] = 0; // the rest sums over the bodies alone
  }
  if (matrix.Importer() != nullptr)
    column_diagonal.Import(diagonal, *matrix.Importer(), Insert);
  else
    column_diagonal = diagonal;
  scale.assign(n_own - n_of_bodies, 1.);
  schur.assign(n_own - n_of_bodies, -1.);
  for (unsigned int i = 0; i < scale.size(); ++i) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    matrix.ExtractMyRowView(n_of_bodies + i, n, values, columns);
    double sum = sums_of_rows[i];
    for (int k = 0; k < n; ++k)
      if (column_diagonal[columns[k]] > 0)
        sum += values[k] * values[k] / column_diagonal[columns[k]];
    if (!dropped[i] && sum > 0) {
      scale[i] = std::sqrt(mean / sum);
      schur[i] = mean;
    }
  }
}

void SaddlePoint::scale_multipliers(GroupVector &x) const
{
  double *values = x.trilinos_vector()[0] + body_operator.n_local();
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
