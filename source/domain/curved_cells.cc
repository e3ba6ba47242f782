// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/curved_cells.h>

#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/mapping_q.h>

namespace dovetail {

namespace {

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
    return cells.nodes_of(cell);
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
      if (cell->level() > 0) {
        const auto nodes_of_cell = nodes_of(cell);
        for (const unsigned int v : cell->vertex_indices())
          cell->vertex(v) = nodes_of_cell[v];
      }
  });
}

template <int dim>
std::vector<dealii::Point<dim>>
WithCurvedCells<dim>::nodes_of(const typename dealii::Triangulation<dim>::cell_iterator &cell) const
{
  if (cell->level() == 0)
    return nodes[cell->index()];
  static const dealii::FE_Q<dim> quadratic(2);
  const auto parent = cell->parent();
  unsigned int child = 0;
  while (parent->child(child) != cell)
    ++child;
  const auto &parent_to_child = quadratic.get_prolongation_matrix(child);
  const auto nodes_of_parent = nodes_of(parent);
  std::vector<dealii::Point<dim>> result(nodes_of_parent.size());
  for (unsigned int a = 0; a < result.size(); ++a)
    for (unsigned int b = 0; b < result.size(); ++b)
      result[a] += parent_to_child(a, b) * nodes_of_parent[b];
  return result;
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
