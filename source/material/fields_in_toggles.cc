// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/fields_in_toggles.h>
#include <dovetail/scene/field_toggle.h>

namespace dovetail {

std::vector<std::optional<unsigned int>> components_in_toggles(const Section &scene,
                                                               const std::vector<Field> &fields)
{
  std::vector<std::optional<unsigned int>> components;
  for (const std::string &name : names_in_toggles(scene)) {
    components.emplace_back();
    for (const Field &field : fields)
      if (name_in_toggles(field.name) == name)
        components.back() = field.first_component;
  }
  return components;
}

} // namespace dovetail
