// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/is_covered.h>
#include <dovetail/domain/open_boundary.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/output/reactions.h>

#include <deal.II/base/mpi.h>

#include <algorithm>

namespace dovetail {

namespace {

using Ids = std::set<dealii::types::boundary_id>;

/// Whether a condition prescribes a component of a field at a node of a face.
template <int dim>
bool is_prescribed(const Domain<dim> &domain, const Field &field,
                   const typename Domain<dim>::BoundaryFace &face, const unsigned int node,
                   const unsigned int component, const double t)
{
  for (const auto &condition : domain.conditions())
    if (condition->field.name == field.name && condition->boundary_ids.count(face.id) > 0 &&
        condition->is_active(t)) {
      const auto components = condition->prescribed_components();
      if (std::find(components.begin(), components.end(), component) != components.end())
        return !is_covered(domain, field.name, face, node, t);
    }
  return false;
}

} // namespace

template <int dim>
Reactions<dim>::Reactions(const Model<dim> &model, const NodalForces<dim> &forces, const Vector &solution)
    : model(model), nodal(forces), solution(solution)
{
  for (const auto &interface : model.interfaces) {
    auto &all = all_transmissions[interface.get()];
    if (interface->is_active(nodal.t)) {
      all = nodal.of_groups(*interface);
      const auto others = interface->tie().transmissions();
      all.insert(all.end(), others.begin(), others.end());
      share_with_held(*interface, interface->tie().held());
    }
    add_up(*interface);
  }
}

/// What acts on a prescribed unknown of the destination that would follow the source is in part what the
/// interface transmits, if the source is prescribed at this place, too: it goes from the support of one body
/// through the interface to that of the other.
template <int dim>
void Reactions<dim>::share_with_held(const Interface<dim> &interface,
                                     const std::vector<HeldUnknown> &all_held)
{
  const InterfaceSide<dim> &side = interface.sides[destination];
  std::vector<std::pair<dealii::types::global_dof_index, double>> pushes;
  for (unsigned int f = 0; f < interface.fields.size(); ++f) {
    const Field &field = side.domain->fields()[interface.fields[f].field[destination]];
    std::vector<const HeldUnknown *> shared;
    for (const HeldUnknown &held : all_held)
      if (held.field == f && nodal.is_prescribed(held.dof) &&
          std::all_of(held.source.begin(), held.source.end(),
                      [this](const auto &entry) { return nodal.is_fixed(entry.first); }))
        shared.push_back(&held);
    if (dealii::Utilities::MPI::max(shared.size(), model.communicator) == 0)
      continue;
    const TraceShares<dim> shares(*side.domain, field, solution, nodal.t,
                                  [&](const auto &face, const unsigned int node, const unsigned int c) {
                                    if (is_prescribed(*side.domain, field, face, node, c, nodal.t))
                                      return 1;
                                    return side.belongs(face.cell, face.id) ? 0 : -1;
                                  });
    for (const HeldUnknown *held : shared) {
      const double influx = shares.of_first(held->dof, nodal(held->dof));
      all_transmissions[&interface].push_back({f, held->component, {{-influx, influx}}});
      pushes.emplace_back(held->dof, -influx);
      for (const auto &[dof, weight] : held->source)
        pushes.emplace_back(dof, weight * influx);
    }
  }
  if (dealii::Utilities::MPI::max(pushes.size(), model.communicator) > 0)
    nodal.add(pushes);
}

template <int dim>
void Reactions<dim>::add_up(const Interface<dim> &interface)
{
  auto &of_fields = resultants[&interface];
  for (const TiedField &tied : interface.fields)
    of_fields.push_back(
        {{std::vector<double>(tied.n_components, 0.), std::vector<double>(tied.n_components, 0.)}});
  for (const Transmission &transmission : all_transmissions.at(&interface))
    for (const unsigned int side : {source, destination})
      of_fields[transmission.field][side][transmission.component] += transmission.influx[side];
  for (auto &of_field : of_fields)
    for (std::vector<double> &of_side : of_field)
      dealii::Utilities::MPI::sum(of_side, model.communicator, of_side);
}

template <int dim>
std::vector<double> Reactions<dim>::resultant(const Domain<dim> &domain, const Ids &ids,
                                              const Field &field) const
{
  std::vector<double> sum(field.n_components, 0.);
  add_prescribed(domain, ids, field, sum);
  add_given(domain, ids, field, sum);
  dealii::Utilities::MPI::sum(sum, model.communicator, sum);
  for (const auto &interface : model.interfaces)
    for (unsigned int f = 0; f < interface->fields.size(); ++f)
      for (const unsigned int side : {source, destination})
        if (interface->sides[side].domain == &domain && interface->fields[f].name == field.name) {
          const std::vector<double> part = of_part(*interface, f, side, ids);
          for (unsigned int c = 0; c < sum.size(); ++c)
            sum[c] += part[c];
        }
  return sum;
}

/// Reactions of prescribed unknowns; where other prescribed faces meet the boundary each has its share.
template <int dim>
void Reactions<dim>::add_prescribed(const Domain<dim> &domain, const Ids &ids, const Field &field,
                                    std::vector<double> &sum) const
{
  const bool is_any_prescribed =
      std::any_of(domain.conditions().begin(), domain.conditions().end(), [&](const auto &condition) {
        return condition->field.name == field.name && !condition->prescribed_components().empty() &&
               std::any_of(ids.begin(), ids.end(),
                           [&](const auto id) { return condition->boundary_ids.count(id) > 0; });
      });
  if (!is_any_prescribed)
    return;
  const TraceShares<dim> shares(domain, field, solution, nodal.t,
                                [&](const auto &face, const unsigned int node, const unsigned int c) {
                                  if (!is_prescribed(domain, field, face, node, c, nodal.t))
                                    return -1;
                                  return ids.count(face.id) > 0 ? 0 : 1;
                                });
  for (const auto &[dof, component] : prescribed(domain, field))
    sum[component] += shares.of_first(dof, nodal(dof));
}

template <int dim>
std::map<dealii::types::global_dof_index, unsigned int> Reactions<dim>::prescribed(const Domain<dim> &domain,
                                                                                   const Field &field) const
{
  const unsigned int n = domain.n_nodes();
  const auto &owned = domain.dof_handler().locally_owned_dofs();
  std::set<dealii::types::boundary_id> with_conditions;
  for (const auto &condition : domain.conditions())
    if (condition->field.name == field.name && !condition->prescribed_components().empty())
      with_conditions.insert(condition->boundary_ids.begin(), condition->boundary_ids.end());
  std::map<dealii::types::global_dof_index, unsigned int> component_of;
  std::vector<dealii::types::global_dof_index> dofs;
  const bool has_axis = domain.measure.has_hoop_strain(field) && domain.reaches_axis();
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (has_axis || with_conditions.count(id) > 0) {
      domain.cell_dofs(domain.dof_cell(cell), dofs);
      for (unsigned int c = 0; c < field.n_components; ++c)
        for (unsigned int a = 0; a < n; ++a)
          if (const auto dof = dofs[(field.first_component + c) * n + a];
              domain.scalar_element().has_support_on_face(a, face) &&
              owned.is_element(dof - domain.first_dof) && nodal.is_prescribed(dof))
            component_of.emplace(dof, c);
    }
  return component_of;
}

/// The influxes that the conditions on these faces prescribe, with the quadrature of CellTerms.
template <int dim>
void Reactions<dim>::add_given(const Domain<dim> &domain, const Ids &ids, const Field &field,
                               std::vector<double> &sum) const
{
  OpenBoundary<dim> open_boundary(domain);
  const unsigned int n_c = field.n_components, n = domain.n_nodes();
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell()), trace(n_c), flux(n_c);
  dealii::FullMatrix<double> d_flux(n_c, n_c);
  for (const auto &condition : domain.conditions())
    if (condition->adds_flux() && condition->field.name == field.name)
      for (const auto &[cell, face, id] : domain.boundary_faces()) {
        if (!cell->is_locally_owned() || ids.count(id) == 0 || condition->boundary_ids.count(id) == 0)
          continue;
        domain.cell_dofs(domain.dof_cell(cell), dofs);
        solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
        open_boundary.for_each_point(
            cell, face, *condition, nodal.t,
            [&](const dealii::Point<dim> &X, const std::vector<double> &shape_values, const double JxW) {
              std::fill(trace.begin(), trace.end(), 0.);
              std::fill(flux.begin(), flux.end(), 0.);
              for (unsigned int c = 0; c < n_c; ++c)
                for (unsigned int a = 0; a < n; ++a)
                  trace[c] += shape_values[a] * unknowns[(field.first_component + c) * n + a];
              condition->flux(X, nodal.t, trace.data(), flux, d_flux);
              for (unsigned int c = 0; c < n_c; ++c)
                sum[c] += flux[c] * JxW;
            });
      }
}

/// What a side of an interface gets through those of its faces that have these ids: the flux of the body
/// there, and by area what it differs on the whole side from what the tie transmits.
template <int dim>
std::vector<double> Reactions<dim>::of_part(const Interface<dim> &interface, const unsigned int f,
                                            const unsigned int s, const Ids &ids) const
{
  const InterfaceSide<dim> &side = interface.sides[s];
  const std::vector<double> &whole = of_interface(interface, f)[s];
  if (!interface.is_active(nodal.t) || std::none_of(side.boundary_ids.begin(), side.boundary_ids.end(),
                                                    [&](const auto id) { return ids.count(id) > 0; }))
    return std::vector<double>(whole.size(), 0.);
  if (std::includes(ids.begin(), ids.end(), side.boundary_ids.begin(), side.boundary_ids.end()))
    return whole;

  const Domain<dim> &domain = *side.domain;
  const unsigned int n_c = whole.size(), first = interface.fields[f].first_component[s];
  dealii::FEFaceValues<dim> values(
      domain.mapping(), domain.scalar_element(), gauss_rule<dim - 1>(domain.face_shape(), domain.degree + 2),
      dealii::update_values | dealii::update_gradients | dealii::update_quadrature_points |
          dealii::update_normal_vectors | dealii::update_JxW_values);
  FluxOnFace<dim> flux_on_face(domain, nodal.t);
  std::vector<double> sums(2 * (n_c + 1), 0.); // of the asked and the other faces: fluxes and area
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell());
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (cell->is_locally_owned() && side.belongs(cell, id)) {
      values.reinit(cell, face);
      domain.cell_dofs(domain.dof_cell(cell), dofs);
      solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
      double *of_part = &sums[ids.count(id) > 0 ? 0 : n_c + 1];
      for (const unsigned int q : values.quadrature_point_indices()) {
        const std::vector<double> &A_N = flux_on_face.evaluate(values, q, unknowns);
        for (unsigned int c = 0; c < n_c; ++c)
          of_part[c] += A_N[first + c] * domain.measure(values, q);
        of_part[n_c] += domain.measure(values, q);
      }
    }
  dealii::Utilities::MPI::sum(sums, model.communicator, sums);
  std::vector<double> part(n_c);
  for (unsigned int c = 0; c < n_c; ++c)
    part[c] =
        sums[c] + (whole[c] - sums[c] - sums[n_c + 1 + c]) * sums[n_c] / (sums[n_c] + sums[2 * n_c + 1]);
  return part;
}

template class Reactions<2>;
template class Reactions<3>;

} // namespace dovetail
