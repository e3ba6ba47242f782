// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// MUMPS through Amesos; KLU where Amesos has no MUMPS.
//
//     subsection Linear solver
//       set Type = direct
//     end
//
// P. R. Amestoy, I. S. Duff, J.-Y. L'Excellent, J. Koster: A fully asynchronous multifrontal solver using
// distributed dynamic scheduling, 2001.

#include <dovetail/solve/group_solver.h>

#include <Amesos.h>
#include <Amesos_BaseSolver.h>
#include <Epetra_CrsMatrix.h>
#include <Epetra_LinearProblem.h>
#include <Epetra_MultiVector.h>
#include <Teuchos_ParameterList.hpp>

#include <memory>
#include <stdexcept>

namespace dovetail {

class Direct : public GroupSolver
{
public:
  Direct(const Section &, const GroupFacts &facts) : facts(facts) {}

  std::string description() const override { return "MUMPS"; }
  void prepare(const GroupOperator &K, const Agreement &ranks) override;
  unsigned int solve(const GroupOperator &, GroupVector &x, const GroupVector &b, double) override;
  void forget() override
  {
    factors.reset();
    problem.reset();
  }

private:
  void make(const GroupOperator &K);

  /// Pivots off the diagonal need more space than the analysis foresees, in per cent.
  static constexpr int space_for_pivots = 1000;

  const GroupFacts &facts;
  std::unique_ptr<Epetra_LinearProblem> problem; ///< the factors refer to it
  std::unique_ptr<Amesos_BaseSolver> factors;
  Teuchos::ParameterList list;
};

namespace {

void check(const int error)
{
  if (error != 0)
    throw std::runtime_error("MUMPS gives error " + std::to_string(error));
}

} // namespace

void Direct::make(const GroupOperator &K)
{
  problem = std::make_unique<Epetra_LinearProblem>();
  problem->SetOperator(const_cast<Epetra_CrsMatrix *>(K.matrix())); // Epetra's interfaces know no const
  for (const char *package : {"Amesos_Mumps", "Amesos_Klu"})
    if (Amesos().Query(package)) {
      factors.reset(Amesos().Create(package, *problem));
      break;
    }
  list = Teuchos::ParameterList();
  list.set("OutputLevel", 0);
  list.set("PrintTiming", false);
  if (facts.has_multipliers)
    list.sublist("mumps").set("ICNTL(14)", space_for_pivots);
  factors->SetParameters(list);
}

void Direct::prepare(const GroupOperator &K, const Agreement &ranks)
{
  forget();
  ranks.run("factorisation", [&]() { make(K); });
  ranks.run("analysis", [&]() { check(factors->SymbolicFactorization()); });
  ranks.run("factors", [&]() {
    if (factors->NumericFactorization() == 0)
      return;
    list.sublist("mumps").set("ICNTL(14)", space_for_pivots);
    factors->SetParameters(list);
    check(factors->SymbolicFactorization());
    check(factors->NumericFactorization());
  });
}

unsigned int Direct::solve(const GroupOperator &, GroupVector &x, const GroupVector &b, const double)
{
  problem->SetLHS(&x.trilinos_vector());
  const Epetra_MultiVector &right_hand_side = b.trilinos_vector();
  problem->SetRHS(const_cast<Epetra_MultiVector *>(&right_hand_side));
  check(factors->Solve());
  return 1;
}

namespace {
[[maybe_unused]] const bool registered = SolverCatalogue::add<Direct>(
    "direct", "MUMPS, for every group; takes over from the other solvers where they fail.");
}

} // namespace dovetail
