// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/krylov.h>

#include "energy_gmres.h"
#include "least_squares.h"

#include <deal.II/lac/solver_cg.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/vector_memory.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace dovetail {

namespace {

/// As deal.II's solvers see it.
struct Bodies
{
  const Preconditioner &P;
  void vmult(GroupVector &z, const GroupVector &r) const { P(z, r); }
};

/// @return whether it met a direction p with p.Kp = r.z / alpha < 0; it does not ask of the last one, of
/// which deal.II does not tell alpha. r.z is beta times the one before; its first sign is found here.
bool solve_by_cg(const GroupOperator &K, const Preconditioner &P, GroupVector &x, const GroupVector &b,
                 dealii::SolverControl &control)
{
  bool met_negative = false;
  double sign = 0; // of r.z
  const Preconditioner P_and_sign = [&](GroupVector &z, const GroupVector &r) {
    P(z, r);
    if (sign == 0)
      sign = std::copysign(1., r * z);
  };
  dealii::SolverCG<GroupVector> cg(control);
  cg.connect_coefficients_slot([&](const double alpha, const double beta) {
    met_negative = met_negative || sign / alpha < 0;
    sign *= std::copysign(1., beta);
  });
  cg.solve(K, x, b, Bodies{P_and_sign});
  return met_negative;
}

/// [A B^T; B -C] as it is preconditioned, in augmented form. Of a residual r, with T = [I B^T W; 0 I]:
/// z = [A 0; B -S]^-1 T r, and H r = T^T diag(A^-1, S^-1) T r.
class BlockTriangular
{
public:
  BlockTriangular(const GroupOperator &K, const Preconditioner &P) : K(K), P(P), W(K.augmentation()) {}

  void vmult(GroupVector &z, const GroupVector &r) const { apply(z, r, nullptr); }
  void apply(GroupVector &z, const GroupVector &r, GroupVector *Hr) const;

private:
  void add_augmentation(const GroupVector &r, GroupVector &body_part) const;
  void add_multipliers(GroupVector &Hr, const GroupVector &r, const double *product,
                       unsigned int begin) const;

  const GroupOperator &K;
  const Preconditioner &P;
  const std::vector<double> *W;
};

void BlockTriangular::apply(GroupVector &z, const GroupVector &r, GroupVector *const Hr) const
{
  GroupVector body_part = K.bodies().vector(), solved(body_part), product(r);
  const unsigned int n_of_bodies = body_part.trilinos_vector().MyLength();
  const double *residual = r.trilinos_vector()[0];
  std::copy(residual, residual + n_of_bodies, body_part.trilinos_vector()[0]);
  add_augmentation(r, body_part);
  P(solved, body_part);
  z = 0;
  double *result = z.trilinos_vector()[0];
  std::copy(solved.trilinos_vector()[0], solved.trilinos_vector()[0] + n_of_bodies, result);
  K.vmult(product, z);
  const double *const of_bodies = product.trilinos_vector()[0] + n_of_bodies;
  if (Hr != nullptr) {
    *Hr = z;
    add_multipliers(*Hr, r, of_bodies, n_of_bodies);
  }
  std::vector<double> rest(r.trilinos_vector().MyLength() - n_of_bodies);
  for (unsigned int i = 0; i < rest.size(); ++i)
    rest[i] = of_bodies[i] - residual[n_of_bodies + i];
  K.solve_schur_complement(result + n_of_bodies, rest.data());
}

/// += B^T W r
void BlockTriangular::add_augmentation(const GroupVector &r, GroupVector &body_part) const
{
  if (W == nullptr)
    return;
  GroupVector weighted = K.vector(), product(weighted);
  const unsigned int n_of_bodies = body_part.trilinos_vector().MyLength();
  for (unsigned int i = 0; i < W->size(); ++i)
    weighted.trilinos_vector()[0][n_of_bodies + i] = (*W)[i] * r.trilinos_vector()[0][n_of_bodies + i];
  K.vmult(product, weighted);
  for (unsigned int i = 0; i < n_of_bodies; ++i)
    body_part.trilinos_vector()[0][i] += product.trilinos_vector()[0][i];
}

/// += S^-1 r + W B z, of which B z is @p product. A multiplier that was dropped has W = 0 and S = -1.
void BlockTriangular::add_multipliers(GroupVector &Hr, const GroupVector &r, const double *const product,
                                      const unsigned int begin) const
{
  double *const result = Hr.trilinos_vector()[0] + begin;
  const double *const residual = r.trilinos_vector()[0] + begin;
  K.solve_schur_complement(result, residual);
  for (unsigned int i = 0; i < W->size(); ++i)
    result[i] = (*W)[i] > 0 ? result[i] + (*W)[i] * product[i] : residual[i];
}

class Control : public dealii::SolverControl
{
public:
  Control(const double goal, const std::function<bool(unsigned int n, double r)> &gives_up)
      : SolverControl(500, goal, false, false), needed(goal), gives_up(gives_up)
  {
  }

  /// From now on @p next is asked for a first goal, and for the next one where that is reached.
  void ask(const std::function<double(double goal, bool begins)> &next)
  {
    next_goal = next;
    set_tolerance(next_goal(tolerance(), true));
  }

  /// The goal is the first one again.
  void ask_no_more()
  {
    next_goal = {};
    set_tolerance(needed);
  }

  State check(const unsigned int step, const double residual) override
  {
    State state = SolverControl::check(step, residual);
    if (state == success && next_goal) {
      set_tolerance(next_goal(residual, false)); // which may be much less than the goal
      state = SolverControl::check(step, residual);
    }
    if (residual <= needed) // what goes on from here may end at any time
      return state == failure ? success : state;
    return state == iterate && gives_up && gives_up(step, residual) ? failure : state;
  }

private:
  const double needed;
  const std::function<bool(unsigned int n, double r)> &gives_up;
  std::function<double(double goal, bool begins)> next_goal;
};

/// Flexible GMRES (Saad 1993): each direction and what the preconditioner made of it are kept, so that it
/// need not be linear, as in single precision. (SolverFGMRES of deal.II 9.4 knows a residual one direction
/// late, which is one more of the three to five that a solve takes here.)
class FlexibleGmres
{
public:
  FlexibleGmres(const GroupOperator &K, Control &control) : K(K), control(control), rest(K.vector()) {}

  /// From @p x, which @p n_iterations others have reached.
  template <typename P>
  void solve(GroupVector &x, const GroupVector &b, const P &preconditioner, unsigned int n_iterations = 0);

private:
  static constexpr unsigned int largest_basis = 100;

  void add_column(unsigned int k);

  const GroupOperator &K;
  Control &control;
  GroupVector rest;
  std::vector<GroupVector> directions, preconditioned;
  LeastSquares projected; ///< on the directions
};

/// Of K z_k, which is in rest and becomes orthogonal to the directions.
void FlexibleGmres::add_column(const unsigned int k)
{
  const double before = rest.l2_norm(), lost = 1e-7; // half of the digits
  std::vector<double> h(k + 2, 0.);
  for (unsigned int pass = 0; pass < 2 && (pass == 0 || h[k + 1] < lost * before); ++pass) {
    for (unsigned int i = 0; i <= k; ++i) {
      const double share = rest * directions[i];
      h[i] += share;
      rest.add(-share, directions[i]);
    }
    h[k + 1] = rest.l2_norm();
  }
  if (h[k + 1] > 0)
    rest /= h[k + 1];
  projected.append(std::move(h));
}

template <typename P>
void FlexibleGmres::solve(GroupVector &x, const GroupVector &b, const P &preconditioner,
                          unsigned int n_iterations)
{
  using dealii::SolverControl;
  SolverControl::State state = SolverControl::iterate;
  while (state == SolverControl::iterate) {
    rest = b;
    if (!x.all_zero()) {
      GroupVector product(b);
      K.vmult(product, x);
      rest -= product;
    }
    const double norm = rest.l2_norm();
    projected = LeastSquares(norm);
    state = control.check(n_iterations, norm);
    if (state == SolverControl::iterate)
      rest /= norm;
    for (unsigned int k = 0; k < largest_basis && state == SolverControl::iterate; ++k) {
      if (k == directions.size()) {
        directions.push_back(rest);
        preconditioned.emplace_back(rest);
      } else
        directions[k] = rest;
      preconditioner.vmult(preconditioned[k], directions[k]);
      K.vmult(rest, preconditioned[k]);
      add_column(k);
      state = control.check(++n_iterations, projected.residual());
    }
    const std::vector<double> shares = projected.solution();
    for (unsigned int k = 0; k < shares.size(); ++k)
      x.add(shares[k], preconditioned[k]);
  }
  if (state != SolverControl::success)
    throw SolverControl::NoConvergence(control.last_step(), control.last_value());
}

void solve_with_multipliers(const GroupOperator &K, const GroupFacts &facts, const BlockTriangular &P,
                            GroupVector &x, const GroupVector &b, Control &control)
{
  if (facts.is_symmetric && K.augmentation() != nullptr) {
    EnergyGmres gmres(K, [&P](GroupVector &z, GroupVector &Hr, const GroupVector &r) { P.apply(z, r, &Hr); });
    if (facts.next_goal)
      control.ask([&](const double reached, const bool begins) {
        if (!begins)
          gmres.update(x);
        return facts.next_goal(x, reached, begins);
      });
    if (gmres.solve(x, b, control))
      return;
    control.ask_no_more();
    FlexibleGmres(K, control).solve(x, b, P, control.last_step());
  } else
    FlexibleGmres(K, control).solve(x, b, P);
}

} // namespace

unsigned int solve_by_iteration(const GroupOperator &K, const GroupFacts &facts, const Preconditioner &P,
                                GroupVector &x, const GroupVector &b, const double goal,
                                const std::function<bool(unsigned int n, double r)> &gives_up,
                                CourseOfIteration *const course)
{
  Control control(goal, gives_up);
  bool met_negative = false;
  if (facts.is_positive_definite()) {
    if (facts.next_goal)
      control.ask(
          [&](const double reached, const bool begins) { return facts.next_goal(x, reached, begins); });
    met_negative = solve_by_cg(K, P, x, b, control);
  } else if (facts.has_multipliers)
    solve_with_multipliers(K, facts, BlockTriangular(K, P), x, b, control);
  else
    FlexibleGmres(K, control).solve(x, b, Bodies{P});
  dealii::GrowingVectorMemory<GroupVector>::release_unused_memory();
  if (course != nullptr)
    *course = {std::log10(b.l2_norm() / std::max(control.last_value(), std::numeric_limits<double>::min())),
               met_negative};
  return control.last_step();
}

unsigned int solve_in_two_attempts(const GroupOperator &K, GroupVector &x, const GroupVector &b,
                                   const Attempt &first, const Attempt &second)
{
  unsigned int n_iterations = 0;
  try {
    return first(x, b);
  } catch (const dealii::SolverControl::NoConvergence &end) { // on all ranks
    n_iterations = end.last_step;
  }
  GroupVector rest(b), correction(K.vector());
  K.vmult(rest, x);
  rest.sadd(-1., 1., b);
  if (!(rest.l2_norm() < b.l2_norm())) {
    x = 0;
    rest = b;
  }
  n_iterations += second(correction, rest);
  x += correction;
  return n_iterations;
}

std::string describe_iteration(const GroupFacts &facts, const std::string &preconditioner)
{
  return std::string(facts.is_positive_definite() ? "CG" : "GMRES") + " with " + preconditioner +
         (facts.has_multipliers ? " and Schur complement" : "");
}

} // namespace dovetail
