// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "chebyshev_smoother.h"

#include "incomplete_factorisation.h"

#include <dovetail/solve/group_solver.h>

#include <deal.II/base/index_set.h>
#include <deal.II/lac/solver_cg.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/trilinos_vector.h>
#include <deal.II/lac/vector_memory.h>

#include <Epetra_Map.h>
#include <Epetra_MpiComm.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

using SingleVector = dealii::TrilinosWrappers::MPI::Vector;

MPI_Comm communicator_of(const LevelProducts &A)
{
  return dynamic_cast<const Epetra_MpiComm &>(A.rows().Comm()).Comm();
}

/// As deal.II's CG sees A and M.
struct Product
{
  const LevelProducts &A;
  void vmult(SingleVector &y, const SingleVector &x) const
  {
    Epetra_Vector product(View, y.trilinos_vector(), 0);
    A.vmult(product, Epetra_Vector(View, x.trilinos_vector(), 0));
  }
};

struct Inverse
{
  const Approximation &M;
  void vmult(SingleVector &z, const SingleVector &r) const
  {
    M.vmult(z.trilinos_vector()[0], r.trilinos_vector()[0]);
  }
};

/// The largest eigenvalue of M^-1 A, from below, or 0 if it is not definite. By a few conjugate gradients
/// from a vector that is rough and the same on any number of ranks.
/// @param power of the diagonal that the vector has; 1/2: bodies count alike, however stiff they are
double estimate_largest_eigenvalue(const LevelProducts &A, const Approximation &M, const double power = 1)
{
  const unsigned int n_iterations = 10;
  const int n_own = A.rows().NumMyElements();
  dealii::IndexSet owned(A.rows().NumGlobalElements());
  if (n_own > 0)
    owned.add_range(A.rows().GID(0), A.rows().GID(0) + n_own);
  SingleVector x(owned, communicator_of(A)), b(owned, communicator_of(A));
  Epetra_Vector diagonal(A.rows());
  A.diagonal(diagonal);
  for (int row = 0; row < n_own; ++row)
    b.trilinos_vector()[0][row] = std::sin(1e4 * (1 + A.rows().GID(row) % 1009)) *
                                  (power == 1 ? diagonal[row] : std::pow(std::abs(diagonal[row]), power));
  dealii::IterationNumberControl control(n_iterations, 1e-30 * b.l2_norm());
  dealii::SolverCG<SingleVector> solver(control);
  double largest = 0;
  solver.connect_eigenvalues_slot([&largest](const std::vector<double> &eigenvalues) {
    if (!eigenvalues.empty() && eigenvalues.front() > 0)
      largest = eigenvalues.back();
  });
  try {
    solver.solve(Product{A}, x, b, Inverse{M});
  } catch (const std::exception &) { // divided by zero
    return 0;
  }
  dealii::GrowingVectorMemory<SingleVector>::release_unused_memory();
  return std::isfinite(largest) ? largest : 0;
}

/// Of a step d = direction d + correction M^-1 r, x += d.
struct StepFactors
{
  double direction, correction;
};

std::vector<StepFactors> factors_of_steps(const ChebyshevSmoother::Range range,
                                          const double largest_eigenvalue)
{
  std::vector<StepFactors> result;
  if (range.ratio == ChebyshevSmoother::fourth_kind) {
    for (unsigned int k = 0; k < range.degree; ++k)
      result.push_back({(2. * k - 1) / (2. * k + 3), (8. * k + 4) / (2. * k + 3) / largest_eigenvalue});
    return result;
  }
  const double middle = largest_eigenvalue * (1 + 1 / range.ratio) / 2,
               half = largest_eigenvalue * (1 - 1 / range.ratio) / 2;
  result.push_back({0., 1 / middle});
  double rho = half / middle;
  while (result.size() < range.degree) {
    const double next = 1 / (2 * middle / half - rho);
    result.push_back({next * rho, 2 * next / half});
    rho = next;
  }
  return result;
}

} // namespace

Diagonal::Diagonal(const LevelProducts &A) : inverse(A.rows().NumMyElements())
{
  Epetra_Vector diagonal(A.rows());
  A.diagonal(diagonal);
  for (unsigned int row = 0; row < inverse.size(); ++row)
    unit = std::max(unit, diagonal[row] > 0 ? 1 / diagonal[row] : 0);
  for (unsigned int row = 0; row < inverse.size(); ++row)
    inverse[row] = diagonal[row] > 0 ? static_cast<float>(1 / diagonal[row] / unit) : 0;
}

void Diagonal::vmult(double *z, const double *r) const
{
  for (unsigned int row = 0; row < inverse.size(); ++row)
    z[row] = unit * inverse[row] * r[row];
}

std::unique_ptr<ChebyshevSmoother> ChebyshevSmoother::with_diagonal(const LevelProducts &A, const Range range,
                                                                    const double known_eigenvalue)
{
  std::unique_ptr<ChebyshevSmoother> result(new ChebyshevSmoother(A, range));
  result->take_diagonal(known_eigenvalue);
  return result;
}

std::unique_ptr<ChebyshevSmoother> ChebyshevSmoother::with_approximation(const LevelProducts &A,
                                                                         std::unique_ptr<Approximation> M,
                                                                         const Range range)
{
  std::unique_ptr<ChebyshevSmoother> result(new ChebyshevSmoother(A, range));
  result->M = std::move(M);
  result->largest_eigenvalue = margin * estimate_largest_eigenvalue(A, *result->M, 0.5);
  if (!(result->largest_eigenvalue > 0))
    result->take_diagonal(0);
  return result;
}

void ChebyshevSmoother::take_diagonal(const double known_eigenvalue)
{
  M = std::make_unique<Diagonal>(A);
  if (known_eigenvalue > 0)
    largest_eigenvalue = margin * known_eigenvalue;
  else
    estimate_spectrum();
  AssertThrow(largest_eigenvalue > 0, dealii::ExcMessage("The matrix is not positive definite."));
}

std::unique_ptr<ChebyshevSmoother> ChebyshevSmoother::with_factorisation(const LevelEntries &A,
                                                                         const Range range)
{
  std::unique_ptr<ChebyshevSmoother> result(new ChebyshevSmoother(A, range));
  result->take_factorisation(A, range);
  return result;
}

void ChebyshevSmoother::take_factorisation(const LevelEntries &matrix, const Range its_range)
{
  const double largest_accepted = 10; // a pivot close to zero gives a larger eigenvalue
  const Agreement ranks{communicator_of(A), {}};
  range = its_range;
  std::shared_ptr<const CompactMatrix> in_single_precision; // once for all shifts
  const bool has_matrix =
      ranks.succeeds("smoother", [&]() { in_single_precision = matrix.single_precision(); });
  for (const double shift : {0.05, 0.3, 1.}) {
    const bool is_made = has_matrix && ranks.succeeds("smoother", [&]() { // it may break down
      M.reset();
      M = std::make_unique<IncompleteFactorisation>(*in_single_precision, shift);
    });
    if (is_made)
      estimate_spectrum();
    if (is_made && largest_eigenvalue > 0 && largest_eigenvalue < largest_accepted)
      return;
  }
  take_diagonal(0);
}

/// The largest eigenvalue was approached from below.
void ChebyshevSmoother::estimate_spectrum()
{
  largest_eigenvalue = margin * estimate_largest_eigenvalue(A, *M);
}

double largest_eigenvalue_with_diagonal(const LevelProducts &A)
{
  return estimate_largest_eigenvalue(A, Diagonal(A));
}

void ChebyshevSmoother::smooth(double *x, const double *b, const bool starts_from_zero) const
{
  const int n = A.rows().NumMyElements();
  Epetra_Vector solution(View, A.rows(), x), residual(A.rows(), false), direction(A.rows(), false);
  double *const d = direction.Values(), *const r = residual.Values();
  const std::vector<StepFactors> factors = factors_of_steps(range, largest_eigenvalue);
  for (unsigned int k = 0; k < range.degree; ++k) {
    if (k == 0 && starts_from_zero) {
      std::fill(x, x + n, 0.);
      std::copy(b, b + n, r);
    } else {
      A.vmult(residual, solution);
      for (int i = 0; i < n; ++i)
        r[i] = b[i] - r[i];
    }
    M->vmult(r, r);
    for (int i = 0; i < n; ++i) {
      d[i] = (k == 0 ? 0 : factors[k].direction * d[i]) + factors[k].correction * r[i];
      x[i] += d[i];
    }
  }
}

} // namespace dovetail
