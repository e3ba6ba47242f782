// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "smoothed_aggregation.h"

#include "aggregate_products.h"

#include <dovetail/solve/free_memory.h>

#include <algorithm>
#include <utility>

namespace dovetail {

namespace {

/// Whether the rows of @p n components of a vector field follow each other, node by node: row i sees no
/// translation but that of component i % n. Each set of modes begins with the translations.
bool are_rows_by_node(const Epetra_MultiVector &modes, const int n)
{
  const int n_of_set = n * (n + 1) / 2; // with rotations
  int here = modes.NumVectors() % n_of_set == 0 && modes.MyLength() % n == 0;
  for (int mode = 0; here && mode < modes.NumVectors(); ++mode)
    for (int row = 0; mode % n_of_set < n && row < modes.MyLength(); ++row)
      here = here && (mode % n_of_set == row % n || modes[mode][row] == 0);
  int everywhere = 0;
  modes.Comm().MinAll(&here, &everywhere, 1);
  return everywhere != 0;
}

/// For aggregates that do not cut nodes.
int rows_per_node(const Epetra_MultiVector &modes)
{
  for (const int n : {3, 2})
    if (are_rows_by_node(modes, n))
      return n;
  return 1;
}

} // namespace

std::unique_ptr<Epetra_MultiVector> make_modes(const GroupFacts &facts, const Epetra_Map &map,
                                               const Selection *rows)
{
  const auto near_null_space = facts.near_null_space(rows);
  auto modes = std::make_unique<Epetra_MultiVector>(map, near_null_space.size());
  for (unsigned int mode = 0; mode < near_null_space.size(); ++mode)
    std::copy(near_null_space[mode].begin(), near_null_space[mode].end(), (*modes)[mode]);
  return modes;
}

SmoothedAggregation::SmoothedAggregation(Finest A, std::shared_ptr<const Epetra_MultiVector> modes,
                                         const MakeSmoother &make_smoother)
    : Cycle(std::move(A))
{
  const int n_modes = modes->NumVectors();
  Aggregation aggregates;
  while (coarsest().NumGlobalRows() > largest_coarse) {
    const Epetra_CrsMatrix &matrix = coarsest();
    aggregates = n_levels() == 0 ? make_aggregation(matrix, *modes, rows_per_node(*modes))
                                 : make_aggregation(matrix, *aggregates.modes, n_modes);
    modes.reset();
    give_back_freed_memory();
    const int n_coarse = aggregates.modes->GlobalLength();
    if (n_coarse == 0 || n_coarse > largest_growth * matrix.NumGlobalRows())
      break;
    const double eigenvalue = largest_eigenvalue_with_diagonal(LevelEntries(matrix));
    auto P = smooth_bases(matrix, SparseRows(matrix), aggregates, 4. / 3 / eigenvalue);
    round_to_single_precision(*P);
    aggregates.basis = std::vector<double>(); // = {} would keep the memory
    give_back_freed_memory();
    const MakeMatrix make_coarse = sum_coarse_matrix(matrix, *P, n_modes);
    add_level(make_smoother, std::move(P), make_coarse, {eigenvalue});
    if (const Epetra_Import *const gather = gather_coarsest())
      aggregates.modes = imported(*aggregates.modes, *gather);
  }
  factorise_coarsest();
}

} // namespace dovetail
