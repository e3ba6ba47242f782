// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/initial_values.h>

#include <dovetail/solve/convergence.h>

#include <deal.II/base/mpi.h>
#include <deal.II/fe/fe_values.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <sstream>

namespace dovetail {

namespace {

/// A sum of values and of their weights.
using Mean = std::array<double, 2>;

/// The value at which a condition would leave the field alone: the prescribed one, or the ambient one, where
/// the influx h(T) vanishes, T = -h(0)/h'(0).
template <int dim>
std::optional<double> value_of(const Domain<dim> &domain, const Condition<dim> &condition,
                               const dealii::Point<dim> &X, const double t)
{
  double value = 0;
  if (!condition.prescribed_components().empty())
    value = condition.prescribed_value(X, t, 0);
  else {
    State<dim> state(domain.n_components());
    state.X = X;
    state.t = t;
    Influx<dim> influx(1, domain.n_components());
    condition.influx(state, {}, influx);
    const double derivative = influx.by_value(0, condition.field.first_component);
    if (derivative == 0)
      return {};
    value = -influx.value[0] / derivative;
  }
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

/// Calls @p visit with every active condition and the vertices of its faces, and with the size of the face.
template <int dim, typename Visit>
void for_each_vertex(const Domain<dim> &domain, const std::string &field, const double t, const Visit &visit)
{
  for (const auto &condition : domain.conditions())
    if (condition->field.name == field && condition->is_active(t))
      for (const auto &[cell, number, id] : domain.boundary_faces())
        if (cell->is_locally_owned() && condition->boundary_ids.count(id) > 0) {
          const auto face = cell->face(number);
          const double size = std::pow(face->diameter(), dim - 1);
          for (const unsigned int v : face->vertex_indices())
            visit(*condition, face->vertex(v), size);
        }
}

/// The same with all nodes of the faces: between the vertices the values may be others.
template <int dim, typename Visit>
void for_each_node(const Domain<dim> &domain, const std::string &field, const double t, const Visit &visit)
{
  const auto &element = domain.scalar_element();
  dealii::FEValues<dim> at_nodes(domain.mapping(), element, element.get_unit_support_points(),
                                 dealii::update_quadrature_points);
  for (const auto &condition : domain.conditions())
    if (condition->field.name == field && condition->is_active(t))
      for (const auto &[cell, number, id] : domain.boundary_faces())
        if (cell->is_locally_owned() && condition->boundary_ids.count(id) > 0) {
          at_nodes.reinit(cell);
          for (unsigned int a = 0; a < domain.n_nodes(); ++a)
            if (element.has_support_on_face(a, number))
              visit(*condition, at_nodes.quadrature_point(a));
        }
}

template <int dim>
Mean mean_of(const Domain<dim> &domain, const std::string &field, const double t,
             const MPI_Comm &communicator)
{
  Mean sum{};
  for_each_vertex(domain, field, t,
                  [&](const Condition<dim> &condition, const dealii::Point<dim> &X, const double size) {
                    auto value = value_of(domain, condition, X, 0.); // loads that grow with t begin there
                    value = value ? value : value_of(domain, condition, X, t);
                    if (value) {
                      sum[0] += size * *value;
                      sum[1] += size;
                    }
                  });
  return {
      {dealii::Utilities::MPI::sum(sum[0], communicator), dealii::Utilities::MPI::sum(sum[1], communicator)}};
}

/// For each domain the mean of those values at the beginning, over the boundaries of all bodies that are tied
/// to it where they are active at time @p t: a start without jumps, in which no conductivity is asked at 0 K.
/// Zero if there are none.
template <int dim>
std::vector<double> mean_given_values(const Model<dim> &model, const std::string &field, const double t)
{
  const unsigned int n = model.domains.size();
  std::vector<Mean> own;
  std::vector<unsigned int> group(n); // of bodies that are tied to each other
  for (unsigned int d = 0; d < n; ++d) {
    own.push_back(mean_of(*model.domains[d], field, t, model.communicator));
    group[d] = d;
  }
  for (const auto &interface : model.interfaces)
    for (const auto &tied : interface->fields)
      if (tied.name == field && interface->is_active(t) && interface->tie().holds(tied)) {
        std::array<unsigned int, 2> side_groups{};
        for (unsigned int d = 0; d < n; ++d)
          for (const unsigned int side : {source, destination})
            if (interface->sides[side].domain == model.domains[d].get())
              side_groups[side] = group[d];
        for (unsigned int &domain_group : group)
          if (domain_group == side_groups[1])
            domain_group = side_groups[0];
      }
  std::vector<Mean> group_means(n, Mean{});
  for (unsigned int d = 0; d < n; ++d)
    for (const unsigned int i : {0, 1})
      group_means[group[d]][i] += own[d][i];

  std::vector<double> means;
  for (unsigned int d = 0; d < n; ++d) {
    const Mean &mean = group_means[group[d]];
    means.push_back(mean[1] > 0 ? mean[0] / mean[1] : 0.);
  }
  return means;
}

/// The smallest and the largest of those values at time @p t over all bodies, between which the solution
/// lies; nothing with sources and given influxes, which may lead out of any range.
template <int dim>
std::optional<std::array<double, 2>> given_range(const Model<dim> &model, const std::string &field,
                                                 const double t)
{
  const double infinity = std::numeric_limits<double>::infinity();
  double smallest = infinity, largest = -infinity;
  bool has_others = false;
  for (const auto &domain : model.domains) {
    const auto &fields = domain->fields();
    for (unsigned int f = 0; f < fields.size(); ++f)
      has_others = has_others || (fields[f].name == field && domain->material.has_source(f));
    has_others = has_others || domain->source().find(field) != nullptr;
    for_each_node(*domain, field, t, [&](const Condition<dim> &condition, const dealii::Point<dim> &X) {
      if (const auto value = value_of(*domain, condition, X, t)) {
        smallest = std::min(smallest, *value);
        largest = std::max(largest, *value);
      } else
        has_others = true;
    });
  }
  smallest = dealii::Utilities::MPI::min(smallest, model.communicator);
  largest = dealii::Utilities::MPI::max(largest, model.communicator);
  if (dealii::Utilities::MPI::max(has_others ? 1 : 0, model.communicator) == 1 || smallest > largest)
    return {};
  return std::array<double, 2>{{smallest, largest}};
}

/// Set the unknowns of a field that this rank owns to value(X, component).
template <int dim, typename Value>
void set_nodes(const Model<dim> &model, const Domain<dim> &domain, const Field &field, const Value &value,
               Vector &x)
{
  const unsigned int n = domain.n_nodes();
  dealii::FEValues<dim> at_nodes(domain.mapping(), domain.scalar_element(),
                                 domain.scalar_element().get_unit_support_points(),
                                 dealii::update_quadrature_points);
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      at_nodes.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      domain.cell_dofs(cell, dofs);
      for (unsigned int c = 0; c < field.n_components; ++c)
        for (unsigned int a = 0; a < n; ++a)
          if (const auto dof = dofs[(field.first_component + c) * n + a];
              model.numbering->owned.is_element(dof))
            x(dof) = value(at_nodes.quadrature_point(a), c);
    }
}

} // namespace

template <int dim>
void set_initial_values(const Model<dim> &model, const double t, Vector &x,
                        const std::string &without_initial)
{
  std::map<std::string, std::vector<double>> guesses; // by field and domain
  const bool may_guess = !model.is_linear();
  for (unsigned int d = 0; d < model.domains.size(); ++d) {
    const auto &domain = model.domains[d];
    for (const Field &field : domain->fields()) {
      const Expression *initial =
          field.name == without_initial ? nullptr : domain->initial().find(field.name);
      const bool is_guessed = !initial && may_guess && field.n_components == 1 &&
                              domain->material.order_in_time(field.first_component) == 0;
      if (is_guessed && guesses.count(field.name) == 0)
        guesses[field.name] = mean_given_values(model, field.name, t);
      if (initial || is_guessed)
        set_nodes(
            model, *domain, field,
            [&](const dealii::Point<dim> &X, const unsigned int c) {
              return initial ? initial->value(X, 0., c) : guesses.at(field.name)[d];
            },
            x);
    }
  }
  x.compress(dealii::VectorOperation::insert);
}

template <int dim>
Vector initial_rates(const Model<dim> &model, const Vector &x)
{
  Vector rates = x;
  rates = 0;
  for (const auto &domain : model.domains)
    for (const Field &field : domain->fields())
      if (const Expression *initial = domain->initial().find(field.rate))
        set_nodes(
            model, *domain, field,
            [&](const dealii::Point<dim> &X, const unsigned int c) { return initial->value(X, 0., c); },
            rates);
  rates.compress(dealii::VectorOperation::insert);
  return rates;
}

template <int dim>
std::vector<std::string> explain_range(const Model<dim> &model, const Vector &solution, const double t)
{
  std::vector<std::string> sentences;
  const auto &blocks = model.numbering->blocks();
  std::map<std::string, std::optional<std::array<double, 2>>> range_of_field;
  for (unsigned int b = 0; b < blocks.size(); ++b) {
    if (blocks[b].is_of_multipliers ||
        model.domains[blocks[b].domain_index]->fields()[blocks[b].field_index].n_components > 1)
      continue;
    const auto [entry, is_new] = range_of_field.try_emplace(blocks[b].field);
    if (is_new)
      entry->second = given_range(model, blocks[b].field, t);
    const auto &range = entry->second;
    if (!range)
      continue;
    const double smallest = solution.block(b).min(), largest = solution.block(b).max();
    const double allowed =
        (*range)[1] - (*range)[0] +
        Convergence::smallest_range * std::max(std::abs((*range)[0]), std::abs((*range)[1]));
    if (smallest >= (*range)[0] - allowed && largest <= (*range)[1] + allowed)
      continue;
    std::ostringstream words;
    words.precision(4);
    words << "the " << blocks[b].field << " of " << blocks[b].name << " runs from " << smallest << " to "
          << largest << ", but what is prescribed allows only " << (*range)[0] << " to " << (*range)[1]
          << ": the result is not to be trusted. Refine the mesh where the field is steep";
    sentences.push_back(words.str());
  }
  return sentences;
}

template std::vector<std::string> explain_range(const Model<2> &, const Vector &, double);
template std::vector<std::string> explain_range(const Model<3> &, const Vector &, double);
template Vector initial_rates(const Model<2> &, const Vector &);
template Vector initial_rates(const Model<3> &, const Vector &);
template void set_initial_values(const Model<2> &, double, Vector &, const std::string &);
template void set_initial_values(const Model<3> &, double, Vector &, const std::string &);

} // namespace dovetail
