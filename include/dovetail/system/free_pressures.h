// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Pressures of incompressible bodies that are known but for a constant.

#pragma once

#include <dovetail/solve/block_matrix.h>
#include <dovetail/system/model.h>

#include <deal.II/lac/affine_constraints.h>

#include <string>
#include <vector>

namespace dovetail {

/// A constant pressure z of tied bodies, with the forces of multipliers that belong to it, which no equation
/// sees: K z = 0, because no free displacement changes their volume.
template <int dim>
struct FreePressure
{
  std::vector<const Domain<dim> *> bodies;
  unsigned int block; ///< of the pressure of the first body
  Vector mode;
  Vector weights; ///< their product with the unknowns is the integral of the pressures
  double volume;  ///< of the mode

  std::string in_words() const; ///< "left, right"
  /// Collective.
  double mean(const Vector &x) const { return weights * x / volume; }
};

/// K - s e e^T for each of them, with e a pressure of one cell or node, and s a measure of its volume over
/// the shear modulus: a regular matrix with the solutions of K in which e is zero, where K has some. Nothing
/// where K has no entries. Collective.
template <int dim>
void hold(const std::vector<FreePressure<dim>> &pressures, BlockMatrix &tangent);

/// Bodies that ties of the displacement join have one constant. It costs nothing without a pressure, and
/// without products of @p tangent K where all bodies are compressible. Collective.
/// @param constraints on which K is assembled
template <int dim>
std::vector<FreePressure<dim>> find_free_pressures(const Model<dim> &model, double t,
                                                   const BlockMatrix &tangent,
                                                   const dealii::AffineConstraints<double> &constraints);

} // namespace dovetail
