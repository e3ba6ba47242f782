// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "cycle.h"

#include <dovetail/solve/free_memory.h>

#include <Epetra_Map.h>

#include <algorithm>
#include <utility>

namespace dovetail {

namespace {

/// The rows in the same order on fewer ranks, which have @p n_rows of them at least on average. @p n_ranks
/// have some now.
Epetra_Map on_fewer_ranks(const Epetra_Map &rows, const int n_ranks, const int n_rows)
{
  int has_rows = rows.NumMyElements() > 0 ? 1 : 0, number = 0;
  rows.Comm().ScanSum(&has_rows, &number, 1);
  const int n_groups = std::max(1, std::min(n_ranks, rows.NumGlobalElements() / n_rows));
  // Group of the i-th rank with rows: i * n_groups / n_ranks. Its first rank takes the rows of all.
  const auto group = [&](const int i) { return static_cast<long long>(i) * n_groups / n_ranks; };
  const int here = number - 1; // among those with rows
  const bool is_first = has_rows != 0 && (here == 0 || group(here - 1) != group(here));
  std::vector<int> rows_of_groups(n_groups, 0), sums(n_groups, 0);
  if (has_rows != 0)
    rows_of_groups[group(here)] = rows.NumMyElements();
  rows.Comm().SumAll(rows_of_groups.data(), sums.data(), n_groups);
  return Epetra_Map(-1, is_first ? sums[group(here)] : 0, 0, rows.Comm());
}

} // namespace

void Cycle::add_level(const MakeSmoother &make_smoother, std::unique_ptr<Epetra_CrsMatrix> P,
                      const MakeMatrix &make_coarse, const LevelFacts &facts)
{
  Level level;
  level.P = std::make_unique<CompactMatrix>(std::move(P), false); // although it may be square
  give_back_freed_memory();
  level.A = last.owned ? std::make_unique<LevelEntries>(CompactMatrix(std::move(last.owned)))
                       : std::make_unique<LevelEntries>(*last.A);
  give_back_freed_memory();
  const bool may_round = last.may_round;
  last = Finest(make_coarse());
  if (may_round)
    level.A->single_precision();
  give_back_freed_memory();
  level.smoother = make_smoother(*level.A, facts);
  levels.push_back(std::move(level));
}

const Epetra_Import *Cycle::gather_coarsest()
{
  const Epetra_Map &rows = coarsest().RowMap();
  if (rows.NumGlobalElements() <= largest_coarse)
    return nullptr;
  int has_rows = rows.NumMyElements() > 0 ? 1 : 0, n_ranks = 0;
  rows.Comm().SumAll(&has_rows, &n_ranks, 1);
  if (n_ranks < 2 || rows.NumGlobalElements() / n_ranks >= few_rows)
    return nullptr;
  const Epetra_Map fewer = on_fewer_ranks(rows, n_ranks, 2 * few_rows);
  levels.back().gather = std::make_unique<Epetra_Import>(fewer, rows);
  auto gathered = std::make_unique<Epetra_CrsMatrix>(Copy, fewer, coarsest().GlobalMaxNumEntries());
  gathered->Import(coarsest(), *levels.back().gather, Insert);
  gathered->FillComplete();
  last = Finest(std::move(gathered));
  return levels.back().gather.get();
}

std::unique_ptr<Epetra_MultiVector> imported(const Epetra_MultiVector &given, const Epetra_Import &import)
{
  auto result = std::make_unique<Epetra_MultiVector>(import.TargetMap(), given.NumVectors());
  result->Import(given, import, Insert);
  return result;
}

void Cycle::correct(const Level &level, const unsigned int next, Epetra_Vector &x,
                    const Epetra_Vector &b) const
{
  if (!level.gather) {
    cycle(next, x, b);
    return;
  }
  Epetra_Vector gathered_x(level.gather->TargetMap(), false), gathered_b(level.gather->TargetMap(), false);
  gathered_b.Import(b, *level.gather, Insert);
  cycle(next, gathered_x, gathered_b);
  x.Export(gathered_x, *level.gather, Insert);
}

void Cycle::cycle(const unsigned int number, Epetra_Vector &x, const Epetra_Vector &b) const
{
  if (number == levels.size()) {
    if (below)
      below->vmult(x, b);
    else
      factors->solve(x.Values(), b.Values());
    return;
  }
  const Level &level = levels[number];
  level.smoother->smooth(x.Values(), b.Values(), true);
  Epetra_Vector residual(b.Map(), false), coarse_b(level.P->domain(), false),
      coarse_x(level.P->domain(), false);
  level.A->vmult(residual, x);
  residual.Update(1., b, -1.);
  level.P->multiply_transposed(coarse_b, residual);
  correct(level, number + 1, coarse_x, coarse_b);
  level.P->multiply(residual, coarse_x);
  x.Update(1., residual, 1.);
  level.smoother->smooth(x.Values(), b.Values(), false);
}

void Cycle::vmult(Epetra_MultiVector &x, const Epetra_MultiVector &b) const
{
  Epetra_Vector solution(View, x, 0);
  cycle(0, solution, Epetra_Vector(View, b, 0));
}

} // namespace dovetail
