// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/open_boundary.h>
#include <dovetail/domain/quadrature.h>

#include <algorithm>
#include <limits>
#include <numeric>

namespace dovetail {

template <int dim>
OpenBoundary<dim>::OpenBoundary(const Domain<dim> &domain)
    : domain(domain), with_gradients(std::any_of(domain.conditions().begin(), domain.conditions().end(),
                                                 [](const auto &condition) {
                                                   return condition->sees_gradients() || condition->is_weak();
                                                 })),
      face_values(domain.mapping(), domain.layout().shape_element(),
                  gauss_rule<dim - 1>(domain.face_shape(), domain.degree + 1),
                  dealii::update_values | dealii::update_quadrature_points | dealii::update_JxW_values |
                      dealii::update_normal_vectors |
                      (with_gradients ? dealii::update_gradients : dealii::update_default)),
      point({State<dim>(domain.n_components()),
             {},
             std::vector<double>(domain.layout().n_shapes()),
             std::vector<dealii::Tensor<1, dim>>(domain.layout().n_shapes()),
             0})
{
}

template <int dim>
void OpenBoundary<dim>::find_state(const std::vector<double> &unknowns)
{
  const CellLayout<dim> &layout = domain.layout();
  if (with_gradients)
    evaluate_state(layout, point.shape_values.data(), point.shape_gradients.data(), unknowns.data(),
                   point.state);
  else
    for (unsigned int c = 0; c < domain.n_components(); ++c)
      point.state.value[c] = value(c, unknowns);
}

template <int dim>
double OpenBoundary<dim>::value(const unsigned int component, const std::vector<double> &unknowns) const
{
  const CellLayout<dim> &layout = domain.layout();
  const auto values = point.shape_values.begin() + layout.first_shape(component);
  return std::inner_product(values, values + layout.n_nodes(component),
                            unknowns.begin() + layout.first(component), 0.);
}

/// At the point. Where no step has begun, nothing is switched off; where the toggle is not a number, neither
/// is the weight, so that the step fails.
template <int dim>
bool OpenBoundary<dim>::is_switched_off(const Condition<dim> &condition, const cell_iterator &cell)
{
  if (!condition.follows_fields())
    return false;
  const std::vector<double> &unknowns = domain.last_good.of_cell(cell->active_cell_index());
  if (unknowns.empty())
    return false;
  std::vector<double> values;
  for (const auto &component : condition.components_of_toggle())
    values.push_back(component ? value(*component, unknowns) : 0);
  const std::optional<bool> is_on = condition.is_on(point.state.X, point.state.t, values);
  if (!is_on)
    point.JxW = std::numeric_limits<double>::quiet_NaN();
  return is_on == false;
}

template <int dim>
void OpenBoundary<dim>::for_each_point(const cell_iterator &cell, const unsigned int face,
                                       const Condition<dim> &condition, const double t,
                                       const std::vector<double> &unknowns, const Visitor &visit)
{
  if (condition.boundary_ids.count(cell->face(face)->boundary_id()) == 0 || !condition.is_active(t))
    return;
  double share = 0;
  std::vector<const typename Cover<dim>::Face *> covered;
  for (const Cover<dim> &cover : domain.covers)
    if (cover.fields.count(condition.field.name) > 0 && cover.is_active(t))
      if (const auto found = cover.faces.find({cell->active_cell_index(), face});
          found != cover.faces.end()) {
        share += found->second.share;
        covered.push_back(&found->second);
      }
  if (share > 1 - 1e-12)
    return;

  face_values.reinit(cell, face);
  point.state.t = t;
  for (const unsigned int q : face_values.quadrature_point_indices()) {
    for (unsigned int a = 0; a < point.shape_values.size(); ++a) {
      const unsigned int i = domain.layout().shape_index(a);
      point.shape_values[a] = face_values.shape_value(i, q);
      if (with_gradients)
        point.shape_gradients[a] = face_values.shape_grad(i, q);
    }
    point.state.X = face_values.quadrature_point(q);
    if (domain.is_on_axis(point.state.X))
      point.state.X[0] = 0;
    point.N = face_values.normal_vector(q);
    point.JxW = domain.measure(face_values, q);
    if (is_switched_off(condition, cell))
      continue;
    find_state(unknowns);
    visit(point);
  }
  if (covered.empty())
    return;
  if (!anywhere)
    anywhere = std::make_unique<ShapeEvaluator<dim>>(domain);
  anywhere->reinit(cell);
  for (const auto *part : covered)
    for (unsigned int q = 0; q < part->JxW.size(); ++q) {
      anywhere->evaluate(part->unit_points[q], point.shape_values.data(), point.shape_gradients.data());
      point.state.X = domain.mapping().transform_unit_to_real_cell(cell, part->unit_points[q]);
      point.N = part->N[q];
      point.JxW = -part->JxW[q];
      if (is_switched_off(condition, cell))
        continue;
      find_state(unknowns);
      visit(point);
    }
}

template class OpenBoundary<2>;
template class OpenBoundary<3>;

} // namespace dovetail
