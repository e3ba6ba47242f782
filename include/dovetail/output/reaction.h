// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The resultant of the flux over a part of the boundary.

#pragma once

#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <set>
#include <vector>

namespace dovetail {

/// The consistent reaction of a boundary Gamma (all these faces), for each component of a field:
/// @f[ \int_\Omega A \cdot\nabla w - f\,w \,dV - \int_{\partial\Omega\setminus\Gamma} h\,w \,dA
///     \approx \int_\Gamma A\cdot N \,dA @f]
/// where w is a finite element function that is 1 on Gamma and falls to 0 inside the body. It balances the
/// sources and the other boundaries exactly and converges twice as fast as the flux integrated over the faces
/// (Carey, Chow & Seager 1985). N is the outward normal: heat that leaves is negative. Collective; @p
/// solution is ghosted.
///
/// w is 1 at all nodes of the cells behind Gamma, because the terms that a Nitsche tie has in the flux of the
/// test function and across a gap vanish only where w is constant. Nodes off Gamma where something else acts
/// (a prescribed value, or another interface and the cells behind it) are left out: there, and only there,
/// some of that tie's terms, which are as small as its jump, count wrongly.
template <int dim>
std::vector<double> reaction(const Model<dim> &model, const Domain<dim> &domain,
                             const typename SideFaces<dim>::Selection &gamma, const Field &field,
                             const Vector &solution, double t);

} // namespace dovetail
