// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Named conditions, in time or by fields, that switch interfaces and boundary conditions on and off.

#pragma once

#include <dovetail/scene/section.h>

#include <map>
#include <string>

namespace dovetail {

/// All toggles of a scene: `set Toggles = heater` announces `subsection Toggle heater` with `Active while`.
/// Each is read and parsed even if nobody refers to it.
class Toggles
{
public:
  explicit Toggles(const Section &scene);

  /// Read the entry `Toggle` of @p section: the name of a toggle, or empty for "always on".
  std::string read_reference(const Section &section) const;

  /// Whether @p name is on at time @p t; always if it is empty, or looks at fields (it may be on somewhere).
  bool is_active(const std::string &name, double t) const;

private:
  std::map<std::string, Expression> active_while;
};

} // namespace dovetail
