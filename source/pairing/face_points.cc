// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/quadrature.h>
#include <dovetail/pairing/face_points.h>

#include <cmath>
#include <numeric>

namespace dovetail {

using namespace dealii;

template <int dim>
void FacePoints<dim>::add(const SideFaces<dim> &own, const unsigned int face, const SurfacePoint<dim> &point,
                          const double JxW)
{
  const FaceShape<dim> &shape = own.shape;
  const unsigned int face_no = own.faces[face].face_no;
  const Tensor<1, dim> normal = shape.normal(face_no, point);
  this->face.push_back(face);
  unit_points.push_back(shape.position_in_cell(face_no, point.xi));
  queries.push_back({point.X, normal / normal.norm(), own.faces[face].size});
  this->JxW.push_back(JxW);
}

namespace {

/// The shares of the unit interval that the points of a Gauss rule have: their weights, in order.
std::vector<std::array<double, 2>> shares(const unsigned int n)
{
  const QGauss<1> rule(n);
  std::vector<std::array<double, 2>> result;
  double begin = 0;
  for (unsigned int i = 0; i < n; ++i) {
    result.push_back({{begin, begin + rule.weight(i)}});
    begin += rule.weight(i);
  }
  return result;
}

/// The corners of the share that point q of a rule has of the reference face.
template <int dim>
std::vector<Point<dim - 1>> share_of(const FaceShape<dim> &shape, const Quadrature<dim - 1> &rule,
                                     const std::vector<std::array<double, 2>> &shares, const unsigned int q)
{
  std::vector<Point<dim - 1>> corners;
  if (shape.is_triangle())
    for (unsigned int v = 0; v < 3; ++v)
      corners.push_back(rule.point(q) + std::sqrt(2 * rule.weight(q)) * (shape.corner(v) - shape.centre()));
  else
    for (unsigned int v = 0; v < (1 << (dim - 1)); ++v) {
      Point<dim - 1> corner;
      for (unsigned int d = 0, i = q, u = v; d < dim - 1; ++d, i /= shares.size(), u /= 2)
        corner[d] = shares[i % shares.size()][u % 2];
      corners.push_back(corner);
    }
  return corners;
}

} // namespace

template <int dim>
FacePoints<dim> mapped_points(const SideFaces<dim> &own, const FaceLocator<dim> &partner,
                              const unsigned int n)
{
  FacePoints<dim> points;
  const auto rule = gauss_rule<dim - 1>(
      own.shape.is_triangle() ? ReferenceCells::Triangle : ReferenceCells::get_hypercube<dim - 1>(), n);
  const auto shares = dovetail::shares(n);
  for (unsigned int face = 0; face < own.faces.size(); ++face) {
    const Point<dim> *nodes = own.nodes(face);
    const unsigned int face_no = own.faces[face].face_no;
    for (unsigned int q = 0; q < rule.size(); ++q) {
      const SurfacePoint<dim> point = own.shape.evaluate(nodes, rule.point(q));
      typename FacePoints<dim>::Piece piece;
      piece.begin = points.size();
      piece.end = piece.begin + 1;
      piece.n_vertices = 0;
      for (const auto &corner : share_of(own.shape, rule, shares, q))
        piece.vertices[piece.n_vertices++] = own.shape.evaluate(nodes, corner).X;
      points.pieces.push_back(piece);
      points.add(own, face, point, rule.weight(q) * own.shape.normal(face_no, point).norm());
    }
  }
  points.matches = partner.locate(points.queries);
  return points;
}

template struct FacePoints<2>;
template struct FacePoints<3>;
template FacePoints<2> mapped_points(const SideFaces<2> &, const FaceLocator<2> &, unsigned int);
template FacePoints<3> mapped_points(const SideFaces<3> &, const FaceLocator<3> &, unsigned int);

} // namespace dovetail
