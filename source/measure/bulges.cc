// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/bulges.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dovetail {

namespace {

const double sharp = 65 * dealii::numbers::PI / 180, coarse = 2 * dealii::numbers::PI / 180;

/// The vertices beside one on a face.
std::vector<unsigned int> neighbours(const unsigned int n_vertices, const unsigned int v)
{
  if (n_vertices == 2)
    return {1 - v};
  if (n_vertices == 3)
    return {(v + 1) % 3, (v + 2) % 3};
  return {v ^ 1, v ^ 2}; // lexicographic
}

} // namespace

template <int dim>
Bulges<dim>::Bulges(const Domain<dim> &domain, const dealii::types::boundary_id id,
                    const SideFaces<dim> &side)
{
  for (const auto &face : side.faces) {
    const auto shape = face.cell->face(face.face_no);
    for (const unsigned int v : shape->vertex_indices())
      normals[shape->vertex_index(v)];
  }
  for (const auto &face : domain.boundary_faces())
    if (face.id == id) {
      const auto shape = face.cell->face(face.number);
      for (const unsigned int v : shape->vertex_indices())
        if (const auto found = normals.find(shape->vertex_index(v)); found != normals.end())
          found->second.push_back(weighted_normal(*face.cell, face.number, v));
    }
  for (unsigned int i = 0; i < side.faces.size(); ++i) {
    const auto &face = side.faces[i];
    const unsigned int n_vertices = face.cell->face(face.face_no)->n_vertices();
    OfFace bulges;
    double half_turn = 0;
    for (unsigned int v = 0; v < n_vertices; ++v)
      for (const unsigned int w : neighbours(n_vertices, v))
        if (v < w)
          if (const Bulge<dim> found = bulge(face, v, w); found.half_turn > 0) {
            half_turn = std::max(half_turn, found.half_turn);
            bulges.push_back(found);
          }
    if (half_turn > coarse / 2)
      of_face[i] = bulges;
  }
}

/// The share of a face in the normal at its vertex @p v.
template <int dim>
dealii::Tensor<1, dim> Bulges<dim>::weighted_normal(const dealii::CellAccessor<dim> &cell,
                                                    const unsigned int face_no, const unsigned int v)
{
  const auto shape = cell.face(face_no);
  const auto beside = neighbours(shape->n_vertices(), v);
  const dealii::Tensor<1, dim> first = shape->vertex(beside[0]) - shape->vertex(v);
  dealii::Tensor<1, dim> weighted;
  if constexpr (dim == 2)
    weighted = dealii::cross_product_2d(first) / first.norm_square();
  else {
    const dealii::Tensor<1, dim> second = shape->vertex(beside[1]) - shape->vertex(v);
    weighted = dealii::cross_product_3d(first, second) / (first.norm_square() * second.norm_square());
  }
  return weighted * (shape->center() - cell.center()) > 0 ? weighted : -weighted;
}

/// Of a face and those that it does not meet in a sharp corner; none if there is no other one.
template <int dim>
std::optional<dealii::Tensor<1, dim>> Bulges<dim>::normal(const typename SideFaces<dim>::Face &face,
                                                          const unsigned int v) const
{
  const dealii::Tensor<1, dim> own = weighted_normal(*face.cell, face.face_no, v);
  dealii::Tensor<1, dim> sum;
  unsigned int n = 0;
  for (const auto &one : normals.at(face.cell->face(face.face_no)->vertex_index(v)))
    if (one * own >= std::cos(sharp) * one.norm() * own.norm()) {
      sum += one;
      ++n;
    }
  if (n < 2)
    return {};
  return sum / sum.norm();
}

template <int dim>
Bulge<dim> Bulges<dim>::bulge(const typename SideFaces<dim>::Face &face, const unsigned int v,
                              const unsigned int w) const
{
  const auto shape = face.cell->face(face.face_no);
  const dealii::Tensor<1, dim> chord = shape->vertex(w) - shape->vertex(v), along = chord / chord.norm();
  const auto from = normal(face, v), to = normal(face, w);
  // sin(a/2), positive where the surface is convex
  const double first = from ? -(along * *from) : to ? along * *to : 0, second = to ? along * *to : first;
  const double sine = std::abs(first) < std::abs(second) ? first : second;
  Bulge<dim> result;
  if (!(first * second > 0))
    return result;
  dealii::Tensor<1, dim> outward;
  for (const auto &end : {from, to})
    if (end)
      outward += *end;
  outward -= (outward * along) * along;
  result.half_turn = std::abs(std::asin(sine));
  result.height = chord.norm() / 2 * std::tan(std::asin(sine) / 2) * outward / outward.norm();
  for (const unsigned int i : face.cell->vertex_indices())
    for (const unsigned int end : {0, 1})
      if (face.cell->vertex_index(i) == shape->vertex_index(end == 0 ? v : w))
        result.vertices[end] = i;
  return result;
}

template <int dim>
dealii::Tensor<1, dim> height_at(const dealii::Point<dim> &unit_point, const dealii::ReferenceCell &cell,
                                 const std::vector<Bulge<dim>> &bulges)
{
  dealii::Tensor<1, dim> height;
  for (const Bulge<dim> &bulge : bulges) {
    const double first = cell.d_linear_shape_function(unit_point, bulge.vertices[0]),
                 second = cell.d_linear_shape_function(unit_point, bulge.vertices[1]);
    const double decay = cell.is_simplex() ? 1 : first + second; // across a quadrilateral, which squares it
    if (decay > 0)
      height += 4 * first * second / decay * bulge.height;
  }
  return height;
}

template class Bulges<2>;
template class Bulges<3>;
template dealii::Tensor<1, 2> height_at(const dealii::Point<2> &, const dealii::ReferenceCell &,
                                        const std::vector<Bulge<2>> &);
template dealii::Tensor<1, 3> height_at(const dealii::Point<3> &, const dealii::ReferenceCell &,
                                        const std::vector<Bulge<3>> &);

} // namespace dovetail
