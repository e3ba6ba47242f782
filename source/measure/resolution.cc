// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/measure/resolution.h>
#include <dovetail/scene/undefined.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace dovetail {

namespace {

const NoteName
    of_resolution("resolution",
                  "a conductivity, a stiffness, or the volume of a mixed solid varies much within one cell");

/// Of the volumes at the points of cells, as root of the mean square.
const double largest_spread = 0.1;

/// Largest over smallest stiffness of a field within one cell, and the centre of that cell.
template <int dim>
using Variation = std::pair<double, dealii::Point<dim>>;

/// Calls @p visit with each cell of this rank, the values at its quadrature points and its unknowns.
template <int dim, typename Visit>
void for_each_cell(const Domain<dim> &domain, const Vector &solution, const Visit &visit)
{
  dealii::FEValues<dim> values(domain.mapping(), domain.layout().shape_element(),
                               gauss_rule<dim>(domain.cell_shape(), domain.degree + 1),
                               dealii::update_values | dealii::update_gradients |
                                   dealii::update_quadrature_points | dealii::update_JxW_values);
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell());
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      domain.cell_dofs(cell, dofs);
      solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
      visit(cell, values, unknowns);
    }
}

/// How A of a field depends on its gradient: a conductivity, or the stiffness of a solid at rest, which large
/// strain does not change.
template <int dim>
class Stiffness
{
public:
  Stiffness(const Domain<dim> &domain, const Field &field, const double t)
      : field(field), n(domain.n_components()), point(domain, t), layout(domain.layout())
  {
    for (const Field &other : domain.fields())
      asked.push_back(other.name == field.name ? Asked::derivatives : Asked::nothing);
  }

  /// At all quadrature points of a cell where the laws are defined.
  std::vector<double> operator()(const dealii::FEValues<dim> &values, std::vector<double> unknowns)
  {
    if (field.n_components > 1)
      std::fill(unknowns.begin() + layout.first(field.first_component),
                unknowns.begin() + layout.first(field.first_component + field.n_components), 0.);
    std::vector<double> result;
    for (const unsigned int q : values.quadrature_point_indices()) {
      point.reinit(values, q, unknowns);
      if (!point.evaluate(asked, point.response))
        continue;
      double square = 0;
      for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c)
        square += point.response.by_gradient[c * (n + 1)].norm_square();
      result.push_back(std::sqrt(square));
    }
    return result;
  }

private:
  const Field &field;
  const unsigned int n;
  CellPoints<dim> point;
  const CellLayout<dim> &layout;
  std::vector<Asked> asked;
};

template <int dim>
Variation<dim> variation_on_this_rank(const Domain<dim> &domain, const Field &field, const Vector &solution,
                                      const double t)
{
  Stiffness<dim> stiffness(domain, field, t);
  Variation<dim> worst(1., dealii::Point<dim>());
  for_each_cell(
      domain, solution, [&](const auto &cell, const auto &values, const std::vector<double> &unknowns) {
        const std::vector<double> k = stiffness(values, unknowns);
        if (k.empty())
          return;
        const auto [smallest, largest] = std::minmax_element(k.begin(), k.end());
        if (*largest > worst.first * *smallest)
          worst = {*smallest > 0 ? *largest / *smallest : std::numeric_limits<double>::max(), cell->center()};
      });
  return worst;
}

/// Of a mixed solid at large strain: J/J_p at the quadrature points, whose mean over a cell is nearly one.
template <int dim>
struct Volumes
{
  double squares = 0, volume = 0;   ///< integrals of (J/J_p - 1)^2 and 1
  double smallest = 1, largest = 1; ///< within the worst cell
  dealii::Point<dim> place;         ///< its centre

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &squares &volume &smallest &largest &place;
  }
  void add(const Volumes &other)
  {
    squares += other.squares;
    volume += other.volume;
    if (other.largest - other.smallest > largest - smallest) {
      smallest = other.smallest;
      largest = other.largest;
      place = other.place;
    }
  }
  double spread() const { return volume > 0 ? std::sqrt(squares / volume) : 0.; }
};

/// The equation of the pressure (doc/theory/laws.md) has the source J - J_p.
template <int dim>
Volumes<dim> volumes_of(const Domain<dim> &domain, const Field &pressure, const Vector &solution,
                        const double t, const MPI_Comm &communicator)
{
  CellPoints<dim> point(domain, t);
  Volumes<dim> own, all;
  for_each_cell(
      domain, solution, [&](const auto &cell, const auto &values, const std::vector<double> &unknowns) {
        Volumes<dim> here = {0, 0, 1, 1, cell->center()};
        for (const unsigned int q : values.quadrature_point_indices()) {
          point.reinit(values, q, unknowns);
          if (!point.evaluate(false))
            continue;
          const double J = determinant(point.displacement_gradient() + dealii::unit_symmetric_tensor<3>()),
                       ratio = J / (J - point.response.source[pressure.first_component]),
                       dV = domain.measure(values, q);
          here.squares += (ratio - 1) * (ratio - 1) * dV;
          here.volume += dV;
          here.smallest = std::min(here.smallest, ratio);
          here.largest = std::max(here.largest, ratio);
        }
        own.add(here);
      });
  for (const auto &of_rank : dealii::Utilities::MPI::all_gather(communicator, own))
    all.add(of_rank);
  return all;
}

template <int dim>
std::string explain_volumes(const Domain<dim> &domain, const Volumes<dim> &volumes)
{
  std::ostringstream words;
  words.precision(2);
  words
      << domain.name << ": the volume at points of its cells differs by " << 100 * volumes.spread()
      << " % (root mean square) from the one that belongs to the pressure, which holds in the mean of cells; "
         "around "
      << in_words(volumes.place) << " it is from " << volumes.smallest << " to " << volumes.largest
      << " times that. The mesh does not resolve the deformation, and strains and stresses may be far off. "
         "Refine it there";
  return words.str();
}

} // namespace

template <int dim>
NoteList explain_resolution(const Model<dim> &model, const Vector &solution, const double t)
{
  NoteList notes;
  for (const auto &domain : model.domains)
    for (unsigned int f = 0; f < domain->fields().size(); ++f) {
      const Field &field = domain->fields()[f];
      if (field.is_multiplier && domain->material.has_large_strain()) {
        const auto volumes = volumes_of(*domain, field, solution, t, model.communicator);
        if (volumes.spread() > largest_spread)
          notes.push_back(of_resolution(explain_volumes(*domain, volumes)));
      }
      const bool is_of_past = field.n_components > 1 && domain->material.has_memory(); // not that at rest
      if (domain->material.has_uniform_stiffness(f) || is_of_past)
        continue;
      const auto gathered = dealii::Utilities::MPI::all_gather(
          model.communicator, variation_on_this_rank(*domain, field, solution, t));
      const Variation<dim> worst = *std::max_element(
          gathered.begin(), gathered.end(), [](const auto &a, const auto &b) { return a.first < b.first; });
      if (!(worst.first > largest_variation))
        continue;
      std::ostringstream words;
      words.precision(2);
      words << domain->name << ": within one cell, around " << in_words(worst.second) << ", the "
            << (field.n_components > 1 ? "stiffness" : "conductivity") << " for its " << field.name
            << " varies by a factor of " << worst.first
            << ". The mesh does not resolve that, and the result may be far off. Refine it there";
      notes.push_back(of_resolution(words.str()));
    }
  return notes;
}

template NoteList explain_resolution(const Model<2> &, const Vector &, double);
template NoteList explain_resolution(const Model<3> &, const Vector &, double);

} // namespace dovetail
