// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/curved_cells.h>

#include <deal.II/base/geometry_info.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/mapping_q.h>

namespace dovetail {

namespace {

template <int dim>
const dealii::FE_Q<dim> &quadratic_element()
{
  static const dealii::FE_Q<dim> element(2);
  return element;
}

template <int dim>
class MappingOfCurvedCells : public dealii::MappingQ<dim>
{
public:
  explicit MappingOfCurvedCells(const WithCurvedCells<dim> &cells) : dealii::MappingQ<dim>(2), cells(cells) {}

  std::unique_ptr<dealii::Mapping<dim>> clone() const override
  {
    return std::make_unique<MappingOfCurvedCells>(cells);
  }

protected:
  std::vector<dealii::Point<dim>> compute_mapping_support_points(
      const typename dealii::Triangulation<dim>::cell_iterator &cell) const override
  {
    std::vector<dealii::Point<dim>> points;
    for (const auto &xi : quadratic_element<dim>().get_unit_support_points())
      points.push_back(cells.position(cell, xi));
    return points;
  }

private:
  const WithCurvedCells<dim> &cells;
};

} // namespace

template <int dim>
void WithCurvedCells<dim>::curve(std::vector<std::vector<dealii::Point<dim>>> nodes_of_cells,
                                 dealii::Triangulation<dim> &mesh)
{
  nodes = std::move(nodes_of_cells);
  on_change = mesh.signals.any_change.connect([this, &mesh] {
    for (const auto &cell : mesh.cell_iterators())
      for (unsigned int v = 0; cell->level() > 0 && v < cell->n_vertices(); ++v)
        cell->vertex(v) = position(cell, dealii::GeometryInfo<dim>::unit_cell_vertex(v));
  });
}

template <int dim>
dealii::Point<dim>
WithCurvedCells<dim>::position(const typename dealii::Triangulation<dim>::cell_iterator &cell,
                               dealii::Point<dim> xi) const
{
  auto coarse = cell;
  while (coarse->level() > 0) {
    const auto parent = coarse->parent();
    unsigned int child = 0;
    while (parent->child(child) != coarse)
      ++child;
    xi = dealii::GeometryInfo<dim>::child_to_cell_coordinates(xi, child);
    coarse = parent;
  }
  dealii::Point<dim> X;
  const auto &nodes_of_cell = nodes[coarse->index()];
  for (unsigned int a = 0; a < nodes_of_cell.size(); ++a)
    X += quadratic_element<dim>().shape_value(a, xi) * nodes_of_cell[a];
  return X;
}

template <int dim>
bool has_curved_cells(const dealii::Triangulation<dim> &mesh)
{
  const auto *const cells = dynamic_cast<const WithCurvedCells<dim> *>(&mesh);
  return cells != nullptr && cells->is_curved();
}

template <int dim>
std::unique_ptr<dealii::Mapping<dim>> mapping_of_curved_cells(const Mesh<dim> &mesh)
{
  return std::make_unique<MappingOfCurvedCells<dim>>(dynamic_cast<const WithCurvedCells<dim> &>(mesh));
}

template class WithCurvedCells<2>;
template class WithCurvedCells<3>;
template bool has_curved_cells<2>(const dealii::Triangulation<2> &);
template bool has_curved_cells<3>(const dealii::Triangulation<3> &);
template std::unique_ptr<dealii::Mapping<2>> mapping_of_curved_cells<2>(const Mesh<2> &);
template std::unique_ptr<dealii::Mapping<3>> mapping_of_curved_cells<3>(const Mesh<3> &);

} // namespace dovetail
