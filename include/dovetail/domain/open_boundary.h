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
/// the whole face (exact for degree 2p + 1) and, with negative weights, those of its covered part. Points
/// where the condition's toggle was off at the last good state are left out. One object per thread.
template <int dim>
class OpenBoundary
{
public:
  explicit OpenBoundary(const Domain<dim> &domain);

  using cell_iterator = typename dealii::Triangulation<dim>::active_cell_iterator;
  /// What there is at a point.
  struct Point
  {
    State<dim> state;         ///< of the domain; the gradients only if some condition sees them, else zero
    dealii::Tensor<1, dim> N; ///< outward, of the undeformed boundary
    std::vector<double> shape_values;                    ///< of the layout
    std::vector<dealii::Tensor<1, dim>> shape_gradients; ///< as the gradients
    double JxW;
  };
  using Visitor = std::function<void(const Point &point)>;

  /// Visit the points of a face on which @p condition acts at time @p t; none if it does not act there.
  /// @param unknowns of the cell, in the order component, node
  void for_each_point(const cell_iterator &cell, unsigned int face, const Condition<dim> &condition, double t,
                      const std::vector<double> &unknowns, const Visitor &visit);

private:
  void find_state(const std::vector<double> &unknowns);
  /// The value of a component at the point, with the unknowns of the cell.
  double value(unsigned int component, const std::vector<double> &unknowns) const;
  bool is_switched_off(const Condition<dim> &condition, const cell_iterator &cell);

  const Domain<dim> &domain;
  const bool with_gradients;
  dealii::FEFaceValues<dim> face_values;
  std::unique_ptr<ShapeEvaluator<dim>> anywhere; ///< made when a partly covered face needs it
  Point point;
};

} // namespace dovetail
