// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the numbers of probes are called in a table, and their units.

#pragma once

#include <dovetail/measure/probes.h>

#include <map>
#include <string>
#include <vector>

namespace dovetail {

/// Of each probe's numbers: the name, that of the component (x, y, z; r, z; xx, xy, ... of a tensor row by
/// row; in axisymmetry t stands for the direction around the axis) and, if the scene has Units, its unit.
template <int dim>
std::map<std::string, std::vector<std::string>> names_of_numbers(const Probes<dim> &probes);

/// Likewise of the places of minima and maxima: "worst at x [mm]".
template <int dim>
std::map<std::string, std::vector<std::string>> names_of_places(const Probes<dim> &probes);

} // namespace dovetail
