// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What happens at one point of a body.

#pragma once

#include <dovetail/domain/cell_points.h>
#include <dovetail/system/vector.h>

#include <deal.II/fe/fe_values.h>

#include <vector>

namespace dovetail {

/// The state of a domain at one point after another, and what its laws answer there: they are asked when
/// somebody wants to know, once.
template <int dim>
class DomainPoint
{
public:
  using BoundaryFace = typename Domain<dim>::BoundaryFace;

  /// @p solution is ghosted and kept by reference.
  DomainPoint(const Domain<dim> &domain, const Vector &solution, double t);

  static dealii::UpdateFlags needed() ///< by enter(), of FEValues
  {
    return dealii::update_values | dealii::update_gradients | dealii::update_quadrature_points;
  }

  /// Take the points of an owned cell, or of its @p face: those of @p values of the layout's shape_element(),
  /// which must stay as they are.
  void enter(const dealii::FEValuesBase<dim> &values, const BoundaryFace *face = nullptr);
  void move_to(unsigned int q); ///< one of them
  /// From now on at this point: the value of a component (@p direction = dim) or its derivative in a
  /// direction is larger by that. For differences.
  void shift(unsigned int component, unsigned int direction, double amount);

  const Domain<dim> &domain;

  typename dealii::Triangulation<dim>::cell_iterator cell() const { return points->get_cell(); }
  const BoundaryFace *face() const { return boundary_face; } ///< nullptr: a point of the cell
  const State<dim> &state() const { return point.state; }

  /// Fluxes of all components, NaN where a law is not defined. No derivatives.
  const Response<dim> &response();
  /// Material::cauchy_stress(). @pre The material has a displacement.
  const dealii::Tensor<2, 3> &cauchy_stress();
  /// Material::displacement_gradient(), H = F - I = grad u. @pre likewise.
  dealii::Tensor<2, 3> displacement_gradient() const;
  double energy_density() const { return point.energy_density(); } ///< Material::energy_density()

  /// Of the cell, in the order component, node (Domain::cell_dofs).
  const std::vector<dealii::types::global_dof_index> &dofs() const { return cell_dofs; }
  const std::vector<double> &shape_values() const { return point.shape_values(); } ///< of all spaces
  const std::vector<dealii::Tensor<1, dim>> &shape_gradients() const { return point.shape_gradients(); }

private:
  const Vector &solution;
  const dealii::FEValuesBase<dim> *points = nullptr;
  const BoundaryFace *boundary_face = nullptr;
  CellPoints<dim> point;
  dealii::Tensor<2, 3> stress;
  bool has_fluxes = false, has_stress = false; ///< of this point
  std::vector<dealii::types::global_dof_index> cell_dofs;
  std::vector<double> unknowns;
};

} // namespace dovetail
