// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where the largest entry of a vector of all unknowns is.

#pragma once

#include <dovetail/system/model.h>

#include <string>

namespace dovetail {

/// ", in the cell at (1, 2)": the centre of a cell at whose nodes the largest absolute entry of a block of
/// @p vector is, the same on all ranks; nothing for multipliers. Collective.
template <int dim>
std::string in_cell_of_largest(const Model<dim> &model, const Vector &vector, unsigned int block);

} // namespace dovetail
