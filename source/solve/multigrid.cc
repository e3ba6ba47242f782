// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// CG or GMRES with smoothed aggregation, for a degree above one after a first coarsening to the functions of
// degree one. A group that is not symmetric is preconditioned by the symmetric part of its matrix.
//
// At degree one the smoothers are made of the diagonal, until an iteration is slow: then, and from then on,
// of incomplete factorisations, which cost more and smooth what stretched cells and the like leave. The
// levels of one matrix are kept for the next ones while that pays.
//
//     subsection Linear solver
//       set Type = multigrid
//     end

#include "degree_coarsening.h"
#include "upkeep.h"

#include <dovetail/solve/krylov.h>

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
  /// The cost of levels: measured, in iterations (doc/theory/linear_solvers.md).
  Multigrid(const Section &, const GroupFacts &facts) : facts(facts), upkeep(12) {}

  std::string description() const override { return describe_iteration(facts, "multigrid"); }
  void prepare(const GroupOperator &K, const Agreement &all_ranks) override;
  unsigned int solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal) override;
  void forget() override
  {
    forget_values();
    upkeep.forget();
    modes.reset();
    is_slow = false;
  }

private:
  using GivesUp = std::function<bool(unsigned int n, double r)>;

  void forget_values();
  void make(const GroupOperator &K);
  void make_aggregation();
  void make_levels();
  unsigned int solve_with_new(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal);
  unsigned int iterate(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal,
                       const GivesUp &gives_up);

  const GroupFacts &facts;
  Agreement ranks;
  Upkeep upkeep;
  bool was_symmetric = true; ///< when the levels were made
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
  ranks = all_ranks;
  if (upkeep.pays() && was_symmetric == facts.is_symmetric) {
    upkeep.keep();
    ++preparations.kept;
  } else
    make(K);
}

void Multigrid::make(const GroupOperator &K)
{
  forget_values();
  upkeep.forget();
  ++preparations.made;
  matrix = K.bodies().matrix();
  if (!modes)
    ranks.run("modes", [&]() { modes = make_modes(facts, matrix->OperatorDomainMap()); });
  if (!facts.is_symmetric) {
    ranks.run("symmetric part",
              [&]() { symmetric_part = make_symmetric_part(*matrix, facts.field_of_row()); });
    matrix = symmetric_part.get();
  }
  ranks.run("multigrid", [&]() { make_levels(); });
  was_symmetric = facts.is_symmetric;
  upkeep.made();
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
  if (!upkeep.is_of_earlier())
    return solve_with_new(K, x, b, goal);
  return solve_in_two_attempts(
      K, x, b,
      [&](GroupVector &z, const GroupVector &r) {
        return iterate(K, z, r, goal, upkeep.gives_up(r.l2_norm(), goal));
      },
      [&](GroupVector &z, const GroupVector &r) {
        make(K);
        return solve_with_new(K, z, r, goal);
      });
}

/// With levels of the present matrix.
unsigned int Multigrid::solve_with_new(const GroupOperator &K, GroupVector &x, const GroupVector &b,
                                       const double goal)
{
  if (is_slow || by_degree || facts.has_multipliers) // whose Schur complement may be what is slow
    return iterate(K, x, b, goal, {});

  const unsigned int n_between_checks = 8;
  const double most_per_decade = 3; // of the residual: 30 iterations for the usual tolerance
  const double norm = b.l2_norm();
  const auto will_take_too_many = [&](const unsigned int n, const double residual) {
    return n > 0 && n % n_between_checks == 0 && n > most_per_decade * std::log10(norm / residual);
  };
  return solve_in_two_attempts(
      K, x, b,
      [&](GroupVector &z, const GroupVector &r) { return iterate(K, z, r, goal, will_take_too_many); },
      [&](GroupVector &z, const GroupVector &r) {
        is_slow = true;
        ranks.run("multigrid", [this]() { make_aggregation(); });
        upkeep.made();
        return iterate(K, z, r, goal, {});
      });
}

unsigned int Multigrid::iterate(const GroupOperator &K, GroupVector &x, const GroupVector &b,
                                const double goal, const GivesUp &gives_up)
{
  const auto cycle = [this](GroupVector &solution, const GroupVector &right_hand_side) {
    Epetra_Vector z(View, solution.trilinos_vector(), 0);
    const Epetra_Vector r(View, right_hand_side.trilinos_vector(), 0);
    by_degree ? by_degree->vmult(z, r) : aggregation->vmult(z, r);
  };
  const unsigned int n_iterations = solve_by_iteration(K, facts, cycle, x, b, goal, gives_up);
  upkeep.solved(n_iterations, std::log10(b.l2_norm() / goal));
  return n_iterations;
}

namespace {
[[maybe_unused]] const bool registered = SolverCatalogue::add<Multigrid>(
    "multigrid", "ML as preconditioner of CG, or of GMRES if the group is not symmetric or has multipliers.");
}

} // namespace dovetail
