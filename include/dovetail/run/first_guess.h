// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where a scalar field starts if the scene has no Initial for it.

#pragma once

#include <dovetail/system/model.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace dovetail {

/// For each domain (of @p model, in its order) the mean of the values that conditions prescribe or hold
/// against a scalar field (ambient values) at the beginning, over the boundaries where they are active at
/// time @p t, of all bodies that are tied to it: a start without jumps, in which no conductivity is asked at
/// 0 K. Zero if there are none. Collective.
template <int dim>
std::vector<double> first_guess(const Model<dim> &model, const std::string &field, double t);

/// The smallest and the largest of those values at time @p t over all bodies. Without sources and given
/// influxes the solution lies between them; with them there is no range. Collective.
template <int dim>
std::optional<std::array<double, 2>> given_range(const Model<dim> &model, const std::string &field, double t);

} // namespace dovetail
