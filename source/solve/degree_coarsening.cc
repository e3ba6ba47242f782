// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "degree_coarsening.h"

#include <deal.II/base/index_set.h>
#include <deal.II/lac/solver_cg.h>
#include <deal.II/lac/solver_control.h>

#include <EpetraExt_MatrixMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_IntVector.h>
#include <Epetra_Map.h>
#include <Epetra_MpiComm.h>
#include <Teuchos_ParameterList.hpp>
#include <ml_epetra_utils.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

using SingleVector = dealii::TrilinosWrappers::MPI::Vector;

/// What a row is: the number of an unknown of the coarse matrix, or
enum Kind { is_fixed = -1, is_sum = -2 };

/// The kinds of the rows that the columns of @p matrix, which is filled, refer to.
Epetra_IntVector column_values(const Epetra_CrsMatrix &matrix, const Epetra_IntVector &row_values)
{
  Epetra_IntVector result(matrix.ColMap());
  const Epetra_Import import(matrix.ColMap(), row_values.Map());
  result.Import(row_values, import, Insert);
  return result;
}

bool on_any_rank(const Epetra_Comm &communicator, const bool here)
{
  int mine = here, anyone = 0;
  communicator.MaxAll(&mine, &anyone, 1);
  return anyone != 0;
}

} // namespace

DegreeCoarsening::DegreeCoarsening(const Epetra_CrsMatrix &matrix, const Sums &sums,
                                   const Epetra_MultiVector &modes, Teuchos::ParameterList parameters)
    : matrix(matrix), inverse_diagonal(matrix.RowMap()), residual(matrix.RowMap()),
      direction(matrix.RowMap()), correction(matrix.RowMap())
{
  make_prolongation(sums);
  Epetra_CrsMatrix *product = nullptr;
  ML_Epetra::Epetra_PtAP(matrix, *prolongation, product);
  coarse_matrix.reset(product);

  const Epetra_Map &coarse_rows = coarse_matrix->OperatorDomainMap();
  coarse_modes = std::make_unique<Epetra_MultiVector>(coarse_rows, modes.NumVectors());
  unsigned int next = 0;
  for (unsigned int row = 0; row < sums.size(); ++row)
    if (sums[row].size() == 1 && sums[row][0].first == matrix.GRID(row)) {
      for (int mode = 0; mode < modes.NumVectors(); ++mode)
        (*coarse_modes)[mode][next] = modes[mode][row];
      ++next;
    }
  parameters.set("null space: vectors", coarse_modes->Values());
  coarse_multigrid.initialize(*coarse_matrix, parameters);

  matrix.ExtractDiagonalCopy(inverse_diagonal);
  inverse_diagonal.Reciprocal(inverse_diagonal);
  estimate_spectrum();
}

/// The sums of @p sums, sums of sums, … until only unknowns of the coarse matrix are left.
std::unique_ptr<Epetra_CrsMatrix> DegreeCoarsening::follow(const Sums &sums)
{
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, matrix.RowMap(), 0);
  Epetra_IntVector kind(matrix.RowMap());
  std::vector<int> columns;
  std::vector<double> weights;
  for (unsigned int row = 0; row < sums.size(); ++row) {
    columns.clear();
    weights.clear();
    for (const auto &[column, weight] : sums[row]) {
      columns.push_back(column);
      weights.push_back(weight);
    }
    const int own = matrix.GRID(row);
    kind[row] = columns.empty() ? is_fixed : columns.size() == 1 && columns[0] == own ? 0 : is_sum;
    result->InsertGlobalValues(own, columns.size(), weights.data(), columns.data());
  }
  result->FillComplete(matrix.RowMap(), matrix.RowMap());

  const unsigned int longest_chain = 4; // squared so often: 16 steps
  for (unsigned int i = 0; i < longest_chain; ++i) {
    const Epetra_IntVector column_kind = column_values(*result, kind);
    bool has_sums = false;
    for (int column = 0; column < column_kind.MyLength(); ++column)
      has_sums = has_sums || column_kind[column] == is_sum;
    if (!on_any_rank(matrix.Comm(), has_sums))
      break;
    auto square = std::make_unique<Epetra_CrsMatrix>(Copy, matrix.RowMap(), 0);
    EpetraExt::MatrixMatrix::Multiply(*result, false, *result, false, *square);
    result = std::move(square);
  }
  return result;
}

void DegreeCoarsening::make_prolongation(const Sums &sums)
{
  const auto all = follow(sums);
  Epetra_IntVector number(matrix.RowMap());
  int n_own = 0, n_before = 0;
  for (unsigned int row = 0; row < sums.size(); ++row)
    if (sums[row].size() == 1 && sums[row][0].first == matrix.GRID(row))
      ++n_own;
  matrix.Comm().ScanSum(&n_own, &n_before, 1);
  n_before -= n_own;
  for (unsigned int row = 0; row < sums.size(); ++row)
    number[row] = sums[row].size() == 1 && sums[row][0].first == matrix.GRID(row) ? n_before++ : is_fixed;

  // a condensed unknown is alone in its row of the matrix, and found afterwards from those it follows
  const Epetra_IntVector column_kind = column_values(*all, number);
  const Epetra_Map coarse(-1, n_own, 0, matrix.Comm());
  prolongation = std::make_unique<Epetra_CrsMatrix>(Copy, matrix.RowMap(), all->MaxNumEntries());
  std::vector<int> columns;
  std::vector<double> weights;
  for (unsigned int row = 0; row < sums.size(); ++row) {
    int n = 0, *local = nullptr;
    double *values = nullptr;
    all->ExtractMyRowView(row, n, values, local);
    columns.clear();
    weights.clear();
    for (int k = 0; k < n; ++k)
      if (column_kind[local[k]] != is_fixed && values[k] != 0 && matrix.NumMyEntries(row) > 1) {
        columns.push_back(column_kind[local[k]]);
        weights.push_back(values[k]);
      }
    prolongation->InsertGlobalValues(matrix.GRID(row), columns.size(), weights.data(), columns.data());
  }
  prolongation->FillComplete(coarse, matrix.RowMap());
}

/// By a few conjugate gradients from a vector that is rough and the same on any number of ranks.
void DegreeCoarsening::estimate_spectrum()
{
  const unsigned int n_iterations = 10;
  struct MatrixAndDiagonal
  {
    const Epetra_CrsMatrix &A;
    const Epetra_Vector &inverse;
  };
  struct Product : MatrixAndDiagonal
  {
    void vmult(SingleVector &y, const SingleVector &x) const
    {
      A.Multiply(false, x.trilinos_vector(), y.trilinos_vector());
    }
  };
  struct Scaling : MatrixAndDiagonal
  {
    void vmult(SingleVector &y, const SingleVector &x) const
    {
      y.trilinos_vector().Multiply(1., inverse, x.trilinos_vector(), 0.);
    }
  };
  const MatrixAndDiagonal both = {matrix, inverse_diagonal};
  const auto &communicator = dynamic_cast<const Epetra_MpiComm &>(matrix.Comm());
  dealii::IndexSet owned(matrix.NumGlobalRows());
  if (matrix.NumMyRows() > 0)
    owned.add_range(matrix.GRID(0), matrix.GRID(0) + matrix.NumMyRows());
  SingleVector x(owned, communicator.Comm()), b(owned, communicator.Comm());
  for (int row = 0; row < matrix.NumMyRows(); ++row)
    b.trilinos_vector()[0][row] = std::sin(1e4 * (1 + matrix.GRID(row) % 1009)) / inverse_diagonal[row];
  dealii::IterationNumberControl control(n_iterations, 1e-30 * b.l2_norm());
  dealii::SolverCG<SingleVector> solver(control);
  solver.connect_eigenvalues_slot([this](const std::vector<double> &eigenvalues) {
    if (!eigenvalues.empty())
      largest_eigenvalue = eigenvalues.back();
  });
  solver.solve(Product{both}, x, b, Scaling{both});
  AssertThrow(largest_eigenvalue > 0, dealii::ExcMessage("The matrix is not positive definite."));
  largest_eigenvalue *= 1.1; // approached from below
}

/// Chebyshev iteration for diag(A)^-1 A on the upper part of its spectrum.
void DegreeCoarsening::smooth(Epetra_Vector &x, const Epetra_Vector &b, const bool starts_from_zero) const
{
  const unsigned int degree = 3;
  const double ratio = 15; // of the largest to the smallest eigenvalue that is smoothed
  const double middle = largest_eigenvalue * (1 + 1 / ratio) / 2,
               half = largest_eigenvalue * (1 - 1 / ratio) / 2;
  double rho = half / middle;
  for (unsigned int k = 0; k < degree; ++k) {
    const bool is_zero = k == 0 && starts_from_zero;
    if (is_zero)
      x.PutScalar(0.);
    else
      matrix.Multiply(false, x, residual);
    const double next = 1 / (2 * middle / half - rho);
    const double residual_factor = k == 0 ? 1 / middle : 2 * next / half,
                 direction_factor = k == 0 ? 0 : next * rho;
    if (k > 0)
      rho = next;
    const int n = x.MyLength();
    double *const x_i = x.Values(), *const d_i = direction.Values();
    const double *const r_i = residual.Values(), *const b_i = b.Values(),
                        *const D_i = inverse_diagonal.Values();
    for (int i = 0; i < n; ++i) {
      d_i[i] = (direction_factor == 0 ? 0 : direction_factor * d_i[i]) +
               residual_factor * D_i[i] * (is_zero ? b_i[i] : b_i[i] - r_i[i]);
      x_i[i] += d_i[i];
    }
  }
}

void DegreeCoarsening::vmult(dealii::TrilinosWrappers::MPI::Vector &destination,
                             const dealii::TrilinosWrappers::MPI::Vector &source) const
{
  const Epetra_Vector b(View, source.trilinos_vector(), 0);
  Epetra_Vector x(View, destination.trilinos_vector(), 0);
  smooth(x, b, true);

  matrix.Multiply(false, x, residual);
  residual.Update(1., b, -1.);
  Epetra_Vector coarse_b(prolongation->DomainMap()), coarse_x(prolongation->DomainMap());
  prolongation->Multiply(true, residual, coarse_b);
  coarse_multigrid.trilinos_operator().ApplyInverse(coarse_b, coarse_x);
  prolongation->Multiply(false, coarse_x, correction);
  x.Update(1., correction, 1.);

  smooth(x, b, false);
}

} // namespace dovetail
