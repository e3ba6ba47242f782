// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/rigid_motions.h>

#include <deal.II/fe/fe_values.h>

namespace dovetail {

namespace {

/// The function 1 of a scalar, whose unknowns are its values unless it is discontinuous.
template <int dim>
std::vector<double> constant(const Domain<dim> &domain, const Block &block, const unsigned int component)
{
  const CellLayout<dim> &layout = domain.layout();
  std::vector<double> mode(block.owned.n_elements(), 1.);
  if (layout.is_continuous(component))
    return mode;
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      for (unsigned int a = 0; a < layout.n_nodes(component); ++a)
        mode[block.owned.index_within_set(dofs[layout.index(component, a)] - block.begin)] =
            layout.unit(component)[a];
    }
  return mode;
}

/// X becomes X + u. The components of u at a node belong to the same cells.
template <int dim>
void displace(std::vector<Place<dim>> &places, const Domain<dim> &domain, const Block &block,
              const Vector &displacements)
{
  const unsigned int first = domain.fields()[block.field_index].first_component;
  const CellLayout<dim> &layout = domain.layout();
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<dealii::Tensor<1, dim>> u(places.size());
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      for (unsigned int a = 0; a < layout.n_nodes(first); ++a)
        for (unsigned int c = 0; c < dim; ++c)
          if (const auto dof = dofs[layout.index(first + c, a)] - block.begin; block.owned.is_element(dof))
            for (unsigned int d = 0; d < dim; ++d)
              u[block.owned.index_within_set(dof)][d] = displacements(dofs[layout.index(first + d, a)]);
    }
  for (unsigned int i = 0; i < places.size(); ++i)
    places[i].position += u[i];
}

template <typename Value>
std::vector<Value> select(std::vector<Value> all, const std::vector<unsigned int> *numbers)
{
  if (numbers == nullptr)
    return all;
  std::vector<Value> result;
  result.reserve(numbers->size());
  for (const unsigned int i : *numbers)
    result.push_back(all[i]);
  return result;
}

} // namespace

template <int dim>
std::vector<Place<dim>> places_of_unknowns(const Domain<dim> &domain, const Block &block)
{
  const Field &field = domain.fields()[block.field_index];
  const CellLayout<dim> &layout = domain.layout();
  const bool has_nodes = layout.is_continuous(field.first_component);
  const auto &element = layout.element(field.first_component);
  const std::vector<dealii::Point<dim>> centre = {domain.cell_shape().template barycenter<dim>()};
  const auto &nodes = has_nodes ? element.get_unit_support_points() : centre;
  dealii::FEValues<dim> at_nodes(domain.mapping(), element, nodes, dealii::update_quadrature_points);
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<Place<dim>> places(block.owned.n_elements());
  std::vector<bool> is_done(places.size(), false);
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      bool is_mapped = false;
      for (unsigned int c = 0; c < field.n_components; ++c)
        for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a) {
          const auto dof = dofs[layout.index(field.first_component + c, a)] - block.begin;
          if (!block.owned.is_element(dof) || is_done[block.owned.index_within_set(dof)])
            continue;
          if (!is_mapped)
            at_nodes.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
          is_mapped = true;
          const auto i = block.owned.index_within_set(dof);
          is_done[i] = true;
          places[i] = {at_nodes.quadrature_point(has_nodes ? a : 0), c};
        }
    }
  return places;
}

template <int dim>
std::vector<std::vector<double>>
rigid_motions(const Domain<dim> &domain, const Block &block, const dealii::Point<dim> &centre,
              const double length, const std::vector<unsigned int> *unknowns, const Vector *displacements)
{
  const Field &field = domain.fields()[block.field_index];
  if (field.n_components == 1)
    return {select(constant(domain, block, field.first_component), unknowns)};

  std::vector<Place<dim>> places;
  if (unknowns == nullptr || !unknowns->empty()) {
    places = places_of_unknowns(domain, block);
    if (displacements != nullptr)
      displace(places, domain, block, *displacements);
    places = select(std::move(places), unknowns);
  }
  const unsigned int n_modes = dim == 2 ? 3 : 6;
  std::vector<std::vector<double>> modes(n_modes, std::vector<double>(places.size(), 0.));
  for (unsigned int i = 0; i < places.size(); ++i) {
    const dealii::Tensor<1, dim> r = (places[i].position - centre) * (2. / length);
    const unsigned int c = places[i].component;
    modes[c][i] = 1;
    if constexpr (dim == 2)
      modes[2][i] = c == 0 ? -r[1] : r[0];
    else
      for (unsigned int axis = 0; axis < 3; ++axis) {
        dealii::Tensor<1, dim> e;
        e[axis] = 1;
        modes[3 + axis][i] = dealii::cross_product_3d(e, r)[c];
      }
  }
  return modes;
}

template std::vector<Place<2>> places_of_unknowns(const Domain<2> &, const Block &);
template std::vector<Place<3>> places_of_unknowns(const Domain<3> &, const Block &);
template std::vector<std::vector<double>> rigid_motions(const Domain<2> &, const Block &,
                                                        const dealii::Point<2> &, double,
                                                        const std::vector<unsigned int> *, const Vector *);
template std::vector<std::vector<double>> rigid_motions(const Domain<3> &, const Block &,
                                                        const dealii::Point<3> &, double,
                                                        const std::vector<unsigned int> *, const Vector *);

} // namespace dovetail
