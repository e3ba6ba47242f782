// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What is doubtful about where bodies meet, before anything is solved.

#pragma once

#include <dovetail/scene/note.h>
#include <dovetail/system/model.h>

namespace dovetail {

/// About ties whose sides overlap or meet at a steep angle, on more than 1 % of their area. Facets of one
/// curved surface differ in both: with angles up to a between the normals of faces of the size h, they are up
/// to h a / 4 apart. Collective. @pre The model is paired.
template <int dim>
NoteList notes_on_sides(const Model<dim> &model);

/// About two bodies with a common field that touch each other where no interface ties them and no conditions
/// act on both: nothing passes from one to the other. Collective.
template <int dim>
NoteList notes_on_untied_bodies(const Model<dim> &model);

/// How far facets of one smooth surface are apart: of a size, with the largest angle between their normals.
inline double distance_of_facets(const double size, const double angle)
{
  return size * (0.01 + angle / 4);
}

} // namespace dovetail
