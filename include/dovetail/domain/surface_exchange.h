// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Exchange of a scalar with surroundings of a given value.

#pragma once

#include <dovetail/domain/condition.h>
#include <dovetail/scene/undefined.h>

namespace dovetail {

inline const NoteName of_negative_coefficient("film coefficient", "a film coefficient is negative");

/// A condition with a factor that should not be negative.
template <int dim>
class ExchangeCoefficient
{
public:
  virtual ~ExchangeCoefficient() = default;
  virtual bool varies() const = 0;        ///< else the condition's notes() tell
  virtual bool follows_state() const = 0; ///< or only place and time
  virtual double exchange_coefficient(const State<dim> &state) const = 0;
};

/// A.N = c(T, X, t) (p(T_ambient) - p(T)) with a coefficient c, the value T_ambient(X, t) of the surroundings
/// and a growing potential p, which a condition gives.
template <int dim>
class SurfaceExchange : public Condition<dim>, public ExchangeCoefficient<dim>
{
public:
  SurfaceExchange(const Section &section, const Material<dim> &material, const Toggles &toggles,
                  const std::string &coefficient, const std::string &surroundings)
      : Condition<dim>(section, material, toggles),
        coefficient(section.require_expression("Coefficient", {1}, coefficient,
                                               {section.documenting() ? "T" : this->field.symbol})),
        ambient(section.require_expression("Ambient", {1}, surroundings))
  {
    section.check(this->field.n_components == 1, "Type",
                  section.peek("Type") + " acts on scalar fields such as temperature.");
  }

  virtual double potential(double T) const = 0; ///< p
  virtual double slope(double T) const = 0;     ///< dp/dT

  bool adds_flux() const override { return true; }
  bool is_linear() const override { return !coefficient.depends_on_scalars(); }
  bool has_constant_tangent() const override { return is_linear() && !coefficient.depends_on_time(); }
  bool depends_on_time() const override { return coefficient.depends_on_time() || ambient.depends_on_time(); }

  void influx(const State<dim> &state, const dealii::Tensor<1, dim> & /*N*/,
              Influx<dim> &influx) const override
  {
    const unsigned int own = this->field.first_component;
    const double T = state.value[own], difference = potential(ambient_at(state.X, state.t)) - potential(T);
    const double c = coefficient_at(state.X, state.t, T);
    influx.value[0] = c * difference;
    influx.by_value(0, own) = -c * slope(T);
    if (coefficient.depends_on_scalars())
      influx.by_value(0, own) += difference * checked(coefficient.derivative(state.X, state.t, 0, {&T, 1}, 0),
                                                      "Coefficient", state.X, state.t);
  }

  NoteList notes() const override
  {
    if (varies() || coefficient.value(dealii::Point<dim>(), 0) >= 0)
      return {};
    return {of_negative_coefficient(
        "Coefficient is negative: what is warmer than its surroundings would be heated by them. "
        "Change its sign, if it was meant for a flux that points outwards")};
  }

  bool varies() const override
  {
    return coefficient.depends_on_position() || coefficient.depends_on_time() ||
           coefficient.depends_on_scalars();
  }
  bool follows_state() const override { return coefficient.depends_on_scalars(); }
  double exchange_coefficient(const State<dim> &state) const override
  {
    return coefficient_at(state.X, state.t, state.value[this->field.first_component]);
  }

  bool removes_constant(unsigned int /*component*/) const override { return true; }

  std::optional<double> equilibrium_value(const dealii::Point<dim> &X, const double t) const override
  {
    const double T = ambient_at(X, t);
    return coefficient_at(X, t, T) == 0 ? std::nullopt : std::optional(T);
  }

private:
  double checked(const double value, const char *entry, const dealii::Point<dim> &X, const double t) const
  {
    return finite(value, this->section, entry, X, t);
  }
  double coefficient_at(const dealii::Point<dim> &X, const double t, const double T) const
  {
    return checked(coefficient.value(X, t, 0, {&T, 1}), "Coefficient", X, t);
  }
  double ambient_at(const dealii::Point<dim> &X, const double t) const
  {
    return checked(ambient.value(X, t), "Ambient", X, t);
  }

  const Expression coefficient;
  const Expression ambient;
};

} // namespace dovetail
