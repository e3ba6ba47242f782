// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// CG or GMRES with smoothed aggregation, for a degree above one after a first coarsening to the functions of
// degree one. A group that is not symmetric is preconditioned by the symmetric part of its matrix. Where
// bodies are stiff and soft, K is multiplied cell by cell if that is possible, since rounding of its entries
// moves stiff bodies, and the matrix serves the preconditioner alone.
//
// At degree one the smoothers are made of the diagonal, until an iteration is slow: then, and from then on,
// of incomplete factorisations, which cost more and smooth what stretched cells and the like leave. If that
// is slow too, levels are made along short couplings only. For a degree above one, the matrix of the
// functions of degree one is factorised where an iteration is slow and that pays. The levels of one matrix
// are kept for the next ones while that pays.
//
//     subsection Linear solver
//       set Type = multigrid
//     end

#include "degree_coarsening.h"
#include "mesh_coarsening.h"
#include "outlook.h"
#include "semicoarsening.h"
#include "soft_leaders.h"
#include "upkeep.h"

#include <dovetail/solve/krylov.h>

#include <deal.II/lac/solver_control.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_MultiVector.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

namespace dovetail {

namespace {

/// Whether the finest level may multiply in single precision, as the others do. What rounding leaves of a
/// rotation holds a stiff body, which must not be more than soft ones do. The matrix of a scalar has few
/// entries per row, and fewer iterations than would pay for the copy.
bool may_be_rounded(const GroupFacts &facts)
{
  return facts.n_components > 1 &&
         (!facts.contrast || facts.contrast() * std::numeric_limits<float>::epsilon() < 1);
}

} // namespace

class Multigrid : public GroupSolver
{
public:
  Multigrid(const Section &, const GroupFacts &facts) : facts(facts), upkeep(facts) {}

  std::string description() const override
  {
    const bool has_entries = needs_entries() || facts.has_multipliers;
    return describe_iteration(facts, has_entries ? "multigrid" : "multigrid and products of cells");
  }
  bool needs_entries() const override { return !facts.why_entries.empty() || !facts.expects_contrast; }
  bool serves(bool) const override { return true; }
  std::optional<ExpectedCost> expected_cost(const GroupSize &size) const override
  {
    const double share = facts.is_symmetric ? 1 : 2;           // GMRES, and the symmetric part
    const double n_matrices = needs_entries() ? share - 1 : 1; // that it makes
    return {{130 * share * size.n_entries, 290 * share * size.n_entries,
             12 * n_matrices * size.n_entries + 75 * size.n_modes * size.n_modes * size.n_unknowns}};
  }
  void prepare(const GroupOperator &K, const Agreement &all_ranks) override;
  unsigned int solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal) override;
  void forget() override
  {
    expected = 0;
    forget_values();
    upkeep.forget();
    modes.reset();
    matrix = nullptr;
    way = Way();
    lacks_factors = false;
  }

private:
  using Lines = Semicoarsening::Lines;
  enum class Means {
    usual,         ///< smoothers made of the diagonal
    factorisation, ///< of incomplete factorisations, and coarsening along short couplings where that is cheap
    semicoarsening ///< and wherever some couplings are long
  };
  struct Way
  {
    Means means = Means::usual; ///< until an iteration is slow with them
    bool has_factors = false;   ///< of the functions of degree one
    bool has_digits = false;    ///< those of double precision, on the finest level of a degree above one

    bool operator==(const Way &other) const
    {
      return means == other.means && has_factors == other.has_factors && has_digits == other.has_digits;
    }
  };

  void forget_values();
  void make(const GroupOperator &K);
  void round_finest();
  void make_levels();
  void make_agreed_levels();
  std::unique_ptr<Cycle> make_cycle_of_degree_one(Cycle::Finest A,
                                                  std::shared_ptr<const Epetra_MultiVector> modes,
                                                  std::vector<GroupFacts::Place> places, bool is_finest,
                                                  Lines lines) const;
  std::vector<MeshStep> mesh_steps() const;
  bool is_stretched() const;
  Way way_for(double n_expected, unsigned int n) const;
  void change_to(const Way &next);
  unsigned int solve_with_new(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal);
  unsigned int iterate(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal,
                       const Upkeep::GivesUp &gives_up);

  const GroupFacts &facts;
  Agreement ranks;
  Upkeep upkeep;
  std::shared_ptr<const Epetra_MultiVector> modes;
  std::unique_ptr<Epetra_CrsMatrix> symmetric_part; ///< where K is not symmetric, or has products
  const Epetra_CrsMatrix *matrix = nullptr;         ///< that is preconditioned
  const Epetra_CrsMatrix *added_rows = nullptr;     ///< as of GroupOperator
  Way way;
  bool lacks_factors = false; ///< they failed, for instance for lack of memory
  bool may_round = false;     ///< the finest level may multiply in single precision
  /// Stiff and soft bodies, more than two. At degree one, no aggregate has nodes of two.
  bool is_mixed = false;
  bool keeps_to_bodies = false; ///< no aggregate of by_degree has
  std::unique_ptr<Cycle> cycle;
  std::unique_ptr<MatrixLevel> finest;         ///< of by_degree
  std::unique_ptr<DegreeCoarsening> by_degree; ///< instead, for a degree above one
  ChebyshevSmoother *of_finest = nullptr;      ///< of by_degree
  static constexpr ChebyshevSmoother::Range factorisation_of_finest{6, 80};
};

void Multigrid::forget_values()
{
  cycle.reset();
  by_degree.reset();
  of_finest = nullptr;
  finest.reset();
  symmetric_part.reset();
}

void Multigrid::prepare(const GroupOperator &K, const Agreement &all_ranks)
{
  ranks = all_ranks;
  bool is_made = false;
  upkeep.prepare(
      [&]() {
        make(K);
        is_made = true;
      },
      preparations);
  if (!is_made && !symmetric_part) // the levels are kept, the entries are new
    round_finest();
}

void Multigrid::make(const GroupOperator &K)
{
  forget_values();
  const GroupOperator &bodies = K.bodies();
  matrix = bodies.entries();
  added_rows = bodies.added_rows();
  if (!facts.is_symmetric) {
    ranks.run("symmetric part",
              [&]() { symmetric_part = make_symmetric_part(*matrix, facts.field_of_row()); });
    matrix = symmetric_part.get();
  }
  if (const PartOperator *const cells = bodies.cells()) {
    ranks.run("matrix", [&]() { symmetric_part = make_matrix(*cells, *matrix); });
    matrix = symmetric_part.get();
  }
  ranks.run("modes", [&]() { modes = make_modes(facts, matrix->OperatorDomainMap()); });
  ranks.run("multigrid", [&]() {
    is_mixed =
        has_mixed_bodies(facts, facts.degree == 1 ? GroupFacts::small_contrast : GroupFacts::large_contrast);
    if (facts.degree == 1 && (is_mixed || way.means == Means::usual) && is_stretched()) {
      way.means = std::max(way.means, Means::factorisation);
      is_mixed = false;
    }
    may_round = may_be_rounded(facts);
    finest = added_rows == nullptr ? std::make_unique<MatrixLevel>(*matrix)
                                   : std::make_unique<AugmentedLevel>(*matrix, *added_rows);
  });
  round_finest();
  make_agreed_levels();
}

/// It has degrees above one; levels of degree one round it themselves.
void Multigrid::round_finest()
{
  if (facts.degree > 1)
    ranks.run("finest level", [this]() { finest->round(may_round && !way.has_digits); });
}

/// On all ranks; without factors if these fail.
void Multigrid::make_agreed_levels()
{
  if (way.has_factors && ranks.succeeds("factors of degree one", [this]() { make_levels(); }))
    return;
  lacks_factors = lacks_factors || way.has_factors;
  way.has_factors = false;
  ranks.run("multigrid", [this]() { make_levels(); });
}

void Multigrid::make_levels()
{
  cycle.reset();
  by_degree.reset();
  of_finest = nullptr;
  const auto part_of_modes = [this](const Epetra_Map &map, const Selection *rows) {
    return rows != nullptr ? select_rows(*modes, map, *rows) : std::make_unique<Epetra_MultiVector>(*modes);
  };
  if (facts.degree > 1 && facts.linear_part) {
    auto smoother = DegreeCoarsening::usual_smoother(*finest, facts.degree, added_rows != nullptr);
    of_finest = smoother.get();
    if (way.means != Means::usual)
      of_finest->take_factorisation(finest->entries(), factorisation_of_finest);
    CoarseSolve coarse = way.has_factors                         ? CoarseSolve::by_factors
                         : is_mixed && way.means != Means::usual ? CoarseSolve::within_bodies
                                                                 : CoarseSolve::by_levels;
    by_degree = coarsen_degree(*finest, facts, part_of_modes, std::move(smoother), coarse);
    keeps_to_bodies = coarse == CoarseSolve::within_bodies;
  } else if (const auto [leaders, are_means] = SoftLeaders::find(facts, finest->rows()); leaders)
    by_degree =
        leaders->coarsen(*finest, facts, part_of_modes, nullptr, [this](Cycle::Finest A_1, auto... level) {
          return make_cycle_of_degree_one(std::move(A_1), std::move(level)..., false, Lines::whole_if_cheap);
        });
  else
    cycle = coarsen_mesh(
        added_rows == nullptr ? Cycle::Finest(*matrix, may_round)
                              : Cycle::Finest(with_added_rows(*matrix, *added_rows)),
        mesh_steps(), modes,
        way.means == Means::usual && !is_mixed ? std::vector<GroupFacts::Place>() : facts.known_places(),
        [this, lines = are_means ? Lines::whole : Lines::whole_if_cheap](Cycle::Finest A, auto... level) {
          return make_cycle_of_degree_one(std::move(A), std::move(level)..., true, lines);
        });
  if (way.means == Means::factorisation && cycle && cycle->is_semicoarsening())
    way.means = Means::semicoarsening;
}

/// At degree one, of vector fields. Where these are slow, aggregates take the place of parents. The vertices
/// of hexahedra that were divided serve wherever cells are stretched, scalars as well.
std::vector<MeshStep> Multigrid::mesh_steps() const
{
  if (!facts.mesh_levels || !facts.linear_part || added_rows != nullptr ||
      (is_mixed && facts.has_large_contrast()))
    return {};
  const bool is_usual = way.means == Means::usual;
  if (is_usual && modes->NumVectors() == 1)
    return {};
  const MeshLevels levels = facts.mesh_levels(is_usual);
  if (!is_usual && !levels.has_parts)
    return {};
  Selection all(matrix->NumMyRows());
  std::iota(all.begin(), all.end(), 0u);
  return make_mesh_steps(levels, facts.linear_part(), finest->rows(), std::move(all), true);
}

bool Multigrid::is_stretched() const
{
  const std::vector<GroupFacts::Place> places = facts.known_places();
  return are_all_known(places, *matrix) && are_mostly_stretched(*matrix, nodes_of_rows(places));
}

std::unique_ptr<Cycle>
Multigrid::make_cycle_of_degree_one(Cycle::Finest A, std::shared_ptr<const Epetra_MultiVector> its_modes,
                                    std::vector<GroupFacts::Place> places, const bool is_finest,
                                    const Lines lines) const
{
  const auto with_diagonal = [this](const LevelEntries &level, const Cycle::LevelFacts &of_level) {
    const ChebyshevSmoother::Range usual{2, 10}, of_mixed{4, 20}, augmented{10, 40};
    const auto range = added_rows != nullptr ? augmented : is_mixed ? of_mixed : usual;
    return ChebyshevSmoother::with_diagonal(level, range, of_level.known_eigenvalue);
  };
  if (way.means == Means::usual && is_mixed)
    return make_cycle(std::move(A), std::move(its_modes), std::move(places), Semicoarsen::always,
                      with_diagonal, with_diagonal, Lines::in_parts);
  if (way.means == Means::usual)
    return std::make_unique<SmoothedAggregation>(std::move(A), std::move(its_modes), with_diagonal);
  return make_cycle_with_factorisations(std::move(A), std::move(its_modes), std::move(places),
                                        way.means == Means::semicoarsening ? Semicoarsen::if_stretched
                                                                           : Semicoarsen::if_cheap,
                                        is_finest, lines);
}

/// What to go on with where so many iterations are expected with the present means. A set-up costs some
/// iterations. Eight of them do not tell 20 from 35. @param n those that are done
Multigrid::Way Multigrid::way_for(const double n_expected, const unsigned int n) const
{
  const double very_slow = 100;
  Way next = way;
  if (facts.degree > 1) {
    const double slow = 40, work_of_entry = DegreeCoarsening::work_of_level_entry;
    const bool has_means = facts.has_multipliers || way.means != Means::usual, // of K without multipliers
        factors_pay = !way.has_factors && !lacks_factors && by_degree &&
                      by_degree->factors_pay(n_expected - n, work_of_entry * matrix->NumGlobalNonzeros64());
    if (factors_pay && (n_expected > very_slow || (has_means && n > Outlook::n_between_looks)))
      next.has_factors = true;
    else if (n_expected > slow && !has_means)
      next.means = Means::factorisation;
    if (may_round && (n_expected > very_slow || (n_expected > slow && has_means)))
      next.has_digits = true;
    return next;
  }
  const bool gains_little = is_mixed || facts.has_multipliers; // by factorisations: hardly an iteration
  const double slow = gains_little ? 60 : 30;
  if (n_expected > (way.means == Means::usual ? very_slow : slow))
    next.means = Means::semicoarsening;
  else if (n_expected > slow)
    next.means = Means::factorisation;
  return next;
}

unsigned int Multigrid::solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, const double goal)
{
  return upkeep.solve(
      K, x, b, goal, [&]() { make(K); }, preparations,
      [&](GroupVector &z, const GroupVector &r, const Upkeep::GivesUp &gives_up) {
        return iterate(K, z, r, goal, gives_up);
      },
      [&](GroupVector &z, const GroupVector &r) { return solve_with_new(K, z, r, goal); });
}

/// With levels of the present matrix. From time to time the iterations of ten decades are extrapolated, which
/// are those of the usual tolerance.
unsigned int Multigrid::solve_with_new(const GroupOperator &K, GroupVector &x, const GroupVector &b,
                                       const double goal)
{
  const double usual_decades = 10;
  Outlook outlook;
  Way next = way;
  expected = 0;
  const auto gives_up = [&](const unsigned int n, const double residual) {
    outlook.see(n, residual);
    if (!outlook.is_time_to_look())
      return false;
    const bool is_slow = !(way_for(outlook.iterations_since_largest(usual_decades), n) == way);
    next = is_slow ? way_for(outlook.iterations(usual_decades), n) : way;
    const bool is_hopeless = is_slow ? outlook.is_long(goal, facts.most_before_change)
                                     : outlook.is_hopeless(goal, facts.most_iterations);
    expected = is_hopeless ? outlook.iterations_to(goal) : 0;
    if (is_hopeless)
      next = way;
    return is_slow || is_hopeless;
  };
  return solve_in_two_attempts(
      K, x, b, [&](GroupVector &z, const GroupVector &r) { return iterate(K, z, r, goal, gives_up); },
      [&](GroupVector &z, const GroupVector &r) {
        if (next == way)
          throw dealii::SolverControl::NoConvergence(0, r.l2_norm());
        change_to(next);
        return solve_with_new(K, z, r, goal);
      });
}

/// The levels of A_1 stay if only the smoother of the finest level changes, unless they are to keep to bodies
/// from then on, as those of mixed ones, and do not yet.
void Multigrid::change_to(const Way &next)
{
  const bool keeps_levels = of_finest != nullptr && next.has_factors == way.has_factors &&
                            (way.has_factors || !is_mixed || keeps_to_bodies);
  const bool has_new_means = next.means != way.means, has_new_digits = next.has_digits != way.has_digits;
  way = next;
  upkeep.forget();
  if (has_new_digits)
    round_finest();
  if (!keeps_levels)
    make_agreed_levels();
  else if (has_new_means)
    ranks.run("multigrid",
              [this]() { of_finest->take_factorisation(finest->entries(), factorisation_of_finest); });
  upkeep.made();
}

unsigned int Multigrid::iterate(const GroupOperator &K, GroupVector &x, const GroupVector &b,
                                const double goal, const Upkeep::GivesUp &gives_up)
{
  const auto apply = [this](GroupVector &solution, const GroupVector &right_hand_side) {
    Epetra_Vector z(View, solution.trilinos_vector(), 0);
    const Epetra_Vector r(View, right_hand_side.trilinos_vector(), 0);
    by_degree ? by_degree->vmult(z, r) : cycle->vmult(z, r);
  };
  CourseOfIteration course;
  const unsigned int n_iterations = solve_by_iteration(K, facts, apply, x, b, goal, gives_up, &course);
  upkeep.solved(n_iterations, course.decades);
  met_negative = course.met_negative;
  return n_iterations;
}

namespace {
[[maybe_unused]] const bool registered = SolverCatalogue::add<Multigrid>(
    "multigrid",
    "Smoothed aggregation as preconditioner of CG, or of GMRES if the group is not symmetric or has "
    "multipliers.");
}

} // namespace dovetail
