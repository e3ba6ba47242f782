// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the numbers of probes are called in a table, and their units.

#pragma once

#include <dovetail/measure/probes.h>

#include <string>
#include <vector>

namespace dovetail {

struct NamesOfProbe
{
  /// The name of the probe, that of the component (x, y, z; r, z; xx, xy, ... of a tensor row by row; in
  /// axisymmetry t stands for the direction around the axis) and, if the scene has Units, the unit.
  std::vector<std::string> numbers;
  std::vector<std::string> places; ///< likewise of a minimum or maximum: "worst at x [mm]"
};

/// Of each probe, in their order.
template <int dim>
std::vector<NamesOfProbe> names_of_columns(const Probes<dim> &probes);

/// What stands behind the name of a column, " [mm]", of a unit in SI; empty if the scene has no Units.
template <int dim>
std::string in_brackets(const Probes<dim> &probes, const std::string &unit);

/// In SI; empty if they are not known. The resultant is the integral of the flux over a surface.
struct UnitsOfField
{
  std::string value, flux, resultant;
};
UnitsOfField units_of_field(const std::string &field);

} // namespace dovetail
