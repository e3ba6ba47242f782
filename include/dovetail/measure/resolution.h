// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Whether a mesh resolves what a law makes of the solution.

#pragma once

#include <dovetail/scene/note.h>
#include <dovetail/system/model.h>

#include <string>
#include <vector>

namespace dovetail {

/// How much a conductivity or a stiffness may vary within a cell without a note.
inline constexpr double largest_variation = 100;

/// Sentences about fields whose |dA/dgrad B| varies more than that over the quadrature points of one cell.
/// Where it depends on the solution, the discrete equations may have several solutions on such a mesh; where
/// it is a formula of X, quadrature sees it at a few points only. The result may be far from the true one.
/// Solids that remember are left out, because they have no stiffness at rest.
/// And about mixed solids at large strain whose J at the points of one cell spreads about the volume that
/// belongs to the pressure, as where a mesh is too coarse. @p solution: ghosted. Collective.
template <int dim>
NoteList explain_resolution(const Model<dim> &model, const Vector &solution, double t);

} // namespace dovetail
