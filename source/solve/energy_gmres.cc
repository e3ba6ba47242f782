// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "energy_gmres.h"

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

/// The next column of the triangular factor. @p below: the entry that the new rotation makes zero.
void EnergyGmres::rotate(std::vector<double> column, const double below)
{
  for (unsigned int i = 0; i < cosines.size(); ++i) {
    const double upper = column[i], lower = column[i + 1];
    column[i] = cosines[i] * upper + sines[i] * lower;
    column[i + 1] = cosines[i] * lower - sines[i] * upper;
  }
  const double length = std::hypot(column.back(), below);
  cosines.push_back(column.back() / length);
  sines.push_back(below / length);
  column.back() = length;
  columns.push_back(std::move(column));
  right_hand_side.push_back(cosines.back() * rest);
  rest *= -sines.back();
}

void EnergyGmres::update(GroupVector &x) const
{
  x = begin;
  if (columns.empty())
    return;
  std::vector<double> y(right_hand_side);
  GroupVector sum(begin), result(begin), unused(begin);
  sum = 0;
  for (unsigned int i = y.size(); i-- > 0;) {
    for (unsigned int k = i + 1; k < y.size(); ++k)
      y[i] -= columns[k][i] * y[k];
    y[i] /= columns[i][i];
    sum.add(y[i], basis[i]);
  }
  apply(result, unused, sum);
  x += result;
}

void EnergyGmres::start(const GroupVector &x)
{
  begin = x;
  basis.clear();
  times_H.clear();
  columns.clear();
  right_hand_side.clear();
  cosines.clear();
  sines.clear();
}

EnergyGmres::State EnergyGmres::solve_for(const GroupVector &r, dealii::SolverControl &control)
{
  const unsigned int most_vectors = 100;
  State state = State::iterate;
  rest = append(r);
  GroupVector direction(basis[0]), w(r); // of the residual
  while (has_only_positive && state == State::iterate && columns.size() < most_vectors) {
    K.vmult(w, z);
    std::vector<double> column;
    for (unsigned int i = 0; i < basis.size(); ++i) {
      column.push_back(w * times_H[i]);
      w.add(-column.back(), basis[i]);
    }
    const double norm = append(w);
    if (!has_only_positive && !w.all_zero()) // what there is does not count
      break;
    rotate(std::move(column), norm);
    direction.sadd(-sines.back(), cosines.back(), basis.back());
    state = control.check(++n, std::abs(rest) * direction.l2_norm());
  }
  return state;
}

bool EnergyGmres::solve(GroupVector &x, const GroupVector &b, dealii::SolverControl &control)
{
  GroupVector r(b);
  State state = State::iterate;
  while (state == State::iterate && has_only_positive) {
    start(x);
    K.vmult(r, x);
    r.sadd(-1., 1., b);
    state = control.check(n, r.l2_norm());
    if (state == State::iterate)
      state = solve_for(r, control);
    update(x);
  }
  if (state == State::failure)
    throw dealii::SolverControl::NoConvergence(n, control.last_value());
  return state == State::success;
}

} // namespace dovetail
