// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Meshes that no computer at hand can hold are refused before they are made.

#pragma once

#include <dovetail/scene/section.h>

#include <deal.II/base/mpi.h>

namespace dovetail {

/// Fail if a mesh of so many cells, of which @p n_copies ranks hold all, needs more memory than all the
/// computers of @p communicator have. @p entry asks for it. A lower estimate: the cells with one unknown
/// each, and its row of a matrix. Collective.
template <int dim>
void check_cells(const Section &section, const std::string &entry, double n_cells, double n_copies,
                 const MPI_Comm &communicator);

/// As above for the unknowns of a domain, p^dim for each cell and component, which must also be fewer than
/// deal.II and Trilinos can number.
template <int dim>
void check_unknowns(const Section &section, double n_cells, unsigned int degree, unsigned int n_components,
                    const MPI_Comm &communicator);

/// @throw UserError if all domains together have more unknowns than can be numbered.
void check_total(double n_unknowns);

} // namespace dovetail
