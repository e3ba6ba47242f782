// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// CG or GMRES with products in place of a matrix: the tangent of the cells is applied by sum factorisation,
// that of ties and boundaries is a sparse matrix beside it. The preconditioner smooths by Chebyshev's
// polynomial of the diagonal, and solves for functions of degree one by smoothed aggregation, or by their
// factors where an iteration is slow.
//
//     subsection Linear solver
//       set Type = matrix-free
//     end
//
// M. Kronbichler, K. Kormann: A generic interface for parallel cell-based finite element operator
// application, 2012.

#include "outlook.h"
#include "semicoarsening.h"
#include "soft_leaders.h"
#include "upkeep.h"

#include <dovetail/solve/free_memory.h>
#include <dovetail/solve/krylov.h>

#include <deal.II/lac/solver_control.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>

namespace dovetail {

namespace {

/// The symmetric part of entries and cells; of cells in single precision, if that is allowed.
class SumLevel : public LevelOperator
{
public:
  SumLevel(const GroupOperator &K, const GroupFacts &facts, const bool is_rough)
      : cells(*K.cells()), entries(K.entries()), is_rough(is_rough)
  {
    if (!facts.is_symmetric) {
      symmetric_entries = make_symmetric_part(*entries, facts.field_of_row());
      entries = symmetric_entries.get();
    }
  }

  const Epetra_Map &rows() const override { return entries->OperatorDomainMap(); }
  void vmult(Epetra_Vector &y, const Epetra_Vector &x) const override
  {
    entries->Multiply(false, x, y);
    if (is_rough)
      cells.add_rough_product(x, y);
    else
      cells.add_product(1., x, y, true);
  }
  void diagonal(Epetra_Vector &values) const override
  {
    LevelEntries(*entries).diagonal(values);
    cells.add_diagonal(values);
  }
  std::unique_ptr<Approximation> approximation() const override
  {
    Epetra_Vector values(rows());
    diagonal(values);
    return cells.cellwise_approximation(values, is_rough);
  }
  std::unique_ptr<Epetra_CrsMatrix> restricted(const Prolongation &P) const override
  {
    return cells.restricted(P, *restrict_few_rows(*entries, P));
  }
  bool is_condensed(const unsigned int row) const override { return cells.condensed()[row]; }
  void leave_single_precision() { is_rough = false; }

private:
  const PartOperator &cells;
  const Epetra_CrsMatrix *entries;
  std::unique_ptr<Epetra_CrsMatrix> symmetric_entries; ///< if they are not
  bool is_rough;
};

const double slow = 40; ///< as many iterations

} // namespace

class MatrixFree : public GroupSolver
{
public:
  MatrixFree(const Section &, const GroupFacts &facts) : facts(facts), upkeep(facts) {}

  std::string description() const override
  {
    return describe_iteration(facts, "matrix-free products and multigrid");
  }
  std::string objection() const override
  {
    return facts.why_entries.empty() ? facts.why_matrix : facts.why_entries;
  }
  bool needs_entries() const override { return false; }
  std::optional<ExpectedCost> expected_cost(const GroupSize &size) const override
  {
    const double share = facts.is_symmetric ? 1 : 2, fields = size.n_modes > 1 ? 1.5 : 1;
    return {
        {5000 * share * size.n_unknowns, 20000 * share * fields * size.n_unknowns, 1000 * size.n_unknowns}};
  }
  void prepare(const GroupOperator &K, const Agreement &ranks) override;
  unsigned int solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal) override;
  void forget() override
  {
    expected = 0;
    cycle.reset();
    level.reset();
    upkeep.forget();
    coarse = CoarseSolve::by_levels;
    lacks_factors = needs_digits = false;
  }

private:
  void make(const GroupOperator &K);
  CoarseSolve next_for(double n_expected, unsigned int n) const;
  unsigned int solve_with_new(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal);
  unsigned int iterate(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal,
                       const Upkeep::GivesUp &gives_up);

  const GroupFacts &facts;
  Agreement ranks;
  Upkeep upkeep;
  std::unique_ptr<SumLevel> level;
  std::unique_ptr<DegreeCoarsening> cycle;
  CoarseSolve coarse = CoarseSolve::by_levels, made = coarse; ///< what is wanted, and what the cycle has
  bool lacks_factors = false; ///< they failed, for instance for lack of memory
  bool needs_digits = false;  ///< those of double precision
};

void MatrixFree::prepare(const GroupOperator &K, const Agreement &all_ranks)
{
  ranks = all_ranks;
  upkeep.prepare([&]() { make(K); }, preparations);
}

/// What rounding leaves of a rotation holds a stiff body that moves with a soft or a slender one.
void MatrixFree::make(const GroupOperator &K)
{
  cycle.reset();
  ranks.run("level", [&]() {
    needs_digits = facts.has_large_contrast() || needs_digits;
    level = std::make_unique<SumLevel>(K, facts, !needs_digits);
  });
  const auto make_cycle = [&]() {
    made = coarse;
    cycle = coarsen_degree(
        *level, facts,
        [this](const Epetra_Map &map, const Selection *rows) { return make_modes(facts, map, rows); },
        DegreeCoarsening::usual_smoother(*level, facts.degree, false), made);
  };
  if (coarse == CoarseSolve::by_factors) {
    if (ranks.succeeds("factors of degree one", make_cycle))
      return;
    lacks_factors = true;
    coarse = CoarseSolve::by_levels;
  }
  ranks.run("multigrid", make_cycle);
}

unsigned int MatrixFree::solve(const GroupOperator &K, GroupVector &x, const GroupVector &b,
                               const double goal)
{
  return upkeep.solve(
      K, x, b, goal, [&]() { make(K); }, preparations,
      [&](GroupVector &z, const GroupVector &r, const Upkeep::GivesUp &gives_up) {
        return iterate(K, z, r, goal, gives_up);
      },
      [&](GroupVector &z, const GroupVector &r) { return solve_with_new(K, z, r, goal); });
}

/// What to go on with where so many iterations are expected: A_1 is factorised if that pays, or coarsened
/// again, within bodies. @param n those that are done
CoarseSolve MatrixFree::next_for(const double n_expected, const unsigned int n) const
{
  const double work_per_unknown = 1500;
  if (coarse == CoarseSolve::by_factors || !(n_expected > slow))
    return coarse;
  if (!lacks_factors && cycle->factors_pay(n_expected - n, work_per_unknown * facts.n_unknowns))
    return CoarseSolve::by_factors;
  return made == CoarseSolve::by_levels && has_mixed_bodies(facts, GroupFacts::large_contrast)
             ? CoarseSolve::within_bodies
             : coarse;
}

unsigned int MatrixFree::solve_with_new(const GroupOperator &K, GroupVector &x, const GroupVector &b,
                                        const double goal)
{
  const double usual_decades = 10;
  CoarseSolve next = coarse;
  bool wants_digits = false;
  Outlook outlook;
  expected = 0;
  const auto gives_up = [&](const unsigned int n, const double residual) {
    outlook.see(n, residual);
    if (!outlook.is_time_to_look())
      return false;
    const double n_expected = outlook.iterations_since_largest(usual_decades);
    wants_digits = !needs_digits && !(n_expected <= slow);
    if (wants_digits)
      return true;
    next = next_for(n_expected, n);
    const bool is_hopeless = next == coarse && outlook.is_hopeless(goal, facts.most_iterations);
    expected = is_hopeless ? outlook.iterations_to(goal) : 0;
    return next != coarse || is_hopeless;
  };
  return solve_in_two_attempts(
      K, x, b, [&](GroupVector &z, const GroupVector &r) { return iterate(K, z, r, goal, gives_up); },
      [&](GroupVector &z, const GroupVector &r) {
        if (wants_digits) {
          needs_digits = true;
          level->leave_single_precision();
          return solve_with_new(K, z, r, goal);
        }
        if (next == coarse)
          throw dealii::SolverControl::NoConvergence(0, r.l2_norm());
        coarse = next;
        upkeep.forget();
        make(K);
        upkeep.made();
        return solve_with_new(K, z, r, goal);
      });
}

unsigned int MatrixFree::iterate(const GroupOperator &K, GroupVector &x, const GroupVector &b,
                                 const double goal, const Upkeep::GivesUp &gives_up)
{
  const double norm = b.l2_norm(), unit = norm > 0 ? norm : 1.; // single precision may not hold r
  const auto apply = [this, unit](GroupVector &z, const GroupVector &r) {
    Epetra_Vector result(View, z.trilinos_vector(), 0), scaled(Copy, r.trilinos_vector(), 0);
    scaled.Scale(1 / unit);
    cycle->vmult(result, scaled);
    result.Scale(unit);
  };
  CourseOfIteration course;
  const unsigned int n_iterations = solve_by_iteration(K, facts, apply, x, b, goal, gives_up, &course);
  give_back_freed_memory();
  upkeep.solved(n_iterations, course.decades);
  met_negative = course.met_negative;
  return n_iterations;
}

namespace {
[[maybe_unused]] const bool registered = SolverCatalogue::add<MatrixFree>(
    "matrix-free", "Products with the cells' tangent by sum factorisation, and multigrid; for one field on "
                   "quadrilaterals or hexahedra, degree 2 and higher, without pressures.");
}

} // namespace dovetail
