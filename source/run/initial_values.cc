// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/quadrature.h>
#include <dovetail/run/initial_values.h>

#include <dovetail/run/given_values.h>

#include <deal.II/base/mpi.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/lac/full_matrix.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace dovetail {

namespace {

/// A sum of values and of their weights.
using Mean = std::array<double, 2>;

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

template <int dim>
Mean mean_of(const Domain<dim> &domain, const std::string &field, const double t,
             const MPI_Comm &communicator)
{
  Mean sum{};
  for_each_vertex(domain, field, t,
                  [&](const Condition<dim> &condition, const dealii::Point<dim> &X, const double size) {
                    auto value = given_value(domain, condition, X, 0.); // loads that grow with t begin there
                    value = value ? value : given_value(domain, condition, X, t);
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
      if (tied.names[source] == field && tied.names[destination] == field && interface->is_active(t) &&
          interface->tie().holds(tied)) {
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

/// Of a discontinuous field those of the projection, cell by cell.
template <int dim, typename Value>
void project(const Domain<dim> &domain, const Field &field, const Value &value, Vector &x)
{
  const CellLayout<dim> &layout = domain.layout();
  const unsigned int n = layout.n_nodes(field.first_component);
  dealii::FEValues<dim> values(domain.mapping(), layout.element(field.first_component),
                               gauss_rule<dim>(domain.cell_shape(), domain.degree + 1),
                               dealii::update_values | dealii::update_quadrature_points |
                                   dealii::update_JxW_values);
  dealii::FullMatrix<double> mass(n, n);
  dealii::Vector<double> moments(n), coefficients(n);
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      domain.cell_dofs(cell, dofs);
      for (unsigned int c = 0; c < field.n_components; ++c) {
        mass = 0;
        moments = 0;
        for (const unsigned int q : values.quadrature_point_indices())
          for (unsigned int i = 0; i < n; ++i) {
            const double phi = values.shape_value(i, q) * values.JxW(q);
            moments[i] += phi * value(values.quadrature_point(q), c);
            for (unsigned int j = 0; j < n; ++j)
              mass(i, j) += phi * values.shape_value(j, q);
          }
        mass.gauss_jordan();
        mass.vmult(coefficients, moments);
        for (unsigned int i = 0; i < n; ++i)
          x(dofs[layout.index(field.first_component + c, i)]) = coefficients[i];
      }
    }
}

} // namespace

template <int dim>
void set_nodes(const Model<dim> &model, const Domain<dim> &domain, const Field &field,
               const std::function<double(const dealii::Point<dim> &X, unsigned int component)> &value,
               Vector &x)
{
  const CellLayout<dim> &layout = domain.layout();
  if (!layout.is_continuous(field.first_component))
    return project(domain, field, value, x);
  const auto &element = layout.element(field.first_component);
  dealii::FEValues<dim> at_nodes(domain.mapping(), element, element.get_unit_support_points(),
                                 dealii::update_quadrature_points);
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      at_nodes.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      domain.cell_dofs(cell, dofs);
      for (unsigned int c = 0; c < field.n_components; ++c)
        for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
          if (const auto dof = dofs[layout.index(field.first_component + c, a)];
              model.numbering->owned.is_element(dof))
            x(dof) = value(at_nodes.quadrature_point(a), c);
    }
}

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
        set_nodes<dim>(
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
        set_nodes<dim>(
            model, *domain, field,
            [&](const dealii::Point<dim> &X, const unsigned int c) { return initial->value(X, 0., c); },
            rates);
  rates.compress(dealii::VectorOperation::insert);
  return rates;
}

template void set_nodes(const Model<2> &, const Domain<2> &, const Field &,
                        const std::function<double(const dealii::Point<2> &, unsigned int)> &, Vector &);
template void set_nodes(const Model<3> &, const Domain<3> &, const Field &,
                        const std::function<double(const dealii::Point<3> &, unsigned int)> &, Vector &);
template Vector initial_rates(const Model<2> &, const Vector &);
template Vector initial_rates(const Model<3> &, const Vector &);
template void set_initial_values(const Model<2> &, double, Vector &, const std::string &);
template void set_initial_values(const Model<3> &, double, Vector &, const std::string &);

} // namespace dovetail
