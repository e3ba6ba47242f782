// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Whether metals bend with one cell across their height.

#pragma once

#include <dovetail/scene/note.h>
#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

namespace dovetail {

/// Sentences about solids of degree 1 and 2 that yield or creep and whose inelastic strain eps_p (an internal
/// variable of nine components whose name ends with "strain") turns its sign within cells, as in a sheet that
/// bends with one cell across its height: the sum over the cells
/// @f[ 1 - \sum_K \Bigl|\int_K \varepsilon_p\Bigr| \Big/ \sum_K \int_K |\varepsilon_p| @f]
/// is one there. Two or three Gauss points miss the moment of a stress that is constant on either side of
/// the middle by 15 and -14 %. Strains that are small beside the whole one are left out. @p solution:
/// ghosted. Collective.
template <int dim>
NoteList explain_bent_cells(const Model<dim> &model, const Vector &solution, double t);

} // namespace dovetail
