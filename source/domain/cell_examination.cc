// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_examination.h>
#include <dovetail/domain/equal_cells.h>
#include <dovetail/domain/quadrature.h>

#include <deal.II/base/mpi.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/grid/cell_id.h>

#include <algorithm>
#include <sstream>

namespace dovetail {

namespace {

template <int dim>
std::string vertices_of(const typename dealii::Triangulation<dim>::active_cell_iterator &cell)
{
  std::ostringstream text;
  for (const unsigned int v : cell->vertex_indices()) {
    text << (v == 0 ? "(" : ", (");
    for (unsigned int d = 0; d < dim; ++d)
      text << (d == 0 ? "" : "; ") << cell->vertex(v)[d];
    text << ")";
  }
  return text.str();
}

} // namespace

template <int dim>
void examine_cells(const Section &section, const Mesh<dim> &mesh, const dealii::Mapping<dim> &mapping,
                   const dealii::FiniteElement<dim> &element, const MPI_Comm &communicator)
{
  dealii::FEValues<dim> values(mapping, element,
                               gauss_rule<dim>(element.reference_cell(), element.degree + 1),
                               dealii::update_JxW_values);
  EqualCells<dim> cells(mapping);
  bool is_good = true;
  unsigned int n_bad = 0;
  std::vector<std::pair<dealii::CellId, std::string>> first; // of this rank
  for (const auto &cell : mesh.active_cell_iterators())
    if (cell->is_locally_owned()) {
      if (!cells.is_equal(cell)) {
        values.reinit(cell);
        const auto &JxW = values.get_JxW_values();
        is_good =
            std::all_of(JxW.begin(), JxW.end(), [](const double dx) { return dx > 0 && std::isfinite(dx); });
      }
      if (is_good)
        continue;
      ++n_bad;
      if (first.empty() || cell->id() < first[0].first)
        first = {{cell->id(), vertices_of<dim>(cell)}};
    }
  n_bad = dealii::Utilities::MPI::sum(n_bad, communicator);
  if (n_bad == 0)
    return;
  std::vector<std::pair<dealii::CellId, std::string>> all_faults;
  for (const auto &rank_faults : dealii::Utilities::MPI::all_gather(communicator, first))
    all_faults.insert(all_faults.end(), rank_faults.begin(), rank_faults.end());
  const auto &found = *std::min_element(all_faults.begin(), all_faults.end());
  section.fail("", "the mesh has " + std::to_string(n_bad) +
                       (n_bad == 1 ? " cell that is" : " cells that are") +
                       " turned over or flat, in whole or in part: the Jacobian is not positive at all "
                       "quadrature points of the cell with the vertices " +
                       found.second + ". Make another mesh there.");
}

template void examine_cells<2>(const Section &, const Mesh<2> &, const dealii::Mapping<2> &,
                               const dealii::FiniteElement<2> &, const MPI_Comm &);
template void examine_cells<3>(const Section &, const Mesh<3> &, const dealii::Mapping<3> &,
                               const dealii::FiniteElement<3> &, const MPI_Comm &);

} // namespace dovetail
