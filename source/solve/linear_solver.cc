// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/linear_solver.h>

#include "degree_coarsening.h"
#include "merged_matrix.h"

#include <deal.II/lac/solver_cg.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>
#include <deal.II/lac/trilinos_precondition.h>

#include <Amesos.h>
#include <Amesos_BaseSolver.h>
#include <Epetra_LinearProblem.h>
#include <Epetra_MultiVector.h>
#include <Epetra_Vector.h>
#include <Teuchos_ParameterList.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

namespace dovetail {

namespace {

using SingleVector = dealii::TrilinosWrappers::MPI::Vector;

/// An Epetra matrix as deal.II's Krylov solvers see it.
struct Operator
{
  const Epetra_CrsMatrix &matrix;
  void vmult(SingleVector &destination, const SingleVector &source) const
  {
    matrix.Multiply(false, source.trilinos_vector(), destination.trilinos_vector());
  }
};

/// The multipliers' part of [A B^T; B 0]. They are scaled so that the diagonal of the Schur complement
/// B diag(A)^-1 B^T becomes the mean diagonal entry of A: then all unknowns, and all residuals, have one
/// unit. Each rank's unknowns of the bodies come first.
class Saddle
{
public:
  Saddle(const Epetra_CrsMatrix &matrix, const unsigned int n_of_bodies)
      : matrix(matrix), n_of_bodies(n_of_bodies), n_own(matrix.NumMyRows()), schur(n_own, 1.),
        scale(n_own, 1.)
  {
    Epetra_Vector diagonal(matrix.RowMap()), of_columns(matrix.ColMap());
    matrix.ExtractDiagonalCopy(diagonal);
    if (matrix.Importer() != nullptr)
      of_columns.Import(diagonal, *matrix.Importer(), Insert);
    else
      of_columns = diagonal;
    std::array<double, 2> own = {{0, static_cast<double>(n_of_bodies)}}, all;
    for (unsigned int i = 0; i < n_of_bodies; ++i)
      own[0] += std::abs(diagonal[i]);
    matrix.Comm().SumAll(own.data(), all.data(), 2);
    const double mean = all[0] / all[1];
    for (unsigned int i = n_of_bodies; i < n_own; ++i) {
      int n = 0, *columns = nullptr;
      double *values = nullptr;
      matrix.ExtractMyRowView(i, n, values, columns);
      double sum = 0;
      for (int k = 0; k < n; ++k)
        if (of_columns[columns[k]] > 0)
          sum += values[k] * values[k] / of_columns[columns[k]];
      is_alone.push_back(diagonal[i] != 0);
      scale[i] = is_alone.back() || !(sum > 0) ? 1 : std::sqrt(mean / sum);
      schur[i] = is_alone.back() || !(sum > 0) ? -1 : mean;
    }
  }

  void scale_multipliers(SingleVector &x) const
  {
    double *values = x.trilinos_vector()[0];
    for (unsigned int i = n_of_bodies; i < n_own; ++i)
      values[i] *= scale[i];
  }

  void vmult(SingleVector &destination, const SingleVector &source) const
  {
    SingleVector scaled(source);
    scale_multipliers(scaled);
    matrix.Multiply(false, scaled.trilinos_vector(), destination.trilinos_vector());
    scale_multipliers(destination);
  }

  const Epetra_CrsMatrix &matrix;
  const unsigned int n_of_bodies, n_own;
  std::vector<double> schur; ///< of the scaled multipliers; -1 where the multiplier is alone: x = b

private:
  std::vector<double> scale;
  std::vector<bool> is_alone;
};

/// z = [A 0; B -S]^-1 r
struct SaddlePreconditioner
{
  const Saddle &saddle;
  const dealii::TrilinosWrappers::PreconditionAMG &multigrid;
  SingleVector template_of_bodies;

  void vmult(SingleVector &z, const SingleVector &r) const
  {
    SingleVector of_bodies(template_of_bodies), solved(template_of_bodies), product(r);
    const double *residual = r.trilinos_vector()[0];
    std::copy(residual, residual + saddle.n_of_bodies, of_bodies.trilinos_vector()[0]);
    multigrid.vmult(solved, of_bodies);
    z = 0;
    double *result = z.trilinos_vector()[0];
    std::copy(solved.trilinos_vector()[0], solved.trilinos_vector()[0] + saddle.n_of_bodies, result);
    saddle.vmult(product, z);
    for (unsigned int i = saddle.n_of_bodies; i < saddle.n_own; ++i)
      result[i] = -(residual[i] - product.trilinos_vector()[0][i]) / saddle.schur[i];
  }
};

} // namespace

/// One group with its merged matrix and what was built from it.
struct LinearSolver::Group : SolveGroup
{
  explicit Group(SolveGroup group) : SolveGroup(std::move(group)) {}

  std::unique_ptr<MergedMatrix> merged;
  std::unique_ptr<MergedMatrix> of_bodies; ///< without the multipliers, if there are any
  std::unique_ptr<Saddle> saddle;
  std::unique_ptr<Epetra_MultiVector> modes; ///< ML refers to them
  std::unique_ptr<dealii::TrilinosWrappers::PreconditionAMG> multigrid;
  std::unique_ptr<DegreeCoarsening> by_degree; ///< instead, for a degree above one
  std::unique_ptr<Epetra_LinearProblem> problem;
  std::unique_ptr<Amesos_BaseSolver> direct;
  bool is_direct = false;
  bool is_decided = false;
  bool iteration_failed = false;
  Counts counts;
  double ended_at = 0; ///< the relative residual of the last iteration
  std::function<void(const std::string &)> fault;

  bool has_multipliers() const { return !multiplier_blocks.empty(); }
  /// What multigrid is built from.
  const MergedMatrix &bodies() const { return has_multipliers() ? *of_bodies : *merged; }
  void take(const Matrix &matrix);
  bool prefers_direct(unsigned int type, unsigned long n) const;
  void decide(unsigned int type);
  double contrast(const Matrix &matrix) const;
  void make_modes(const Matrix &matrix);
  std::vector<unsigned int> color_blocks(const Matrix &matrix) const;
  void make_operators(const Matrix &matrix);
  void make_multigrid(const Matrix &matrix);
  DegreeCoarsening::Sums linear_sums(const Matrix &matrix) const;
  bool succeeds(const std::string &place, const std::function<void()> &action) const;
  bool prepare_iteration(const Matrix &matrix);
  double rounding(const SingleVector &x) const;
  std::optional<unsigned int> iterate(const Matrix &matrix, SingleVector &x, const SingleVector &b,
                                      double tolerance);
  std::optional<unsigned int> iterate_to(SingleVector &x, const SingleVector &b, double tolerance);
  std::optional<unsigned int> solve(const Matrix &matrix, SingleVector &x, const SingleVector &b,
                                    double tolerance, std::vector<std::string> &notes);
  bool factorise();
  unsigned int iterate_once(SingleVector &x, const SingleVector &b, double tolerance) const;
  bool solve_directly(SingleVector &x, const SingleVector &b);
  void forget_values()
  {
    multigrid.reset();
    by_degree.reset();
    saddle.reset();
    direct.reset();
  }
};

void LinearSolver::Group::take(const Matrix &matrix)
{
  forget_values();
  if (!merged) {
    std::vector<unsigned int> all = blocks;
    all.insert(all.end(), multiplier_blocks.begin(), multiplier_blocks.end());
    merged = std::make_unique<MergedMatrix>(matrix, all);
  }
  merged->copy_values(matrix);
}

/// Factorisation wins while the fill is small: measured on two cores, 3D elasticity up to some 6 000
/// unknowns, 2D up to some 60 000.
bool LinearSolver::Group::prefers_direct(const unsigned int type, const unsigned long n) const
{
  const unsigned long largest = dim == 2 ? 60000 : 6000;
  return type == 1 || (type == 0 && n <= largest);
}

void LinearSolver::Group::decide(const unsigned int type)
{
  if (is_decided)
    return;
  is_decided = true;
  is_direct = prefers_direct(type, merged->matrix().NumGlobalRows());
}

/// Ratio of the largest to the smallest mean diagonal entry of the blocks: how much the bodies differ in
/// stiffness.
double LinearSolver::Group::contrast(const Matrix &matrix) const
{
  double largest = 0, smallest = std::numeric_limits<double>::infinity();
  for (const unsigned int block : blocks) {
    const Epetra_CrsMatrix &of_block = matrix.block(block, block).trilinos_matrix();
    Epetra_Vector diagonal(of_block.RowMap());
    of_block.ExtractDiagonalCopy(diagonal);
    double sum = 0;
    diagonal.Norm1(&sum);
    const double mean = sum / of_block.NumGlobalRows();
    largest = std::max(largest, mean);
    smallest = std::min(smallest, mean);
  }
  return largest / smallest;
}

/// The near-null space. Rigid-body modes of each body for itself, zero on the others, keep the iteration
/// count flat in any contrast of the stiffness, but they double the coarse matrices of two bodies and worse
/// for more. The modes of all bodies together cost nothing extra, and some iterations at a high contrast
/// (measured on two blocks, 3D: 16 iterations for both at contrast 1, 18 against 23 at 1e6). Bodies that can
/// come apart need their own modes (two blocks with an elastic joint: 13 iterations against up to 37). Bodies
/// that are not coupled share vectors, so a chain of any length needs two sets.
void LinearSolver::Group::make_modes(const Matrix &matrix)
{
  const double largest_shared_contrast = 1e3;
  const unsigned int largest_number = 24;
  const unsigned int n_of_block = near_null_space(blocks[0], true).size();
  const std::vector<unsigned int> set_of = color_blocks(matrix);
  const unsigned int n_sets = *std::max_element(set_of.begin(), set_of.end()) + 1;
  const bool is_shared =
      n_sets * n_of_block > largest_number || (!allows_jumps && contrast(matrix) <= largest_shared_contrast);
  modes = std::make_unique<Epetra_MultiVector>(bodies().matrix().OperatorDomainMap(),
                                               is_shared ? n_of_block : n_sets * n_of_block);
  for (unsigned int i = 0; i < blocks.size(); ++i) {
    const auto of_block = near_null_space(blocks[i], is_shared);
    for (unsigned int mode = 0; mode < of_block.size(); ++mode)
      std::copy(of_block[mode].begin(), of_block[mode].end(),
                (*modes)[is_shared ? mode : set_of[i] * n_of_block + mode] + bodies().first_local_of(i));
  }
}

/// Numbers for the blocks of the group, from 0 on, different for those that are coupled: to each in turn the
/// smallest that none of its neighbours has.
std::vector<unsigned int> LinearSolver::Group::color_blocks(const Matrix &matrix) const
{
  std::map<unsigned int, unsigned int> color;
  std::vector<unsigned int> colors;
  for (const unsigned int block : blocks) {
    std::set<unsigned int> taken;
    for (const auto &[neighbour, known] : color)
      if (matrix.has_block(block, neighbour) || matrix.has_block(neighbour, block))
        taken.insert(known);
    unsigned int next = 0;
    while (taken.count(next) > 0)
      ++next;
    color[block] = next;
    colors.push_back(next);
  }
  return colors;
}

/// What multigrid is built from and with.
void LinearSolver::Group::make_operators(const Matrix &matrix)
{
  if (has_multipliers()) {
    if (!of_bodies)
      of_bodies = std::make_unique<MergedMatrix>(matrix, blocks);
    of_bodies->copy_values(matrix);
    saddle = std::make_unique<Saddle>(merged->matrix(), of_bodies->n_local());
  }
  if (!modes)
    make_modes(matrix);
}

void LinearSolver::Group::make_multigrid(const Matrix &matrix)
{
  const bool coarsens_degree = degree > 1 && is_symmetric && !has_multipliers() && linear_part != nullptr;
  dealii::TrilinosWrappers::PreconditionAMG::AdditionalData data;
  data.elliptic = is_symmetric;
  data.higher_order_elements = degree > 1 && !coarsens_degree;
  data.smoother_sweeps = 2;
  data.smoother_type = is_symmetric ? "Chebyshev" : "ILU";
  Teuchos::ParameterList list;
  std::unique_ptr<Epetra_MultiVector> unused;
  data.set_parameters(list, unused, bodies().matrix());
  list.set("null space: type", "pre-computed");
  list.set("null space: dimension", modes->NumVectors());
  list.set("null space: vectors", modes->Values());
  list.set("aggregation: threshold", 0.0); // a positive one drops the couplings of a stiff with a soft body
  ++counts.multigrids;
  if (coarsens_degree) {
    by_degree = std::make_unique<DegreeCoarsening>(merged->matrix(), linear_sums(matrix), *modes, list);
    return;
  }
  multigrid = std::make_unique<dealii::TrilinosWrappers::PreconditionAMG>();
  multigrid->initialize(bodies().matrix(), list);
}

/// The sums of linear_part with the rows of the merged matrix.
DegreeCoarsening::Sums LinearSolver::Group::linear_sums(const Matrix &matrix) const
{
  std::vector<unsigned int> position(matrix.n_block_rows()); // in the group
  for (unsigned int i = 0; i < blocks.size(); ++i)
    position[blocks[i]] = i;
  DegreeCoarsening::Sums sums;
  for (const unsigned int block : blocks)
    for (const SolveGroup::Sum &of_unknown : linear_part(block)) {
      sums.emplace_back();
      for (const auto &[dof, weight] : of_unknown) {
        const auto [of_dof, index] = matrix.get_row_indices().global_to_local(dof);
        sums.back().emplace_back(merged->global_row(position[of_dof], index), weight);
      }
    }
  return sums;
}

unsigned int LinearSolver::Group::iterate_once(SingleVector &x, const SingleVector &b,
                                               const double tolerance) const
{
  const unsigned int maximum_iterations = 500;
  dealii::SolverControl control(maximum_iterations, tolerance, false, false);
  const Operator K = {merged->matrix()};
  // right preconditioning: the true residual is the one that is checked
  const dealii::SolverGMRES<SingleVector>::AdditionalData data(102, true);
  if (has_multipliers())
    dealii::SolverGMRES<SingleVector>(control, data)
        .solve(*saddle, x, b, SaddlePreconditioner{*saddle, *multigrid, of_bodies->vector()});
  else if (by_degree)
    dealii::SolverCG<SingleVector>(control).solve(K, x, b, *by_degree);
  else if (is_symmetric)
    dealii::SolverCG<SingleVector>(control).solve(K, x, b, *multigrid);
  else
    dealii::SolverGMRES<SingleVector>(control, data).solve(K, x, b, *multigrid);
  return control.last_step();
}

/// Whether an action ends without an exception on all ranks. What only some ranks meet must not send them
/// another way than the rest. Where an action ends on one rank in the middle of what the others do together
/// nobody can help; so what takes memory is an action of its own, before the others are entered.
bool LinearSolver::Group::succeeds(const std::string &place, const std::function<void()> &action) const
{
  const auto is_agreed = [this](const bool is_good) {
    int mine = is_good ? 1 : 0, all = 0;
    merged->matrix().Comm().MinAll(&mine, &all, 1);
    return all == 1;
  };
  const auto ends_well = [](const auto &what) {
    try {
      what();
      return true;
    } catch (const std::exception &) { // no convergence, no preconditioner, no memory
      return false;
    }
  };
  return (!fault || is_agreed(ends_well([&]() { fault(place); }))) && is_agreed(ends_well(action));
}

bool LinearSolver::Group::prepare_iteration(const Matrix &matrix)
{
  if (multigrid || by_degree)
    return true;
  const bool is_made = succeeds("modes", [&]() { make_operators(matrix); }) &&
                       succeeds("multigrid", [&]() { make_multigrid(matrix); });
  if (!is_made) {
    multigrid.reset();
    by_degree.reset();
  }
  return is_made;
}

/// What rounding leaves of K x, as doc/theory/convergence.md does it, with the largest row sum of K.
double LinearSolver::Group::rounding(const SingleVector &x) const
{
  const Epetra_CrsMatrix &K = merged->matrix();
  return std::numeric_limits<double>::epsilon() / 2 * std::sqrt(K.GlobalMaxNumEntries()) * K.NormInf() *
         x.l2_norm();
}

std::optional<unsigned int> LinearSolver::Group::iterate(const Matrix &matrix, SingleVector &x,
                                                         const SingleVector &b, const double tolerance)
{
  std::optional<unsigned int> n_iterations;
  if (!prepare_iteration(matrix) ||
      !succeeds("iteration", [&]() { n_iterations = iterate_to(x, b, tolerance); }))
    return {};
  return n_iterations;
}

/// Iterate until the true residual, not only that of the recurrence, is small, or rounding stops its
/// decrease.
std::optional<unsigned int> LinearSolver::Group::iterate_to(SingleVector &x, const SingleVector &b,
                                                            const double tolerance)
{
  const auto multiply = [this](SingleVector &product, const SingleVector &y) {
    if (saddle)
      saddle->vmult(product, y);
    else
      Operator{merged->matrix()}.vmult(product, y);
  };
  unsigned int n_iterations = 0;
  SingleVector residual(b), correction(b);
  if (saddle)
    saddle->scale_multipliers(residual);
  const SingleVector given(residual);
  const double goal = tolerance * given.l2_norm();
  double norm = given.l2_norm();
  for (unsigned int pass = 0; pass < 3 && norm > goal; ++pass) {
    correction = 0;
    n_iterations += iterate_once(correction, residual, goal);
    x += correction;
    multiply(residual, x);
    residual.sadd(-1., 1., given);
    const double new_norm = residual.l2_norm();
    if (!std::isfinite(new_norm))
      return {};
    const bool is_done = new_norm <= 2 * goal || new_norm > norm / 10;
    norm = new_norm;
    if (is_done)
      break;
  }
  ended_at = norm <= std::max(2 * goal, rounding(x)) ? 0 : norm / given.l2_norm();
  if (saddle)
    saddle->scale_multipliers(x);
  return n_iterations;
}

/// By iteration, or directly if that does not reach its tolerance. What it did reach serves if MUMPS fails,
/// for instance for lack of memory.
std::optional<unsigned int> LinearSolver::Group::solve(const Matrix &matrix, SingleVector &x,
                                                       const SingleVector &b, const double tolerance,
                                                       std::vector<std::string> &notes)
{
  const double largest_usable = 1e-4;
  ++counts.solves;
  if (is_direct)
    return solve_directly(x, b) ? std::optional<unsigned int>(1) : std::nullopt;
  const auto n_iterations = iterate(matrix, x, b, tolerance);
  if (n_iterations && ended_at == 0)
    return n_iterations;

  const SingleVector iterated(x);
  std::ostringstream words;
  words.precision(2);
  words << "the iteration for " << name;
  if (n_iterations)
    words << " ended at a relative residual of " << ended_at << " in place of " << tolerance;
  else
    words << " failed";
  x = 0;
  if (solve_directly(x, b)) {
    iteration_failed = is_direct = true;
    notes.push_back(words.str() + "; MUMPS solved the system and solves those after it");
    return 1;
  }
  if (!n_iterations || ended_at > largest_usable)
    return {};
  x = iterated;
  notes.push_back(words.str() + ", and MUMPS failed (memory?): the result of the iteration is used");
  return n_iterations;
}

bool LinearSolver::Group::factorise()
{
  auto &matrix = const_cast<Epetra_CrsMatrix &>(merged->matrix()); // Epetra's interfaces know no const
  const auto is_prepared = succeeds("factorisation", [&]() {
    problem = std::make_unique<Epetra_LinearProblem>();
    problem->SetOperator(&matrix);
    for (const char *package : {"Amesos_Mumps", "Amesos_Klu"})
      if (Amesos().Query(package)) {
        direct.reset(Amesos().Create(package, *problem));
        break;
      }
    Teuchos::ParameterList list;
    list.set("OutputLevel", 0);
    list.set("PrintTiming", false);
    if (has_multipliers()) // pivots off the diagonal need more space than the analysis foresees, in per cent
      list.sublist("mumps").set("ICNTL(14)", 1000);
    direct->SetParameters(list);
  });
  if (!is_prepared)
    return false;
  ++counts.factorisations;
  const auto is_done = [&](const std::string &place, const std::function<int()> &action) {
    return succeeds(place, [&]() {
      if (action() != 0)
        throw std::runtime_error(place);
    });
  };
  return is_done("analysis", [&]() { return direct->SymbolicFactorization(); }) &&
         is_done("factors", [&]() { return direct->NumericFactorization(); });
}

bool LinearSolver::Group::solve_directly(SingleVector &x, const SingleVector &b)
{
  if (!direct && !factorise()) {
    direct.reset();
    return false;
  }
  const auto solve = [&](SingleVector &solution, const SingleVector &right_hand_side) {
    return succeeds("solution", [&]() {
      problem->SetLHS(&solution.trilinos_vector());
      problem->SetRHS(const_cast<Epetra_MultiVector *>(
          static_cast<const Epetra_MultiVector *>(&right_hand_side.trilinos_vector())));
      if (direct->Solve() != 0)
        throw std::runtime_error("solution");
    });
  };
  bool is_solved = solve(x, b);
  if (has_multipliers() && is_solved) { // indefinite: one step of iterative refinement
    SingleVector residual(b), correction(b);
    Operator{merged->matrix()}.vmult(residual, x);
    residual.sadd(-1., 1., b);
    correction = 0;
    is_solved = solve(correction, residual);
    x += correction;
  }
  return std::isfinite(x.l2_norm()) && is_solved;
}

LinearSolver::LinearSolver(const Section &section, std::vector<SolveGroup> given_groups)
    : type(section.choose("Type", {"automatic", "direct", "multigrid"}, 0,
                          "direct: MUMPS; multigrid: CG, or GMRES for nonsymmetric systems, with ML; "
                          "automatic: chosen by the number of unknowns [-]")),
      relative_tolerance(section.read<double>(
          "Relative tolerance", 1e-10,
          "Tolerance of the residual of the linear system, relative to its right-hand side [-]",
          Patterns::Double(0, 1)))
{
  for (SolveGroup &group : given_groups)
    groups.push_back(std::make_unique<Group>(std::move(group)));
}

LinearSolver::~LinearSolver() = default;

void LinearSolver::set_matrix(const Matrix &new_matrix)
{
  matrix = &new_matrix;
  for (auto &group : groups) {
    group->take(new_matrix);
    group->decide(type);
  }
}

void LinearSolver::forget_matrix()
{
  for (auto &group : groups) {
    group->forget_values();
    group->problem.reset();
    group->modes.reset();
    group->merged.reset();
    group->of_bodies.reset();
    group->is_decided = group->iteration_failed;
  }
}

std::optional<unsigned int> LinearSolver::solve(Vector &dx, const Vector &right_hand_side)
{
  unsigned int n_iterations = 0;
  dx = 0;
  for (unsigned int g = 0; g < groups.size(); ++g) {
    Group &group = *groups[g];
    Vector rest;
    rest.reinit(right_hand_side);
    rest = right_hand_side;
    for (unsigned int before = 0; before < g; ++before)
      for (const unsigned int row : group.blocks)
        for (const unsigned int column : groups[before]->blocks)
          if (matrix->has_block(row, column)) {
            SingleVector product(rest.block(row));
            matrix->block(row, column).vmult(product, dx.block(column));
            rest.block(row) -= product;
          }

    SingleVector x = group.merged->vector(), b = group.merged->vector();
    group.merged->gather(rest, b);
    std::optional<unsigned int> of_group = 0;
    if (b.l2_norm() > 0)
      of_group = group.solve(*matrix, x, b, relative_tolerance, all_notes);
    if (!of_group)
      return {};
    n_iterations += *of_group;
    group.merged->scatter(x, dx);
  }
  return n_iterations;
}

bool LinearSolver::prefer_direct()
{
  bool is_new = false;
  for (auto &group : groups) {
    is_new = is_new || !group->is_direct;
    group->iteration_failed = group->iteration_failed || !group->is_direct;
    group->is_direct = group->is_decided = true;
  }
  return is_new;
}

void LinearSolver::set_fault(std::function<void(const std::string &place)> fault)
{
  for (auto &group : groups)
    group->fault = fault;
}

std::vector<std::string> LinearSolver::description() const
{
  std::vector<std::string> lines;
  for (const auto &group : groups)
    lines.push_back(group->name + ": " +
                    ((group->is_decided ? group->is_direct : group->prefers_direct(type, group->n_unknowns))
                         ? (group->iteration_failed ? "MUMPS, after the iteration failed" : "MUMPS")
                         : std::string(group->is_symmetric && !group->has_multipliers() ? "CG" : "GMRES") +
                               " with multigrid" +
                               (group->has_multipliers() ? " and Schur complement" : "")));
  return lines;
}

LinearSolver::Counts LinearSolver::counts() const
{
  Counts all;
  for (const auto &group : groups) {
    all.solves += group->counts.solves;
    all.factorisations += group->counts.factorisations;
    all.multigrids += group->counts.multigrids;
  }
  return all;
}

} // namespace dovetail
