// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "upkeep.h"

#include <algorithm>
#include <cmath>

namespace dovetail {

void Upkeep::prepare(const std::function<void()> &make, GroupSolver::Preparations &counts)
{
  if (is_made && excess <= cost && was_symmetric == facts.is_symmetric) {
    is_fresh = false;
    ++counts.kept;
  } else
    renew(make, counts);
}

void Upkeep::renew(const std::function<void()> &make, GroupSolver::Preparations &counts)
{
  forget();
  ++counts.made;
  make();
  made();
}

unsigned int Upkeep::solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, const double goal,
                           const std::function<void()> &make, GroupSolver::Preparations &counts,
                           const Iterate &iterate, const Attempt &with_new)
{
  if (is_fresh || !is_made)
    return with_new(x, b);
  return solve_in_two_attempts(
      K, x, b,
      [&](GroupVector &z, const GroupVector &r) { return iterate(z, r, gives_up(r.l2_norm(), goal)); },
      [&](GroupVector &z, const GroupVector &r) {
        renew(make, counts);
        return with_new(z, r);
      });
}

void Upkeep::made()
{
  is_made = is_fresh = true;
  was_symmetric = facts.is_symmetric;
  per_decade = excess = 0;
}

void Upkeep::solved(const unsigned int n, const double decades)
{
  const double fewest_decades = 1; // less says little of the rate
  if (!(decades >= fewest_decades))
    return;
  const double here = n / decades;
  per_decade = per_decade > 0 ? std::min(per_decade, here) : here;
  if (!is_fresh)
    excess += n - per_decade * decades;
}

Upkeep::GivesUp Upkeep::gives_up(const double r_0, const double goal) const
{
  const unsigned int first_look = 8;
  return [=](const unsigned int n, const double r) {
    if (n < first_look || per_decade == 0)
      return false;
    if (!(r < r_0))
      return n >= cost;
    const double done = std::log10(r_0 / r), rest = std::log10(r / goal);
    return n / done * rest > cost + per_decade * rest;
  };
}

} // namespace dovetail
