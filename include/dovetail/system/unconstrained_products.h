// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Residual and products with the transposed tangent, before constraints.

#pragma once

#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <optional>
#include <vector>

namespace dovetail {

/// R(x) and the products K(x)^T w of all bodies, conditions and ties, with an entry at each unknown, also
/// where constraints prescribe it.
struct UnconstrainedProducts
{
  Vector residual;
  std::vector<Vector> transposed; ///< K^T w for each w
};

/// Of a static state at time @p t. @p x and @p all_w: ghosted. Collective. @pre The ties have begun the step.
/// @return nothing, on all ranks alike, if a law is not defined somewhere.
template <int dim>
std::optional<UnconstrainedProducts>
unconstrained_products(const Model<dim> &model, double t, const Vector &x, const std::vector<Vector> &all_w);

} // namespace dovetail
