// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/measure_by_vertices.h>
#include <dovetail/system/mean_gradient.h>

#include <deal.II/base/mpi.h>
#include <deal.II/fe/fe_values.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace dovetail {

namespace {

/// The integral of |grad u|^2 over this rank's cells of a body, and their volume.
template <int dim>
std::array<double, 2> integrate_square(const Domain<dim> &domain, const unsigned int first_component,
                                       const Vector &u)
{
  const CellLayout<dim> &layout = domain.layout();
  const auto &element = layout.element(first_component);
  dealii::FEValues<dim> at_centre(domain.mapping(), element, {domain.cell_shape().template barycenter<dim>()},
                                  dealii::update_gradients);
  std::vector<dealii::types::global_dof_index> dofs;
  std::array<double, 2> sums{};
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      at_centre.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      domain.cell_dofs(cell, dofs);
      double square = 0;
      for (unsigned int c = first_component; c < first_component + dim; ++c) {
        dealii::Tensor<1, dim> gradient;
        for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
          gradient += u(dofs[layout.index(c, a)]) * at_centre.shape_grad(a, 0);
        square += gradient.norm_square();
      }
      const double volume = measure_by_vertices<dim>(cell);
      sums[0] += square * volume;
      sums[1] += volume;
    }
  return sums;
}

} // namespace

template <int dim>
double largest_mean_gradient(const Model<dim> &model, const Vector &ghosted)
{
  std::vector<double> sums;
  for (const auto &domain : model.domains)
    for (const Field &field : domain->fields())
      if (field.n_components == dim && domain->material.has_large_strain()) {
        const auto its = integrate_square(*domain, field.first_component, ghosted);
        sums.insert(sums.end(), its.begin(), its.end());
      }
  dealii::Utilities::MPI::sum(sums, model.communicator, sums);
  double largest = 0;
  for (unsigned int i = 0; i < sums.size(); i += 2)
    largest = std::max(largest, std::sqrt(sums[i] / sums[i + 1]));
  return largest;
}

template double largest_mean_gradient(const Model<2> &, const Vector &);
template double largest_mean_gradient(const Model<3> &, const Vector &);

} // namespace dovetail
