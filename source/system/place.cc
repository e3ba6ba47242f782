// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/undefined.h>
#include <dovetail/system/place.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/point.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace dovetail {

namespace {

/// Nothing for multipliers.
template <int dim>
std::optional<dealii::Point<dim>> place_of_largest(const Model<dim> &model, const Vector &vector,
                                                   const unsigned int block)
{
  const Block &found_block = model.numbering->blocks()[block];
  if (found_block.is_of_multipliers)
    return {};
  const Domain<dim> &domain = *model.domains[found_block.domain_index];
  const auto size = [&vector](const dealii::types::global_dof_index dof) { // NaN is larger than all
    return std::isfinite(vector(dof)) ? std::abs(vector(dof)) : std::numeric_limits<double>::max();
  };
  std::vector<dealii::types::global_dof_index> dofs;
  const auto for_each = [&](const auto &action) {
    for (const auto &cell : domain.dof_handler().active_cell_iterators())
      if (!cell->is_artificial()) {
        domain.cell_dofs(cell, dofs);
        for (const auto dof : dofs)
          if (dof >= found_block.begin && dof < found_block.end && model.numbering->owned.is_element(dof))
            action(cell->center(), size(dof));
      }
  };
  double largest = -1;
  for_each([&](const dealii::Point<dim> &, const double value) { largest = std::max(largest, value); });
  largest = dealii::Utilities::MPI::max(largest, model.communicator);
  const auto comes_before = [](const dealii::Point<dim> &one, const dealii::Point<dim> &other) {
    return std::lexicographical_compare(one.begin_raw(), one.end_raw(), other.begin_raw(), other.end_raw());
  };
  std::pair<bool, dealii::Point<dim>> first(false, {}); // of equal ones, whatever their rounding is
  const auto consider = [&](const dealii::Point<dim> &place) {
    if (!first.first || comes_before(place, first.second))
      first = {true, place};
  };
  for_each([&](const dealii::Point<dim> &centre, const double value) {
    if (value >= (1 - 1e-6) * largest)
      consider(centre);
  });
  for (const auto &[is_there, place] : dealii::Utilities::MPI::all_gather(model.communicator, first))
    if (is_there)
      consider(place);
  return first.first ? std::optional(first.second) : std::nullopt;
}

} // namespace

template <int dim>
std::string in_cell_of_largest(const Model<dim> &model, const Vector &vector, const unsigned int block)
{
  const auto place = place_of_largest(model, vector, block);
  return place ? ", in the cell at " + in_words(*place, 3) : "";
}

template std::string in_cell_of_largest(const Model<2> &, const Vector &, unsigned int);
template std::string in_cell_of_largest(const Model<3> &, const Vector &, unsigned int);

} // namespace dovetail
