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

} // namespace

template <int dim>
std::vector<std::vector<double>> rigid_motions(const Domain<dim> &domain, const Block &block,
                                               const dealii::Point<dim> &centre, const double length)
{
  const Field &field = domain.fields()[block.field_index];
  const unsigned int n_local = block.owned.n_elements();
  if (field.n_components == 1)
    return {constant(domain, block, field.first_component)};

  const unsigned int n_modes = dim == 2 ? 3 : 6;
  std::vector<std::vector<double>> modes(n_modes, std::vector<double>(n_local, 0.));
  const auto &element = domain.layout().element(field.first_component);
  dealii::FEValues<dim> at_nodes(domain.mapping(), element, element.get_unit_support_points(),
                                 dealii::update_quadrature_points);
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<bool> is_done(n_local, false);
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      bool is_mapped = false;
      for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
        for (unsigned int c = 0; c < dim; ++c) {
          const auto dof = dofs[domain.layout().index(field.first_component + c, a)] - block.begin;
          if (!block.owned.is_element(dof))
            continue;
          const auto i = block.owned.index_within_set(dof);
          if (is_done[i])
            continue;
          is_done[i] = true;
          if (!is_mapped)
            at_nodes.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
          is_mapped = true;
          const dealii::Tensor<1, dim> r = (at_nodes.quadrature_point(a) - centre) * (2. / length);
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
    }
  return modes;
}

template std::vector<std::vector<double>> rigid_motions(const Domain<2> &, const Block &,
                                                        const dealii::Point<2> &, double);
template std::vector<std::vector<double>> rigid_motions(const Domain<3> &, const Block &,
                                                        const dealii::Point<3> &, double);

} // namespace dovetail
