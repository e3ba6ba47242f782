// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Whether interfaces leave a node to a domain's conditions.

#pragma once

#include <dovetail/domain/domain.h>

#include <algorithm>

namespace dovetail {

/// Whether interfaces that are active cover a node's surroundings on a face, so that conditions on a field do
/// not act on it.
template <int dim>
bool is_covered(const Domain<dim> &domain, const std::string &field,
                const typename Domain<dim>::BoundaryFace &face, const unsigned int node, const double t)
{
  return std::any_of(domain.covers.begin(), domain.covers.end(), [&](const Cover<dim> &cover) {
    return cover.nodes.count({{face.cell->active_cell_index(), face.number, node}}) > 0 &&
           cover.fields.count(field) > 0 && cover.is_active(t);
  });
}

} // namespace dovetail
