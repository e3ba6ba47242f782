// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How a body moves without deforming.

#pragma once

#include <dovetail/domain/numbering.h>

#include <vector>

namespace dovetail {

/// At this rank's unknowns of a block, in their order: the constant for scalars; for vectors translations and
/// then rotations about @p centre, with positions in units of @p length / 2.
template <int dim>
std::vector<std::vector<double>> rigid_motions(const Domain<dim> &domain, const Block &block,
                                               const dealii::Point<dim> &centre, double length);

} // namespace dovetail
