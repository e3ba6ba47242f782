// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Shape functions of a domain's element at any points of a cell.

#pragma once

#include <dovetail/domain/domain.h>
#include <dovetail/domain/geometry.h>

#include <deal.II/fe/fe_values.h>

#include <memory>
#include <vector>

namespace dovetail {

/// dX_i / dxi_j of a straight triangle or tetrahedron.
template <int dim>
dealii::Tensor<2, dim>
jacobian_of_simplex(const typename dealii::Triangulation<dim>::active_cell_iterator &cell)
{
  dealii::Tensor<2, dim> jacobian;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int j = 0; j < dim; ++j)
      jacobian[i][j] = cell->vertex(j + 1)[i] - cell->vertex(0)[i];
  return jacobian;
}

/// Values and gradients of all shape functions (CellLayout) at reference points of any cell whose geometry is
/// known there.
template <int dim>
class UnitShapes
{
public:
  explicit UnitShapes(const Domain<dim> &domain);

  /// Write n_shapes() values and gradients by X. @p inverse: dxi_i / dX_j
  void evaluate(const dealii::Point<dim> &unit_point, const dealii::Tensor<2, dim> &inverse, double *values,
                dealii::Tensor<1, dim> *gradients);

private:
  const CellLayout<dim> &layout;
  const bool has_simplices;
  const LagrangeBasis<dim> of_hypercubes;
  const SimplexBasis<dim> of_simplices;
  std::vector<unsigned int> number; ///< in that basis, of the shape functions of the scalar element
  std::vector<double> values;
  std::vector<dealii::Tensor<1, dim>> gradients;
  std::vector<dealii::Tensor<2, dim>> no_hessians;
};

/// Values and gradients (by X) of all shape functions (CellLayout) at reference points of a cell, as FEValues
/// would give them, but without its set-up for every new set of points.
template <int dim>
class ShapeEvaluator
{
public:
  using cell_iterator = typename dealii::Triangulation<dim>::active_cell_iterator;

  explicit ShapeEvaluator(const Domain<dim> &domain);

  void reinit(const cell_iterator &cell);
  /// dxi_i / dX_j at @p unit_point of the current cell.
  dealii::Tensor<2, dim> inverse_jacobian(const dealii::Point<dim> &unit_point);
  /// X at @p unit_point of the current cell.
  dealii::Point<dim> position(const dealii::Point<dim> &unit_point);
  /// Write n_shapes() values and gradients at @p unit_point of the current cell.
  void evaluate(const dealii::Point<dim> &unit_point, double *values, dealii::Tensor<1, dim> *gradients)
  {
    unit_shapes.evaluate(unit_point, inverse_jacobian(unit_point), values, gradients);
  }

  double cell_measure(const cell_iterator &cell);                    ///< volume
  double face_measure(const cell_iterator &cell, unsigned int face); ///< area

private:
  double sum_of(const dealii::FEValuesBase<dim> &points) const;

  const Domain<dim> &domain;
  UnitShapes<dim> unit_shapes;
  const LagrangeBasis<dim> geometry;                     ///< of hypercubes
  const SimplexBasis<dim> geometry_of_simplex;           ///< of curved triangles or tetrahedra
  std::unique_ptr<dealii::FEValues<dim>> geometry_nodes; ///< of curved cells
  dealii::FEValues<dim> measure_of_cell;
  dealii::FEFaceValues<dim> measure_of_face;
  std::vector<dealii::Point<dim>> nodes;
  std::vector<dealii::Tensor<1, dim>> geometry_gradients;
  std::vector<dealii::Tensor<2, dim>> no_hessians;
  std::vector<double> no_values;
  dealii::Tensor<2, dim> inverse_of_simplex; ///< dxi_i / dX_j of a straight one
};

} // namespace dovetail
