// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/factored_eigenvalue.h>

#include <deal.II/base/config.h>

#include <Teuchos_BLAS.hpp>
#include <Teuchos_LAPACK.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

extern "C" void DEAL_II_FORTRAN_MANGLE(dgeqp3, DGEQP3)(const int *m, const int *n, double *A, const int *lda,
                                                       int *pivots, double *tau, double *work,
                                                       const int *lwork, int *info);

namespace dovetail {

namespace {

using Lapack = Teuchos::LAPACK<int, double>;
using Blas = Teuchos::BLAS<int, double>;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double rank_tolerance = 1e-12;  ///< of pivots
constexpr double kernel_tolerance = 1e-6; ///< of S on the kernel, relative to S

/// [B; C] P = Q R, column by column.
struct PivotedQr
{
  explicit PivotedQr(const FactoredProblem &problem);

  int m, n, rank = 0;
  std::vector<double> A; ///< R above the diagonal, Householder vectors below it
  std::vector<int> pivots;
  std::vector<double> tau, work;
};

PivotedQr::PivotedQr(const FactoredProblem &problem)
    : m((problem.B.size() + problem.C.size()) / problem.n), n(problem.n),
      A(problem.B.size() + problem.C.size()), pivots(n, 0), tau(n), work(64 * (n + 2))
{
  const std::vector<double> &B = problem.B, &C = problem.C;
  const int n_B = B.size() / n;
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < n; ++j)
      A[j * m + i] = i < n_B ? B[i * n + j] : C[(i - n_B) * n + j];
  const int n_work = work.size();
  int info = 0;
  DEAL_II_FORTRAN_MANGLE(dgeqp3, DGEQP3)
  (&m, &n, A.data(), &m, pivots.data(), tau.data(), work.data(), &n_work, &info);
  for (int &pivot : pivots)
    --pivot;
  const double least = std::max(rank_tolerance, problem.rounding) * std::abs(A[0]);
  while (info == 0 && rank < std::min(m, n) && std::abs(A[rank * m + rank]) > least)
    ++rank;
}

/// R^-T P^T of each row of length n: columns of length rank.
std::vector<double> solve(const PivotedQr &qr, const std::vector<double> &rows)
{
  const int n_rows = rows.size() / qr.n;
  std::vector<double> result(n_rows * qr.rank);
  for (int s = 0; s < n_rows; ++s)
    for (int i = 0; i < qr.rank; ++i)
      result[s * qr.rank + i] = rows[s * qr.n + qr.pivots[i]];
  int info = 0;
  if (n_rows > 0)
    Lapack().TRTRS('U', 'T', 'N', qr.rank, n_rows, qr.A.data(), qr.m, result.data(), qr.rank, &info);
  return result;
}

/// Whether S is zero on the kernel: the columns that R does not determine are what the others make of them.
bool vanishes_on_kernel(const PivotedQr &qr, const std::vector<double> &S, const std::vector<double> &Y)
{
  const int n_rows = S.size() / qr.n;
  const double norm = std::sqrt(std::inner_product(S.begin(), S.end(), S.begin(), 0.));
  for (int j = qr.rank; j < qr.n; ++j)
    for (int s = 0; s < n_rows; ++s) {
      double rest = S[s * qr.n + qr.pivots[j]];
      for (int i = 0; i < qr.rank; ++i)
        rest -= Y[s * qr.rank + i] * qr.A[j * qr.m + i];
      if (!(std::abs(rest) <= kernel_tolerance * norm))
        return false;
    }
  return true;
}

/// Of Y^T Y or Y Y^T, whichever is smaller; Y has n_rows columns of length rank.
double largest_of_square(const std::vector<double> &Y, const int rank, const int n_rows)
{
  const bool is_wide = n_rows < rank;
  const int n = std::min(n_rows, rank);
  std::vector<double> square(n * n), values(n), work(64 * (n + 2));
  Blas().SYRK(Teuchos::UPPER_TRI, is_wide ? Teuchos::TRANS : Teuchos::NO_TRANS, n, is_wide ? rank : n_rows,
              1., Y.data(), rank, 0., square.data(), n);
  int info = 0;
  Lapack().SYEV('N', 'U', n, square.data(), n, values.data(), work.data(), work.size(), &info);
  return info == 0 ? std::max(0., values.back()) : infinity;
}

/// Of Y Y^T y = lambda (I - 2 Q_C^T Q_C + trace sum z z^T) y.
double largest_of_indefinite(PivotedQr &qr, const std::vector<double> &Y, const FactoredProblem &problem)
{
  const int r = qr.rank, m = qr.m, n_C = problem.C.size() / qr.n, n_rows = problem.S.size() / qr.n;
  std::vector<double> E(r * r), square(r * r), values(r), work(64 * (r + m + 2)), lifted;
  for (const auto &z : problem.lifted)
    lifted.insert(lifted.end(), z.begin(), z.end());
  lifted = solve(qr, lifted);
  const double trace = std::inner_product(problem.B.begin(), problem.B.end(), problem.B.begin(), 0.) -
                       std::inner_product(problem.C.begin(), problem.C.end(), problem.C.begin(), 0.);
  int info = 0;
  Lapack().ORGQR(m, r, r, qr.A.data(), m, qr.tau.data(), work.data(), work.size(), &info);
  if (info != 0 || !(trace > 0))
    return infinity;
  for (int i = 0; i < r; ++i)
    E[i * r + i] = 1;
  Blas().SYRK(Teuchos::UPPER_TRI, Teuchos::TRANS, r, n_C, -2., &qr.A[m - n_C], m, 1., E.data(), r);
  Blas().SYRK(Teuchos::UPPER_TRI, Teuchos::NO_TRANS, r, problem.lifted.size(), trace, lifted.data(), r, 1.,
              E.data(), r);
  Blas().SYRK(Teuchos::UPPER_TRI, Teuchos::NO_TRANS, r, n_rows, 1., Y.data(), r, 0., square.data(), r);
  Lapack().SYGV(1, 'N', 'U', r, square.data(), r, E.data(), r, values.data(), work.data(), work.size(),
                &info);
  return info == 0 ? std::max(0., values.back()) : infinity;
}

} // namespace

double largest_eigenvalue(const FactoredProblem &problem)
{
  if (problem.B.empty())
    return std::numeric_limits<double>::quiet_NaN();
  PivotedQr qr(problem);
  if (qr.rank == 0)
    return std::numeric_limits<double>::quiet_NaN();
  if (problem.S.empty())
    return 0;
  const std::vector<double> Y = solve(qr, problem.S);
  if (!vanishes_on_kernel(qr, problem.S, Y))
    return infinity;
  return problem.C.empty() ? largest_of_square(Y, qr.rank, problem.S.size() / problem.n)
                           : largest_of_indefinite(qr, Y, problem);
}

} // namespace dovetail
