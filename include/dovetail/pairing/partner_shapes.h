// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the assembly needs of the cells behind matched points, fetched once from the ranks that own them.

#pragma once

#include <dovetail/domain/shapes.h>
#include <dovetail/pairing/face_locator.h>

#include <vector>

namespace dovetail {

/// A cell behind points of an interface: its unknowns (component, node), the measures of it and of its face,
/// and, where the solid's law is nonlinear, the gradients of its shape functions at its centre.
template <int dim>
struct CellBehind
{
  std::vector<dealii::types::global_dof_index> dofs;
  double cell_measure = 0;                               ///< Omega
  double face_measure = 0;                               ///< Gamma
  std::vector<dealii::Tensor<1, dim>> central_gradients; ///< of each one
  unsigned int face_no = 0;                              ///< of the face in the cell
  std::vector<dealii::Point<dim>>
      nodes; ///< of the shape functions of hypercubes above degree 1, if asked for
  unsigned int rank = dealii::numbers::invalid_unsigned_int; ///< that owns the cell
  unsigned int face = dealii::numbers::invalid_unsigned_int; ///< of the side, as in SideFaces::faces there

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &dofs &cell_measure &face_measure &central_gradients &face_no &nodes &rank &face;
  }
};

/// That of a face that this rank owns. @p shapes: of the domain; they become those of this cell.
template <int dim>
CellBehind<dim> cell_behind(const Domain<dim> &domain, const SideFaces<dim> &side, unsigned int face,
                            unsigned int this_rank, bool with_nodes, ShapeEvaluator<dim> &shapes);

/// For each match the cell behind it, and what UnitShapes needs for the shape functions there.
template <int dim>
struct PartnerShapes
{
  std::vector<CellBehind<dim>> cells;
  std::vector<unsigned int> cell_of_point; ///< invalid_unsigned_int if the point has no partner
  std::vector<dealii::Tensor<2, dim>> inverse_jacobians;
};

/// Matches on the same face share one cell. Collective; nothing is sent for matches of this rank.
template <int dim>
PartnerShapes<dim> fetch_shapes(const Domain<dim> &partner, const FaceLocator<dim> &locator,
                                const std::vector<typename FaceLocator<dim>::Match> &matches, bool with_nodes,
                                const MPI_Comm &communicator);

} // namespace dovetail
