// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "cycle.h"

#include <dovetail/solve/free_memory.h>

#include <utility>

namespace dovetail {

void Cycle::add_level(const MakeSmoother &make_smoother, std::unique_ptr<Epetra_CrsMatrix> P,
                      const MakeMatrix &make_coarse, const double known_eigenvalue)
{
  Level level;
  level.P = std::make_unique<CompactMatrix>(std::move(P));
  give_back_freed_memory();
  level.A = last.owned ? std::make_unique<LevelEntries>(CompactMatrix(std::move(last.owned)))
                       : std::make_unique<LevelEntries>(*last.A);
  give_back_freed_memory();
  last = Finest(make_coarse());
  give_back_freed_memory();
  level.smoother = make_smoother(*level.A, known_eigenvalue);
  levels.push_back(std::move(level));
}

void Cycle::cycle(const unsigned int number, Epetra_Vector &x, const Epetra_Vector &b) const
{
  if (number == levels.size()) {
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
  cycle(number + 1, coarse_x, coarse_b);
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
