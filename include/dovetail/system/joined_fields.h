// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Which fields of which bodies are joined to each other, directly or through others.

#pragma once

#include <dovetail/system/model.h>

#include <functional>
#include <vector>

namespace dovetail {

/// For each domain and each of its fields a number, the same for those that are joined by interfaces for
/// which
/// @p joins is true; the fields at the ends may have different names. The cost is that of the domains and
/// interfaces.
template <int dim>
std::vector<std::vector<unsigned int>>
joined_fields(const Model<dim> &model,
              const std::function<bool(const Interface<dim> &, const TiedField &)> &joins);

} // namespace dovetail
