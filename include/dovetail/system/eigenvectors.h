// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Of small symmetric matrices, by LAPACK.

#pragma once

#include <deal.II/lac/full_matrix.h>
#include <deal.II/lac/vector.h>

#include <utility>

namespace dovetail {

/// Eigenvalues of a symmetric matrix in increasing order, and its eigenvectors, which are columns.
std::pair<dealii::Vector<double>, dealii::FullMatrix<double>>
eigenvectors(const dealii::FullMatrix<double> &matrix);

} // namespace dovetail
