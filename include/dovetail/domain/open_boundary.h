// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The part of a face on which a boundary condition acts.

#pragma once

#include <dovetail/domain/shapes.h>

#include <deal.II/fe/fe_values.h>

#include <functional>
#include <memory>
#include <vector>

namespace dovetail {

/// Quadrature points of boundary faces, without what interfaces cover of them (Domain::covers): the points of
/// the whole face (exact for degree 2p + 1) and, with negative weights, those of its covered part. One object
/// per thread.
template <int dim>
class OpenBoundary
{
public:
  explicit OpenBoundary(const Domain<dim> &domain);

  using cell_iterator = typename dealii::Triangulation<dim>::active_cell_iterator;
  /// At a point: its position, the shape values of the scalar element there, and its weight.
  using Visitor =
      std::function<void(const dealii::Point<dim> &X, const std::vector<double> &shape_values, double JxW)>;

  /// Visit the points of a face on which @p condition acts at time @p t; none if it does not act there.
  void for_each_point(const cell_iterator &cell, unsigned int face, const Condition<dim> &condition, double t,
                      const Visitor &visit);

private:
  const Domain<dim> &domain;
  dealii::FEFaceValues<dim> face_values;
  std::unique_ptr<ShapeEvaluator<dim>> anywhere; ///< made when a partly covered face needs it
  std::vector<double> shape_values;
  std::vector<dealii::Tensor<1, dim>> gradients;
};

} // namespace dovetail
