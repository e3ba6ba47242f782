// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/coefficient.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

namespace {

const double infinity = std::numeric_limits<double>::infinity();

/// A formula that contains entries of the scene, each in brackets.
Coefficient made_of(const Section &section, const std::string &formula)
{
  return Coefficient(Expression(formula, {section.dimension(), {"T"}}));
}

bool is_number(const Section &section, const std::string &entry)
{
  const std::string text = section.peek(entry);
  return text.empty() || text == "inf" || Patterns::Double().match(text);
}

} // namespace

Coefficient::Coefficient(const Expression &formula)
    : is_number(!formula.depends_on_position() && !formula.depends_on_time() &&
                !formula.depends_on_scalars()),
      formula(formula)
{
  if (is_number)
    number = formula.value(dealii::Point<3>(), 0);
}

Coefficient::Coefficient(SolidLaw &law, const Section &section, const std::string &entry,
                         const std::string &description, const SolidLaw::Range &range,
                         const std::string &default_text)
    : Coefficient(default_text.empty()
                      ? section.require_expression(entry, {1}, description, {"T"})
                      : section.read_expression(entry, default_text, {1}, description, {"T"}))
{
  if (is_number)
    section.check(number >= range.least && number <= range.most, entry, range.words + ".");
  else
    law.add_formula({section, entry, formula, formula.depends_on_scalars(), range});
}

SolidLaw::Range Coefficient::positive()
{
  return {std::numeric_limits<double>::min(), infinity, "must be positive"};
}

SolidLaw::Range Coefficient::not_negative()
{
  return {0, infinity, "must not be negative"};
}

SolidLaw::Range Coefficient::any()
{
  return {std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max(),
          "must be a finite number"};
}

double Coefficient::evaluate(const SolidLaw::Place &place) const
{
  const Expression::Scalars T(&place.T, 1);
  switch (place.derivative) {
  case 0:
    return formula.value(place.X, place.t, 0, T);
  case 1:
    return formula.derivative(place.X, place.t, 0, T, 0);
  default:
    return formula.second_derivative(place.X, place.t, 0, T, 0, 0);
  }
}

VaryingModuli::VaryingModuli(SolidLaw &law, const Section &section) : is_mixed(dovetail::is_mixed(section))
{
  const auto entries = IsotropicModuli::entries(section);
  if (section.documenting() || (is_number(section, entries[0]) && is_number(section, entries[1]))) {
    const IsotropicModuli numbers(section);
    shear = numbers.shear;
    bulk = numbers.bulk;
    compressibility = 1 / numbers.bulk;
    return;
  }
  const bool is_technical = entries[0] == "Young modulus";
  const SolidLaw::Range ratios = {std::nextafter(-1., 0.), is_mixed ? 0.5 : std::nextafter(0.5, 0.),
                                  is_mixed ? "must be greater than -1 and not greater than 0.5"
                                           : "must be greater than -1 and less than 0.5"};
  SolidLaw::Range moduli = Coefficient::positive();
  moduli.most = std::numeric_limits<double>::max(); // only a bulk modulus may be infinite
  moduli.words = "must be positive and finite";
  const Coefficient first(law, section, entries[0], "[Pa]", moduli),
      second(law, section, entries[1], is_technical ? "[-]" : "[Pa]",
             is_technical ? ratios : Coefficient::positive());
  const std::string one = "(" + section.peek(entries[0]) + ")", other = "(" + section.peek(entries[1]) + ")";
  shear = is_technical ? made_of(section, one + "/(2*(1 + " + other + "))") : first;
  bulk = is_technical ? made_of(section, one + "/(3*(1 - 2*" + other + "))") : second;
  compressibility = made_of(section, is_technical ? "3*(1 - 2*" + other + ")/" + one : "1/" + other);
}

Coefficient read_bulk_modulus(SolidLaw &law, const Section &section, Coefficient &compressibility)
{
  if (section.documenting() || is_number(section, "Bulk modulus")) {
    const double kappa = read_bulk_modulus(section, "kappa (three-dimensional) [Pa]");
    compressibility = 1 / kappa;
    return kappa;
  }
  const Coefficient kappa(law, section, "Bulk modulus", "[Pa]", Coefficient::positive());
  compressibility = made_of(section, "1/(" + section.peek("Bulk modulus") + ")");
  return kappa;
}

} // namespace dovetail
