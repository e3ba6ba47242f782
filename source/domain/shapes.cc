// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/quadrature.h>
#include <dovetail/domain/shapes.h>

namespace dovetail {

namespace {

template <int dim>
unsigned int nearest(const std::vector<dealii::Point<dim>> &points, const dealii::Point<dim> &to)
{
  unsigned int result = 0;
  for (unsigned int i = 1; i < points.size(); ++i)
    if (to.distance_square(points[i]) < to.distance_square(points[result]))
      result = i;
  return result;
}

} // namespace

template <int dim>
UnitShapes<dim>::UnitShapes(const Domain<dim> &domain)
    : layout(domain.layout()), has_simplices(domain.has_simplices()), of_hypercubes(domain.degree),
      of_simplices(has_simplices ? domain.degree : 1),
      values(has_simplices ? of_simplices.size() : of_hypercubes.size()), gradients(values.size())
{
  for (const auto &point : domain.scalar_element().get_unit_support_points())
    number.push_back(
        nearest(has_simplices ? of_simplices.support_points() : of_hypercubes.support_points(), point));
}

template <int dim>
void UnitShapes<dim>::evaluate(const dealii::Point<dim> &unit_point, const dealii::Tensor<2, dim> &inverse,
                               double *shape_values, dealii::Tensor<1, dim> *shape_gradients)
{
  if (has_simplices)
    of_simplices.evaluate(unit_point, values, gradients, no_hessians);
  else
    of_hypercubes.evaluate(unit_point, values, gradients, no_hessians);
  for (unsigned int a = 0; a < number.size(); ++a) {
    shape_values[a] = values[number[a]];
    shape_gradients[a] = gradients[number[a]] * inverse;
  }
  unsigned int i = number.size();
  for (unsigned int s = 1; s < layout.n_spaces(); ++s) {
    const dealii::FiniteElement<dim> &space_element = layout.element_of_space(s);
    for (unsigned int a = 0; a < space_element.n_dofs_per_cell(); ++a, ++i) {
      shape_values[i] = space_element.shape_value(a, unit_point);
      shape_gradients[i] = space_element.shape_grad(a, unit_point) * inverse;
    }
  }
}

template <int dim>
ShapeEvaluator<dim>::ShapeEvaluator(const Domain<dim> &domain)
    : domain(domain), unit_shapes(domain), geometry(domain.mapping_degree()),
      geometry_of_simplex(domain.has_simplices() ? domain.mapping_degree() : 1),
      measure_of_cell(domain.mapping(), domain.scalar_element(),
                      gauss_rule<dim>(domain.cell_shape(), domain.mapping_degree() + 1),
                      domain.measure.update_flags()),
      measure_of_face(domain.mapping(), domain.scalar_element(),
                      gauss_rule<dim - 1>(domain.face_shape(), domain.mapping_degree() + 1),
                      domain.measure.update_flags()),
      nodes(geometry.size()),
      geometry_gradients(domain.has_simplices() ? geometry_of_simplex.size() : geometry.size())
{
  if (domain.mapping_degree() > 1)
    geometry_nodes = std::make_unique<dealii::FEValues<dim>>(
        domain.mapping(), domain.scalar_element(),
        dealii::Quadrature<dim>(domain.has_simplices() ? geometry_of_simplex.support_points()
                                                       : geometry.support_points()),
        dealii::update_quadrature_points);
}

template <int dim>
void ShapeEvaluator<dim>::reinit(const cell_iterator &cell)
{
  if (domain.mapping_degree() == 1) {
    for (const unsigned int v : cell->vertex_indices())
      nodes[v] = cell->vertex(v);
    if (domain.has_simplices())
      inverse_of_simplex = dealii::invert(jacobian_of_simplex<dim>(cell));
    return;
  }
  geometry_nodes->reinit(cell);
  nodes = geometry_nodes->get_quadrature_points();
}

template <int dim>
dealii::Tensor<2, dim> ShapeEvaluator<dim>::inverse_jacobian(const dealii::Point<dim> &unit_point)
{
  if (domain.has_simplices() && domain.mapping_degree() == 1)
    return inverse_of_simplex;
  if (domain.has_simplices())
    geometry_of_simplex.evaluate(unit_point, no_values, geometry_gradients, no_hessians);
  else
    geometry.evaluate(unit_point, no_values, geometry_gradients, no_hessians);
  dealii::Tensor<2, dim> jacobian; // dX_i / dxi_j
  for (unsigned int a = 0; a < nodes.size(); ++a)
    for (unsigned int i = 0; i < dim; ++i)
      jacobian[i] += nodes[a][i] * geometry_gradients[a];
  return dealii::invert(jacobian);
}

template <int dim>
dealii::Point<dim> ShapeEvaluator<dim>::position(const dealii::Point<dim> &unit_point)
{
  std::vector<double> values(geometry_gradients.size());
  if (domain.has_simplices())
    geometry_of_simplex.evaluate(unit_point, values, geometry_gradients, no_hessians);
  else
    geometry.evaluate(unit_point, values, geometry_gradients, no_hessians);
  dealii::Point<dim> X;
  for (unsigned int a = 0; a < values.size(); ++a)
    X += values[a] * nodes[a];
  return X;
}

template <int dim>
double ShapeEvaluator<dim>::cell_measure(const cell_iterator &cell)
{
  // cell->measure() of a hexahedron cancels far from the origin
  measure_of_cell.reinit(cell);
  return sum_of(measure_of_cell);
}

template <int dim>
double ShapeEvaluator<dim>::face_measure(const cell_iterator &cell, const unsigned int face)
{
  measure_of_face.reinit(cell, face);
  return sum_of(measure_of_face);
}

template <int dim>
double ShapeEvaluator<dim>::sum_of(const dealii::FEValuesBase<dim> &points) const
{
  double sum = 0;
  for (const unsigned int q : points.quadrature_point_indices())
    sum += domain.measure(points, q);
  return sum;
}

template class UnitShapes<2>;
template class UnitShapes<3>;
template class ShapeEvaluator<2>;
template class ShapeEvaluator<3>;

} // namespace dovetail
