// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/quadrature.h>
#include <dovetail/domain/shapes.h>

namespace dovetail {

template <int dim>
ShapeEvaluator<dim>::ShapeEvaluator(const Domain<dim> &domain)
    : domain(domain), geometry(domain.mapping_degree()), element(domain.degree),
      geometry_of_simplex(domain.has_simplices() ? domain.mapping_degree() : 1),
      measure_of_cell(domain.mapping(), domain.scalar_element(),
                      gauss_rule<dim>(domain.cell_shape(), domain.mapping_degree() + 1),
                      domain.measure.update_flags()),
      measure_of_face(domain.mapping(), domain.scalar_element(),
                      gauss_rule<dim - 1>(domain.face_shape(), domain.mapping_degree() + 1),
                      domain.measure.update_flags()),
      nodes(geometry.size()), values(element.size()), geometry_gradients(geometry.size()),
      element_gradients(element.size())
{
  if (domain.mapping_degree() > 1)
    geometry_nodes = std::make_unique<dealii::FEValues<dim>>(
        domain.mapping(), domain.scalar_element(),
        dealii::Quadrature<dim>(domain.has_simplices() ? geometry_of_simplex.support_points()
                                                       : geometry.support_points()),
        dealii::update_quadrature_points);
  if (domain.has_simplices()) {
    geometry_gradients.resize(geometry_of_simplex.size());
    return;
  }
  for (const auto &point : domain.scalar_element().get_unit_support_points()) {
    unsigned int nearest = 0;
    for (unsigned int i = 1; i < element.size(); ++i)
      if (point.distance_square(element.support_points()[i]) <
          point.distance_square(element.support_points()[nearest]))
        nearest = i;
    lexicographic.push_back(nearest);
  }
}

template <int dim>
void ShapeEvaluator<dim>::reinit(const cell_iterator &cell)
{
  if (domain.has_simplices() && domain.mapping_degree() == 1) {
    inverse_of_simplex = dealii::invert(jacobian_of_simplex<dim>(cell));
    return;
  }
  if (domain.mapping_degree() == 1) {
    for (const unsigned int v : cell->vertex_indices())
      nodes[v] = cell->vertex(v);
    return;
  }
  geometry_nodes->reinit(cell);
  nodes = geometry_nodes->get_quadrature_points();
}

template <int dim>
void ShapeEvaluator<dim>::evaluate_simplex(const dealii::Point<dim> &unit_point, double *shape_values,
                                           dealii::Tensor<1, dim> *shape_gradients)
{
  if (domain.mapping_degree() > 1) {
    geometry_of_simplex.evaluate(unit_point, no_values, geometry_gradients, no_hessians);
    dealii::Tensor<2, dim> jacobian; // dX_i / dxi_j
    for (unsigned int a = 0; a < nodes.size(); ++a)
      for (unsigned int i = 0; i < dim; ++i)
        jacobian[i] += nodes[a][i] * geometry_gradients[a];
    inverse_of_simplex = dealii::invert(jacobian);
  }
  evaluate_spaces(0, unit_point, inverse_of_simplex, shape_values, shape_gradients);
}

/// The functions of the spaces from the @p first one on. @p inverse: dxi_i / dX_j
template <int dim>
void ShapeEvaluator<dim>::evaluate_spaces(const unsigned int first, const dealii::Point<dim> &unit_point,
                                          const dealii::Tensor<2, dim> &inverse, double *shape_values,
                                          dealii::Tensor<1, dim> *shape_gradients) const
{
  unsigned int i = first == 0 ? 0 : element.size();
  for (unsigned int s = first; s < domain.layout().n_spaces(); ++s) {
    const dealii::FiniteElement<dim> &space_element = domain.layout().element_of_space(s);
    for (unsigned int a = 0; a < space_element.n_dofs_per_cell(); ++a, ++i) {
      shape_values[i] = space_element.shape_value(a, unit_point);
      shape_gradients[i] = space_element.shape_grad(a, unit_point) * inverse;
    }
  }
}

template <int dim>
void ShapeEvaluator<dim>::evaluate(const dealii::Point<dim> &unit_point, double *shape_values,
                                   dealii::Tensor<1, dim> *shape_gradients)
{
  if (domain.has_simplices()) {
    evaluate_simplex(unit_point, shape_values, shape_gradients);
    return;
  }
  element.evaluate(unit_point, values, element_gradients, no_hessians);
  const bool is_isoparametric = geometry.size() == element.size(); // then the bases are the same
  if (!is_isoparametric)
    geometry.evaluate(unit_point, no_values, geometry_gradients, no_hessians);
  const auto &gradients_of_geometry = is_isoparametric ? element_gradients : geometry_gradients;
  dealii::Tensor<2, dim> jacobian; // dX_i / dxi_j
  for (unsigned int a = 0; a < nodes.size(); ++a)
    for (unsigned int i = 0; i < dim; ++i)
      jacobian[i] += nodes[a][i] * gradients_of_geometry[a];
  const dealii::Tensor<2, dim> inverse = dealii::invert(jacobian);
  for (unsigned int a = 0; a < lexicographic.size(); ++a) {
    shape_values[a] = values[lexicographic[a]];
    shape_gradients[a] = element_gradients[lexicographic[a]] * inverse;
  }
  evaluate_spaces(1, unit_point, inverse, shape_values, shape_gradients);
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

template class ShapeEvaluator<2>;
template class ShapeEvaluator<3>;

} // namespace dovetail
