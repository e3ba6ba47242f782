// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Which bodies are joined to each other, directly or through others.

#pragma once

#include <dovetail/system/model.h>

#include <functional>
#include <string>
#include <vector>

namespace dovetail {

/// For each domain the first one of those it is joined to by the interfaces that tie a field and for which @p
/// joins is true. The cost is that of the domains and interfaces.
template <int dim>
std::vector<unsigned int>
joined_domains(const Model<dim> &model, const std::string &field,
               const std::function<bool(const Interface<dim> &, const TiedField &)> &joins);

} // namespace dovetail
