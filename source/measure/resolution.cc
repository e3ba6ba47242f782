// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/measure/resolution.h>
#include <dovetail/scene/undefined.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <limits>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_resolution("resolution", "a conductivity varies much within one cell");

/// Largest over smallest conductivity of a field within one cell, and the centre of that cell.
template <int dim>
using Variation = std::pair<double, dealii::Point<dim>>;

template <int dim>
Variation<dim> variation_on_this_rank(const Domain<dim> &domain, const Field &field, const Vector &solution,
                                      const double t)
{
  const unsigned int n = domain.n_components();
  dealii::FEValues<dim> values(domain.mapping(), domain.layout().shape_element(),
                               gauss_rule<dim>(domain.cell_shape(), domain.degree + 1),
                               dealii::update_values | dealii::update_gradients |
                                   dealii::update_quadrature_points);
  CellPoints<dim> point(domain, t);
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell());
  Variation<dim> worst(1., dealii::Point<dim>());
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      domain.cell_dofs(cell, dofs);
      solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
      double smallest = std::numeric_limits<double>::infinity(), largest = 0;
      for (const unsigned int q : values.quadrature_point_indices()) {
        point.reinit(values, q, unknowns);
        if (!point.evaluate(true))
          continue;
        const double k = point.response.by_gradient[field.first_component * (n + 1)].norm();
        smallest = std::min(smallest, k);
        largest = std::max(largest, k);
      }
      if (largest > worst.first * smallest)
        worst = {smallest > 0 ? largest / smallest : std::numeric_limits<double>::max(), cell->center()};
    }
  return worst;
}

} // namespace

template <int dim>
NoteList explain_resolution(const Model<dim> &model, const Vector &solution, const double t)
{
  NoteList notes;
  for (const auto &domain : model.domains)
    for (unsigned int f = 0; f < domain->fields().size(); ++f) {
      const Field &field = domain->fields()[f];
      if (field.n_components > 1 || domain->material.is_linear(f))
        continue;
      const auto gathered = dealii::Utilities::MPI::all_gather(
          model.communicator, variation_on_this_rank(*domain, field, solution, t));
      const Variation<dim> worst = *std::max_element(
          gathered.begin(), gathered.end(), [](const auto &a, const auto &b) { return a.first < b.first; });
      if (!(worst.first > largest_variation))
        continue;
      std::ostringstream words;
      words.precision(2);
      words << domain->name << ": within one cell, around " << in_words(worst.second)
            << ", the conductivity for its " << field.name << " varies by a factor of " << worst.first
            << ". The mesh does not resolve that, and the result may be far off. Refine it there";
      notes.push_back(of_resolution(words.str()));
    }
  return notes;
}

template NoteList explain_resolution(const Model<2> &, const Vector &, double);
template NoteList explain_resolution(const Model<3> &, const Vector &, double);

} // namespace dovetail
