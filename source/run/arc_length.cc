// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/arc_length.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

template <int dim>
double ArcLength<dim>::product(const Vector &x, const Vector &y) const
{
  double sum = 0;
  for (unsigned int b = 0; b < x.n_blocks(); ++b)
    if (step.equations().is_vector(b))
      sum += x.block(b) * y.block(b);
  return sum;
}

/// v = dx/dt from the update at x for a time a little later; that for time @p t is @p a. Exact where loads
/// are affine in t. @pre The tangent at x has been solved with.
template <int dim>
bool ArcLength<dim>::find_rate(const double t, const Vector &x, const Vector &a, Vector &v)
{
  const double later = 0.1 * size * (first_length > 0 ? length / first_length : 1.);
  StepProblem<dim> &equations = step.equations();
  step.system().set_time(t + later);
  const bool is_defined = std::isfinite(equations.residual(x));
  bool is_solved = false;
  if (is_defined && !step.system().moves_constraints())
    is_solved = equations.correct(x, x, 1, v);
  else if (is_defined) { // values that move are loads by the tangent
    equations.residual_and_tangent(x);
    is_solved = equations.solve(x, v).has_value();
  }
  step.system().set_time(t);
  v -= a;
  v *= 1 / later;
  return is_solved;
}

template <int dim>
NewtonResult ArcLength<dim>::solve(const Vector &x_0, const double t_0, Vector &x, double &t,
                                   const unsigned int most_iterations)
{
  StepProblem<dim> &equations = step.equations();
  NewtonResult result;
  Vector a = x, v = x, change = x;
  bool is_small = false;
  t = t_0;
  x = x_0;
  equations.first_stage(); // no update has led here
  for (unsigned int iteration = 0; iteration <= most_iterations; ++iteration) {
    step.system().set_time(t);
    const double norm = equations.residual_and_tangent(x);
    result.residuals.push_back(norm);
    if (iteration > 0)
      equations.iteration_ends(iteration, norm, result.linear_iterations.back(), 1);
    if (!std::isfinite(norm))
      return result;
    equations.accept_state();
    if (iteration > 1 && norm <= step.tolerance() && is_small) {
      result.is_converged = true;
      return result;
    }
    const auto linear_iterations = equations.solve(x, a);
    if (!linear_iterations)
      return result;
    result.linear_iterations.push_back(*linear_iterations);
    is_small = equations.is_small(a, x);
    if (!find_rate(t, x, a, v))
      return result;
    change = x;
    change -= x_0;
    double s = 0;
    if (iteration == 0) {
      const double speed = std::sqrt(product(v, v));
      if (!(speed > 0))
        return result;
      if (length == 0)
        length = first_length = speed * size;
      s = (last_change && product(*last_change, v) < 0 ? -1 : 1) * length / speed;
    } else {
      change += a;
      const double A = product(v, v), B = product(v, change), C = product(change, change) - length * length,
                   discriminant = B * B - A * C;
      if (!(discriminant >= 0))
        return result;
      Vector before = x;
      before -= x_0;
      const double direction = product(v, before) < 0 ? -1 : 1; // of the root that goes on
      s = (-B + direction * std::sqrt(discriminant)) / A;
    }
    x += a;
    x.add(s, v);
    t += s;
  }
  return result;
}

template <int dim>
void ArcLength<dim>::accept(const Vector &change, const unsigned int n_iterations)
{
  const double usual = 5, largest_growth = 2, largest_cut = 0.5;
  last_change = change;
  const double factor = std::sqrt(usual / std::max(1u, n_iterations));
  length = std::min(first_length, length * std::min(largest_growth, std::max(largest_cut, factor)));
  length_after_good = length;
}

template <int dim>
bool ArcLength<dim>::shorten()
{
  length /= 2;
  return length > 0 && length >= smallest * first_length;
}

template <int dim>
void ArcLength<dim>::save(SavedState &to) const
{
  to.numbers["path"] = {length_after_good, first_length};
  to.vectors["change along path"] = *last_change;
}

template <int dim>
void ArcLength<dim>::restore(const SavedState &from)
{
  length = length_after_good = from.numbers["path"][0];
  first_length = from.numbers["path"][1];
  last_change = from.vectors.at("change along path");
}

template class ArcLength<2>;
template class ArcLength<3>;

} // namespace dovetail
