// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Which boundaries of different domains face each other.

#pragma once

#include <dovetail/domain/domain.h>

#include <array>
#include <memory>
#include <set>
#include <vector>

namespace dovetail {

/// Whether two domains have a field of one name.
template <int dim>
bool share_a_field(const Domain<dim> &one, const Domain<dim> &other);

/// Boundary ids of two domains of which some part faces the other within @p search_radius face sizes, without
/// a third domain between them.
struct FacingBoundaries
{
  std::array<unsigned int, 2> domains;
  std::array<std::set<dealii::types::boundary_id>, 2> ids;
};

/// One entry for each pair of domains that share a field and face each other, in the order of the domains.
/// Collective.
template <int dim>
std::vector<FacingBoundaries> find_facing_boundaries(const std::vector<std::unique_ptr<Domain<dim>>> &domains,
                                                     double search_radius, const MPI_Comm &communicator);

} // namespace dovetail
