// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Lines, quadrilaterals and hexahedra of a mesh file that are curved by further nodes.

#pragma once

#include <dovetail/domain/mesh_file.h>

#include <deal.II/base/tensor.h>

#include <array>
#include <vector>

namespace dovetail {

/// The further nodes of a curved quadrilateral or hexahedron, or of a line or face of it, in the order of
/// FE_Q(2): on the lines, on the faces of a hexahedron, in the middle.
/// @param part its vertices in deal.II's order, which may be turned against that of the mesh
template <int structdim>
std::vector<dealii::Point<3>> further_nodes_of(const MeshFile &mesh, std::size_t cell,
                                               const std::vector<unsigned int> &part);

/// X(xi) = sum_a phi_a(xi) X_a with the functions phi_a of FE_Q(2), in space whatever the dimension is.
template <int structdim>
class CurvedCube
{
public:
  /// Of such a part.
  CurvedCube(const MeshFile &mesh, std::size_t cell, const std::vector<unsigned int> &part);

  /// Its length, area or volume, the integral of sqrt(det J^T J), J = dX/dxi [m, m^2, m^3].
  double measure() const;

  /// Whether det J <= 0 at a node, of a cell (a quadrilateral in the plane, a hexahedron).
  bool is_turned_over() const;

private:
  /// The columns of J, with the gradients of the functions at a point.
  std::array<dealii::Tensor<1, 3>, structdim>
  jacobian(const std::vector<dealii::Tensor<1, structdim>> &gradients) const;

  std::vector<dealii::Point<3>> nodes;
};

} // namespace dovetail
