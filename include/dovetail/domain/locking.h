// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Bodies that are stiffer than they should be because they hardly change their volume.

#pragma once

#include <dovetail/domain/domain.h>
#include <dovetail/scene/note.h>

namespace dovetail {

/// What a user should know of a nearly incompressible solid of low degree: displacements of degree 1 cannot
/// follow a motion without change of volume beyond a Poisson ratio of 0.45, those of degree 2 beyond 0.49,
/// and the body locks. The ratio is that of the tangent at rest, D_1122 / (D_1111 + D_1122). Collective.
template <int dim>
NoteList notes_on_locking(const Domain<dim> &domain, const MPI_Comm &communicator);

} // namespace dovetail
