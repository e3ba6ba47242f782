// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "degree_coarsening.h"
#include "factors.h"
#include "followed_sums.h"
#include "mesh_coarsening.h"
#include "semicoarsening.h"

#include <dovetail/solve/free_memory.h>

#include <Epetra_IntVector.h>
#include <Epetra_Map.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace dovetail {

DegreeCoarsening::DegreeCoarsening(const LevelOperator &A, RowSums &&sums, const MakeModes &make_modes,
                                   const GroupFacts &facts, std::unique_ptr<Smoother> given_smoother,
                                   const MakeCoarse &make_coarse, const MeshLevels *const levels)
    : A(A), dim(facts.dim), nodes_across(facts.shape.nodes_across), smoother(std::move(given_smoother))
{
  give_back_freed_memory();
  find_coarse_rows(sums);
  std::vector<MeshStep> steps;
  if (levels != nullptr)
    steps = make_mesh_steps(*levels, sums, A.rows(), coarse_rows);
  prolongation = make_prolongation(std::move(sums));
  if (prolongation->domain().NumGlobalElements() == 0) // all vertices are prescribed
    return;
  auto modes = make_modes(prolongation->domain(), &coarse_rows);
  std::vector<GroupFacts::Place> places = facts.known_places(&coarse_rows);
  coarse_rows = Selection(); // = {} would keep the memory
  give_back_freed_memory();
  auto A_1 = A.restricted(*prolongation);
  n_entries = A_1->NumGlobalNonzeros64();
  give_back_freed_memory();
  coarse = coarsen_mesh(std::move(A_1), std::move(steps), std::move(modes), std::move(places), make_coarse);
}

std::unique_ptr<Cycle> DegreeCoarsening::make_usual_coarse(Cycle::Finest A_1,
                                                           std::shared_ptr<const Epetra_MultiVector> modes,
                                                           std::vector<GroupFacts::Place> places)
{
  return make_cycle_with_factorisations(std::move(A_1), std::move(modes), std::move(places),
                                        Semicoarsen::if_cheap, false, // costs little beside the rows of A
                                        Semicoarsening::Lines::whole_if_cheap);
}

/// What functions of degree one leave reaches the further down the higher the degree is. Solves in cells see
/// all functions of the degree.
std::unique_ptr<ChebyshevSmoother>
DegreeCoarsening::usual_smoother(const LevelOperator &A, const unsigned int degree, const bool is_augmented)
{
  if (auto M = A.approximation())
    return ChebyshevSmoother::with_approximation(A, std::move(M), {std::max(3u, degree), 7. * degree + 1});
  const unsigned int times = is_augmented ? 2 : 1;
  return ChebyshevSmoother::with_diagonal(A, {times * (degree + 1), times * (12.5 * degree - 10)});
}

void DegreeCoarsening::find_coarse_rows(const RowSums &sums)
{
  for (unsigned int row = 0; row < sums.size(); ++row)
    if (sums.is_only(row, A.rows().GID(row)))
      coarse_rows.push_back(row);
}

/// P. A condensed unknown is alone in its row of the matrix, and found afterwards from those it follows.
std::unique_ptr<Prolongation> DegreeCoarsening::make_prolongation(RowSums &&sums) const
{
  const Epetra_Map coarse(-1, static_cast<int>(coarse_rows.size()), 0, A.rows().Comm());
  Epetra_IntVector number(A.rows());
  number.PutValue(-1);
  for (unsigned int i = 0; i < coarse_rows.size(); ++i)
    number[coarse_rows[i]] = coarse.GID(i);
  FollowedSums followed(std::move(sums), A.rows(), number);
  return std::make_unique<Prolongation>(
      A.rows(), coarse, [&](const int row, std::vector<int> &columns, std::vector<double> &weights) {
        columns.clear();
        weights.clear();
        if (!A.is_condensed(row))
          followed.read(row, columns, weights);
      });
}

void DegreeCoarsening::vmult(Epetra_Vector &x, const Epetra_Vector &b) const
{
  smoother->smooth(x.Values(), b.Values(), true);
  if (coarse)
    correct(x, b);
  smoother->smooth(x.Values(), b.Values(), false);
}

/// Where thousands of iterations are expected, the residual has hardly begun to fall, and that tells little.
bool DegreeCoarsening::factors_pay(const double n_expected, const double work_above) const
{
  const double n_with_factors = 15, largest_n = 1000;
  const int largest = 300000; // rows: about 5 GiB for those of a cube. Factors looks how much is free
  if (!coarse || !coarse->has_levels() || n_expected > largest_n)
    return false;
  const int n_rows = prolongation->domain().NumGlobalElements();
  return n_rows <= largest &&
         work_of_factors(n_rows, dim, nodes_across) <
             (n_expected - n_with_factors) * (work_above + work_of_level_entry * n_entries);
}

/// By the functions of degree one.
void DegreeCoarsening::correct(Epetra_Vector &x, const Epetra_Vector &b) const
{
  Epetra_Vector residual(A.rows(), false), coarse_b(prolongation->domain(), false),
      coarse_x(prolongation->domain());
  A.vmult(residual, x);
  residual.Update(1., b, -1.);
  prolongation->multiply_transposed(coarse_b, residual);
  coarse->vmult(coarse_x, coarse_b);
  prolongation->multiply(residual, coarse_x);
  x.Update(1., residual, 1.);
}

} // namespace dovetail
