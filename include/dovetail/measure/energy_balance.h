// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where the work of the loads goes.

#pragma once

#include <dovetail/measure/reactions.h>
#include <dovetail/system/block_system.h>
#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <nlohmann/json.hpp>

#include <optional>

namespace dovetail {

/// How a scheme has led a motion through a step, in owned vectors of all unknowns.
struct StepOfMotion
{
  std::optional<double> new_start; ///< just after this time it started anew, if it did
  /// Then: the rates there, and the second ones and the forces of supports, if the scheme knows them.
  std::optional<Vector> rates_at_start, second_rates_at_start, supports_at_start;
  /// The second ones are those that the equations saw.
  std::optional<Vector> rates_at_end, second_rates_at_end;
};

/// What conditions that constrain put into the nodes of solids.
template <int dim>
Vector forces_of_supports(const Model<dim> &model, const Reactions<dim> &reactions, const Vector &x);

/// The energy of all solids of a scene after each step, with the displacement u and the velocity v,
/// @f[ \mathrm{kinetic} = \sum \int \tfrac12 \rho |v|^2 dV, \quad \mathrm{elastic} = \sum \int W dV, \quad
///     \mathrm{ties} = \sum \int -\{A\} \cdot [B] + \tfrac12 \gamma |[B]|^2 dA, \quad
///     \mathrm{work} = \sum_n \tfrac12 (f_n + f_{n+1}) \cdot (u_{n+1} - u_n), @f]
/// by the quadrature of the equations, and lost = initial energy + work - kinetic - elastic - ties. f are the
/// forces that sources, conditions and supports put into the nodes; in a new start f_n are those just after
/// its beginning, but those of supports at its end where the scheme does not know the second rates there.
/// Ties that do not follow from an energy (theta other than 1, joints) have no "ties": what they take or give
/// is in what is lost, as is what plastic flow and the time scheme take and what heating gives, with its sign
/// (doc/theory/time.md). What the scheme takes is the difference between the work of the forces of inertia
/// and the kinetic energy, with the mass M, the velocities v and the accelerations b that the equations see,
/// @f[ \mathrm{scheme} = \sum_n \tfrac12 (b_n + b_{n+1}) \cdot M (u_{n+1} - u_n)
///     - \tfrac12 (v_n + v_{n+1}) \cdot M (v_{n+1} - v_n), @f]
/// which a linear scene with an energy loses. It is there if b is known from the first step on.
template <int dim>
class EnergyBalance
{
public:
  explicit EnergyBalance(const Model<dim> &model) : model(model) {}

  /// The state before the first step, owned and @p ghosted. @p velocity: ghosted; nullptr: all bodies are at
  /// rest. Collective.
  void start(const Vector &x, const Vector &ghosted, const Vector *velocity, double t);
  /// After a good step to @p x, owned and @p ghosted. Collective.
  nlohmann::ordered_json add_step(const Reactions<dim> &reactions, const Vector &x, const Vector &ghosted,
                                  const Vector *velocity, const StepOfMotion &step);

  /// What a checkpoint has to hold.
  struct Memory
  {
    double initial = 0, work = 0;
    std::optional<double> scheme = 0.;
    Vector forces, x; ///< at the last good step, owned; forces without blocks before the first one
    Vector velocity, acceleration; ///< likewise, if known; else without blocks
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
  void start_anew(const Vector &of_support, const Vector &ghosted, const StepOfMotion &step,
                  const GhostExchange &exchange);
  void add_scheme(const Vector &change, const Vector &ghosted, const StepOfMotion &step,
                  const GhostExchange &exchange);
  Vector product_with_mass(const Vector &ghosted, const Vector &ghosted_rate,
                           const GhostExchange &exchange) const;
  Vector loads(double t, const Vector &x, const Vector &ghosted, const GhostExchange &exchange) const;

  const Model<dim> &model;
  Memory last;
};

} // namespace dovetail
