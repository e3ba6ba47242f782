// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/given_values.h>

#include <deal.II/base/mpi.h>
#include <deal.II/fe/fe_values.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

namespace dovetail {

template <int dim>
std::optional<double> given_value(const Domain<dim> &domain, const Condition<dim> &condition,
                                  const dealii::Point<dim> &X, const double t)
{
  double value = 0;
  if (!condition.prescribed_components().empty())
    value = condition.prescribed_value(X, t, 0);
  else if (const auto equilibrium = condition.equilibrium_value(X, t); equilibrium || !condition.is_linear())
    return equilibrium;
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

namespace {

/// Likewise; nothing if a formula refuses, which must not end one rank alone.
template <int dim>
std::optional<double> value_or_nothing(const Domain<dim> &domain, const Condition<dim> &condition,
                                       const dealii::Point<dim> &X, const double t)
{
  try {
    return given_value(domain, condition, X, t);
  } catch (const UserError &) {
    return {};
  }
}

/// The influx into a body whose fields are zero.
template <int dim>
double influx_at_zero(const Domain<dim> &domain, const Condition<dim> &condition, const dealii::Point<dim> &X,
                      const double t, const unsigned int component)
{
  State<dim> state(domain.n_components());
  state.X = X;
  state.t = t;
  dealii::Tensor<1, dim> N;
  for (unsigned int d = 0; d < dim; ++d)
    N[d] = 1 / std::sqrt(dim); // any direction
  Influx<dim> influx(condition.field.n_components, domain.n_components());
  condition.influx(state, N, influx);
  return influx.value[component];
}

/// Whether value(t) jumps between two times. Its change is compared with the values of a step before as well:
/// a ramp that has just ended changes by the rounding of t, and what falls to zero has no other size.
template <typename Value>
bool jumps(const Value &value, double begin, double end)
{
  double first = value(begin), last = value(end);
  const double change = std::abs(last - first), earlier = value(std::max(0., 2 * begin - end)),
               size = std::max({std::abs(first), std::abs(last), std::abs(earlier)});
  if (change < 1e-10 * size)
    return false;
  const unsigned int most_halvings = 20;
  for (unsigned int halving = 0; halving < most_halvings; ++halving) {
    const double middle = (begin + end) / 2, between = value(middle);
    const bool is_first_half = std::abs(between - first) > std::abs(last - between);
    (is_first_half ? end : begin) = middle;
    (is_first_half ? last : first) = between;
    // a smooth function loses half of its change in each halving
    if (!(std::abs(last - first) > change / 2))
      return false;
  }
  return true;
}

} // namespace

template <int dim>
GivenValues<dim>::GivenValues(const Model<dim> &model) : model(model)
{
  const auto less = [](const dealii::Point<dim> &X, const dealii::Point<dim> &Y) {
    for (unsigned int d = 0; d < dim; ++d)
      if (X[d] != Y[d])
        return X[d] < Y[d];
    return false;
  };
  for (const auto &domain : model.domains) {
    for (const auto &condition : domain->conditions()) {
      const auto &element = domain->layout().nodal_element(condition->field.first_component);
      dealii::FEValues<dim> at_nodes(domain->mapping(), element, element.get_unit_support_points(),
                                     dealii::update_quadrature_points);
      std::array<std::vector<unsigned int>, dealii::GeometryInfo<dim>::faces_per_cell> on_face;
      for (unsigned int f = 0; f < element.reference_cell().n_faces(); ++f)
        for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
          if (element.has_support_on_face(a, f))
            on_face[f].push_back(a);
      std::set<dealii::Point<dim>, decltype(less)> nodes(less); // cells share them
      for (const auto &[cell, number, id] : domain->boundary_faces())
        if (cell->is_locally_owned() && condition->boundary_ids.count(id) > 0) {
          at_nodes.reinit(cell);
          for (const unsigned int a : on_face[number])
            nodes.insert(at_nodes.quadrature_point(a));
        }
      for (const auto &X : nodes)
        places.push_back({domain.get(), condition.get(), X});
    }
    for (const auto &[field, source] : domain->source().expressions)
      if (source.depends_on_time())
        for (const auto &cell : domain->mesh().active_cell_iterators())
          if (cell->is_locally_owned())
            sources.push_back({&source, cell->center()});
  }
}

template <int dim>
bool GivenValues<dim>::has_sources(const std::string &field) const
{
  for (const auto &domain : model.domains) {
    const auto &fields = domain->fields();
    for (unsigned int f = 0; f < fields.size(); ++f)
      if (fields[f].name == field && domain->material.has_load(f))
        return true;
    if (domain->source().find(field) != nullptr)
      return true;
  }
  return std::any_of(model.interfaces.begin(), model.interfaces.end(), [&](const auto &interface) {
    return std::any_of(interface->fields.begin(), interface->fields.end(), [&](const TiedField &tied) {
      const bool brings_other_values =
          interface->has_prescribed_jump() || tied.has_partition() || tied.names[0] != tied.names[1];
      return tied.ties(field) && brings_other_values;
    });
  });
}

template <int dim>
std::optional<ValueRange> GivenValues<dim>::range(const std::string &field, const double t) const
{
  const double infinity = std::numeric_limits<double>::infinity();
  double smallest = infinity, largest = -infinity;
  bool has_others = has_sources(field);
  for (const auto &[domain, condition, X] : places)
    if (condition->field.name == field && condition->is_active(t)) {
      if (const auto value = value_or_nothing(*domain, *condition, X, t)) {
        smallest = std::min(smallest, *value);
        largest = std::max(largest, *value);
      } else
        has_others = true;
    }
  smallest = dealii::Utilities::MPI::min(smallest, model.communicator);
  largest = dealii::Utilities::MPI::max(largest, model.communicator);
  if (dealii::Utilities::MPI::max(has_others ? 1 : 0, model.communicator) == 1)
    return {};
  return ValueRange{{smallest, largest}};
}

template <int dim>
bool GivenValues<dim>::jump_at(const Place &place, const double begin, const double end) const
{
  const Condition<dim> &condition = *place.condition;
  if (!condition.is_active(begin) || !condition.is_active(end))
    return false;
  bool found = false;
  for (const unsigned int c : condition.prescribed_components())
    found =
        found || jumps([&](const double t) { return condition.prescribed_value(place.X, t, c); }, begin, end);
  for (unsigned int c = 0; condition.adds_flux() && c < condition.field.n_components; ++c)
    found = found ||
            jumps([&](const double t) { return influx_at_zero(*place.domain, condition, place.X, t, c); },
                  begin, end);
  return found;
}

template <int dim>
bool GivenValues<dim>::jump_between(const double begin, const double end) const
{
  bool found = false;
  try {
    for (const Place &place : places)
      found = found || jump_at(place, begin, end);
    for (const auto &entry : sources) {
      const auto &source = *entry.first;
      for (unsigned int c = 0; c < source.n_components(); ++c)
        found = found || jumps([&](const double t) { return source.value(entry.second, t, c); }, begin, end);
    }
  } catch (const UserError &) { // not defined somewhere in between; the step does not ask there
  }
  return dealii::Utilities::MPI::max(found ? 1 : 0, model.communicator) == 1;
}

template class GivenValues<2>;
template class GivenValues<3>;
template std::optional<double> given_value(const Domain<2> &, const Condition<2> &, const dealii::Point<2> &,
                                           double);
template std::optional<double> given_value(const Domain<3> &, const Condition<3> &, const dealii::Point<3> &,
                                           double);

} // namespace dovetail
