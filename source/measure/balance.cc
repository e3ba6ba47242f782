// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_terms.h>
#include <dovetail/measure/balance.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_balance("balance", "forces or heat of a body are not in balance");

using nlohmann::ordered_json;

/// What flows through a body, and what its cells gain and lose.
struct FlowsOfField
{
  Flows through, stored;
};

/// What a cell's part of the residual gives, by field.
template <int dim>
void add_influxes(const Domain<dim> &domain, const std::vector<double> &residual, const double sign,
                  Flows FlowsOfField::*flow, std::vector<FlowsOfField> &flows)
{
  for (unsigned int f = 0; f < flows.size(); ++f)
    for (unsigned int c = 0; c < domain.fields()[f].n_components; ++c) {
      const unsigned int component = domain.fields()[f].first_component + c;
      const std::vector<double> &unit = domain.layout().unit(component);
      (flows[f].*flow)
          .add(c, sign * std::inner_product(unit.begin(), unit.end(),
                                            residual.begin() + domain.layout().first(component), 0.));
    }
}

void add_flow(const Flows &from, const unsigned int component, Flows &to, const unsigned int component_there)
{
  to.in[component_there] += from.in[component];
  to.out[component_there] += from.out[component];
}

/// Sources, those of the laws too, given influxes and what is stored, cell by cell. @p given: of the sources
/// in cells that meet no condition with a flux; nullptr: not known, but to be found.
template <int dim>
void add_cells(const Domain<dim> &domain, const Vector &solution, const double t, const Rates &rates,
               const Flows *given, std::vector<FlowsOfField> &flows)
{
  const bool has_flux =
      std::any_of(domain.conditions().begin(), domain.conditions().end(),
                  [](const auto &condition) { return condition->adds_flux() || condition->is_weak(); });
  bool has_source =
      given == nullptr && (!domain.source().expressions.empty() || domain.body_force().is_given());
  for (unsigned int f = 0; f < flows.size(); ++f)
    has_source = has_source || domain.material.has_load(f);
  const bool has_storage = rates.has_first() && domain.material.order_in_time() > 0;
  for (unsigned int f = 0; f < flows.size() && given != nullptr; ++f)
    for (unsigned int c = 0; c < domain.fields()[f].n_components; ++c)
      add_flow(*given, domain.fields()[f].first_component + c, flows[f].through, c);
  if (!has_flux && !has_source && !has_storage)
    return;
  CellTerms<dim> terms(domain);
  terms.set_rates(&rates);
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell()), residual(unknowns.size());
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned() && (has_source || has_storage || cell->at_boundary())) {
      domain.cell_dofs(cell, dofs);
      solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
      if ((has_source || (has_flux && cell->at_boundary())) &&
          terms.assemble_loads(cell, t, unknowns, residual))
        add_influxes(domain, residual, -1., &FlowsOfField::through, flows);
      if (terms.assemble_storage(cell, t, unknowns, residual))
        add_influxes(domain, residual, 1., &FlowsOfField::stored, flows);
    }
}

/// Of all fields of a domain, on all ranks.
template <int dim>
std::vector<FlowsOfField> find_flows(const Model<dim> &model, const Domain<dim> &domain,
                                     const Reactions<dim> &reactions, const Vector &solution)
{
  std::vector<FlowsOfField> flows;
  unsigned int number = 0;
  while (model.domains[number].get() != &domain)
    ++number;
  const auto *of_cells = reactions.forces().flows_of_cells(number);
  for (const Field &field : domain.fields()) {
    flows.push_back({Flows(field.n_components), Flows(field.n_components)});
    for (unsigned int c = 0; of_cells != nullptr && c < field.n_components; ++c) {
      add_flow(of_cells->loads, field.first_component + c, flows.back().through, c);
      add_flow(of_cells->stored, field.first_component + c, flows.back().stored, c);
    }
    for (const auto &[dof, at_node] : reactions.at_nodes(domain, field))
      flows.back().through.add(at_node.component, at_node.force);
  }
  if (of_cells == nullptr)
    add_cells(domain, solution, reactions.forces().t, reactions.forces().rates,
              reactions.forces().given_flows(number), flows);
  for (const auto &interface : model.interfaces)
    for (const auto &[f, component, influx] : reactions.transmissions(*interface))
      for (const unsigned int side : {source, destination})
        if (interface->sides[side].domain == &domain)
          flows[interface->fields[f].field[side]].through.add(component, influx[side]);
  for (auto &[through, stored] : flows)
    for (std::vector<double> *sums : {&through.in, &through.out, &stored.in, &stored.out})
      dealii::Utilities::MPI::sum(*sums, model.communicator, *sums);
  return flows;
}

/// The smallest and the largest value of a field in a domain.
template <int dim>
std::array<double, 2> range_of(const Model<dim> &model, const Domain<dim> &domain, const Field &field,
                               const Vector &solution)
{
  std::array<double, 2> range = {{std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest()}};
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell());
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
      const auto first = unknowns.begin() + domain.layout().first(field.first_component),
                 last = unknowns.begin() + domain.layout().first(field.first_component + field.n_components);
      range[0] = std::min(range[0], *std::min_element(first, last));
      range[1] = std::max(range[1], *std::max_element(first, last));
    }
  return {{dealii::Utilities::MPI::min(range[0], model.communicator),
           dealii::Utilities::MPI::max(range[1], model.communicator)}};
}

const double smallest_difference = 1e-10; ///< of the values of a field, in the largest one

/// Whether nothing flows but rounding: a field that is constant, or one whose differences alone would
/// leave as much.
template <int dim>
bool is_at_rest(const Model<dim> &model, const Domain<dim> &domain, const Field &field,
                const Vector &solution, const double rounding, const double throughput)
{
  const auto range = range_of(model, domain, field, solution);
  const double difference = range[1] - range[0], level = std::max(std::abs(range[0]), std::abs(range[1]));
  return difference <= smallest_difference * level || throughput * level <= rounding * difference;
}

ordered_json value(const std::vector<double> &components)
{
  return components.size() == 1 ? ordered_json(components[0]) : ordered_json(components);
}

/// What does not add up in a field.
struct Imbalance
{
  explicit Imbalance(const FlowsOfField &flows)
  {
    const auto &[through, change] = flows;
    for (unsigned int c = 0; c < through.in.size(); ++c) {
      stored.push_back(change.in[c] - change.out[c]);
      by_component.push_back(through.in[c] - through.out[c] - stored[c]);
      if (!(std::abs(by_component[c]) <= largest)) // std::max drops NaN
        largest = std::abs(by_component[c]);
      throughput = std::max({throughput, through.in[c], through.out[c], change.in[c], change.out[c]});
    }
  }

  std::vector<double> stored, by_component;
  double largest = 0, throughput = 0;
};

template <int dim>
std::string explain_loss(const Domain<dim> &domain, const Field &field, const Imbalance &imbalance)
{
  std::ostringstream sentence;
  sentence.precision(2);
  sentence << "the " << field.name << " of " << domain.name << " is not in balance: of "
           << imbalance.throughput << " that is put in, taken out or stored, " << imbalance.largest
           << " is missing. The equations have not been solved exactly enough: lower the Relative "
              "tolerance of Newton and of the "
              "Linear solver";
  return sentence.str();
}

template <int dim>
std::string explain_rounding(const Domain<dim> &domain, const Field &field, const Imbalance &imbalance,
                             const double rounding)
{
  std::ostringstream sentence;
  sentence.precision(2);
  sentence << "whether the " << field.name << " of " << domain.name << " is in balance cannot be told: of "
           << imbalance.throughput << " that is put in, taken out or stored, rounding can hide " << rounding
           << ", because the values are large beside their differences. Measure them from another zero";
  return sentence.str();
}

/// Of what flows: more can hide a loss.
const double largest_rounding = 1e-6;

/// The squares of smaller flows underflow, and norms of them are zero: solvers see nothing.
const double least_throughput = std::sqrt(std::numeric_limits<double>::min());

} // namespace

template <int dim>
Balance measure_balance(const Model<dim> &model, const Reactions<dim> &reactions, const Vector &solution,
                        double expected, double allowed, NoteList *notes)
{
  expected = std::max(largest_imbalance, expected);
  allowed = std::max(expected, allowed);
  Balance balance = {ordered_json::object()};
  for (const auto &domain : model.domains) {
    const std::vector<FlowsOfField> flows = find_flows(model, *domain, reactions, solution);
    for (unsigned int f = 0; f < flows.size(); ++f) {
      const Field &field = domain->fields()[f];
      if (field.is_multiplier) // nothing flows
        continue;
      const Imbalance imbalance(flows[f]);
      ordered_json &result = balance.report[domain->name][field.name];
      result = {{"stored", value(imbalance.stored)},
                {"in", value(flows[f].through.in)},
                {"out", value(flows[f].through.out)},
                {"imbalance", value(imbalance.by_component)}};
      if (imbalance.throughput < least_throughput)
        continue;
      const bool is_allowed = imbalance.largest <= allowed * imbalance.throughput;
      if (is_allowed)
        balance.worst =
            std::max(balance.worst, imbalance.throughput > 0 ? imbalance.largest / imbalance.throughput : 0.);
      if (imbalance.largest <= expected * imbalance.throughput)
        continue;
      const double rounding = reactions.forces().rounding(*domain, field, solution);
      result["rounding"] = rounding;
      if (imbalance.throughput > 0)
        balance.rounding = std::max(balance.rounding, rounding / imbalance.throughput);
      if (is_allowed)
        continue;
      if (imbalance.largest <= rounding &&
          (rounding <= largest_rounding * imbalance.throughput ||
           is_at_rest(model, *domain, field, solution, rounding, imbalance.throughput))) {
        if (rounding <= largest_rounding * imbalance.throughput)
          balance.worst = std::max(balance.worst, imbalance.largest / imbalance.throughput);
        continue;
      }
      const double relative = imbalance.throughput > 0 ? imbalance.largest / imbalance.throughput : 1.;
      if (!(relative <= balance.worst))
        balance.worst = relative;
      if (notes != nullptr)
        notes->push_back(of_balance(imbalance.largest <= rounding
                                        ? explain_rounding(*domain, field, imbalance, rounding)
                                        : explain_loss(*domain, field, imbalance)));
    }
  }
  return balance;
}

template Balance measure_balance(const Model<2> &, const Reactions<2> &, const Vector &, double, double,
                                 NoteList *);
template Balance measure_balance(const Model<3> &, const Reactions<3> &, const Vector &, double, double,
                                 NoteList *);

} // namespace dovetail
