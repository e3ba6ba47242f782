// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the parts of a material need to know of `subsection Steps`.

#pragma once

#include <dovetail/scene/section.h>

namespace dovetail {

/// Whether rates count in the scene of a section: only then a material has terms that store.
inline bool is_transient(const Section &section)
{
  return section.top().peek("Steps", "Kind") == "transient";
}

/// Whether the scene asks for the eigenmodes of its solids.
inline bool finds_eigenmodes(const Section &section)
{
  return section.top().peek("Steps", "Kind") == "eigenmodes";
}

/// Whether solids have a mass, too.
inline bool has_inertia(const Section &section)
{
  if (finds_eigenmodes(section))
    return true;
  return is_transient(section) && section.top().peek("Steps", "Inertia") == "true";
}

} // namespace dovetail
