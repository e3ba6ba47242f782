// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/thermal_law.h>
#include <dovetail/scene/undefined.h>

#include <algorithm>
#include <array>
#include <limits>
#include <sstream>

namespace dovetail {

using dealii::Tensor;

namespace {

SolidLaw::Place at_temperature(const SolidLaw::Place &place, const double T, const unsigned int derivative)
{
  SolidLaw::Place result = place;
  result.T = T;
  result.derivative = derivative;
  return result;
}

/// (w:D)_kL = w_iJ D_iJkL
Tensor<2, 3> contract(const Tensor<2, 3> &w, const Tensor<4, 3> &D)
{
  return dealii::double_contract<0, 0, 1, 1>(w, D);
}

} // namespace

ThermalStrain::ThermalStrain(const Section &section)
{
  const Expression alpha =
      section.read_expression("Expansion coefficient", "0", {1},
                              "alpha in the free thermal strain alpha (T - Reference temperature); a number, "
                              "or a formula of x, y, z, t and T for the secant coefficient [1/K]",
                              {"T"});
  reference = section.read<double>("Reference temperature", 0,
                                   "Temperature at which the undeformed solid is free of stress [K]");
  is_none = alpha.is_zero();
  is_of_time = alpha.depends_on_time();
  if (!alpha.depends_on_position() && !alpha.depends_on_time() && !alpha.depends_on_scalars())
    coefficient = alpha.value(dealii::Point<3>(), 0);
  if (is_none)
    return;
  std::ostringstream formula;
  formula.precision(std::numeric_limits<double>::max_digits10);
  formula << '(' << section.peek("Expansion coefficient") << ")*(T - (" << reference << "))";
  strain = Coefficient(Expression(formula.str(), {section.dimension(), {"T"}}));
}

ThermalLaw::ThermalLaw(std::unique_ptr<SolidLaw> law_of_strain, const ThermalStrain &strain)
    : law(std::move(law_of_strain)), strain(strain),
      has_coefficients_of_temperature(
          std::any_of(law->formulas().begin(), law->formulas().end(),
                      [](const Formula &formula) { return formula.depends_on_temperature; }))
{
}

bool ThermalLaw::are_in_range(const Place &place) const
{
  for (const Formula &formula : law->formulas()) {
    if (!formula.range)
      continue;
    const double value = formula.value.value(place.X, place.t, 0, {&place.T, 1});
    if (value >= formula.range->least && value <= formula.range->most)
      continue;
    const std::string at = formula.depends_on_temperature ? "T = " + in_words(place.T) + ", " : "";
    return undefined(sentence_about(formula.section, formula.entry,
                                    "is " + in_words(value) + " at " + at + in_words(place.X) + " and t = " +
                                        in_words(place.t) + ", but " + formula.range->words + "."),
                     !formula.depends_on_temperature);
  }
  return true;
}

bool ThermalLaw::evaluate(const Tensor<2, 3> &H, const double T, const bool with_derivatives,
                          Response &response) const
{
  response.T = T;
  const double e = strain.at(response);
  if (!are_in_range(response) || !law->evaluate(H, e, with_derivatives, response))
    return false;
  if (!with_derivatives)
    return true;
  response.dP_de *= strain.at(at_temperature(response, T, 1));
  if (!has_coefficients_of_temperature)
    return true;
  Response change;
  static_cast<Place &>(change) = at_temperature(response, T, 1);
  if (!law->evaluate(H, e, false, change))
    return false;
  response.dP_de += change.P;
  return true;
}

SolidLaw::Curvature ThermalLaw::curvature(const Tensor<2, 3> &H, const double T, const Tensor<2, 3> &w,
                                          const Place &place) const
{
  std::array<double, 3> e; // and its derivatives
  for (unsigned int order = 0; order < 3; ++order)
    e[order] = strain.at(at_temperature(place, T, order));
  const auto response = [&](const unsigned int order, const bool with_derivatives) {
    Response result;
    static_cast<Place &>(result) = at_temperature(place, T, order);
    const bool is_defined = law->evaluate(H, e[0], with_derivatives, result);
    (void)is_defined;
    Assert(is_defined, dealii::ExcMessage("The curvature exists only where evaluate() succeeds."));
    return result;
  };
  const Curvature K = law->curvature(H, e[0], w, at_temperature(place, T, 0));
  Curvature result = {K.FF, e[1] * K.Fe, e[1] * e[1] * K.ee};
  if (e[2] != 0)
    result.ee += e[2] * scalar_product(w, response(0, true).dP_de);
  if (has_coefficients_of_temperature) {
    const Response change = response(1, true);
    result.Fe += contract(w, change.dP_dF);
    result.ee += 2 * e[1] * scalar_product(w, change.dP_de) + scalar_product(w, response(2, false).P);
  }
  return result;
}

/// A law without curvature has numbers as coefficients: only its strain changes with the temperature.
bool ThermalLaw::expansion_work(const Tensor<2, 3> &H, const double T, const Tensor<2, 3> &H_n,
                                const Place &place, ExpansionWork &work) const
{
  if (law->has_curvature())
    return SolidLaw::expansion_work(H, T, H_n, place, work);
  const Place here = at_temperature(place, T, 0);
  if (!are_in_range(here) || !law->expansion_work(H, strain.at(here), H_n, here, work))
    return false;
  const double slope = strain.at(at_temperature(place, T, 1));
  work = {slope * work.value, slope * slope * work.by_e + strain.at(at_temperature(place, T, 2)) * work.value,
          slope * work.by_F};
  return true;
}

double ThermalLaw::energy(const Tensor<2, 3> &H, const double T, const Place &place) const
{
  const Place here = at_temperature(place, T, 0);
  return are_in_range(here) ? law->energy(H, strain.at(here), here)
                            : std::numeric_limits<double>::quiet_NaN();
}

} // namespace dovetail
