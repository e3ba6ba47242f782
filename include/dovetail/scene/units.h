// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The units of length, mass, time and temperature of a scene.

#pragma once

#include <array>
#include <optional>
#include <string>

namespace dovetail {

/// A set of base units, "mm, t, s, K". The program computes with numbers only; what it takes in SI is
/// converted.
class Units
{
public:
  /// @throw UserError naming what is not known and what is.
  explicit Units(const std::string &text);

  /// The factor from SI for a quantity whose unit in SI is @p unit, "W/(m K)": 1 Pa is 1e-6 t/(mm s^2). None
  /// if it is not understood.
  std::optional<double> from_si(const std::string &unit) const;

  /// A unit of SI in these: of "J/m^3" in mm, t, s, K "t/(mm s^2)", of "Pa" by its name, "MPa". Empty if it
  /// is not understood or has no dimension.
  std::string of(const std::string &unit) const;

private:
  std::array<std::string, 4> names;
  std::array<double, 4> in_si = {{1, 1, 1, 1}};
};

} // namespace dovetail
