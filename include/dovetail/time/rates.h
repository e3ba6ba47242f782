// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the equations of a step see of a time scheme.

#pragma once

#include <deal.II/lac/trilinos_parallel_block_vector.h>

#include <vector>

namespace dovetail {

/// The rates of the unknowns x of a step,
/// @f[ \dot x = \mathrm{by\_value}\, x + \mathrm{rest}, \qquad
///     \ddot x = \mathrm{second\_by\_value}\, x + \mathrm{second\_rest}. @f]
/// A vector without blocks says that nobody asks for these rates.
struct Rates
{
  using Vector = dealii::TrilinosWrappers::MPI::BlockVector;

  double by_value = 0, second_by_value = 0; ///< [1/s], [1/s^2]
  Vector rest, second_rest;
  /// If asked for (TimeScheme::show_past()): rest = sum_j weights[j] past[j] with the states of the steps
  /// before. The weights and by_value add up to zero.
  std::vector<double> weights;
  std::vector<Vector> past;

  bool has_first() const { return rest.n_blocks() > 0; }
  bool has_second() const { return second_rest.n_blocks() > 0; }
};

} // namespace dovetail
