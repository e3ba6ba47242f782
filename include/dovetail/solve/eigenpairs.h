// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Eigenvalues next to a shift; knows operators and no finite elements.

#pragma once

#include <deal.II/base/mpi.h>

#include <functional>
#include <vector>

namespace dovetail {

/// K v = lambda M v with symmetric K and M, where M may be semidefinite (multipliers have no mass). Each rank
/// owns some entries of a vector. All functions are collective.
struct EigenProblem
{
  using Column = std::vector<double>;                     ///< own entries
  using Product = std::function<Column(const Column &x)>; ///< may throw, on all ranks alike

  MPI_Comm communicator;
  double shift;
  Product stiffness, mass; ///< K x and M x
  Product inverse;         ///< (K - shift M)^-1 x
  /// Functions of the place that know no partition: the first ones are where the search begins, and they
  /// choose signs and the vectors of repeated eigenvalues.
  std::vector<Column> guides;
};

struct EigenPairs
{
  std::vector<double> values;                ///< lambda, in increasing order
  std::vector<EigenProblem::Column> vectors; ///< v.Mv = 1
  /// By pair ||(K - shift M)^-1 M v - v / (lambda - shift)|| |lambda - shift| in the norm of M: some
  /// eigenvalue differs from lambda by no more than this, relative to lambda - shift.
  std::vector<double> residuals;
  bool has_converged = false;
};

/// At least the @p n pairs nearest to the shift, and some more; fewer if there are no more.
///
/// The Lanczos method for (K - shift M)^-1 M with the inner product of M, from several vectors at once, all
/// of them orthogonalised, restarted from the best Ritz vectors (Wu & Simon, SIAM Journal on Matrix Analysis
/// and Applications 22 (2000), 602; bands: Ruhe, Mathematics of Computation 33 (1979), 680). Where the
/// vectors span an invariant subspace it goes on from a new one, so that repeated eigenvalues and bodies with
/// few unknowns are no special cases. Collective.
EigenPairs nearest_eigenpairs(const EigenProblem &problem, unsigned int n);

} // namespace dovetail
