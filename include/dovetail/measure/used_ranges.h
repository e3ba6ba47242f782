// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Whether what the scene gives by formulas is asked only where it means something.

#pragma once

#include <dovetail/scene/note.h>
#include <dovetail/scene/scene_text.h>
#include <dovetail/system/model.h>

namespace dovetail {

/// About tables of a material or a condition that a field looks up beyond their ends by more than 1 % of
/// their width, where they stay constant. Collective; @p solution is ghosted.
template <int dim>
NoteList explain_tables(const Model<dim> &model, const SceneText &text, const Vector &solution);

/// About coefficients of conditions that are negative somewhere at the time @p t, or earlier if they depend
/// on no field . Collective; @p solution is ghosted.
template <int dim>
NoteList explain_coefficients(const Model<dim> &model, const Vector &solution, double t);

} // namespace dovetail
