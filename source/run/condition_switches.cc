// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/condition_switches.h>

#include <dovetail/domain/open_boundary.h>
#include <dovetail/measure/domain_point.h>

#include <deal.II/base/mpi.h>
#include <deal.II/fe/fe_values.h>

#include <algorithm>

namespace dovetail {

namespace {

template <int dim>
bool has_inertia(const Domain<dim> &domain, const Condition<dim> &condition)
{
  return domain.material.order_in_time(condition.field.first_component) > 1;
}

/// Whether two laws at a point disagree in a force on what has inertia, or in what a body's volume is.
template <int dim>
bool change_pushes(const Domain<dim> &domain, DomainPoint<dim> &one, DomainPoint<dim> &other)
{
  if (domain.material.order_in_time() < 2)
    return false;
  const Response<dim> &first = one.response(), &second = other.response();
  for (const Field &field : domain.fields())
    for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c)
      if ((field.is_multiplier && !(first.source[c] == second.source[c])) ||
          (domain.material.order_in_time(c) > 1 && !(first.flux[c] == second.flux[c])))
        return true;
  return false;
}

} // namespace

template <int dim>
typename ConditionSwitches<dim>::Places ConditionSwitches<dim>::find(const Model<dim> &model, const double t)
{
  Places places;
  for (const auto &domain : model.domains) {
    if (!domain->has_conditions_by_fields())
      continue;
    OpenBoundary<dim> boundary(*domain);
    for (const auto &cell : domain->dof_handler().active_cell_iterators()) {
      if (!cell->is_locally_owned() || !cell->at_boundary())
        continue;
      const std::vector<double> &unknowns = domain->last_good.of_cell(cell->active_cell_index());
      for (const auto &condition : domain->conditions())
        if (condition->follows_fields())
          for (const unsigned int face : cell->face_indices())
            if (cell->face(face)->at_boundary())
              boundary.for_each_point(cell, face, *condition, t, unknowns, [&](const auto &point) {
                places.all.push_back(point.state.X);
                if (has_inertia(*domain, *condition))
                  places.with_inertia.push_back(point.state.X);
              });
    }
  }
  return places;
}

/// At the points at which materials remember their phases.
template <int dim>
void ConditionSwitches<dim>::look_at_phases(const Model<dim> &model, const double last, const double t,
                                            const Vector &x)
{
  bool has_changed = false, has_pushed = false;
  for (const auto &domain : model.domains) {
    if (!domain->memory || !domain->material.has_phases())
      continue;
    dealii::FEValues<dim> values(domain->mapping(), domain->layout().shape_element(),
                                 domain->cell_quadrature(), DomainPoint<dim>::needed());
    DomainPoint<dim> before_step(*domain, x, last), in_step(*domain, x, t);
    bool has_pushed_here = false;
    for (const auto &cell : domain->dof_handler().active_cell_iterators()) {
      if (!cell->is_locally_owned() || has_pushed_here)
        continue;
      values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      before_step.enter(values);
      in_step.enter(values);
      for (const unsigned int q : values.quadrature_point_indices()) {
        before_step.move_to(q);
        in_step.move_to(q);
        if (domain->material.phase(before_step.state()) == domain->material.phase(in_step.state()))
          continue;
        has_changed = true;
        has_pushed_here = has_pushed_here || change_pushes(*domain, before_step, in_step);
      }
    }
    has_pushed = has_pushed || has_pushed_here;
  }
  learn(is_new || has_changed, pushes || has_pushed, model.communicator);
}

template <int dim>
void ConditionSwitches<dim>::learn(const bool has_switched, const bool has_pushed,
                                   const MPI_Comm &communicator)
{
  const int most = dealii::Utilities::MPI::max(has_pushed ? 2 : has_switched ? 1 : 0, communicator);
  is_new = most > 0;
  pushes = most > 1;
}

template <int dim>
void ConditionSwitches<dim>::look(const Model<dim> &model, const double t)
{
  if (!model.has_conditions_by_fields()) {
    is_new = pushes = false;
    return;
  }
  if (before && before->first == t) {
    now = std::exchange(before, {});
    is_new = pushes = false;
    return;
  }
  if (now && now->first == t)
    return;
  if (now && t > now->first)
    before = std::move(now);
  now.emplace(t, find(model, t));
  learn(before && now->second.all != before->second.all,
        before && now->second.with_inertia != before->second.with_inertia, model.communicator);
}

template class ConditionSwitches<2>;
template class ConditionSwitches<3>;

} // namespace dovetail
