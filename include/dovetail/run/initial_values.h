// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where a run starts: from values that conditions prescribe or hold against a scalar field (ambient values).

#pragma once

#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <functional>
#include <string>
#include <vector>

namespace dovetail {

/// Set the fields of @p x that have an `Initial` to it, and other scalar fields of nonlinear scenes without
/// rates in each body to the mean of those values at the beginning, over all that is tied to it and active at
/// time @p t. The `Initial` of the field @p without_initial, if one is named, does not count. A linear scene
/// needs no guess, and an update from one far from the solution has the rounding of the guess. Collective.
template <int dim>
void set_initial_values(const Model<dim> &model, double t, Vector &x,
                        const std::string &without_initial = "");

/// Set the unknowns of a field that this rank owns to the values of a function of the place and the component
/// at the nodes; those of a discontinuous one to its projection, cell by cell.
template <int dim>
void set_nodes(const Model<dim> &model, const Domain<dim> &domain, const Field &field,
               const std::function<double(const dealii::Point<dim> &X, unsigned int component)> &value,
               Vector &x);

/// The rates at the time 0 that the scene gives (`Initial`: velocity), else zero. @param x whose layout they
/// get. Collective.
template <int dim>
Vector initial_rates(const Model<dim> &model, const Vector &x);

} // namespace dovetail
