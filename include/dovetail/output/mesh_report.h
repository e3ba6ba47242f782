// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a mesh file holds, before any scene uses it.

#pragma once

#include <iosfwd>
#include <string>

namespace dovetail {

/// Print for each volume of a mesh file: cells, shape, extents, volume, smallest angle between two edges at a
/// corner, largest aspect ratio (the ratio of the singular values of the map from the ideal cell, a cube or a
/// regular simplex, at the corners), and the boundaries with ids, names and areas. Write STEM_mesh.vtu to the
/// working directory. By one process.
/// @throw UserError if the file cannot be used
void report_on_mesh(const std::string &file_name, std::ostream &out);

} // namespace dovetail
