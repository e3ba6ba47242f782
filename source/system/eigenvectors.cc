// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/eigenvectors.h>

#include <deal.II/lac/lapack_full_matrix.h>

#include <limits>

namespace dovetail {

std::pair<dealii::Vector<double>, dealii::FullMatrix<double>>
eigenvectors(const dealii::FullMatrix<double> &matrix)
{
  dealii::LAPACKFullMatrix<double> copy(matrix.m(), matrix.n());
  copy = matrix;
  dealii::Vector<double> values;
  dealii::FullMatrix<double> vectors;
  const double all = std::numeric_limits<double>::max();
  copy.compute_eigenvalues_symmetric(-all, all, 0., values, vectors);
  return {values, vectors};
}

} // namespace dovetail
