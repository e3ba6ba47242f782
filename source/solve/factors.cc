// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "factors.h"

#include "mumps_factors.h"

#include <dovetail/solve/free_memory.h>
#include <dovetail/solve/group_solver.h>

#include <deal.II/base/exceptions.h>
#include <deal.II/base/mpi.h>

#include <Amesos_Klu.h>
#include <Epetra_LinearProblem.h>
#include <Epetra_Map.h>
#include <Epetra_MpiComm.h>
#include <Epetra_MultiVector.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace dovetail {

double thin_share(const double n_rows, const unsigned int dim, const double nodes_across)
{
  const double across_cube = std::cbrt(n_rows / 3) / 3;
  return dim == 3 && nodes_across > 0 ? std::min(1., nodes_across / across_cube) : 1;
}

double work_of_factors(const double n_rows, const unsigned int dim, const double nodes_across)
{
  return dim == 3 ? 1.6 * n_rows * n_rows * std::pow(thin_share(n_rows, dim, nodes_across), 1.5)
                  : 6000 * n_rows;
}

Factors::Factors(std::unique_ptr<Epetra_CrsMatrix> given, const bool is_symmetric)
    : owned(std::move(given)), A(*owned), is_symmetric(is_symmetric)
{
  factorise();
}

Factors::Factors(const Epetra_CrsMatrix &A, const bool is_symmetric) : A(A), is_symmetric(is_symmetric)
{
  factorise();
}

Factors::Factors(const Epetra_CrsMatrix &A, const std::vector<int> &first_row) : A(A), is_symmetric(true)
{
  factorise(first_row);
}

Factors::~Factors() = default;

void Factors::factorise(const std::vector<int> &first_row)
{
  const int most_of_klu = 2000;
  if (A.NumGlobalRows() > most_of_klu) {
    const bool has_small_pivots = false;
    const Agreement ranks{dynamic_cast<const Epetra_MpiComm &>(A.Comm()).Comm(), {}};
    mumps =
        std::make_unique<MumpsFactors>(ranks.communicator, A.NumGlobalRows(), is_symmetric, has_small_pivots);
    std::vector<int> rows_of_nodes;
    ranks.run("entries", [&]() {
      mumps->take(A);
      for (std::size_t node = 0; node + 1 < first_row.size(); ++node)
        rows_of_nodes.push_back(first_row[node + 1] - first_row[node]);
    });
    mumps->analyse(rows_of_nodes);
    const double missing = mumps->memory_on_machine() - free_memory(); // the kernel would end the process
    AssertThrow(dealii::Utilities::MPI::max(missing, ranks.communicator) <= 0,
                dealii::ExcMessage("There is too little memory for the factors of a matrix."));
    mumps->factorise();
    return;
  }
  problem = std::make_unique<Epetra_LinearProblem>();
  problem->SetOperator(const_cast<Epetra_CrsMatrix *>(&A));
  solver = std::make_unique<Amesos_Klu>(*problem);
  AssertThrow(solver->SymbolicFactorization() == 0 && solver->NumericFactorization() == 0,
              dealii::ExcMessage("A small matrix cannot be factorised."));
}

void Factors::solve(double *x, const double *b, const bool by_transposed) const
{
  if (mumps) {
    mumps->solve(x, b, by_transposed);
    return;
  }
  double none = 0; // a null pointer is refused
  const int n = A.NumMyRows();
  Epetra_MultiVector solution(View, A.OperatorDomainMap(), n > 0 ? x : &none, std::max(n, 1), 1),
      right_hand_side(View, A.OperatorRangeMap(), n > 0 ? const_cast<double *>(b) : &none, std::max(n, 1), 1);
  problem->SetLHS(&solution);
  problem->SetRHS(&right_hand_side);
  solver->SetUseTranspose(by_transposed);
  solver->Solve();
}

} // namespace dovetail
