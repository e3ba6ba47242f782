// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Vectors of all unknowns.

#pragma once

#include <dovetail/domain/domain.h>

#include <deal.II/lac/trilinos_parallel_block_vector.h>

namespace dovetail {

/// All unknowns in the blocks of Numbering. Owned vectors are written, ghosted ones (owned, relevant and
/// partners' unknowns) are read only; the two are never mixed.
using Vector = dealii::TrilinosWrappers::MPI::BlockVector;

/// As compress(insert) on all ranks, each of which has written to what it owns and to nothing else: none
/// waits for another.
void keep_owned_values(Vector &x);

/// The part of a ghosted vector of all unknowns that belongs to one domain, in the numbering of its
/// DoFHandler, with ghosts.
template <int dim>
dealii::TrilinosWrappers::MPI::Vector domain_vector(const Domain<dim> &domain, const Vector &ghosted);

} // namespace dovetail
