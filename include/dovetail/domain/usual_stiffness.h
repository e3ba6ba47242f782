// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How stiff a body is, before there is a matrix.

#pragma once

#include <dovetail/domain/domain.h>

namespace dovetail {

/// About a diagonal entry of the tangent of a field: d A_cJ / d (grad B_c)_J at rest, on average over the
/// components c and directions J, times h^(dim - 2), in the middle of the first own cell of the length h.
/// @return 0 if this rank has no cell, or the laws are not defined there, which the assembly tells
template <int dim>
double usual_stiffness(const Domain<dim> &domain, const Field &field);

} // namespace dovetail
