// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How a body moves without deforming.

#pragma once

#include <dovetail/domain/numbering.h>
#include <dovetail/system/vector.h>

#include <vector>

namespace dovetail {

/// Where an unknown is: at its node, or at the centre of its cell if it is of a discontinuous function.
template <int dim>
struct Place
{
  dealii::Point<dim> position;
  unsigned int component = 0; ///< of its field
};

/// Of this rank's unknowns of a block, in their order.
template <int dim>
std::vector<Place<dim>> places_of_unknowns(const Domain<dim> &domain, const Block &block);

/// At some of this rank's unknowns of a block, by default all, in their order: the constant for scalars; for
/// vectors translations and then rotations about @p centre, with positions in units of @p length / 2. @p
/// displacements: all unknowns, ghosted; the positions are those of the displaced body then.
template <int dim>
std::vector<std::vector<double>>
rigid_motions(const Domain<dim> &domain, const Block &block, const dealii::Point<dim> &centre, double length,
              const std::vector<unsigned int> *unknowns = nullptr, const Vector *displacements = nullptr);

} // namespace dovetail
