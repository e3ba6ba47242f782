// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Convex regions of a line and of a plane: intervals and polygons.

#pragma once

#include <deal.II/base/point.h>

#include <vector>

namespace dovetail {

/// Its corners: two on a line, in increasing order; in a plane any number from three on, counter-clockwise.
/// All lengths are measured in a unit of the order of one, so tolerances are absolute: corners closer than
/// 1e-14 are one, regions smaller than that are empty (no corners).
template <int dim>
using Region = std::vector<dealii::Point<dim>>;

/// What a × b is perpendicular to the plane.
double cross(const dealii::Tensor<1, 2> &a, const dealii::Tensor<1, 2> &b);

/// Length or area.
double measure(const Region<1> &region);
double measure(const Region<2> &region);

/// Of the length or area.
dealii::Point<1> centroid(const Region<1> &region);
dealii::Point<2> centroid(const Region<2> &region);

/// The region of these corners in either orientation.
Region<1> oriented(Region<1> corners);
Region<2> oriented(Region<2> corners);

/// The part of @p subject inside the convex @p window (Sutherland and Hodgman, 1974).
Region<1> clip(const Region<1> &subject, const Region<1> &window);
Region<2> clip(const Region<2> &subject, const Region<2> &window);

/// The part of @p region outside the convex @p hole, in convex parts.
std::vector<Region<1>> subtract(const Region<1> &region, const Region<1> &hole);
std::vector<Region<2>> subtract(const Region<2> &region, const Region<2> &hole);

} // namespace dovetail
