// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_memory.h>

#include <deal.II/fe/fe_nothing.h>
#include <deal.II/fe/fe_values.h>

#include <limits>

namespace dovetail {

template <int dim>
CellMemory<dim>::CellMemory(const dealii::Triangulation<dim> &mesh, const dealii::Mapping<dim> &mapping,
                            const dealii::Quadrature<dim> &quadrature, const std::vector<double> &initial)
    : n_points_of_cell(quadrature.size()), initial(initial),
      first_point(mesh.n_active_cells(), dealii::numbers::invalid_unsigned_int)
{
  const dealii::FE_Nothing<dim> no_element(mesh.get_reference_cells().front());
  dealii::FEValues<dim> values(mapping, no_element, quadrature, dealii::update_quadrature_points);
  for (const auto &cell : mesh.active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(cell);
      first_point[cell->active_cell_index()] = points.size();
      const auto &cell_points = values.get_quadrature_points();
      points.insert(points.end(), cell_points.begin(), cell_points.end());
    }
  variables = InternalVariables(points.size(), initial);
}

namespace {

/// Number of the nearest of @p n points from @p begin on. Of several that are as near, up to rounding, as
/// where a cell has been halved, the first one: rounding decides nothing.
template <int dim, typename Iterator>
unsigned int find_nearest(const Iterator begin, const unsigned int n, const dealii::Point<dim> &X)
{
  unsigned int nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (unsigned int q = 0; q < n && least > 0; ++q)
    if (const double square = X.distance_square(begin[q]); square < (1 - 1e-9) * least) {
      least = square;
      nearest = q;
    }
  return nearest;
}

} // namespace

template <int dim>
dealii::ArrayView<const double> CellMemory<dim>::nearest(const cell_iterator &cell,
                                                         const dealii::Point<dim> &X) const
{
  if (!cell->is_locally_owned())
    return {initial.data(), initial.size()};
  const unsigned int first = first_point[cell->active_cell_index()];
  return variables.accepted(first + find_nearest(points.begin() + first, n_points_of_cell, X));
}

template <int dim>
typename CellMemory<dim>::PackedCells CellMemory<dim>::pack() const
{
  PackedCells packed(first_point.size());
  for (unsigned int cell = 0; cell < packed.size(); ++cell)
    if (first_point[cell] != dealii::numbers::invalid_unsigned_int)
      for (unsigned int q = first_point[cell]; q < first_point[cell] + n_points_of_cell; ++q) {
        for (unsigned int d = 0; d < dim; ++d)
          packed[cell].push_back(points[q][d]);
        const auto values = variables.accepted(q);
        packed[cell].insert(packed[cell].end(), values.begin(), values.end());
      }
  return packed;
}

template <int dim>
void CellMemory<dim>::unpack(const PackedCells &packed)
{
  AssertDimension(packed.size(), first_point.size());
  const unsigned int size = dim + initial.size();
  for (unsigned int cell = 0; cell < packed.size(); ++cell)
    if (first_point[cell] != dealii::numbers::invalid_unsigned_int) {
      std::vector<dealii::Point<dim>> parent_points(packed[cell].size() / size);
      for (unsigned int q = 0; q < parent_points.size(); ++q)
        for (unsigned int d = 0; d < dim; ++d)
          parent_points[q][d] = packed[cell][q * size + d];
      for (unsigned int q = first_point[cell]; q < first_point[cell] + n_points_of_cell; ++q) {
        const unsigned int parent = find_nearest(parent_points.begin(), parent_points.size(), points[q]);
        variables.set_accepted(q, {&packed[cell][parent * size + dim], initial.size()});
      }
    }
}

template class CellMemory<2>;
template class CellMemory<3>;

} // namespace dovetail
