// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_terms.h>
#include <dovetail/measure/domain_point.h>
#include <dovetail/measure/energy_balance.h>
#include <dovetail/measure/interface_point.h>

#include <deal.II/base/mpi.h>

#include <vector>

namespace dovetail {

namespace {

bool is_of_solid(const Field &field)
{
  return field.law == "solid";
}

template <int dim>
const Field *solid_field(const Domain<dim> &domain)
{
  for (const Field &field : domain.fields())
    if (is_of_solid(field))
      return &field;
  return nullptr;
}

/// sum_a |v_a|^2/2 int phi_a dV over the nodes of a cell, in which @p values are.
template <int dim>
double lumped_square(const Domain<dim> &domain, const Field &field, const Vector &velocity,
                     const typename Domain<dim>::cell_iterator &cell, const dealii::FEValues<dim> &values)
{
  const CellLayout<dim> &layout = domain.layout();
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> v(domain.dofs_per_cell());
  domain.cell_dofs(cell, dofs);
  velocity.extract_subvector_to(dofs.begin(), dofs.end(), v.begin());
  double sum = 0;
  for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c)
    for (unsigned int a = 0; a < layout.n_nodes(c); ++a) {
      double weight = 0;
      for (const unsigned int q : values.quadrature_point_indices())
        weight +=
            values.shape_value(layout.shape_index(layout.first_shape(c) + a), q) * domain.measure(values, q);
      const double v_a = v[layout.index(c, a)];
      sum += v_a * v_a / 2 * weight;
    }
  return sum;
}

} // namespace

template <int dim>
Vector forces_of_supports(const Model<dim> &model, const Reactions<dim> &reactions, const Vector &x)
{
  Vector result = x;
  result = 0;
  for (const auto &domain : model.domains)
    if (const Field *field = solid_field(*domain))
      for (const auto &[dof, at_node] : reactions.at_nodes(*domain, *field))
        result(dof) += at_node.force;
  result.compress(dealii::VectorOperation::add);
  return result;
}

template <int dim>
void EnergyBalance<dim>::start(const Vector &x, const Vector &ghosted, const Vector *velocity, const double t)
{
  last = Memory();
  last.x = x;
  last.initial = energies(ghosted, velocity, t).sum();
}

template <int dim>
void EnergyBalance<dim>::add_domain(const Domain<dim> &domain, const Vector &x, const Vector *velocity,
                                    const double t, Energies &sums) const
{
  const Field *field = solid_field(domain);
  if (field == nullptr)
    return;
  const double density = domain.material.solid_density();
  dealii::FEValues<dim> values(domain.mapping(), domain.layout().shape_element(), domain.cell_quadrature(),
                               DomainPoint<dim>::needed() | dealii::update_JxW_values);
  DomainPoint<dim> point(domain, x, t), rate(domain, velocity != nullptr ? *velocity : x, t);
  const bool is_lumped = !lumped_components(domain, 2).empty();
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      point.enter(values);
      if (velocity != nullptr)
        rate.enter(values);
      for (const unsigned int q : values.quadrature_point_indices()) {
        const double dV = domain.measure(values, q);
        point.move_to(q);
        sums.elastic += point.energy_density() * dV;
        if (velocity == nullptr || is_lumped)
          continue;
        rate.move_to(q);
        for (unsigned int c = field->first_component; c < field->first_component + dim; ++c)
          sums.kinetic += density / 2 * rate.state().value[c] * rate.state().value[c] * dV;
      }
      if (velocity != nullptr && is_lumped)
        sums.kinetic += density * lumped_square(domain, *field, *velocity, cell, values);
    }
}

template <int dim>
void EnergyBalance<dim>::add_interface(const Interface<dim> &interface, const Vector &x, const double t,
                                       Energies &sums) const
{
  if (!interface.is_active(t))
    return;
  InterfacePoint<dim> point(interface, t);
  point.for_each(x, [&](const unsigned int q, const unsigned int /*side*/) {
    for (const TiedField &field : interface.fields)
      if (is_of_solid(interface.sides[source].domain->fields()[field.field[source]])) {
        const auto energy = interface.tie().energy(interface, field, q, point.flux_without_pressure(field, q),
                                                   point.fields[field.index].jump);
        sums.ties += energy.value_or(0) * interface.pairing().weight(q);
        sums.knows_ties = sums.knows_ties && energy.has_value();
      }
  });
}

template <int dim>
typename EnergyBalance<dim>::Energies EnergyBalance<dim>::energies(const Vector &x, const Vector *velocity,
                                                                   const double t) const
{
  Energies sums;
  for (const auto &domain : model.domains)
    add_domain(*domain, x, velocity, t, sums);
  for (const auto &interface : model.interfaces)
    add_interface(*interface, x, t, sums);
  std::vector<double> over_ranks = {sums.kinetic, sums.elastic, sums.ties, sums.knows_ties ? 0. : 1.};
  dealii::Utilities::MPI::sum(over_ranks, model.communicator, over_ranks);
  return {over_ranks[0], over_ranks[1], over_ranks[2], over_ranks[3] == 0};
}

namespace {

/// In the nodes of solids, before constraints: the sum of what @p assemble(terms, cell, unknowns, of_cell)
/// finds.
/// @p result: any vector of owned unknowns
template <int dim, typename Assemble>
Vector sum_in_nodes_of_solids(const Model<dim> &model, const Vector &ghosted, Vector result,
                              const GhostExchange &exchange, const Assemble &assemble)
{
  SharedSums sums;
  sums.begin(exchange);
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &domain : model.domains) {
    const Field *field = solid_field(*domain);
    if (field == nullptr)
      continue;
    CellTerms<dim> terms(*domain);
    const CellLayout<dim> &layout = domain->layout();
    std::vector<double> unknowns(domain->dofs_per_cell()), of_cell(unknowns.size());
    for (const auto &cell : domain->dof_handler().active_cell_iterators())
      if (cell->is_locally_owned()) {
        domain->cell_dofs(cell, dofs);
        ghosted.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
        if (!assemble(terms, cell, unknowns, of_cell))
          continue;
        for (unsigned int c = field->first_component; c < field->first_component + dim; ++c)
          for (unsigned int a = 0; a < layout.n_nodes(c); ++a)
            sums(dofs[layout.index(c, a)]) += of_cell[layout.index(c, a)];
      }
  }
  sums.finish(result);
  return result;
}

} // namespace

/// Of sources and conditions.
template <int dim>
Vector EnergyBalance<dim>::loads(const double t, const Vector &x, const Vector &ghosted,
                                 const GhostExchange &exchange) const
{
  std::vector<double> boundary;
  return sum_in_nodes_of_solids(
      model, ghosted, x, exchange,
      [&](CellTerms<dim> &terms, const auto &cell, const auto &unknowns, auto &of_cell) {
        boundary.resize(unknowns.size());
        terms.assemble_given(cell, t, of_cell);
        terms.assemble_boundary(cell, t, unknowns, boundary);
        for (unsigned int i = 0; i < of_cell.size(); ++i)
          of_cell[i] = -(of_cell[i] + boundary[i]);
        return true;
      });
}

/// M w of solids.
template <int dim>
Vector EnergyBalance<dim>::product_with_mass(const Vector &ghosted, const Vector &ghosted_rate,
                                             const GhostExchange &exchange) const
{
  Rates rates;
  rates.rest = ghosted_rate; // of what stores by first rates, which does not count
  rates.second_rest = ghosted_rate;
  rates.weights = {0};
  rates.past = {ghosted};
  return sum_in_nodes_of_solids(
      model, ghosted, last.x, exchange,
      [&](CellTerms<dim> &terms, const auto &cell, const auto &unknowns, auto &of_cell) {
        terms.set_rates(&rates);
        return terms.assemble_storage(cell, 0, unknowns, of_cell);
      });
}

/// The forces just after the beginning of a step. @p of_support: at its end
template <int dim>
void EnergyBalance<dim>::start_anew(const Vector &of_support, const Vector &ghosted, const StepOfMotion &step,
                                    const GhostExchange &exchange)
{
  Vector ghosted_before = ghosted;
  exchange.update(ghosted_before, last.x);
  last.forces = loads(*step.new_start, last.x, ghosted_before, exchange);
  if (!step.second_rates_at_start) {
    last.forces += of_support;
    last.scheme.reset();
    return;
  }
  last.forces += *step.supports_at_start;
  last.velocity = *step.rates_at_start;
  last.acceleration = *step.second_rates_at_start;
}

template <int dim>
void EnergyBalance<dim>::add_scheme(const Vector &change, const Vector &ghosted, const StepOfMotion &step,
                                    const GhostExchange &exchange)
{
  if (!step.second_rates_at_end || last.acceleration.n_blocks() == 0 || !last.scheme) {
    last.scheme.reset();
    return;
  }
  const auto add_mean = [&](Vector owned_sum, const Vector &other, const Vector &change_of_other,
                            const int sign) {
    owned_sum.sadd(0.5, 0.5, other);
    Vector mean = ghosted;
    exchange.update(mean, owned_sum);
    *last.scheme += sign * (product_with_mass(ghosted, mean, exchange) * change_of_other);
  };
  Vector change_of_velocity = *step.rates_at_end;
  change_of_velocity -= last.velocity;
  add_mean(last.acceleration, *step.second_rates_at_end, change, 1);
  add_mean(last.velocity, *step.rates_at_end, change_of_velocity, -1);
  last.velocity = *step.rates_at_end;
  last.acceleration = *step.second_rates_at_end;
}

template <int dim>
nlohmann::ordered_json EnergyBalance<dim>::add_step(const Reactions<dim> &reactions, const Vector &x,
                                                    const Vector &ghosted, const Vector *velocity,
                                                    const StepOfMotion &step)
{
  const Vector of_support = forces_of_supports(model, reactions, x);
  const GhostExchange &exchange = *reactions.forces().exchange;
  Vector now = loads(reactions.forces().t, x, ghosted, exchange), change = x;
  now += of_support;
  const bool is_first = last.x.n_blocks() == 0; // a run that goes on from one without
  if (is_first)
    last.x = x;
  if (last.forces.n_blocks() == 0)
    last.forces = now;
  if (step.new_start)
    start_anew(of_support, ghosted, step, exchange);
  change -= last.x;
  last.work += (now * change + last.forces * change) / 2;
  add_scheme(change, ghosted, step, exchange);
  last.forces = std::move(now);
  last.x = x;
  const Energies present = energies(ghosted, velocity, reactions.forces().t);
  if (is_first)
    last.initial = present.sum();
  nlohmann::ordered_json result = {{"kinetic", present.kinetic}, {"elastic", present.elastic}};
  if (present.knows_ties)
    result["ties"] = present.ties;
  result["work"] = last.work;
  if (last.scheme)
    result["scheme"] = *last.scheme;
  result["lost"] = last.initial + last.work - present.sum();
  return result;
}

template Vector forces_of_supports(const Model<2> &, const Reactions<2> &, const Vector &);
template Vector forces_of_supports(const Model<3> &, const Reactions<3> &, const Vector &);
template class EnergyBalance<2>;
template class EnergyBalance<3>;

} // namespace dovetail
