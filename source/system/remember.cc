// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/remember.h>

#include <dovetail/interface/side_points.h>
#include <dovetail/scene/undefined.h>

#include <deal.II/base/mpi.h>

#include <algorithm>

namespace dovetail {

template <int dim>
bool has_to_remember(const Model<dim> &model)
{
  return std::any_of(model.materials.begin(), model.materials.end(),
                     [](const auto &material) { return material->has_memory(); }) ||
         std::any_of(model.interfaces.begin(), model.interfaces.end(),
                     [](const auto &interface) { return !interface->tie().internal_variables().empty(); });
}

namespace {

/// Calls @p visit with each own cell of a domain and its unknowns.
template <int dim, typename Visit>
void for_each_cell(const Domain<dim> &domain, const ValuesOf &values_of, const Visit &visit)
{
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      values_of(dofs, unknowns);
      visit(cell, unknowns);
    }
}

template <int dim>
bool evaluate_memory(const Model<dim> &model, const std::vector<std::unique_ptr<CellTerms<dim>>> &cell_terms,
                     const double t, const ValuesOf &values_of)
{
  bool is_defined = true;
  for (unsigned int d = 0; d < model.domains.size(); ++d)
    if (model.domains[d]->memory)
      for_each_cell(*model.domains[d], values_of, [&](const auto &cell, const auto &unknowns) {
        is_defined = cell_terms[d]->evaluate_memory(cell, t, unknowns) && is_defined;
      });
  for (const auto &interface : model.interfaces)
    if (!interface->memory.empty())
      is_defined =
          (interface->is_active(t) ? interface->tie().evaluate_memory(*interface, t, values_of)
                                   : interface->tie().Tie<dim>::evaluate_memory(*interface, t, values_of)) &&
          is_defined;
  return is_defined;
}

} // namespace

template <int dim>
bool remember(Model<dim> &model, const std::vector<std::unique_ptr<CellTerms<dim>>> &cell_terms,
              const double t, const ValuesOf &values_of)
{
  std::exception_ptr fault;
  bool is_defined = true;
  try {
    is_defined = evaluate_memory(model, cell_terms, t, values_of);
  } catch (...) { // perhaps of this rank alone
    fault = std::current_exception();
  }
  throw_on_all_ranks(fault, model.communicator);
  if (dealii::Utilities::MPI::min(is_defined ? 1 : 0, model.communicator) == 0)
    return false;
  for (const auto &domain : model.domains)
    if (domain->memory)
      domain->memory->accept();
  for (const auto &interface : model.interfaces)
    interface->memory.accept();
  return true;
}

template <int dim>
bool has_to_look_at_start(const Model<dim> &model)
{
  return std::any_of(model.domains.begin(), model.domains.end(),
                     [](const auto &domain) { return domain->material.has_to_look_at_start(); });
}

namespace {

/// At the points of an interface, of both sides.
template <int dim>
void look_at_start_of_sides(Interface<dim> &interface, const ValuesOf &values_of)
{
  SidePoints<dim> points(interface, 0);
  for_each_group(interface, values_of, [&](const auto &group, const std::vector<double> &unknowns) {
    for (unsigned int q = group.begin; q < group.end; ++q)
      for (const unsigned int side : {source, destination})
        if (const Material<dim> &material = interface.sides[side].domain->material;
            material.has_to_look_at_start()) {
          points.reinit(side, q, unknowns);
          material.look_at_start(points.state[side]);
          interface.memory.set_trial(side, q, points.state[side].memory.trial);
        }
  });
  interface.memory.accept();
}

} // namespace

template <int dim>
void look_at_start(Model<dim> &model, const std::vector<std::unique_ptr<CellTerms<dim>>> &cell_terms,
                   const ValuesOf &values_of)
{
  for (unsigned int d = 0; d < model.domains.size(); ++d)
    if (model.domains[d]->material.has_to_look_at_start()) {
      for_each_cell(*model.domains[d], values_of, [&](const auto &cell, const auto &unknowns) {
        cell_terms[d]->look_at_start(cell, unknowns);
      });
      model.domains[d]->memory->accept();
    }
  for (const auto &interface : model.interfaces)
    if (std::any_of(interface->sides.begin(), interface->sides.end(),
                    [](const auto &side) { return side.domain->material.has_to_look_at_start(); }))
      look_at_start_of_sides(*interface, values_of);
}

template bool has_to_remember(const Model<2> &);
template bool remember(Model<2> &, const std::vector<std::unique_ptr<CellTerms<2>>> &, double,
                       const ValuesOf &);
template bool has_to_look_at_start(const Model<2> &);
template void look_at_start(Model<2> &, const std::vector<std::unique_ptr<CellTerms<2>>> &, const ValuesOf &);
template bool has_to_remember(const Model<3> &);
template bool remember(Model<3> &, const std::vector<std::unique_ptr<CellTerms<3>>> &, double,
                       const ValuesOf &);
template bool has_to_look_at_start(const Model<3> &);
template void look_at_start(Model<3> &, const std::vector<std::unique_ptr<CellTerms<3>>> &, const ValuesOf &);

} // namespace dovetail
