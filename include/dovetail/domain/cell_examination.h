// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Whether all cells of a mesh, as they are mapped, have a volume and lie the right way round.

#pragma once

#include <dovetail/domain/mesh.h>

#include <deal.II/fe/fe.h>
#include <deal.II/fe/mapping.h>

namespace dovetail {

/// det dX/dxi > 0 at the quadrature points of @p element on every cell. Collective.
/// @throw UserError that says where the first cell is for which this is not so, and how many there are
template <int dim>
void examine_cells(const Section &section, const Mesh<dim> &mesh, const dealii::Mapping<dim> &mapping,
                   const dealii::FiniteElement<dim> &element, const MPI_Comm &communicator);

} // namespace dovetail
