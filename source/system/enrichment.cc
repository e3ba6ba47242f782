// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/enrichment.h>

#include <deal.II/fe/fe_tools.h>

namespace dovetail {

namespace {

using Index = dealii::types::global_dof_index;

/// Interpolates cell by cell between the spaces of two models on the same meshes. @p ghosted: of the first.
template <int dim>
Vector interpolate(const Model<dim> &from, const Model<dim> &to, const Vector &ghosted)
{
  Vector result(to.numbering->split(to.numbering->owned), to.communicator);
  std::vector<Index> from_dofs, to_dofs;
  std::vector<double> values;
  for (unsigned int d = 0; d < from.domains.size(); ++d) {
    const Domain<dim> &first = *from.domains[d], &second = *to.domains[d];
    std::map<unsigned int, dealii::FullMatrix<double>> matrices; // by space
    for (unsigned int c = 0; c < first.n_components(); ++c)
      if (const auto [matrix, is_new] = matrices.try_emplace(first.layout().space(c)); is_new) {
        matrix->second.reinit(second.layout().n_nodes(c), first.layout().n_nodes(c));
        dealii::FETools::get_interpolation_matrix(first.layout().element(c), second.layout().element(c),
                                                  matrix->second);
      }
    for (const auto &cell : first.mesh().active_cell_iterators())
      if (cell->is_locally_owned()) {
        first.cell_dofs(first.dof_cell(cell), from_dofs);
        second.cell_dofs(second.dof_cell(cell), to_dofs);
        values.resize(from_dofs.size());
        ghosted.extract_subvector_to(from_dofs.begin(), from_dofs.end(), values.begin());
        for (unsigned int c = 0; c < first.n_components(); ++c) {
          const auto &matrix = matrices.at(first.layout().space(c));
          for (unsigned int i = 0; i < matrix.m(); ++i) {
            const Index dof = to_dofs[second.layout().index(c, i)];
            if (!to.numbering->owned.is_element(dof))
              continue;
            double sum = 0;
            for (unsigned int j = 0; j < matrix.n(); ++j)
              sum += matrix(i, j) * values[first.layout().index(c, j)];
            result(dof) = sum;
          }
        }
      }
  }
  result.compress(dealii::VectorOperation::insert);
  return result;
}

/// Without what the constraints prescribe.
template <int dim>
void distribute_homogeneously(const BlockSystem<dim> &system, const Model<dim> &model, Vector &z)
{
  const auto &constraints = system.all_constraints();
  const Vector ghosted = system.ghosted(z);
  for (const Index dof : model.numbering->owned)
    if (constraints.is_constrained(dof)) {
      double sum = 0;
      for (const auto &[other, weight] : *constraints.get_constraint_entries(dof))
        sum += weight * ghosted(other);
      z(dof) = sum;
    }
  z.compress(dealii::VectorOperation::insert);
}

} // namespace

template <int dim>
Enrichment<dim>::Enrichment(const Model<dim> &coarse_model, const BlockSystem<dim> &coarse_system,
                            const double t, const Vector &x)
    : t(t), coarse_model(coarse_model), coarse_system(coarse_system), fine_model(coarse_model, 1),
      fine_system(fine_model, Form::transposed)
{
  fine_system.set_up(t);
  state = raised(x);
  ghosted_state = fine_system.ghosted(state);
  fine_system.begin_step(t, state);
}

template <int dim>
Vector Enrichment<dim>::distance_to_constraints()
{
  Vector moved = state;
  fine_system.constrain(moved);
  moved -= state;
  return moved;
}

template <int dim>
Vector Enrichment<dim>::raised(const Vector &coarse) const
{
  return interpolate(coarse_model, fine_model, coarse_system.ghosted(coarse));
}

template <int dim>
Vector Enrichment<dim>::lowered(const Vector &fine) const
{
  Vector coarse = interpolate(fine_model, coarse_model, fine_system.ghosted(fine));
  distribute_homogeneously(coarse_system, coarse_model, coarse);
  return coarse;
}

template <int dim>
Vector Enrichment<dim>::condensed(const Vector &v) const
{
  const auto &constraints = fine_system.all_constraints();
  Vector result = v, passed_on = fine_system.owned_vector();
  for (const Index dof : fine_model.numbering->owned)
    if (constraints.is_constrained(dof)) {
      for (const auto &[other, weight] : *constraints.get_constraint_entries(dof))
        passed_on(other) += weight * v(dof);
      result(dof) = 0;
    }
  result.compress(dealii::VectorOperation::insert);
  passed_on.compress(dealii::VectorOperation::add);
  result += passed_on;
  return result;
}

template <int dim>
void Enrichment<dim>::distribute(Vector &z) const
{
  distribute_homogeneously(fine_system, fine_model, z);
}

template class Enrichment<2>;
template class Enrichment<3>;

} // namespace dovetail
