// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a run would do, in tables: bodies, boundaries, conditions and what nothing holds.

#pragma once

#include <dovetail/output/notes.h>
#include <dovetail/scene/scene_text.h>
#include <dovetail/system/model.h>

namespace dovetail {

/// Prints the extents, volumes and masses of all bodies, the areas of their boundaries with the names that
/// files give them, what each condition acts on, and notes the motions that nothing holds, always or, with
/// toggles, at one of the @p times. Collective. @pre The model is paired.
template <int dim>
void rehearse(const Model<dim> &model, const SceneText &text, const Section &scene,
              const std::vector<double> &times, Log &log, Notes &notes);

} // namespace dovetail
