// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Whether interfaces leave a node to a domain's conditions.

#pragma once

#include <dovetail/domain/domain.h>

#include <algorithm>

namespace dovetail {

/// Whether interfaces that are active cover the surroundings on a face of a node of a field, so that
/// conditions on the field do not act on it.
template <int dim>
bool is_covered(const Domain<dim> &domain, const Field &field, const typename Domain<dim>::BoundaryFace &face,
                const unsigned int node, const double t)
{
  return std::any_of(domain.covers.begin(), domain.covers.end(), [&](const Cover<dim> &cover) {
    return cover.nodes.count({{face.cell->active_cell_index(), face.number,
                               domain.layout().space(field.first_component), node}}) > 0 &&
           cover.fields.count(field.name) > 0 && cover.is_active(t);
  });
}

} // namespace dovetail
