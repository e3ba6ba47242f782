// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The two quadratures of an interface: points on the faces of one side, each with its partner.

#pragma once

#include <dovetail/pairing/face_locator.h>

#include <array>
#include <vector>

namespace dovetail {

/// Quadrature points on the own faces of one side. The points that have a partner cover the part of the side
/// that is tied, the others the rest: either set is a quadrature of its part.
template <int dim>
struct FacePoints
{
  /// Neighbouring points with the area that is theirs: a line, triangle or quadrilateral (in lexicographic
  /// order).
  struct Piece
  {
    unsigned int begin, end; ///< points
    unsigned int n_vertices;
    std::array<dealii::Point<dim>, 1 << (dim - 1)> vertices;
  };

  std::vector<unsigned int> face;              ///< of each point, position in SideFaces::faces
  std::vector<dealii::Point<dim>> unit_points; ///< in the cell behind the face
  std::vector<typename FaceLocator<dim>::Query> queries;
  std::vector<double> JxW;
  std::vector<typename FaceLocator<dim>::Match> matches;
  std::vector<Piece> pieces;
  unsigned long n_segments = 0;

  unsigned int size() const { return JxW.size(); }
  void add(const SideFaces<dim> &own, unsigned int face, const SurfacePoint<dim> &point, double JxW);
};

/// `mapped points`: Gauss points of the faces, exact for degree 2 n - 1, each with the closest point of the
/// other side. The integrands have kinks inside a face, so the error falls like 1/n^2. Collective.
template <int dim>
FacePoints<dim> mapped_points(const SideFaces<dim> &own, const FaceLocator<dim> &partner, unsigned int n);

/// `segments`: the common refinement of the faces of both sides. A segment is what a face shares with a face
/// of the other side when that is projected along the own face's normal: an interval in 2D, a convex polygon
/// in 3D, clipped by Sutherland and Hodgman (1974) in the plane of the own face (curved faces: in its
/// parameter plane) and divided into a fan about a corner where both faces are affine, and about its area
/// centroid elsewhere. Neighbours project their common vertices to the same points, so the segments tile the
/// face exactly; what no face covers remains as pieces of its own. Each quadrature point lies on the true own
/// face and has the closest point of the true other face.
///
/// On affine faces all products of shape functions are integrated exactly; @p own_degree and @p
/// partner_degree are the degrees of the elements. Where several faces overlap in projection (sharp corners,
/// thin layers) the nearest one wins. Collective.
template <int dim>
FacePoints<dim> segments(const SideFaces<dim> &own, const FaceLocator<dim> &partner, unsigned int own_degree,
                         unsigned int partner_degree);

} // namespace dovetail
