// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Numbers that look as if they were given in different units.

#pragma once

#include <dovetail/scene/note.h>
#include <dovetail/system/model.h>

namespace dovetail {

/// A sentence for each body whose size and Young modulus cannot fit together: without Units, a body of more
/// than 50 units whose modulus is above 1e9 (a mesh in millimetres, moduli in pascals); with Units, a modulus
/// above 2000 GPa, more than that of diamond (about 1100 GPa). And about densities that
/// nothing uses, and what conditions find doubtful.
template <int dim>
NoteList notes_on_magnitudes(const Model<dim> &model, const Section &scene);

} // namespace dovetail
