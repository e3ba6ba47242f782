// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/linear_solver.h>

#include "group_system.h"

#include <boost/scope_exit.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace dovetail {

namespace {

const NoteName of_solver("linear solver", "another solver takes over from the one that was chosen");

const std::string automatic = "automatic", name_of_direct = "direct", name_of_multigrid = "multigrid",
                  name_of_matrix_free = "matrix-free";

const double few_iterations = 14, usual_iterations = 30, many_iterations = 100;
const double few_entries = 6e5;  ///< up to which factors cost about as much as products
const double large_share = 0.15; ///< of a row, for what an unknown follows

/// About, of quadrilaterals or hexahedra: (degree + 2)^dim nodes. Products take about the same time for each
/// degree, and what makes or factorises entries takes time for each of them.
double entries_of_row(const GroupFacts &facts)
{
  return facts.n_components * std::pow(facts.degree + 2., facts.dim);
}

/// A solver of a group, and whether it has seen the present values of the matrix.
struct Member
{
  std::string name;
  std::unique_ptr<GroupSolver> solver;
  bool is_prepared = false;
};

std::vector<std::string> all_types()
{
  std::vector<std::string> types = SolverCatalogue::names();
  types.insert(types.begin(), automatic);
  return types;
}

/// What rounding leaves of K x, as doc/theory/convergence.md does it, with the largest row sum of K.
double rounding(const MergedMatrix &K, const GroupVector &x)
{
  const auto [largest_sum, largest_number] = K.largest_row();
  return std::numeric_limits<double>::epsilon() / 2 * std::sqrt(largest_number) * largest_sum * x.l2_norm();
}

} // namespace

/// One group with the solver that was chosen for it, and the one that takes over if that fails.
struct LinearSolver::Group
{
  Group(LinearSolver &owner, SolveGroup group) : owner(owner), system(std::move(group)) {}

  Member make(const std::string &name) const;
  void choose_solver();
  [[noreturn]] void refuse(const std::string &name, const std::string &reason) const;
  void set_matrix(const Matrix &matrix);
  void forget_matrix();
  bool is_direct_by_size() const;
  double iterations_of_direct() const;
  double iterations_worth_factors() const;
  double most_before_change() const;
  bool is_matrix_free_by_degree() const;
  bool needs_entries() const { return takes_direct() || must_have_entries || chosen.solver->needs_entries(); }
  bool lacks_entries() const
  {
    return (is_direct || must_have_entries || !chosen.solver->serves(true)) && system.plain().has_products();
  }
  bool lacks_products() const { return wants_products && !system.plain().has_products(); }
  bool prepare(Member &member, const GroupOperator &K);
  std::optional<unsigned int> iterate(GroupVector &x, const GroupVector &b);
  unsigned int iterate_to_residual(GroupVector &x, const GroupVector &b);
  bool is_rounding(double residual, const GroupVector &x, const GroupVector &b) const;
  bool solve_directly(GroupVector &x, const GroupVector &b);
  std::optional<unsigned int> solve(GroupVector &x, const GroupVector &b);
  void be_patient();
  double residual_by_rounding(const GroupVector &x, const GroupVector &b) const;
  GroupFacts::NextGoal make_next_goal(const GroupVector &x, const GroupVector &b, Vector &dx,
                                      const Demand &demand) const;
  bool takes_direct() const { return is_decided ? is_direct : is_direct_by_size(); }
  std::string description() const;

  LinearSolver &owner;
  GroupSystem system;
  Member chosen, direct;
  bool is_direct = false;
  bool is_decided = false;
  bool iteration_failed = false;
  bool was_slow = false;          ///< and did not fail
  bool is_patient = false;        ///< since the direct solver is no help
  bool wants_products = false;    ///< likewise, and the iteration took products
  bool must_have_entries = false; ///< since multipliers stay
  double ended_at = 0;            ///< the relative residual of the last iteration
};

Member LinearSolver::Group::make(const std::string &name) const
{
  return {name, SolverCatalogue::create_member(
                    name, owner.section, name == name_of_direct ? system.facts() : system.iterated_facts())};
}

void LinearSolver::Group::choose_solver()
{
  direct = make(name_of_direct);
  const bool is_open = owner.type == automatic || owner.type == name_of_direct;
  chosen = make(!is_open ? owner.type : is_matrix_free_by_degree() ? name_of_matrix_free : name_of_multigrid);
  if (const std::string objection = chosen.solver->objection(); !objection.empty())
    refuse(chosen.name, objection);
}

void LinearSolver::Group::refuse(const std::string &name, const std::string &reason) const
{
  std::string others = automatic;
  for (const std::string &other : SolverCatalogue::names())
    if (other != name && make(other).solver->objection().empty())
      others += ", " + other;
  owner.section.fail("Type", "cannot be " + name + " for " + system.facts().name + ": " + reason +
                                 ". Take one of: " + others + ".");
}

/// As long as so many iterations takes the direct solver, by nested dissection (George 1973). It factorises a
/// body from the smallest cross-section on, which m nodes across and n nodes in all make about (m n)^(1/2)
/// large: (m n)^(3/2) operations. Measured: doc/theory/linear_solvers.md.
double LinearSolver::Group::iterations_of_direct() const
{
  const GroupFacts &facts = system.facts();
  const double n = facts.n_unknowns, share = facts.is_positive_definite() ? 1 : 2;
  if (facts.dim == 2)
    return share * std::log2(n + 1);
  const double of_cube = 0.38 * std::cbrt(n / facts.n_components), // no cross-section has more
      across = facts.shape.nodes_across > 0 ? std::min(facts.shape.nodes_across, of_cube) : std::cbrt(n) / 3;
  return share * 0.01 * std::sqrt(n) * std::pow(across, 1.5);
}

/// From how many iterations on, as iterations_of_direct() counts them, the factors of bodies that are not
/// flat do not pay. An iteration by products takes less time, by the entries of a row. Bodies that are as
/// long as many cubes in a row need more of them.
double LinearSolver::Group::iterations_worth_factors() const
{
  const GroupFacts &facts = system.facts();
  if (!is_matrix_free_by_degree())
    return few_iterations;
  const double n_nodes = static_cast<double>(facts.n_unknowns) / facts.n_components,
               n_of_cube = std::pow(3 * facts.shape.nodes_across, 3);
  return few_iterations * std::pow(3 / (facts.degree + 2.), facts.dim) *
         std::sqrt(facts.n_solves * std::max(1., n_nodes / n_of_cube));
}

/// From how many expected iterations on the direct solver takes over before multigrid tries other means: it
/// takes half as long by iterations_of_direct(), which is right to a factor of 1.5 where shapes are known.
double LinearSolver::Group::most_before_change() const
{
  const GroupFacts &facts = system.facts();
  if (owner.type != automatic || facts.has_multipliers || !(facts.shape.nodes_across > 0))
    return std::numeric_limits<double>::infinity();
  return std::max(usual_iterations, 2 * iterations_of_direct());
}

/// Factorisation wins while the fill is small, and longer for L D L^T: the tables of
/// doc/theory/linear_solvers.md. In thin bodies the fill is small, and in flat ones, also in layers
/// that are flat by themselves, aggregates longer than the thickness leave much to the iteration. Beside
/// products the entries cost, too, unless the bodies may be slender: that takes many iterations. Where
/// unknowns follow many others, which follow others again, coarser matrices are fuller than K.
bool LinearSolver::Group::is_direct_by_size() const
{
  const GroupFacts &facts = system.facts();
  const bool is_cheaper = facts.is_positive_definite(), knows_shape = facts.shape.nodes_across > 0;
  double largest = facts.dim == 2 ? (is_cheaper ? 100000 : 60000) : (is_cheaper ? 12000 : 6000);
  if (is_matrix_free_by_degree() && (knows_shape || facts.n_components == 1))
    largest = std::min(largest, few_entries * std::sqrt(facts.n_solves) /
                                    (entries_of_row(facts) * (is_cheaper ? 1 : 2)));
  const bool is_flat = facts.shape.distance_by_thickness > 0.7 ||
                       (!is_matrix_free_by_degree() && facts.shape.flat_share > 0.8),
             is_filled = facts.n_followed > large_share * entries_of_row(facts) / facts.n_components,
             is_thin = knows_shape &&
                       iterations_of_direct() < (is_flat ? many_iterations : iterations_worth_factors());
  return owner.type == name_of_direct ||
         (owner.type == automatic && !is_patient && (facts.n_unknowns <= largest || is_thin || is_filled));
}

/// Products win over a matrix where rows are long: from degree 2 on.
bool LinearSolver::Group::is_matrix_free_by_degree() const
{
  const GroupFacts &facts = system.facts();
  return facts.why_entries.empty() && facts.why_matrix.empty() && facts.degree >= 2;
}

void LinearSolver::Group::set_matrix(const Matrix &matrix)
{
  system.set_matrix(matrix);
  chosen.is_prepared = direct.is_prepared = false;
  if (lacks_products()) // nobody has made them, but entries
    chosen = make(name_of_multigrid);
  if (!is_decided)
    is_direct = is_direct_by_size();
  // the matrix of a new mesh was made as that of the last one
  wants_products = !is_direct && !chosen.solver->serves(false) && !system.plain().has_products();
  system.smooth_by_products(!chosen.solver->serves(false));
  if (!is_patient)
    system.limit_iterations(std::max(many_iterations, iterations_of_direct()), most_before_change());
  is_decided = true;
  if (is_direct)
    chosen.solver->forget();
}

void LinearSolver::Group::forget_matrix()
{
  chosen.solver->forget();
  direct.solver->forget();
  system.forget_matrix();
  is_decided = iteration_failed;
}

void LinearSolver::Group::be_patient()
{
  is_patient = true;
  const double infinity = std::numeric_limits<double>::infinity();
  system.limit_iterations(infinity, infinity);
}

bool LinearSolver::Group::prepare(Member &member, const GroupOperator &K)
{
  if (!member.is_prepared)
    member.is_prepared =
        owner.ranks.succeeds("preparation", [&]() { member.solver->prepare(K, owner.ranks); });
  return member.is_prepared;
}

/// @return the number of iterations, or nothing if it failed. Where it ended: ended_at. Where that was
/// without multipliers, one with them is tried.
std::optional<unsigned int> LinearSolver::Group::iterate(GroupVector &x, const GroupVector &b)
{
  unsigned int n_iterations = 0;
  const bool has_operator = chosen.is_prepared || owner.ranks.succeeds("operator", [&]() {
    system.make_iterated([&]() { chosen.solver->forget(); });
  });
  if (system.lacks_entries()) {
    if (owner.type == name_of_matrix_free)
      owner.all_notes.push_back(
          of_solver("the multipliers of " + system.facts().name +
                    " stay unknowns, for which the matrix is made; multigrid solves it"));
    must_have_entries = true;
    chosen = make(name_of_multigrid);
    return {};
  }
  const bool is_done = has_operator && chosen.solver->objection().empty() &&
                       prepare(chosen, system.iterated()) &&
                       owner.ranks.succeeds("residual", [&]() { n_iterations = iterate_to_residual(x, b); });
  if (is_done)
    return n_iterations;
  x.reinit(b);
  if (!system.keep_multipliers())
    return {};
  chosen.is_prepared = false;
  return iterate(x, b);
}

/// Iterate from zero until the true residual, not only that of the recurrence, is small, or is what rounding
/// leaves.
unsigned int LinearSolver::Group::iterate_to_residual(GroupVector &x, const GroupVector &b)
{
  const GroupOperator &K = system.iterated();
  const IteratedForm *const form = system.form();
  unsigned int n_iterations = 0;
  GroupVector of_form; // b, if that differs
  if (form != nullptr) {
    of_form = form->right_hand_side(b);
    x.reinit(of_form);
  }
  const GroupVector &given = form != nullptr ? of_form : b;
  const double size = given.l2_norm(), goal = owner.present_tolerance * size;
  double norm = size;
  GroupVector residual, correction; // from the second pass on: memory is scarce while a solver iterates
  x = 0;
  for (unsigned int pass = 0; pass < 3 && norm > goal; ++pass) {
    if (pass > 0)
      correction.reinit(x);
    GroupVector &z = pass == 0 ? x : correction;
    owner.ranks.run("iteration", [&]() {
      n_iterations += chosen.solver->solve(K, z, pass == 0 ? given : residual, goal);
    });
    if (pass > 0)
      x += correction;
    else
      residual.reinit(x);
    K.vmult(residual, x);
    residual.sadd(-1., 1., given);
    const double new_norm = residual.l2_norm();
    if (!std::isfinite(new_norm))
      throw std::runtime_error("the residual is not finite");
    const bool is_done = new_norm <= 2 * goal || new_norm > norm / 10 || is_rounding(new_norm, x, b);
    norm = new_norm;
    if (is_done)
      break;
  }
  ended_at = norm <= 2 * goal || norm <= rounding(system.plain(), x) ? 0 : norm / size;
  if (form != nullptr)
    x = form->solution(x, b);
  return n_iterations;
}

/// Whether a solution that rounding does not disturb could have this residual: another pass would solve for
/// noise.
bool LinearSolver::Group::is_rounding(const double residual, const GroupVector &x, const GroupVector &b) const
{
  const IteratedForm *const form = system.form();
  GroupVector hidden = system.plain().rounding_of_product(form != nullptr ? form->solution(x, b) : x);
  if (form != nullptr)
    hidden = form->sizes_of_residual(hidden);
  return residual <= 2 * hidden.l2_norm();
}

bool LinearSolver::Group::solve_directly(GroupVector &x, const GroupVector &b)
{
  if (lacks_entries())
    return false;
  const GroupOperator &K = system.plain();
  const auto solve = [&](GroupVector &solution, const GroupVector &right_hand_side) {
    return owner.ranks.succeeds("solution", [&]() { direct.solver->solve(K, solution, right_hand_side, 0); });
  };
  if (!prepare(direct, K))
    return false;
  bool is_solved = solve(x, b);
  if (system.facts().has_multipliers && is_solved) { // indefinite: one step of iterative refinement
    GroupVector residual(b), correction(b);
    K.vmult(residual, x);
    residual.sadd(-1., 1., b);
    correction = 0;
    is_solved = solve(correction, residual);
    x += correction;
  }
  return std::isfinite(x.l2_norm()) && is_solved;
}

/// By iteration, or directly if that does not reach its tolerance. Where the direct solver fails, for
/// instance for lack of memory, an iteration that was slow goes on; of one by entries, what it did reach may
/// serve.
std::optional<unsigned int> LinearSolver::Group::solve(GroupVector &x, const GroupVector &b)
{
  const double largest_usable = 1e-4;
  if (lacks_products())
    return {};
  if (is_direct) {
    if (solve_directly(x, b))
      return 1;
    const std::string shortage = direct.solver->shortage();
    if (shortage.empty())
      return {};
    if (owner.type == name_of_direct && !iteration_failed)
      refuse(name_of_direct, shortage);
    owner.all_notes.push_back(of_solver(system.facts().name + " is not solved directly: " + shortage));
    if (iteration_failed && !was_slow)
      return {};
    iteration_failed = is_direct = false;
    be_patient();
    wants_products = !chosen.solver->serves(false);
    if (lacks_products())
      return {};
  }
  const auto n_iterations = iterate(x, b);
  if ((n_iterations && ended_at == 0) || lacks_entries())
    return n_iterations;
  was_slow = chosen.solver->expected_iterations() > 0;

  const GroupVector iterated(x);
  std::ostringstream words;
  words.precision(2);
  words << "the iteration for " << system.facts().name;
  if (n_iterations)
    words << " ended at a relative residual of " << ended_at << " in place of " << owner.present_tolerance;
  else if (was_slow)
    words << " was slow: it expected " << std::lround(chosen.solver->expected_iterations()) << " iterations";
  else
    words << " failed";
  x = 0;
  if (system.plain().has_products()) {
    iteration_failed = is_direct = true;
    owner.all_notes.push_back(of_solver(words.str() + "; MUMPS takes over, for which the matrix is made"));
    return {};
  }
  if (solve_directly(x, b)) {
    iteration_failed = is_direct = true;
    owner.all_notes.push_back(of_solver(words.str() + "; MUMPS solved the system and solves those after it"));
    return 1;
  }
  const std::string shortage = direct.solver->shortage();
  words << ", and MUMPS failed" << (shortage.empty() ? "" : ": " + shortage);
  if (was_slow) {
    be_patient();
    return solve(x, b);
  }
  if (!n_iterations || ended_at > largest_usable) {
    owner.all_notes.push_back(of_solver(words.str()));
    return {};
  }
  x = iterated;
  owner.all_notes.push_back(of_solver(words.str() + "; the result of the iteration is used"));
  return n_iterations;
}

std::string LinearSolver::Group::description() const
{
  return system.facts().name + ": " + (takes_direct() ? direct : chosen).solver->description() +
         (!takes_direct() || !iteration_failed ? ""
          : was_slow                           ? ", after the iteration was slow"
                                               : ", after the iteration failed");
}

LinearSolver::LinearSolver(const Section &section, std::vector<SolveGroup> given_groups, const Choice choice)
    : section(section), types(all_types()),
      type(types[section.choose("Type", types, 0,
                                "automatic: direct, multigrid or matrix-free, by size, shape and degree; "
                                "where an iteration fails or is "
                                "slow, direct takes over [-]")]),
      relative_tolerance(section.read<double>(
          "Relative tolerance", 1e-10,
          "Tolerance of the residual of the linear system, relative to its right-hand side [-]",
          Patterns::Double(0, 1)))
{
  if (choice == Choice::by_entries && type == name_of_matrix_free)
    type = automatic;
  if (section.documenting())
    SolverCatalogue::document(section, GroupFacts());
  for (SolveGroup &group : given_groups) {
    groups.push_back(std::make_unique<Group>(*this, std::move(group)));
    groups.back()->choose_solver();
  }
}

LinearSolver::~LinearSolver() = default;

std::optional<ExpectedCost> LinearSolver::expected_cost(const unsigned int group, const GroupSize &size) const
{
  const Group &its = *groups[group];
  return (its.takes_direct() ? its.direct : its.chosen).solver->expected_cost(size);
}

void LinearSolver::consider_shapes()
{
  for (auto &group : groups)
    group->system.consider_shape();
}

void LinearSolver::consider_constraints()
{
  for (auto &group : groups)
    if (type == automatic)
      group->system.consider_constraints();
}

std::vector<bool> LinearSolver::needs_entries() const
{
  std::vector<bool> result;
  for (const auto &group : groups)
    result.push_back(group->needs_entries());
  return result;
}

bool LinearSolver::lacks_operator() const
{
  return std::any_of(groups.begin(), groups.end(),
                     [](const auto &group) { return group->lacks_entries() || group->lacks_products(); });
}

void LinearSolver::set_matrix(const Matrix &new_matrix)
{
  matrix = &new_matrix;
  ranks.communicator = matrix->get_mpi_communicator();
  for (auto &group : groups)
    group->set_matrix(new_matrix);
}

void LinearSolver::forget_matrix()
{
  for (auto &group : groups)
    group->forget_matrix();
}

std::optional<unsigned int> LinearSolver::solve(Vector &dx, const Vector &right_hand_side)
{
  return solve(dx, right_hand_side, {0, static_cast<unsigned int>(groups.size())});
}

/// The largest residual of a row of K x = b, in units of what rounding leaves of the row.
double LinearSolver::Group::residual_by_rounding(const GroupVector &x, const GroupVector &b) const
{
  const double usual = 100; // of a hundred terms, in each of a hundred updates
  GroupVector residual(b);
  system.plain().vmult(residual, x);
  residual.sadd(-1., 1., b);
  const GroupVector rounding = system.plain().rounding_of_product(x);
  const double *const r = residual.trilinos_vector()[0], *const hidden = rounding.trilinos_vector()[0];
  double largest = 0;
  for (int i = 0; i < residual.trilinos_vector().MyLength(); ++i)
    if (r[i] != 0)
      largest = std::max(largest, std::abs(r[i]) / (usual * hidden[i]));
  return dealii::Utilities::MPI::max(largest, owner.ranks.communicator);
}

/// GroupFacts::next_goal of K x = b. In stiff bodies that move with soft ones rounding may leave a residual
/// far above the goal, which the recurrence does not see: with a large contrast the iteration looks on its
/// way whether all rows are solved to rounding, at residuals where that is to be expected. At the goal itself
/// it goes on while the residual is too large for @p demand, and falls. An iteration that is not the first
/// one finds a correction of x.
GroupFacts::NextGoal LinearSolver::Group::make_next_goal(const GroupVector &x, const GroupVector &b,
                                                         Vector &dx, const Demand &demand) const
{
  const double first_look = 1e-3, far = 1e3, margin = 0.5, slow = 0.9;
  const bool may_round = system.facts().has_large_contrast();
  if (may_round && !demand.ends_at_rounding)
    return {};
  return [=, &x, &b, &dx, &demand, last_goal = 0.,
          last_excess = far](const GroupVector &found, const double goal, const bool begins) mutable {
    if (begins) {
      last_goal = goal;
      return may_round ? std::max(goal, first_look * b.l2_norm()) : goal;
    }
    if (found.all_zero()) // what it begins with is less than the first look
      return last_goal;
    GroupVector all(found);
    if (&found != &x)
      all += x;
    if (system.form() != nullptr)
      all = system.form()->solution(all, b);
    if (may_round) {
      const double size = residual_by_rounding(all, b);
      if (size <= 1)
        return goal;
      if (goal > last_goal)
        return std::max(last_goal, std::min(goal / size, margin * goal));
    }
    if (goal > last_goal) // the iteration has started again
      return last_goal;
    if (!demand.excess)
      return goal;
    system.plain().scatter(all, dx);
    const double excess = demand.excess(dx, system.blocks().blocks);
    const bool is_done = !(excess > 1) || excess > slow * last_excess;
    last_excess = excess;
    return is_done ? goal : margin * goal / excess;
  };
}

std::optional<unsigned int> LinearSolver::solve(Vector &dx, const Vector &right_hand_side,
                                                const Demand &demand)
{
  unsigned int n_iterations = 0;
  present_tolerance = std::max(relative_tolerance, demand.enough);
  dx = 0;
  for (unsigned int g = demand.first_group; g < demand.end_group; ++g) {
    GroupSystem &system = groups[g]->system;
    GroupVector b = system.plain().vector(), x(b); // one map: a copy that asks no other rank
    if (g == demand.first_group)
      system.plain().gather(right_hand_side, b);
    else {
      Vector rest = right_hand_side;
      for (unsigned int before = demand.first_group; before < g; ++before)
        matrix->subtract_product(system.blocks().blocks, groups[before]->system.blocks().blocks, dx, rest);
      system.plain().gather(rest, b);
    }
    std::optional<unsigned int> block_group = 0;
    if (b.l2_norm() > 0) {
      ++n_solves;
      BOOST_SCOPE_EXIT_ALL(&system)
      {
        system.set_next_goal({}); // which refers to what is here
      };
      system.set_next_goal(groups[g]->make_next_goal(x, b, dx, demand));
      block_group = groups[g]->solve(x, b);
    }
    if (!block_group)
      return {};
    n_iterations += *block_group;
    system.plain().scatter(x, dx);
  }
  return n_iterations;
}

unsigned int LinearSolver::first_with_stiff_and_soft(const unsigned int first_group,
                                                     const unsigned int end_group) const
{
  unsigned int g = first_group;
  while (g < end_group && !groups[g]->system.has_stiff_and_soft_bodies())
    ++g;
  return g;
}

bool LinearSolver::is_symmetric(const unsigned int group) const
{
  return groups[group]->system.facts().is_symmetric;
}

std::optional<unsigned long> LinearSolver::n_negative_eigenvalues(const unsigned int group) const
{
  const Group &g = *groups[group];
  const Member &member = g.is_direct ? g.direct : g.chosen;
  return member.is_prepared ? member.solver->n_negative_eigenvalues() : std::nullopt;
}

bool LinearSolver::iterates() const
{
  return std::any_of(groups.begin(), groups.end(), [](const auto &group) {
    return !(group->is_decided ? group->is_direct : group->is_direct_by_size());
  });
}

bool LinearSolver::has_met_negative(const unsigned int group) const
{
  const Group &g = *groups[group];
  const Member &member = g.is_direct ? g.direct : g.chosen;
  return member.is_prepared && member.solver->has_met_negative();
}

LinearSolver::Counts LinearSolver::counts() const
{
  Counts result{n_solves, {}};
  for (const auto &group : groups)
    for (const Member *member : {&group->chosen, &group->direct}) {
      result.preparations[member->name].made += member->solver->counts().made;
      result.preparations[member->name].kept += member->solver->counts().kept;
    }
  return result;
}

void LinearSolver::prefer_direct(const std::string &reason)
{
  for (auto &group : groups) {
    if (!group->is_direct && !reason.empty())
      all_notes.push_back(
          of_solver(reason + "; MUMPS solves " + group->system.facts().name + " from now on"));
    group->iteration_failed = group->iteration_failed || !group->is_direct;
    group->is_direct = group->is_decided = true;
  }
}

void LinearSolver::set_fault(std::function<void(const std::string &place)> fault)
{
  ranks.fault = std::move(fault);
}

std::vector<std::string> LinearSolver::description() const
{
  std::vector<std::string> lines;
  for (const auto &group : groups)
    lines.push_back(group->description());
  return lines;
}

} // namespace dovetail
