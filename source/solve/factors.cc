// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "factors.h"

#include <deal.II/base/exceptions.h>

#include <Amesos_Klu.h>
#include <Amesos_Lapack.h>
#include <Epetra_Comm.h>
#include <Epetra_LinearProblem.h>
#include <Epetra_Map.h>
#include <Epetra_MultiVector.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace dovetail {

Factors::Factors(std::unique_ptr<Epetra_CrsMatrix> given) : owned(std::move(given)), A(*owned)
{
  factorise();
}

Factors::Factors(const Epetra_CrsMatrix &A) : A(A)
{
  factorise();
}

Factors::~Factors() = default;

void Factors::factorise()
{
  problem = std::make_unique<Epetra_LinearProblem>();
  problem->SetOperator(const_cast<Epetra_CrsMatrix *>(&A));
  const double n_rows = A.NumGlobalRows(), n_entries = A.NumGlobalNonzeros(), few = n_rows / 8; // in a row
  if (n_entries > few * n_rows)
    solver = std::make_unique<Amesos_Lapack>(*problem);
  else
    solver = std::make_unique<Amesos_Klu>(*problem);
  int has_failed = solver->SymbolicFactorization() != 0 || solver->NumericFactorization() != 0,
      has_any_failed = 0; // LAPACK tells the first rank alone
  A.Comm().MaxAll(&has_failed, &has_any_failed, 1);
  if (has_any_failed == 0) { // and not of each pivot that is zero
    std::vector<double> x(A.NumMyRows(), std::numeric_limits<double>::quiet_NaN()), b(x.size(), 1.);
    solve(x.data(), b.data());
    has_failed = !std::all_of(x.begin(), x.end(), [](const double value) { return std::isfinite(value); });
    A.Comm().MaxAll(&has_failed, &has_any_failed, 1);
  }
  AssertThrow(has_any_failed == 0, dealii::ExcMessage("A small matrix cannot be factorised."));
}

void Factors::solve(double *x, const double *b) const
{
  double none = 0; // a null pointer is refused
  const int n = A.NumMyRows();
  Epetra_MultiVector solution(View, A.OperatorDomainMap(), n > 0 ? x : &none, std::max(n, 1), 1),
      right_hand_side(View, A.OperatorRangeMap(), n > 0 ? const_cast<double *>(b) : &none, std::max(n, 1), 1);
  problem->SetLHS(&solution);
  problem->SetRHS(&right_hand_side);
  solver->Solve();
}

} // namespace dovetail
