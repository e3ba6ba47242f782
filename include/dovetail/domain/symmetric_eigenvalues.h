// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Eigenvalues of a symmetric tensor.

#pragma once

#include <deal.II/base/symmetric_tensor.h>

#include <array>
#include <cmath>

namespace dovetail {

/// From the largest to the smallest. In 2D dealii::eigenvalues is not a number where two equal ones differ by
/// rounding.
template <int dim>
std::array<double, dim> symmetric_eigenvalues(const dealii::SymmetricTensor<2, dim> &A)
{
  if constexpr (dim == 2) {
    const double mean = trace(A) / 2, radius = std::hypot((A[0][0] - A[1][1]) / 2, A[0][1]);
    return {{mean + radius, mean - radius}};
  } else
    return dealii::eigenvalues(A);
}

} // namespace dovetail
