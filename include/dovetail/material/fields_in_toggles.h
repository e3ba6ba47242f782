// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Which unknowns the names in toggles are (scene/field_toggle.h).

#pragma once

#include <dovetail/material/term.h>
#include <dovetail/scene/section.h>

#include <optional>
#include <vector>

namespace dovetail {

/// Of each of names_in_toggles() of a scene the component, if one of the fields has this name.
std::vector<std::optional<unsigned int>> components_in_toggles(const Section &scene,
                                                               const std::vector<Field> &fields);

} // namespace dovetail
