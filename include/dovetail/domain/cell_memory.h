// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the laws of a domain remember.

#pragma once

#include <dovetail/material/memory.h>

#include <deal.II/base/quadrature.h>
#include <deal.II/fe/mapping.h>
#include <deal.II/grid/tria.h>

#include <vector>

namespace dovetail {

/// The internal variables of a material at the quadrature points of the cells that this rank owns. Elsewhere
/// in a cell those of the nearest point hold: what is between two admissible states of a law need not be one.
template <int dim>
class CellMemory
{
public:
  using cell_iterator = typename dealii::Triangulation<dim>::active_cell_iterator;

  /// @param initial the numbers at a point before the first step
  CellMemory(const dealii::Triangulation<dim> &mesh, const dealii::Mapping<dim> &mapping,
             const dealii::Quadrature<dim> &quadrature, const std::vector<double> &initial);

  /// At the point of the cell that is the nearest to X; the initial ones in cells of other ranks.
  dealii::ArrayView<const double> nearest(const cell_iterator &cell, const dealii::Point<dim> &X) const;

  void set_trial(const cell_iterator &cell, const unsigned int q, const dealii::ArrayView<double> &values)
  {
    variables.set_trial(first_point[cell->active_cell_index()] + q, values);
  }
  void accept() { variables.accept(); }

  /// By active cell index, for each point X and the accepted variables: what divided cells hand on.
  using PackedCells = std::vector<std::vector<double>>;
  PackedCells pack() const;
  /// From the cells of which those of this mesh are parts: of the nearest of their points.
  void unpack(const PackedCells &packed);

private:
  unsigned int n_points_of_cell;
  std::vector<double> initial;
  std::vector<unsigned int> first_point; ///< by active cell index; of owned cells
  std::vector<dealii::Point<dim>> points;
  InternalVariables variables;
};

} // namespace dovetail
