// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The plane in which faces of the other side are clipped against an own face.

#pragma once

#include <dovetail/pairing/curved_region.h>
#include <dovetail/pairing/face_shape.h>

namespace dovetail {

/// Coordinates s on a face: in 2D its reference coordinate, in 3D coordinates in the plane through its
/// corners in units of its size. Straight edges of plane faces are straight there.
///
/// Integration runs over s where the face is flat (the multilinear image of its corners, and plane), else
/// over its reference coordinates xi.
template <int dim>
class Chart
{
public:
  /// @p offset: rounding is relative to this distance from the origin, or to that of the face if it is
  /// larger.
  Chart(const FaceShape<dim> &shape, const FaceShape<dim> &bilinear, const dealii::Point<dim> *nodes,
        double size, double offset);

  Region<dim - 1> window;                         ///< the corners of the face; empty if it has no area
  std::vector<dealii::Point<dim>> nodes_of_plane; ///< of the plane face through the corners
  bool is_flat, is_affine;
  double rounding;   ///< of coordinates
  double negligible; ///< regions below this fraction of a face are rounding

  /// Whether a point lies in the plane of the corners, in 3D.
  bool is_in_plane(const dealii::Point<dim> &X) const;
  /// The projection of a point of the other side.
  dealii::Point<dim - 1> project(const dealii::Point<dim> &X) const;
  /// From the coordinates of the clipping to those of the integration, with straight edges in both.
  Region<dim - 1> to_integration(const Region<dim - 1> &region) const;
  /// The point of the face with these coordinates of the integration, and dA / ds there.
  SurfacePoint<dim> evaluate(const dealii::Point<dim - 1> &s) const;
  double jacobian(const SurfacePoint<dim> &point) const;

private:
  dealii::Point<dim> lift(const dealii::Point<dim - 1> &s) const; ///< the point of the plane
  dealii::Point<dim - 1> xi_of(const dealii::Point<dim - 1> &s) const;
  void improve(const dealii::Point<dim - 1> &s, dealii::Point<dim - 1> &xi) const;
  dealii::Tensor<2, dim - 1> derivative(const SurfacePoint<dim> &point) const; ///< ds / dxi

  const FaceShape<dim> &shape, &bilinear;
  const dealii::Point<dim> *nodes;
  double size;
  dealii::Point<dim> origin;
  std::array<dealii::Tensor<1, dim>, dim - 1> axis;
  dealii::Tensor<2, dim - 1> inverse; ///< dxi / ds of an affine face

  friend class CurvedWindow;
};

/// A face in 3D as a window for regions with curved edges, which are projections of faces of the other side.
///
/// A point is inside if its reference coordinates xi(s) are; they are found by Newton's method for the point
/// X(xi) of the true face that is projected to s, also near the face outside of it. So the rim of the window
/// is that of the face, and the parts of a region in all faces of a side tile the region.
class CurvedWindow
{
public:
  explicit CurvedWindow(const Chart<3> &chart);

  /// The projection of a face of the other side, counter-clockwise.
  CurvedRegion project(const FaceShape<3> &shape, const dealii::Point<3> *nodes,
                       const Interpolation &interpolation) const;
  /// What of it is inside.
  CurvedRegion clip(const CurvedRegion &region) const;

  /// A point of an arc and its derivative by the arc's parameter, in coordinates of the integration.
  struct CurvePoint
  {
    dealii::Point<2> s;
    dealii::Tensor<1, 2> derivative;
  };
  CurvePoint evaluate(const Arc &arc, double v) const;
  /// Whether an arc is straight in coordinates of the integration.
  bool is_straight(const Arc &arc) const;
  /// In coordinates of the integration.
  double measure(const CurvedRegion &region) const;
  dealii::Point<2> centroid(const CurvedRegion &region) const;
  double measure() const { return whole; } ///< of the face
  /// Reference coordinates: of a point of the integration, of the ends of an arc and, unless it is straight
  /// there, of points between them, and of the corners of the face.
  dealii::Point<2> reference_point(const dealii::Point<2> &s) const;
  std::vector<dealii::Point<2>> reference_points(const Arc &arc) const;
  Region<2> reference_corners() const;

  /// Whether somewhere no reference coordinates were found, since the face is too strongly curved.
  bool has_failed() const { return failed; }

private:
  dealii::Point<2> xi_of(const Arc &arc, double v) const;
  dealii::Point<2> xi_of(const dealii::Point<2> &s) const;
  CurvedRegion without_detours(const CurvedRegion &region) const;
  double distance_from_rim(unsigned int rim, const dealii::Point<2> &xi) const;
  double parameter_of_rim(unsigned int rim, const dealii::Point<2> &xi) const;
  Region<2> surroundings() const;

  const Chart<3> &chart;
  std::vector<Arc> rims;
  Region<2> polygon; ///< around the face, or the face if it is flat
  double whole;
  mutable bool failed = false;
};

} // namespace dovetail
