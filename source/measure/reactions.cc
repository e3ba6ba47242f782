// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/face_nodes.h>
#include <dovetail/domain/is_covered.h>
#include <dovetail/domain/open_boundary.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/measure/reactions.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <set>

namespace dovetail {

namespace {

using Ids = std::set<dealii::types::boundary_id>;

/// Whether a condition prescribes a component of a field on one of these boundaries.
template <int dim>
bool is_any_prescribed(const Domain<dim> &domain, const Ids &ids, const Field &field)
{
  return std::any_of(domain.conditions().begin(), domain.conditions().end(), [&](const auto &condition) {
    return condition->field.name == field.name && !condition->prescribed_components().empty() &&
           std::any_of(ids.begin(), ids.end(),
                       [&](const auto id) { return condition->boundary_ids.count(id) > 0; });
  });
}

/// Whether a condition prescribes a component of a field at a node of a face.
template <int dim>
bool is_prescribed(const Domain<dim> &domain, const Field &field,
                   const typename Domain<dim>::BoundaryFace &face, const unsigned int node,
                   const unsigned int component, const double t)
{
  for (const auto &condition : domain.conditions())
    if (condition->field.name == field.name && condition->is_active(t) &&
        domain.constrains(*condition, face, component))
      return !is_covered(domain, field, face, node, t);
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
      all = nodal.group_transmissions(*interface);
      const TieParts<dim> parts = interface->tie().parts();
      if (parts.flux_recovery != nullptr) {
        const auto others = parts.flux_recovery->transmissions();
        all.insert(all.end(), others.begin(), others.end());
      }
      if (parts.elimination != nullptr)
        share_with_held(*interface, parts.elimination->held());
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
    std::set<dealii::types::global_dof_index> supported; // at points, which take the whole force
    std::vector<dealii::types::global_dof_index> dofs;
    for (const auto &[condition, node] : side.domain->nodes_of_points())
      if (condition->field.name == field.name) {
        side.domain->cell_dofs(side.domain->dof_cell(node.cell), dofs);
        for (const unsigned int c : condition->prescribed_components())
          supported.insert(dofs[side.domain->layout().index(field.first_component + c, node.node)]);
      }
    std::vector<const HeldUnknown *> shared;
    for (const HeldUnknown &held : all_held)
      if (held.field == f && nodal.is_prescribed(held.dof) && supported.count(held.dof) == 0 &&
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
      const double influx = shares.first_share(held->dof, nodal(held->dof));
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
  auto &field_resultants = resultants[&interface];
  for (const TiedField &tied : interface.fields)
    field_resultants.push_back(
        {{std::vector<double>(tied.n_components, 0.), std::vector<double>(tied.n_components, 0.)}});
  for (const Transmission &transmission : all_transmissions.at(&interface))
    for (const unsigned int side : {source, destination})
      field_resultants[transmission.field][side][transmission.component] += transmission.influx[side];
  for (auto &field_sides : field_resultants)
    for (std::vector<double> &side_resultant : field_sides)
      dealii::Utilities::MPI::sum(side_resultant, model.communicator, side_resultant);
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
        if (interface->sides[side].domain == &domain && interface->fields[f].names[side] == field.name) {
          const std::vector<double> part = part_resultant(*interface, f, side, ids);
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
  if (!is_any_prescribed(domain, ids, field))
    return;
  const TraceShares<dim> shares = shares_of(domain, ids, field);
  for (const auto &[dof, at_node] : at_nodes(domain, field))
    sum[at_node.component] += shares.first_share(dof, at_node.force);
}

/// Of prescribed nodes: what faces with these ids have, and what others have.
template <int dim>
TraceShares<dim> Reactions<dim>::shares_of(const Domain<dim> &domain, const Ids &ids,
                                           const Field &field) const
{
  return TraceShares<dim>(domain, field, solution, nodal.t,
                          [&](const auto &face, const unsigned int node, const unsigned int c) {
                            if (!is_prescribed(domain, field, face, node, c, nodal.t))
                              return -1;
                            return ids.count(face.id) > 0 ? 0 : 1;
                          });
}

template <int dim>
typename Reactions<dim>::Lift Reactions<dim>::lift(const Domain<dim> &domain, const Ids &ids,
                                                   const Field &field, const unsigned int component) const
{
  const Vector zero(model.numbering->split(model.numbering->owned), model.communicator);
  Lift result = {zero, {{zero, zero}}};
  if (!is_any_prescribed(domain, ids, field))
    return result;
  const TraceShares<dim> shares = shares_of(domain, ids, field);
  const auto component_of = components_at_nodes(domain, field);
  const auto share = [&](const dealii::types::global_dof_index dof) {
    return component_of.at(dof) == component ? shares.first_area(dof) : 0.;
  };
  for (const auto &[dof, dof_component] : component_of)
    if (const ConstraintLine *line = nodal.line_of_condition(dof)) {
      result.w(dof) += share(dof);
      for (const auto &[other, weight] : line->entries) // as at_nodes() has it
        result.w(dof) -= weight * share(other);
      if (dof_component == component && shares.is_common(dof)) {
        result.g[0](dof) = 1 - share(dof);
        result.g[1](dof) = -share(dof);
      }
    }
  result.w.compress(dealii::VectorOperation::add);
  result.w = nodal.extended(result.w);
  for (Vector &g : result.g) {
    g.compress(dealii::VectorOperation::insert);
    g = nodal.extended(g);
  }
  return result;
}

/// The component of the field of each unknown that conditions may constrain.
template <int dim>
std::map<dealii::types::global_dof_index, unsigned int>
Reactions<dim>::components_at_nodes(const Domain<dim> &domain, const Field &field) const
{
  const auto face_nodes = nodes_of_faces(domain.layout().element(field.first_component));
  std::set<dealii::types::boundary_id> with_conditions;
  for (const auto &condition : domain.conditions())
    if (condition->field.name == field.name && !condition->prescribed_components().empty())
      with_conditions.insert(condition->boundary_ids.begin(), condition->boundary_ids.end());
  std::map<dealii::types::global_dof_index, unsigned int> component_of;
  std::vector<dealii::types::global_dof_index> dofs;
  const auto add_node = [&](const auto &cell, const unsigned int a) {
    domain.cell_dofs(domain.dof_cell(cell), dofs);
    for (unsigned int c = 0; c < field.n_components; ++c)
      component_of.emplace(dofs[domain.layout().index(field.first_component + c, a)], c);
  };
  const bool has_axis = domain.measure.has_hoop_strain(field) && domain.reaches_axis();
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (has_axis || with_conditions.count(id) > 0)
      for (const unsigned int a : face_nodes[face])
        add_node(cell, a);
  for (const auto &[condition, node] : domain.nodes_of_points())
    if (condition->field.name == field.name)
      add_node(node.cell, node.node);
  return component_of;
}

template <int dim>
std::map<dealii::types::global_dof_index, typename Reactions<dim>::ForceAtNode>
Reactions<dim>::at_nodes(const Domain<dim> &domain, const Field &field) const
{
  std::map<dealii::types::global_dof_index, ForceAtNode> result;
  if (field.n_components == 1) {
    for (const Block &block : model.numbering->blocks())
      if (!block.is_of_multipliers && model.domains[block.domain_index].get() == &domain &&
          block.field == field.name)
        nodal.for_each_line_of_condition(block.begin, block.end, [&](const auto dof, const ConstraintLine &) {
          result.emplace_hint(result.end(), dof, ForceAtNode{0, nodal(dof)});
        });
    return result;
  }
  const auto component_of = components_at_nodes(domain, field);
  for (const auto &[dof, component] : component_of)
    if (const ConstraintLine *line = nodal.line_of_condition(dof)) {
      const double force = nodal(dof);
      result[dof].component = component;
      result[dof].force += force;
      for (const auto &[other, weight] : line->entries) {
        result[other].component = component_of.at(other);
        result[other].force -= weight * force;
      }
    }
  return result;
}

namespace {

/// A_c.N - gamma (B_c - g_c) of a component that is prescribed weakly, as CellTerms has it, at a point.
template <int dim>
void add_weak_influx(const Condition<dim> &condition, const typename OpenBoundary<dim>::Point &at,
                     const double gamma, const std::vector<double> &unknowns, CellPoints<dim> &point,
                     std::vector<double> &sum)
{
  point.reinit(at.state.X, at.shape_values.data(), at.shape_gradients.data(), unknowns);
  if (!point.evaluate(false))
    return;
  const unsigned int first = condition.field.first_component;
  for (const unsigned int c : condition.prescribed_components())
    sum[c] += at.JxW *
              (point.response.flux[first + c] * at.N -
               gamma * (at.state.value[first + c] - condition.prescribed_value(at.state.X, at.state.t, c)));
}

} // namespace

/// The influxes that the conditions on these faces prescribe, with the quadrature of CellTerms.
template <int dim>
void Reactions<dim>::add_given(const Domain<dim> &domain, const Ids &ids, const Field &field,
                               std::vector<double> &sum) const
{
  OpenBoundary<dim> open_boundary(domain);
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell());
  CellPoints<dim> point(domain, nodal.t);
  for (const auto &condition : domain.conditions())
    if ((condition->adds_flux() || condition->is_weak()) && condition->field.name == field.name)
      for (const auto &[cell, face, id] : domain.boundary_faces()) {
        if (!cell->is_locally_owned() || ids.count(id) == 0 || condition->boundary_ids.count(id) == 0)
          continue;
        domain.cell_dofs(domain.dof_cell(cell), dofs);
        solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
        const unsigned int index = cell->active_cell_index();
        point.enter(cell);
        open_boundary.for_each_point(cell, face, *condition, nodal.t, unknowns, [&](const auto &at) {
          if (condition->is_weak())
            return add_weak_influx(*condition, at, domain.weak_penalties.at({field.name, index}), unknowns,
                                   point, sum);
          Influx<dim> influx(field.n_components, domain.n_components());
          condition->influx(at.state, at.N, influx);
          for (unsigned int c = 0; c < field.n_components; ++c)
            sum[c] += influx.value[c] * at.JxW;
        });
      }
}

/// What a side of an interface gets through those of its faces that have these ids: the flux of the body
/// there, and by area what it differs on the whole side from what the tie transmits.
template <int dim>
std::vector<double> Reactions<dim>::part_resultant(const Interface<dim> &interface, const unsigned int f,
                                                   const unsigned int s, const Ids &ids) const
{
  const InterfaceSide<dim> &side = interface.sides[s];
  const std::vector<double> &whole = interface_resultants(interface, f)[s];
  if (!interface.is_active(nodal.t) || std::none_of(side.boundary_ids.begin(), side.boundary_ids.end(),
                                                    [&](const auto id) { return ids.count(id) > 0; }))
    return std::vector<double>(whole.size(), 0.);
  if (std::includes(ids.begin(), ids.end(), side.boundary_ids.begin(), side.boundary_ids.end()))
    return whole;

  const Domain<dim> &domain = *side.domain;
  const unsigned int n_c = whole.size(), first = interface.fields[f].first_component[s];
  dealii::FEFaceValues<dim> values(domain.mapping(), domain.layout().shape_element(),
                                   gauss_rule<dim - 1>(domain.face_shape(), domain.degree + 2),
                                   dealii::update_values | dealii::update_gradients |
                                       dealii::update_quadrature_points | dealii::update_normal_vectors |
                                       dealii::update_JxW_values);
  FluxOnFace<dim> flux_on_face(domain, nodal.t);
  std::vector<double> sums(2 * (n_c + 1), 0.); // of the asked and the other faces: fluxes and area
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell());
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (cell->is_locally_owned() && side.belongs(cell, id)) {
      values.reinit(cell, face);
      domain.cell_dofs(domain.dof_cell(cell), dofs);
      solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
      double *part_resultant = &sums[ids.count(id) > 0 ? 0 : n_c + 1];
      for (const unsigned int q : values.quadrature_point_indices()) {
        const std::vector<double> &A_N = flux_on_face.evaluate(values, q, unknowns);
        for (unsigned int c = 0; c < n_c; ++c)
          part_resultant[c] += A_N[first + c] * domain.measure(values, q);
        part_resultant[n_c] += domain.measure(values, q);
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
