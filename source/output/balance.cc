// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_terms.h>
#include <dovetail/output/balance.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace dovetail {

namespace {

using nlohmann::ordered_json;

/// Sums of positive and of negative influxes, by component.
struct Flows
{
  explicit Flows(const unsigned int n_components) : in(n_components, 0.), out(n_components, 0.) {}
  std::vector<double> in, out;

  void add(const unsigned int component, const double influx)
  {
    if (influx < 0)
      out[component] -= influx;
    else
      in[component] += influx;
  }
};

/// Sources, those of the laws too, and given influxes, cell by cell.
template <int dim>
void add_loads(const Domain<dim> &domain, const Vector &solution, const double t, std::vector<Flows> &flows)
{
  const bool has_flux =
      std::any_of(domain.conditions().begin(), domain.conditions().end(),
                  [](const auto &condition) { return condition->adds_flux() || condition->is_weak(); });
  const bool has_source =
      !domain.source().of_field.empty() || domain.body_force().is_given() || domain.material.has_source();
  if (!has_flux && !has_source)
    return;
  CellTerms<dim> terms(domain);
  const unsigned int n = domain.n_nodes();
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell()), residual(unknowns.size());
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned() && (has_source || cell->at_boundary())) {
      domain.cell_dofs(cell, dofs);
      solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
      if (!terms.assemble_loads(cell, t, unknowns, residual))
        continue;
      for (unsigned int f = 0; f < flows.size(); ++f)
        for (unsigned int c = 0; c < domain.fields()[f].n_components; ++c) {
          double influx = 0;
          for (unsigned int a = 0; a < n; ++a)
            influx -= residual[(domain.fields()[f].first_component + c) * n + a];
          flows[f].add(c, influx);
        }
    }
}

/// Of all fields of a domain, on all ranks.
template <int dim>
std::vector<Flows> find_flows(const Model<dim> &model, const Domain<dim> &domain,
                              const Reactions<dim> &reactions, const Vector &solution)
{
  std::vector<Flows> flows;
  for (const Field &field : domain.fields()) {
    flows.emplace_back(field.n_components);
    for (const auto &[dof, at_node] : reactions.at_nodes(domain, field))
      flows.back().add(at_node.component, at_node.force);
  }
  add_loads(domain, solution, reactions.forces().t, flows);
  for (const auto &interface : model.interfaces)
    for (const auto &[f, component, influx] : reactions.transmissions(*interface))
      for (const unsigned int side : {source, destination})
        if (interface->sides[side].domain == &domain)
          flows[interface->fields[f].field[side]].add(component, influx[side]);
  for (Flows &of_field : flows)
    for (std::vector<double> *sums : {&of_field.in, &of_field.out})
      dealii::Utilities::MPI::sum(*sums, model.communicator, *sums);
  return flows;
}

ordered_json value(const std::vector<double> &components)
{
  return components.size() == 1 ? ordered_json(components[0]) : ordered_json(components);
}

} // namespace

template <int dim>
ordered_json measure_balance(const Model<dim> &model, const Reactions<dim> &reactions, const Vector &solution,
                             const double tolerance, std::vector<std::string> &notes)
{
  const double allowed = std::max(largest_imbalance, tolerance);
  ordered_json all = ordered_json::object();
  for (const auto &domain : model.domains) {
    const std::vector<Flows> flows = find_flows(model, *domain, reactions, solution);
    for (unsigned int f = 0; f < flows.size(); ++f) {
      const Field &field = domain->fields()[f];
      std::vector<double> imbalance;
      double largest = 0, throughput = 0;
      for (unsigned int c = 0; c < field.n_components; ++c) {
        imbalance.push_back(flows[f].in[c] - flows[f].out[c]);
        if (!(std::abs(imbalance[c]) <= largest)) // std::max drops NaN
          largest = std::abs(imbalance[c]);
        throughput = std::max({throughput, flows[f].in[c], flows[f].out[c]});
      }
      ordered_json &result = all[domain->name][field.name];
      result = {{"stored", value(std::vector<double>(field.n_components, 0.))},
                {"in", value(flows[f].in)},
                {"out", value(flows[f].out)},
                {"imbalance", value(imbalance)}};
      if (largest <= allowed * throughput)
        continue;
      const double rounding = reactions.forces().rounding(*domain, field, solution);
      result["rounding"] = rounding;
      if (largest <= rounding)
        continue;
      std::ostringstream sentence;
      sentence.precision(2);
      sentence << "the " << field.name << " of " << domain->name << " is not in balance: of " << throughput
               << " that is put in or taken out, " << largest
               << " is missing. The equations have not been solved exactly enough: lower the Relative "
                  "tolerance of Newton and of the "
                  "Linear solver";
      notes.push_back(sentence.str());
    }
  }
  return all;
}

template ordered_json measure_balance(const Model<2> &, const Reactions<2> &, const Vector &, double,
                                      std::vector<std::string> &);
template ordered_json measure_balance(const Model<3> &, const Reactions<3> &, const Vector &, double,
                                      std::vector<std::string> &);

} // namespace dovetail
