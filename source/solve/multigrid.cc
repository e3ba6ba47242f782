// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// CG or GMRES with smoothed aggregation, for a degree above one after a first coarsening to the functions of
// degree one. A group that is not symmetric is preconditioned by the symmetric part of its matrix.
//
// At degree one the smoothers are made of the diagonal, until an iteration is slow: then, and from then on,
// of incomplete factorisations, which cost more and smooth what stretched cells and the like leave.
//
//     subsection Linear solver
//       set Type = multigrid
//     end

#include "degree_coarsening.h"

#include <dovetail/solve/krylov.h>

#include <deal.II/lac/solver_control.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_MultiVector.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

namespace dovetail {

class Multigrid : public GroupSolver
{
public:
  Multigrid(const Section &, const GroupFacts &facts) : facts(facts) {}

  std::string description() const override { return describe_iteration(facts, "multigrid"); }
  void prepare(const GroupOperator &K, const Agreement &all_ranks) override;
  unsigned int solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal) override;
  void forget() override
  {
    forget_values();
    modes.reset();
    is_slow = false;
  }

private:
  void forget_values();
  void make_aggregation();
  void make_levels();
  unsigned int iterate(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal,
                       const std::function<bool(unsigned int n, double r)> &gives_up);

  const GroupFacts &facts;
  Agreement ranks;
  std::unique_ptr<Epetra_MultiVector> modes;
  std::unique_ptr<Epetra_CrsMatrix> symmetric_part; ///< of a matrix that is not symmetric
  const Epetra_CrsMatrix *matrix = nullptr;         ///< that is preconditioned
  bool is_slow = false;                             ///< with smoothers made of the diagonal
  std::unique_ptr<SmoothedAggregation> aggregation;
  std::unique_ptr<MatrixLevel> finest;         ///< of by_degree
  std::unique_ptr<DegreeCoarsening> by_degree; ///< instead, for a degree above one
};

void Multigrid::forget_values()
{
  aggregation.reset();
  by_degree.reset();
  finest.reset();
  symmetric_part.reset();
}

void Multigrid::prepare(const GroupOperator &K, const Agreement &all_ranks)
{
  forget_values();
  ranks = all_ranks;
  matrix = K.bodies().matrix();
  if (!modes)
    ranks.run("modes", [&]() { modes = make_modes(facts, matrix->OperatorDomainMap()); });
  if (!facts.is_symmetric) {
    ranks.run("symmetric part",
              [&]() { symmetric_part = make_symmetric_part(*matrix, facts.field_of_row()); });
    matrix = symmetric_part.get();
  }
  ranks.run("multigrid", [&]() { make_levels(); });
}

void Multigrid::make_levels()
{
  if (facts.degree > 1 && facts.linear_part) {
    finest = std::make_unique<MatrixLevel>(*matrix);
    by_degree = std::make_unique<DegreeCoarsening>(*finest, facts.degree, facts.linear_part(), *modes);
  } else
    make_aggregation();
}

void Multigrid::make_aggregation()
{
  aggregation.reset();
  aggregation = std::make_unique<SmoothedAggregation>(*matrix, *modes, [this](const auto &level) {
    return is_slow ? ChebyshevSmoother::with_factorisation(level, {4, 40})
                   : ChebyshevSmoother::with_diagonal(level, {2, 10});
  });
}

unsigned int Multigrid::solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, const double goal)
{
  if (is_slow || by_degree || facts.has_multipliers) // whose Schur complement may be what is slow
    return iterate(K, x, b, goal, {});

  const unsigned int n_between_checks = 8, most_iterations = 30;
  const double decades = std::log10(b.l2_norm() / goal);
  const auto will_take_too_many = [&](const unsigned int n, const double residual) {
    return n > 0 && n % n_between_checks == 0 &&
           n * decades > most_iterations * std::log10(b.l2_norm() / residual);
  };
  unsigned int n_iterations = 0;
  try {
    return iterate(K, x, b, goal, will_take_too_many);
  } catch (const dealii::SolverControl::NoConvergence &end) { // on all ranks
    n_iterations = end.last_step;
  }
  is_slow = true;
  ranks.run("multigrid", [this]() { make_aggregation(); });
  GroupVector residual(b), correction(K.vector());
  K.vmult(residual, x);
  residual.sadd(-1., 1., b);
  if (!(residual.l2_norm() < b.l2_norm())) {
    x = 0;
    residual = b;
  }
  n_iterations += iterate(K, correction, residual, goal, {});
  x += correction;
  return n_iterations;
}

unsigned int Multigrid::iterate(const GroupOperator &K, GroupVector &x, const GroupVector &b,
                                const double goal,
                                const std::function<bool(unsigned int n, double r)> &gives_up)
{
  const auto cycle = [this](GroupVector &solution, const GroupVector &right_hand_side) {
    Epetra_Vector z(View, solution.trilinos_vector(), 0);
    const Epetra_Vector r(View, right_hand_side.trilinos_vector(), 0);
    by_degree ? by_degree->vmult(z, r) : aggregation->vmult(z, r);
  };
  return solve_by_iteration(K, facts, cycle, x, b, goal, gives_up);
}

namespace {
[[maybe_unused]] const bool registered = SolverCatalogue::add<Multigrid>(
    "multigrid", "ML as preconditioner of CG, or of GMRES if the group is not symmetric or has multipliers.");
}

} // namespace dovetail
