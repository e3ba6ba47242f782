// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where there is space between two sides, and where they overlap.

#pragma once

#include <dovetail/interface/interface.h>

namespace dovetail {

/// At a point of a pairing |X_src + shift - X_dst|, negative where the sides overlap, that is where
/// (X_dst - X_src - shift).(N_src - N_dst) < 0.
template <int dim>
double signed_gap(const Interface<dim> &interface, unsigned int q);

/// The largest distances of facing points, apart and overlapping.
struct Gaps
{
  double largest_gap = 0, largest_overlap = 0;
};

/// Of the points of all ranks. Collective.
template <int dim>
Gaps find_gaps(const Interface<dim> &interface, const MPI_Comm &communicator);

} // namespace dovetail
