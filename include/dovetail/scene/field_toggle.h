// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Toggles that look at fields: Active while = temperature > 1700.

#pragma once

#include <dovetail/scene/section.h>

#include <functional>
#include <string>
#include <vector>

namespace dovetail {

/// The names of scalar fields that toggles of a scene may look at: what those who own fields have registered,
/// each with the names that it knows for the whole scene.
std::vector<std::string> names_in_toggles(const Section &scene);
bool add_names_in_toggles(const std::function<std::vector<std::string>(const Section &scene)> &names);

/// The formula of a toggle in these names, of the scene of any section.
Expression formula_of_toggle(const Section &section, const std::string &toggle);
/// The names of the fields that the toggle of a section, if it has any, looks at.
std::vector<std::string> names_in_toggle(const Section &section);
/// Whether the entry Toggle of a section names one that looks at fields.
bool has_field_toggle(const Section &section);
/// As toggles write it: they know no spaces.
std::string name_in_toggles(std::string field);

} // namespace dovetail
