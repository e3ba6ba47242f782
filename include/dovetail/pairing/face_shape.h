// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A face as a surface in space, whatever the shape of the cell behind it.

#pragma once

#include <dovetail/domain/geometry.h>

#include <deal.II/base/bounding_box.h>
#include <deal.II/grid/reference_cell.h>

#include <array>
#include <vector>

namespace dovetail {

/// A point X(xi) of a face with its tangents X_,k, and what belongs to it.
template <int dim>
struct SurfacePoint
{
  dealii::Point<dim - 1> xi;
  dealii::Point<dim> X;
  std::array<dealii::Tensor<1, dim>, dim - 1> tangent;
};

/// The faces of one mesh: X(xi) = sum_a phi_a(xi) X_a with the support points X_a of the mapping. Lines and
/// quadrilaterals have xi in [0,1]^(dim-1), triangles have xi_0, xi_1 >= 0, xi_0 + xi_1 <= 1. The support
/// points of a face are given by a pointer to the first of n_nodes() points, so one
/// object serves all faces.
template <int dim>
class FaceShape
{
public:
  FaceShape(const dealii::ReferenceCell &cell, unsigned int mapping_degree);

  dealii::ReferenceCell cell() const { return reference_cell; }
  bool is_triangle() const { return triangle; }
  unsigned int degree() const { return mapping_degree; }
  unsigned int n_nodes() const { return triangle ? simplex_basis.size() : basis.size(); }
  /// Reference coordinates in the cell of the support points of a face.
  std::vector<dealii::Point<dim>> nodes_in_cell(unsigned int face_no) const;
  dealii::Point<dim> position_in_cell(unsigned int face_no, const dealii::Point<dim - 1> &xi) const;
  dealii::Point<dim - 1> centre() const;

  unsigned int n_corners() const { return dim == 2 ? 2 : triangle ? 3 : 4; }
  /// Corners in the order around the face.
  dealii::Point<dim> corner(const dealii::Point<dim> *nodes, unsigned int i) const;
  dealii::Point<dim - 1> corner(unsigned int i) const;
  /// Of the edge of a face in 3D from corner i to the next one, at the Gauss-Lobatto points.
  std::vector<dealii::Point<dim>> edge(const dealii::Point<dim> *nodes, unsigned int i) const;
  /// The largest distance of the nodes of an edge of a face in 3D from the line through its ends.
  double bulge_of_rim(const dealii::Point<dim> *nodes) const;

  SurfacePoint<dim> evaluate(const dealii::Point<dim> *nodes, const dealii::Point<dim - 1> &xi) const;
  /// The outward normal, not normalised: its length is dA / dxi.
  dealii::Tensor<1, dim> normal(unsigned int face_no, const SurfacePoint<dim> &point) const;
  /// The closest point to Y on the face, clamped to its rim.
  SurfacePoint<dim> closest(const dealii::Point<dim> *nodes, const dealii::Point<dim> &Y) const;

  double diameter(const dealii::Point<dim> *nodes) const; ///< of the support points
  /// A box that holds the face.
  dealii::BoundingBox<dim> box(const dealii::Point<dim> *nodes) const;
  /// Whether the face is the straight or plane face through its corners, up to 1e-12 of its size.
  bool is_flat(const dealii::Point<dim> *nodes) const;
  /// Flat, and xi is an affine function of X.
  bool is_affine(const dealii::Point<dim> *nodes) const;

private:
  void find_edges();
  std::vector<dealii::Tensor<1, dim>> rest_of_linear(const dealii::Point<dim> *nodes) const;

  /// Reference coordinates along a face: origin + xi_k direction_k; orientation: of the tangents' product
  /// against the outward normal.
  struct Frame
  {
    dealii::Point<dim> origin;
    std::array<dealii::Tensor<1, dim>, dim - 1> direction;
    double orientation;
  };

  dealii::ReferenceCell reference_cell;
  unsigned int mapping_degree;
  bool triangle;
  LagrangeBasis<dim - 1> basis;                         ///< of lines and quadrilaterals
  SimplexBasis<dim - 1> simplex_basis;                  ///< of triangles
  std::vector<std::vector<unsigned int>> nodes_of_edge; ///< in 3D, from one corner to the next
  std::vector<dealii::Point<1>> points_of_edge;         ///< Gauss-Lobatto
  std::vector<Frame> frames;
  mutable std::vector<dealii::Tensor<1, dim>> offsets; // scratch
  mutable std::vector<double> values;
  mutable std::vector<dealii::Tensor<1, dim - 1>> gradients;
  mutable std::vector<dealii::Tensor<2, dim - 1>> hessians, no_hessians;
};

} // namespace dovetail
