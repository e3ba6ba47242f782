// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Laws, conditions and ties that are compiled outside of the program.

#pragma once

#include <dovetail/scene/section.h>

namespace dovetail {

/// Read `Plugins` and load these shared libraries: what registers itself in the last line of a file of theirs
/// is known from now on (catalogue.h). Relative paths start at the working directory. @throw UserError if one
/// cannot be loaded or brings what is there already.
void load_plugins(const Section &scene);

} // namespace dovetail
