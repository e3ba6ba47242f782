// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A picture of a scene before it is solved.

#pragma once

#include <dovetail/system/model.h>

#include <string>

namespace dovetail {

/// Writes `<directory>/check.pvd` with the folder `check`: the boundary of each body, coloured by `boundary
/// id`, by `condition` (the number of the one of the body that acts on it, from 1; 0: none) and by
/// `interface` (of those of the scene that name it, from 1); and each interface where its sides face each
/// other, with `gap` and `angle` in degrees. Names of results are never used. Collective. @pre The model is
/// paired.
/// @throw UserError or OutputError
template <int dim>
void write_preview(const Model<dim> &model, const std::string &directory);

} // namespace dovetail
