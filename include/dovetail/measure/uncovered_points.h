// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Points of an interface that face nothing.

#pragma once

#include <dovetail/interface/interface.h>

#include <nlohmann/json.hpp>

namespace dovetail {

/// The first @p n of them in the order of their coordinates, each as {"side", "point": [x, y(, z)]}: the same
/// on every number of ranks. Collective.
template <int dim>
nlohmann::ordered_json list_uncovered_points(const Pairing<dim> &pairing, unsigned int n,
                                             const MPI_Comm &communicator);

} // namespace dovetail
