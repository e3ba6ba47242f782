// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where the work of the loads goes.

#pragma once

#include <dovetail/measure/reactions.h>
#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <nlohmann/json.hpp>

#include <optional>

namespace dovetail {

/// The energy of all solids of a scene after each step, with the displacement u and the velocity v,
/// @f[ \mathrm{kinetic} = \sum \int \tfrac12 \rho |v|^2 dV, \quad \mathrm{elastic} = \sum \int W dV, \quad
///     \mathrm{ties} = \sum \int -\{A\} \cdot [B] + \tfrac12 \gamma |[B]|^2 dA, \quad
///     \mathrm{work} = \sum_n \tfrac12 (f_n + f_{n+1}) \cdot (u_{n+1} - u_n), @f]
/// by the quadrature of the equations, and lost = initial energy + work - kinetic - elastic - ties. f are the
/// forces that sources, conditions and supports put into the nodes; in a new start f_n are those just after
/// its beginning, but those of supports at its end. Ties that do not follow from an energy (theta other than
/// 1, joints) have no "ties": what they take or give is in what is lost, as is what plastic flow and the time
/// scheme take and what heating gives, with its sign (doc/theory/time.md).
template <int dim>
class EnergyBalance
{
public:
  explicit EnergyBalance(const Model<dim> &model) : model(model) {}

  /// The state before the first step, owned and @p ghosted. @p velocity: ghosted; nullptr: all bodies are at
  /// rest. Collective.
  void start(const Vector &x, const Vector &ghosted, const Vector *velocity, double t);
  /// After a good step to @p x, owned and @p ghosted. @p new_start: just after this time it started anew, if
  /// it did. Collective.
  nlohmann::ordered_json add_step(const Reactions<dim> &reactions, const Vector &x, const Vector &ghosted,
                                  const Vector *velocity, std::optional<double> new_start);

  /// What a checkpoint has to hold.
  struct Memory
  {
    double initial = 0, work = 0;
    Vector forces, x; ///< at the last good step, owned; forces without blocks before the first one
  };
  const Memory &memory() const { return last; }
  void restore(Memory memory) { last = std::move(memory); }

private:
  struct Energies
  {
    double kinetic = 0, elastic = 0, ties = 0;
    bool knows_ties = true;
    double sum() const { return kinetic + elastic + ties; }
  };
  Energies energies(const Vector &x, const Vector *velocity, double t) const;
  void add_domain(const Domain<dim> &domain, const Vector &x, const Vector *velocity, double t,
                  Energies &sums) const;
  void add_interface(const Interface<dim> &interface, const Vector &x, double t, Energies &sums) const;
  Vector loads(double t, const Vector &x, const Vector &ghosted) const;
  Vector support(const Reactions<dim> &reactions, const Vector &x) const;

  const Model<dim> &model;
  Memory last;
};

} // namespace dovetail
