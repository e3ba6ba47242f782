// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/open_boundary.h>
#include <dovetail/domain/quadrature.h>

namespace dovetail {

template <int dim>
OpenBoundary<dim>::OpenBoundary(const Domain<dim> &domain)
    : domain(domain),
      face_values(domain.mapping(), domain.scalar_element(),
                  gauss_rule<dim - 1>(domain.face_shape(), domain.degree + 1),
                  dealii::update_values | dealii::update_quadrature_points | dealii::update_JxW_values),
      shape_values(domain.n_nodes()), gradients(domain.n_nodes())
{
}

template <int dim>
void OpenBoundary<dim>::for_each_point(const cell_iterator &cell, const unsigned int face,
                                       const Condition<dim> &condition, const double t, const Visitor &visit)
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
  for (const unsigned int q : face_values.quadrature_point_indices()) {
    for (unsigned int a = 0; a < shape_values.size(); ++a)
      shape_values[a] = face_values.shape_value(a, q);
    visit(face_values.quadrature_point(q), shape_values, domain.measure(face_values, q));
  }
  if (covered.empty())
    return;
  if (!anywhere)
    anywhere = std::make_unique<ShapeEvaluator<dim>>(domain);
  anywhere->reinit(cell);
  for (const auto *part : covered)
    for (unsigned int q = 0; q < part->JxW.size(); ++q) {
      anywhere->evaluate(part->unit_points[q], shape_values.data(), gradients.data());
      visit(domain.mapping().transform_unit_to_real_cell(cell, part->unit_points[q]), shape_values,
            -part->JxW[q]);
    }
}

template class OpenBoundary<2>;
template class OpenBoundary<3>;

} // namespace dovetail
