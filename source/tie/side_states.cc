// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/tie/side_states.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

template <int dim>
bool has_large_strain(const Interface<dim> &interface, const TiedField &field)
{
  return field.n_components > 1 && (interface.sides[source].domain->material.has_large_strain() ||
                                    interface.sides[destination].domain->material.has_large_strain());
}

template <int dim>
bool has_large_strain(const Interface<dim> &interface)
{
  return std::any_of(interface.fields.begin(), interface.fields.end(),
                     [&](const TiedField &field) { return has_large_strain(interface, field); });
}

template <int dim>
void SideStates<dim>::begin_step(const Interface<dim> &interface, const double t, const ValuesOf &values_of)
{
  this->reinit(interface, t);
  choices.assign(interface.pairing().n_points(), {});
  if (!has_large_strain(interface))
    return;
  for_each_group(interface, values_of, [&](const auto &group, const std::vector<double> &unknowns) {
    for (unsigned int q = group.begin; q < group.end; ++q)
      for (const unsigned int side : {source, destination}) {
        const bool is_central = stiffens(interface, group, side, q, unknowns);
        choices[q][side] = {is_central, is_central};
      }
  });
}

template <int dim>
bool SideStates<dim>::stiffens(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                               const unsigned int side, const unsigned int q,
                               const std::vector<double> &unknowns)
{
  if (!interface.sides[side].domain->material.has_large_strain())
    return false;
  const auto &at_centre = interface.pairing().cells[side][group.cells[side]].central_gradients;
  this->reinit(side, q, unknowns);
  if (!this->evaluate(side, true))
    return true;
  const std::vector<TiedField> &fields = interface.fields;
  std::vector<double> here(fields.size(), 0.);
  for (unsigned int f = 0; f < fields.size(); ++f)
    if (has_large_strain(interface, fields[f]))
      here[f] = normal_stiffness(interface, fields[f], side, q);
  this->reinit(side, q, at_centre.data(), unknowns);
  if (!this->evaluate(side, true))
    return false;
  bool does = false;
  for (unsigned int f = 0; f < fields.size(); ++f)
    does = does ||
           (here[f] > 0 && here[f] > largest_stiffening * normal_stiffness(interface, fields[f], side, q));
  return does;
}

template <int dim>
bool SideStates<dim>::evaluate(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                               const unsigned int side, const unsigned int q, const double t,
                               const std::vector<double> &unknowns, const std::vector<Asked> &asked)
{
  this->state[side].t = t;
  Choice &choice = choices[q][side];
  choice.is_of_trial = choice.is_accepted;
  if (!choice.is_accepted) {
    this->reinit(side, q, unknowns);
    if (this->evaluate(side, asked))
      return true;
  }
  if (!interface.sides[side].domain->material.has_large_strain())
    return false;
  choice.is_of_trial = true;
  const auto &at_centre = interface.pairing().cells[side][group.cells[side]].central_gradients;
  this->reinit(side, q, at_centre.data(), unknowns);
  return this->evaluate(side, asked);
}

template <int dim>
void SideStates<dim>::accept()
{
  for (auto &chosen : choices)
    for (Choice &choice : chosen)
      choice.is_accepted = choice.is_of_trial;
}

template <int dim>
unsigned int SideStates<dim>::n_central() const
{
  unsigned int n = 0;
  for (unsigned int q = 0; q < choices.size(); ++q)
    n += is_central(source, q) || is_central(destination, q) ? 1 : 0;
  return n;
}

template <int dim>
double SideStates<dim>::normal_stiffness(const Interface<dim> &interface, const TiedField &field,
                                         const unsigned int side, const unsigned int q) const
{
  const unsigned int n = interface.sides[side].domain->n_components(), first = field.first_component[side];
  double square = 0;
  for (unsigned int c = first; c < first + field.n_components; ++c)
    for (unsigned int d = first; d < first + field.n_components; ++d)
      square += (interface.pairing().N(side, q) * this->response[side].by_gradient[c * n + d]).norm_square();
  return std::sqrt(square);
}

template class SideStates<2>;
template class SideStates<3>;
template bool has_large_strain(const Interface<2> &, const TiedField &);
template bool has_large_strain(const Interface<3> &, const TiedField &);
template bool has_large_strain(const Interface<2> &);
template bool has_large_strain(const Interface<3> &);

} // namespace dovetail
