// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "cycle.h"

#include <utility>

namespace dovetail {

void Cycle::add_level(std::unique_ptr<ChebyshevSmoother> smoother, std::unique_ptr<Epetra_CrsMatrix> P,
                      std::unique_ptr<Epetra_CrsMatrix> coarse)
{
  levels.push_back({std::move(smoother), std::move(P), std::move(coarse)});
}

void Cycle::cycle(const unsigned int number, Epetra_Vector &x, const Epetra_Vector &b) const
{
  if (number == levels.size()) {
    factors->solve(x.Values(), b.Values());
    return;
  }
  const Level &level = levels[number];
  const Epetra_CrsMatrix &matrix = number == 0 ? A : *levels[number - 1].coarse;
  level.smoother->smooth(x.Values(), b.Values(), true);
  Epetra_Vector residual(b.Map(), false), coarse_b(level.P->OperatorDomainMap(), false),
      coarse_x(level.P->OperatorDomainMap(), false);
  matrix.Multiply(false, x, residual);
  residual.Update(1., b, -1.);
  level.P->Multiply(true, residual, coarse_b);
  cycle(number + 1, coarse_x, coarse_b);
  level.P->Multiply(false, coarse_x, residual);
  x.Update(1., residual, 1.);
  level.smoother->smooth(x.Values(), b.Values(), false);
}

void Cycle::vmult(Epetra_MultiVector &x, const Epetra_MultiVector &b) const
{
  Epetra_Vector solution(View, x, 0);
  cycle(0, solution, Epetra_Vector(View, b, 0));
}

} // namespace dovetail
