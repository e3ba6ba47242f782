// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Constraints between unknowns of all domains, the same on every rank that needs them.

#pragma once

#include <dovetail/domain/constraint_lines.h>
#include <dovetail/domain/numbering.h>

#include <deal.II/lac/affine_constraints.h>

#include <set>

namespace dovetail {

/// From the lines of the unknowns that each rank owns, the closed constraints of all unknowns in @p needed
/// and, since chains are resolved locally, of the unknowns their lines refer to, and so on. Collective; only
/// lines that some other rank asks for are sent.
///
/// Where unknowns follow each other in a circle, as at a point where several interfaces meet, the one with
/// the largest index is set free, and so on until no circle is left; @p unconstrained gets those that this
/// rank owns.
dealii::AffineConstraints<double>
close_constraints(const ConstraintLines &owned_lines, const Numbering &numbering,
                  const dealii::IndexSet &needed, const MPI_Comm &communicator,
                  std::set<dealii::types::global_dof_index> *unconstrained = nullptr);

} // namespace dovetail
