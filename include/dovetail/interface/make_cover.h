// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What an interface leaves to the boundary conditions on its boundary ids.

#pragma once

#include <dovetail/interface/interface.h>

namespace dovetail {

/// The cover of one side by the other. A node of a face is covered if the face is, 1e-3 of the way from the
/// node towards each of its corners. Collective; @pre the interface is
/// paired.
template <int dim>
Cover<dim> make_cover(const Interface<dim> &interface, unsigned int side, const MPI_Comm &communicator);

} // namespace dovetail
