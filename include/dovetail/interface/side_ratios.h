// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How much the two sides of an interface differ.

#pragma once

#include <dovetail/interface/interface.h>
#include <dovetail/scene/note.h>

#include <string>

namespace dovetail {

/// Destination over source.
struct SideRatios
{
  double face_size = 1; ///< mean diameter of the faces
  double stiffness =
      1; ///< |dA/dgrad B| in the undeformed state at B = 0, the largest ratio over the tied fields
};

/// Collective. A law that is not defined in that state counts as a ratio of 1.
template <int dim>
SideRatios side_ratios(const Interface<dim> &interface, const MPI_Comm &communicator);

/// Of the gap between facing points X (of the source, of the destination), the share that the extension of
/// the side @p own bridges, whose gradient is k_partner/k_own times as large as the partner's: none up to
/// equal stiffnesses k and in a body that is tied to itself, 1 - k_partner/k_own beyond. k is |dA/dgrad B|
/// there, before the first step.
template <int dim>
double own_share_of_gap(const Interface<dim> &interface, const TiedField &field, unsigned int own,
                        const std::array<dealii::Point<dim>, 2> &X);

/// How much stiffer a destination may be that follows a source whose trace it cannot represent.
inline constexpr double largest_stiffness_ratio = 3;

/// What a user should know if the destination follows the source and is much stiffer: a stiff body that must
/// take another one's trace answers every deviation of that trace from its own with its stiffness. Its
/// deformation stays right, but the flux through the interface errs by the ratio of the stiffnesses.
Note note_on_stiff_destination(double stiffness);

/// What a user should know if a destination's multipliers tie a source that is softer and finer: between two
/// of them the source slips, the more the larger its strain.
Note note_on_fine_soft_source(const SideRatios &ratios);

} // namespace dovetail
