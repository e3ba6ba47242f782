// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Lines, triangles and tetrahedra of a mesh file, straight or curved by nodes on their edges.

#pragma once

#include <dovetail/domain/mesh_file.h>

namespace dovetail {

/// X(l) = sum_i l_i X_i + sum_{i<j} 4 l_i l_j (X_ij - (X_i + X_j) / 2) with the barycentric coordinates l,
/// the vertices X_i and the nodes X_ij on the edges; in space, whatever the dimension of the simplex is.
class CurvedSimplex
{
public:
  /// The part of a cell that some of its vertices span: an edge, a face or the cell itself. Of quadrilaterals
  /// and hexahedra, an edge only.
  CurvedSimplex(const MeshFile &mesh, std::size_t cell, const std::vector<unsigned int> &part);

  /// Its length, area or volume, the integral of sqrt(det J^T J), J_d = dX/dl_d - dX/dl_0 [m, m^2, m^3].
  double measure() const;

  /// Whether det J <= 0 at a vertex, in the middle of an edge or in the centre of a triangle in the plane (J
  /// of its x and y) or of a tetrahedron.
  bool is_turned_over() const;

private:
  std::vector<dealii::Tensor<1, 3>> jacobian(const std::vector<double> &l) const;
  double determinant(const std::vector<double> &l) const;
  template <int dim>
  double integrate() const;

  std::vector<dealii::Tensor<1, 3>> vertices;
  std::vector<dealii::Tensor<1, 3>> bulges; ///< X_ij - (X_i + X_j) / 2
};

} // namespace dovetail
