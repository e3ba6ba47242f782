// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The resultant of the flux over a part of the boundary.

#pragma once

#include <dovetail/system/vector.h>

#include <set>
#include <vector>

namespace dovetail {

/// The consistent reaction of a boundary Gamma (all faces with these ids), for each component of a field:
/// @f[ \int_\Omega A \cdot\nabla w - f\,w \,dV - \int_{\partial\Omega\setminus\Gamma} h\,w \,dA
///     \approx \int_\Gamma A\cdot N \,dA @f]
/// where w is the finite element function that is 1 at the nodes of Gamma and 0 at all others. It balances
/// the sources and the other boundaries exactly and converges twice as fast as the flux integrated over the
/// faces (Carey, Chow & Seager 1985). N is the outward normal: heat that leaves is negative. Collective; @p
/// solution is ghosted.
template <int dim>
std::vector<double> reaction(const Domain<dim> &domain,
                             const std::set<dealii::types::boundary_id> &boundary_ids, const Field &field,
                             const Vector &solution, double t);

} // namespace dovetail
