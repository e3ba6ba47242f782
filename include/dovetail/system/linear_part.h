// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Functions of degree one within those of a higher degree, for multigrid.

#pragma once

#include <dovetail/domain/domain.h>
#include <dovetail/domain/edge_lengths.h>
#include <dovetail/domain/numbering.h>

#include <dovetail/solve/row_sums.h>

#include <deal.II/lac/affine_constraints.h>

#include <set>

namespace dovetail {

/// Of each owned unknown of the block of a field: the unknowns, and the weights, that it is the sum of in a
/// function of degree one, those at the vertices of its cell. A constrained unknown is the sum of those it
/// follows.
///
/// Along edges of a quadrilateral or hexahedron that are longer than @p smallest_stretch times the shortest
/// ones, the functions keep their degree, so that an unknown inside such an edge is the sum of itself. What
/// varies along it between vertices costs so little energy that a smoother, which sees the short edges, would
/// leave it. In an element of degree two that is three times as long in x as in y and z, a node at (1/2, 1/2,
/// 0) is the mean of those at (1/2, 0, 0) and (1/2, 1, 0). A sum may name an unknown that is a sum itself, of
/// another cell. In cells with a face of the boundaries @p tied, the ratio is dovetail::smallest_stretch.
template <int dim>
RowSums
linear_part(const Domain<dim> &domain, const Block &block,
            const dealii::AffineConstraints<double> &constraints = dealii::AffineConstraints<double>(),
            double smallest_stretch = dovetail::smallest_stretch,
            const std::set<dealii::types::boundary_id> &tied = {});

} // namespace dovetail
