// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A is diagonal with entries from 1 to 1e8, and K sees three of its functions wrongly, by factors of 1/4, 2/3
// and 3/2: three steps and a last one for its rounding solve A x = b, which corrections that are added as
// they are reach after 1/(1 - 4) has diverged. With an inverse to two digits, the digits double their number
// of steps at most. Where K has a hundred times A, too, and its inverse one digit, a step is larger than the
// one before. Where K fails or r is undefined, x stays where it was, and the result says that it has no
// digits. One block on each rank's share of 60 unknowns.
//
// ranks: 1, 2, 3

#include <dovetail/solve/iterative_refinement.h>

#include <deal.II/base/mpi.h>

#include <cmath>
#include <iostream>
#include <limits>

using namespace dovetail;
using Vector = IterativeRefinement::Vector;

namespace {

const unsigned int n = 60;

double entry(const unsigned int i)
{
  return std::pow(10., 2. * i / (n - 1));
}

/// What K has in place of A.
double factor(const unsigned int i, const double largest)
{
  return i == 7 ? 0.25 : i == 20 ? 2. / 3 : i == 45 ? 1.5 : i == 52 ? largest : 1.;
}

/// result_i = f(i, x_i)
template <typename Function>
void for_each(const Vector &x, Vector &result, const Function &function)
{
  for (const auto i : x.locally_owned_elements())
    result(i) = function(i, x(i));
  result.compress(dealii::VectorOperation::insert);
}

struct Result
{
  double error;
  unsigned int n_steps;
  bool is_exact, grows; ///< whether a step was larger than the one before
};

Result solve(const double exactness, const unsigned int fails_at = 100, const unsigned int undefined_at = 100,
             const double largest = 1)
{
  const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD),
                     rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD);
  dealii::IndexSet owned(n);
  owned.add_range(n * rank / n_ranks, n * (rank + 1) / n_ranks);
  Vector x(std::vector<dealii::IndexSet>(1, owned), MPI_COMM_WORLD);
  unsigned int n_residuals = 0, n_steps = 0;
  const auto residual = [&](const Vector &at, Vector &r) {
    for_each(at, r, [](const unsigned int i, const double value) { return entry(i) * (1. - value); });
    return ++n_residuals != undefined_at;
  };
  const auto inverse = [&](const Vector &r, Vector &c) -> std::optional<unsigned int> {
    for_each(r, c, [&](const unsigned int i, const double value) {
      return value / (entry(i) * factor(i, largest)) * (1 + exactness * (i % 2 ? 1 : -1));
    });
    if (++n_steps == fails_at)
      return {};
    return 1;
  };
  double last = std::numeric_limits<double>::infinity();
  bool grows = false;
  const auto share = [&](const Vector &step, const Vector &at) {
    const double its = step.l2_norm() / at.l2_norm();
    grows = grows || its > last;
    return last = its;
  };
  for_each(x, x, [&](const unsigned int i, double) { return 1 / factor(i, largest); });
  IterativeRefinement refinement(residual, inverse, share, true);
  refinement.refine(x);
  x.add(-1.);
  return {x.linfty_norm(), n_steps, refinement.is_exact(), grows};
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const bool speaks = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;
  for (const double exactness : {0., 1e-2}) {
    const Result result = solve(exactness);
    if (speaks)
      std::cout << "inverse to " << exactness << ": error below 1e-8 " << (result.error < 1e-8) << ", "
                << result.n_steps << " steps, exact " << result.is_exact << std::endl;
  }
  const Result growing = solve(0.1, 100, 100, 100.);
  if (speaks)
    std::cout << "inverse to 0.1: error below 1e-8 " << (growing.error < 1e-8) << ", exact "
              << growing.is_exact << ", a step grows " << growing.grows << std::endl;
  const Result failed = solve(1e-2, 2), undefined = solve(1e-2, 100, 3);
  if (speaks)
    std::cout << "the inverse fails: exact " << failed.is_exact << "\nr is undefined: exact "
              << undefined.is_exact << ", error of one step "
              << (undefined.error > 1e-3 && undefined.error < 10) << std::endl;
}
