// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "energy_gmres.h"

#include <algorithm>
#include <cmath>

namespace dovetail {

/// w divided by its norm becomes the next vector. @return the norm, 0 if there is none
double EnergyGmres::append(const GroupVector &w)
{
  GroupVector v(w), Hv(w);
  z.reinit(w);
  apply(z, Hv, w);
  const double square = w * Hv;
  has_only_positive = square > 0 && std::isfinite(square);
  const double norm = has_only_positive ? std::sqrt(square) : 0;
  if (has_only_positive)
    for (GroupVector *const each : {&v, &Hv, &z})
      *each /= norm;
  basis.push_back(std::move(v));
  times_H.push_back(std::move(Hv));
  return norm;
}

void EnergyGmres::update(GroupVector &x)
{
  was_asked = true;
  x = begin;
  if (projected.n_columns() == 0)
    return;
  const std::vector<double> shares = projected.solution();
  GroupVector sum(begin), result(begin), unused(begin);
  sum = 0;
  for (unsigned int i = 0; i < shares.size(); ++i)
    sum.add(shares[i], basis[i]);
  apply(result, unused, sum);
  x += result;
}

void EnergyGmres::start(const GroupVector &x)
{
  begin = x;
  basis.clear();
  times_H.clear();
  projected = LeastSquares();
}

/// Where @p control has asked for x and is not content: whether its residual is far above @p claimed, but
/// much less than the one that the vectors began with. What is left is found from it, not among the vectors.
bool EnergyGmres::is_left_behind(const GroupVector &x, const GroupVector &b, const double claimed,
                                 const double at_begin) const
{
  const double far = 10, much = 0.5;
  GroupVector rest(b);
  K.vmult(rest, x);
  rest.sadd(-1., 1., b);
  const double size = rest.l2_norm();
  return size > far * claimed && size < much * at_begin;
}

EnergyGmres::State EnergyGmres::solve_for(const GroupVector &r, const GroupVector &x, const GroupVector &b,
                                          dealii::SolverControl &control)
{
  const unsigned int most_vectors = 100;
  const double half_of_digits = 1e-8, still = 0.9;
  State state = State::iterate;
  projected = LeastSquares(append(r));
  const double first = projected.residual(), norm_of_r = r.l2_norm();
  bool is_lost = false;                  // rounding hides what is left, as of motions of stiff bodies
  GroupVector direction(basis[0]), w(r); // of the residual
  double size = first * direction.l2_norm();
  while (has_only_positive && state == State::iterate && projected.n_columns() < most_vectors && !is_lost) {
    const double before = projected.residual(), size_before = size;
    K.vmult(w, z);
    std::vector<double> column;
    for (unsigned int i = 0; i < basis.size(); ++i) {
      column.push_back(w * times_H[i]);
      w.add(-column.back(), basis[i]);
    }
    const double norm = append(w);
    if (!has_only_positive && !w.all_zero()) // what there is does not count
      break;
    column.push_back(norm);
    projected.append(std::move(column));
    const auto [cosine, sine] = projected.last_rotation();
    direction.sadd(-sine, cosine, basis.back());
    size = projected.residual() * direction.l2_norm();
    was_asked = false;
    state = control.check(++n, size);
    looks_again = was_asked && state == State::iterate && is_left_behind(x, b, size, norm_of_r);
    const bool stands_still = before < half_of_digits * first && projected.residual() > still * before &&
                              size > still * size_before;
    is_lost = stands_still || looks_again;
  }
  return state;
}

bool EnergyGmres::solve(GroupVector &x, const GroupVector &b, dealii::SolverControl &control)
{
  const double share_of_residual = 1e-3; // at the next look
  GroupVector r(b);
  State state = State::iterate;
  while (state == State::iterate && has_only_positive) {
    start(x);
    K.vmult(r, x);
    r.sadd(-1., 1., b);
    if (looks_again) // which the goal takes for much smaller
      control.set_tolerance(std::max(control.tolerance(), share_of_residual * r.l2_norm()));
    looks_again = false;
    state = control.check(n, r.l2_norm());
    if (state == State::iterate)
      state = solve_for(r, x, b, control);
    update(x);
  }
  if (state == State::failure)
    throw dealii::SolverControl::NoConvergence(n, control.last_value());
  return state == State::success;
}

} // namespace dovetail
