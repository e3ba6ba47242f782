// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/fields_in_toggles.h>
#include <dovetail/scene/field_toggle.h>
#include <dovetail/scene/undefined.h>
#include <dovetail/tie/point_toggle.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

template <int dim>
PointToggle<dim>::PointToggle(const Section &section) : section(section)
{
  if (!has_field_toggle(section))
    return;
  names = names_in_toggles(section.top());
  formula = formula_of_toggle(section, section.peek("Toggle"));
}

/// Of each name the component of each side that has the field.
template <int dim>
std::vector<std::array<std::optional<unsigned int>, 2>>
PointToggle<dim>::components_of_names(const Interface<dim> &interface) const
{
  std::vector<std::array<Component, 2>> result(names.size());
  for (const unsigned int side : {source, destination}) {
    const auto components = components_in_toggles(section.top(), interface.sides[side].domain->fields());
    for (unsigned int s = 0; s < names.size(); ++s)
      if (formula->depends_on_scalar(s))
        result[s][side] = components[s];
  }
  return result;
}

template <int dim>
std::vector<double> PointToggle<dim>::find(const Interface<dim> &interface, const double t,
                                           const ValuesOf &values_of, const MPI_Comm &communicator) const
{
  const auto components = components_of_names(interface);
  std::vector<double> result(interface.pairing().n_points()), scalars(names.size());
  SidePoints<dim> points(interface, t);
  Undefined not_a_number;
  for_each_group(interface, values_of, [&](const auto &group, const std::vector<double> &unknowns) {
    for (unsigned int q = group.begin; q < group.end; ++q) {
      for (const unsigned int side : {source, destination})
        points.reinit(side, q, unknowns);
      for (unsigned int s = 0; s < names.size(); ++s) {
        double sum = 0, n = 0;
        for (const unsigned int side : {source, destination})
          if (const Component &c = components[s][side]) {
            sum += points.state[side].value[*c];
            ++n;
          }
        scalars[s] = n > 0 ? sum / n : 0;
      }
      const dealii::Point<dim> &X = interface.pairing().X(source, q);
      const double condition = formula->value(X, t, 0, scalars);
      result[q] = condition != 0 ? 1 : 0;
      if (std::isnan(condition) && !not_a_number)
        not_a_number = {sentence_about(section, "Toggle",
                                       "names " + section.peek("Toggle") +
                                           ", whose Active while is not a number at " + in_words(X) +
                                           " and t = " + in_words(t) + "."),
                        true};
    }
  });
  refuse_undefined(not_a_number, communicator);
  return result;
}

template <int dim>
void PointToggle<dim>::look(const Interface<dim> &interface, const double t, const ValuesOf &values_of,
                            const MPI_Comm &communicator)
{
  if (!is_given())
    return;
  if (time_before && t == *time_before) {
    on = on_before;
    time = time_before;
    is_new = false;
    return;
  }
  if (time && t > *time) { // a step that fails is followed by one that ends earlier
    on_before = on;
    time_before = time;
  }
  if (time && t == *time)
    return;
  on = find(interface, t, values_of, communicator);
  time = t;
  is_new = dealii::Utilities::MPI::max(time_before && on != on_before ? 1 : 0, communicator) == 1;
}

template <int dim>
std::vector<double> PointToggle<dim>::pack(const unsigned int n_points,
                                           const std::vector<double> &others) const
{
  if (!is_given() || on.empty())
    return others;
  const unsigned int n = others.size() / std::max(n_points, 1u);
  std::vector<double> numbers;
  for (unsigned int q = 0; q < n_points; ++q) {
    numbers.insert(numbers.end(), others.begin() + q * n, others.begin() + (q + 1) * n);
    numbers.push_back(on[q]);
  }
  return numbers;
}

template <int dim>
std::vector<double> PointToggle<dim>::unpack(const unsigned int n_points, const std::vector<double> &numbers)
{
  if (!is_given())
    return numbers;
  const unsigned int n = numbers.size() / std::max(n_points, 1u) - (n_points > 0 ? 1 : 0);
  std::vector<double> others;
  on.resize(n_points);
  for (unsigned int q = 0; q < n_points; ++q) {
    const auto begin = numbers.begin() + q * (n + 1);
    others.insert(others.end(), begin, begin + n);
    on[q] = begin[n];
  }
  return others;
}

template class PointToggle<2>;
template class PointToggle<3>;

} // namespace dovetail
