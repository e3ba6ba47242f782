// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/shapes.h>
#include <dovetail/measure/cell_search.h>

#include <deal.II/base/geometry_info.h>
#include <deal.II/numerics/rtree.h>

#include <iterator>

namespace dovetail {

namespace {

/// Further away than this a polynomial of a cell says nothing any more.
constexpr double reach = 0.3;

/// Barycentric coordinates below zero, for simplices.
template <int dim>
double distance_to_unit_cell(const dealii::Point<dim> &unit_point, const bool is_simplex)
{
  if (!is_simplex)
    return dealii::GeometryInfo<dim>::distance_to_unit_cell(unit_point);
  double last = 1, distance = 0;
  for (unsigned int d = 0; d < dim; ++d) {
    last -= unit_point[d];
    distance = std::max(distance, -unit_point[d]);
  }
  return std::max(distance, -last);
}

} // namespace

template <int dim>
struct CellSearch<dim>::Tree
{
  using Leaf = std::pair<dealii::BoundingBox<dim>, unsigned int>;
  dealii::RTree<Leaf> leaves;
};

template <int dim>
CellSearch<dim>::CellSearch(const Domain<dim> &domain) : domain(domain), tree(std::make_unique<Tree>())
{
  std::vector<typename Tree::Leaf> boxes;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      auto box = cell->bounding_box();
      box.extend(reach * cell->diameter());
      boxes.emplace_back(box, cells.size());
      cells.push_back(cell);
    }
  tree->leaves = dealii::pack_rtree(boxes);
}

template <int dim>
CellSearch<dim>::~CellSearch() = default;

template <int dim>
void CellSearch<dim>::compare(const unsigned int index, const dealii::Point<dim> &X, Place &place) const
{
  const auto &cell = cells[index];
  try {
    const typename dealii::Triangulation<dim>::active_cell_iterator mesh_cell(cell);
    const dealii::Point<dim> unit_point =
        domain.has_simplices() && domain.mapping_degree() == 1
            ? dealii::Point<dim>(dealii::invert(jacobian_of_simplex<dim>(mesh_cell)) * (X - cell->vertex(0)))
            : domain.mapping().transform_real_to_unit_cell(cell, X);
    const double distance = distance_to_unit_cell<dim>(unit_point, domain.has_simplices());
    if (distance < place.distance)
      place = {index, unit_point, distance};
  } catch (const typename dealii::Mapping<dim>::ExcTransformationFailed &) {
    // too far away for this curved cell
  }
}

template <int dim>
typename CellSearch<dim>::Place CellSearch<dim>::find(const dealii::Point<dim> &X) const
{
  namespace bgi = boost::geometry::index;
  std::vector<typename Tree::Leaf> found;
  tree->leaves.query(bgi::intersects(X), std::back_inserter(found));
  // most likely the cell whose middle is nearest
  std::vector<std::pair<double, unsigned int>> candidates;
  for (const auto &leaf : found)
    candidates.emplace_back(leaf.first.center().distance_square(X), leaf.second);
  std::sort(candidates.begin(), candidates.end());
  Place place;
  for (const auto &candidate : candidates) {
    compare(candidate.second, X, place);
    if (place.distance < 1e-12)
      break;
  }
  return place.distance <= reach ? place : Place();
}

template class CellSearch<2>;
template class CellSearch<3>;

} // namespace dovetail
