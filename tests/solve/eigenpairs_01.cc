// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The chain K = tridiag(-1, 2, -1), M = 1, of n links has the eigenvalues 4 sin^2(k pi / (2 (n + 1))).
// Several copies of it that do not know each other have each of them several times, more often than the
// search has vectors. The numbers next to a shift inside the spectrum. Unknowns without a mass follow the
// others: a chain of which every second link has none is one of half as many links with half the stiffness.
// If more pairs are wanted than there are, all are found. The rank owns copies, so that the products need no
// partner.
//
// ranks: 1 2 3

#include <dovetail/solve/eigenpairs.h>

#include <deal.II/base/mpi.h>

#include <cmath>
#include <cstdio>
#include <numeric>

using namespace dovetail;
using Column = EigenProblem::Column;

namespace {

const unsigned int n_copies = 6;

/// Copies of a chain, each on one rank.
struct Chains
{
  unsigned int n_links, n_own; ///< of a chain; copies on this rank
  bool has_light_links;

  template <typename Visit>
  Column each(const Column &x, const Visit &visit) const
  {
    Column y(x.size(), 0.);
    for (unsigned int copy = 0; copy < n_own; ++copy)
      visit(x.data() + copy * n_links, y.data() + copy * n_links);
    return y;
  }

  Column stiffness(const Column &x) const
  {
    return each(x, [this](const double *u, double *Ku) {
      for (unsigned int i = 0; i < n_links; ++i)
        Ku[i] = 2 * u[i] - (i > 0 ? u[i - 1] : 0) - (i + 1 < n_links ? u[i + 1] : 0);
    });
  }

  double mass(const unsigned int i) const { return has_light_links && i % 2 == 0 ? 0 : 1; }

  Column mass(const Column &x) const
  {
    return each(x, [this](const double *u, double *Mu) {
      for (unsigned int i = 0; i < n_links; ++i)
        Mu[i] = mass(i) * u[i];
    });
  }

  /// Gaussian elimination of the tridiagonal matrix.
  Column inverse(const double shift, const Column &b) const
  {
    return each(b, [&](const double *right, double *u) {
      std::vector<double> pivot(n_links);
      for (unsigned int i = 0; i < n_links; ++i) {
        pivot[i] = 2 - shift * mass(i) - (i > 0 ? 1 / pivot[i - 1] : 0);
        u[i] = right[i] + (i > 0 ? u[i - 1] / pivot[i - 1] : 0);
      }
      for (unsigned int i = n_links; i-- > 0;)
        u[i] = (u[i] + (i + 1 < n_links ? u[i + 1] : 0)) / pivot[i];
    });
  }
};

void show(const char *title, const Chains &chains, const double shift, const unsigned int n)
{
  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD),
                     n_ranks = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
  EigenProblem problem;
  problem.communicator = MPI_COMM_WORLD;
  problem.shift = shift;
  problem.stiffness = [&](const Column &x) { return chains.stiffness(x); };
  problem.mass = [&](const Column &x) { return chains.mass(x); };
  problem.inverse = [&](const Column &x) { return chains.inverse(shift, x); };
  const unsigned int first_copy = rank * n_copies / n_ranks;
  for (unsigned int g = 0; g < 8; ++g) {
    Column guide;
    for (unsigned int i = 0; i < chains.n_own * chains.n_links; ++i)
      guide.push_back(std::sin(1. + g + 0.37 * (g + 1) * (first_copy * chains.n_links + i)));
    problem.guides.push_back(guide);
  }
  const EigenPairs pairs = nearest_eigenpairs(problem, n);
  if (rank == 0)
    std::printf("%s: %s, %zu pairs\n", title, pairs.has_converged ? "converged" : "not converged",
                std::min<std::size_t>(pairs.values.size(), n));
  double error = 0, residual = 0;
  for (unsigned int k = 0; k < pairs.values.size(); ++k) {
    const Column Kv = chains.stiffness(pairs.vectors[k]), Mv = chains.mass(pairs.vectors[k]);
    double square = 0;
    for (unsigned int i = 0; i < Kv.size(); ++i)
      square += std::pow(Kv[i] - pairs.values[k] * Mv[i], 2);
    error = std::max(error, std::sqrt(dealii::Utilities::MPI::sum(square, MPI_COMM_WORLD)));
    residual = std::max(residual, pairs.residuals[k]);
    if (rank == 0 && k < n)
      std::printf("  %.8f", pairs.values[k]);
  }
  double sum = 0; // of a vector, which the guides have chosen
  if (!pairs.vectors.empty())
    sum = std::accumulate(pairs.vectors[0].begin(), pairs.vectors[0].end(), 0.);
  sum = dealii::Utilities::MPI::sum(sum, MPI_COMM_WORLD);
  if (rank == 0)
    std::printf("\n  |Kv - lambda Mv| < 1e-9: %s, residuals < 1e-11: %s, the first vector has the sum %.6f\n",
                error < 1e-9 ? "yes" : "no", residual < 1e-11 ? "yes" : "no", sum);
}

} // namespace

int main(int argc, char **argv)
{
  const dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD),
                     n_ranks = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
  const unsigned int n_own = (rank + 1) * n_copies / n_ranks - rank * n_copies / n_ranks;
  show("six copies", {40, n_own, false}, 0, 14);
  show("next to 1.2", {40, n_own, false}, 1.2, 6);
  show("links without mass", {41, n_own, true}, -0.1, 7);
  show("all there are", {3, n_own, false}, 0, 40);
}
