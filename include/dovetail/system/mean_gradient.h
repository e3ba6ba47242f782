// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How much a displacement turns and strains bodies.

#pragma once

#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

namespace dovetail {

/// Of bodies of large strain (Material::has_large_strain), with displacements u, the largest root mean square
/// of grad u [-] over a body of volume V,
/// @f$ ( \frac{1}{V} \int |\nabla u|^2 \, dV )^{1/2} @f$, by the gradient at the centre of each cell.
/// @param ghosted the unknowns of this rank's cells. Collective.
template <int dim>
double largest_mean_gradient(const Model<dim> &model, const Vector &ghosted);

} // namespace dovetail
