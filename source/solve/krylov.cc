// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/krylov.h>

#include <deal.II/lac/solver_cg.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>
#include <deal.II/lac/vector_memory.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

namespace {

/// As deal.II's solvers see it.
struct Bodies
{
  const Preconditioner &P;
  void vmult(GroupVector &z, const GroupVector &r) const { P(z, r); }
};

/// z = [A 0; B -S]^-1 [I B^T W; 0 I] r, with A augmented
struct BlockTriangular
{
  const GroupOperator &K;
  const Preconditioner &P;

  void vmult(GroupVector &z, const GroupVector &r) const
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
    std::vector<double> rest(r.trilinos_vector().MyLength() - n_of_bodies);
    for (unsigned int i = 0; i < rest.size(); ++i)
      rest[i] = product.trilinos_vector()[0][n_of_bodies + i] - residual[n_of_bodies + i];
    K.solve_schur_complement(result + n_of_bodies, rest.data());
  }

private:
  /// += B^T W r
  void add_augmentation(const GroupVector &r, GroupVector &body_part) const
  {
    const std::vector<double> *W = K.augmentation();
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
};

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

} // namespace

unsigned int solve_by_iteration(const GroupOperator &K, const GroupFacts &facts, const Preconditioner &P,
                                GroupVector &x, const GroupVector &b, const double goal,
                                const std::function<bool(unsigned int n, double r)> &gives_up,
                                double *const decades)
{
  Control control(goal, gives_up);
  const dealii::SolverGMRES<GroupVector>::AdditionalData data(102, true);
  if (facts.is_positive_definite()) {
    if (facts.next_goal)
      control.ask(
          [&](const double reached, const bool begins) { return facts.next_goal(x, reached, begins); });
    dealii::SolverCG<GroupVector>(control).solve(K, x, b, Bodies{P});
  } else if (facts.has_multipliers)
    dealii::SolverGMRES<GroupVector>(control, data).solve(K, x, b, BlockTriangular{K, P});
  else
    dealii::SolverGMRES<GroupVector>(control, data).solve(K, x, b, Bodies{P});
  dealii::GrowingVectorMemory<GroupVector>::release_unused_memory();
  if (decades != nullptr)
    *decades = std::log10(b.l2_norm() / std::max(control.last_value(), std::numeric_limits<double>::min()));
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
