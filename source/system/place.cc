// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/place.h>

#include <deal.II/base/mpi.h>

#include <cmath>
#include <limits>

namespace dovetail {

template <int dim>
std::optional<dealii::Point<dim>> place_of_largest(const Model<dim> &model, const Vector &vector,
                                                   const unsigned int block)
{
  const Block &found_block = model.numbering->blocks()[block];
  if (found_block.is_of_multipliers)
    return {};
  const Domain<dim> &domain = *model.domains[found_block.domain_index];
  double largest = -1;
  dealii::Point<dim> centre;
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      for (const auto dof : dofs)
        if (dof >= found_block.begin && dof < found_block.end && model.numbering->owned.is_element(dof) &&
            !(std::abs(vector(dof)) <= largest)) { // NaN is larger than all
          largest = std::isfinite(vector(dof)) ? std::abs(vector(dof)) : std::numeric_limits<double>::max();
          centre = cell->center();
        }
    }
  const auto all = dealii::Utilities::MPI::all_gather(model.communicator, std::make_pair(largest, centre));
  const double largest_of_all = dealii::Utilities::MPI::max(largest, model.communicator);
  for (const auto &[size, place] : all)
    if (size == largest_of_all)
      return place;
  return {};
}

template std::optional<dealii::Point<2>> place_of_largest(const Model<2> &, const Vector &, unsigned int);
template std::optional<dealii::Point<3>> place_of_largest(const Model<3> &, const Vector &, unsigned int);

} // namespace dovetail
