// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Coefficients of a solid law that are numbers or formulas of T, x, y, z and t.

#pragma once

#include <dovetail/material/solid_law.h>

#include <string>

namespace dovetail {

/// A coefficient in which the stress of a law is linear: a number, or a formula of the position, the time and
/// the temperature. At a place that asks for derivatives by T (SolidLaw::Place) it is its own derivative, so
/// that the law gives that of its stress without a line of its own: all coefficients in which the stress is
/// linear must be such ones, or none.
class Coefficient
{
public:
  Coefficient(const double number) : number(number), is_number(true) {}
  explicit Coefficient(const Expression &formula);
  /// Reads @p entry, whose values must be in the range, and makes it known to @p law. Without a default it
  /// must be given.
  Coefficient(SolidLaw &law, const Section &section, const std::string &entry, const std::string &description,
              const SolidLaw::Range &range, const std::string &default_text = "");

  static SolidLaw::Range positive();
  static SolidLaw::Range not_negative();
  static SolidLaw::Range any();

  double at(const SolidLaw::Place &place) const
  {
    return is_number ? (place.derivative == 0 ? number : 0) : evaluate(place);
  }
  bool is_constant() const { return is_number; }
  bool depends_on_temperature() const { return !is_number && formula.depends_on_scalars(); }

private:
  double evaluate(const SolidLaw::Place &place) const;

  double number = 0;
  bool is_number;
  Expression formula;
};

/// Isotropic moduli that may be formulas: those of IsotropicModuli at a place.
class VaryingModuli
{
public:
  VaryingModuli(SolidLaw &law, const Section &section);

  /// The moduli, or their derivatives if the place asks for these.
  IsotropicModuli at(const SolidLaw::Place &place) const
  {
    return {shear.at(place), bulk.at(place), is_mixed};
  }

  Coefficient shear = 0, bulk = 0;
  Coefficient compressibility = 0; ///< 1/kappa

private:
  const bool is_mixed;
};

/// The entry `Bulk modulus` of laws without a Poisson ratio, and 1/kappa.
Coefficient read_bulk_modulus(SolidLaw &law, const Section &section, Coefficient &compressibility);

} // namespace dovetail
