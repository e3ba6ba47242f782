// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How far the smooth surface for which coarse facets stand is from them.

#pragma once

#include <dovetail/domain/domain.h>
#include <dovetail/pairing/face_locator.h>

#include <array>
#include <map>
#include <optional>
#include <vector>

namespace dovetail {

/// Of an edge of a face (in 2D the face itself), in its middle.
template <int dim>
struct Bulge
{
  std::array<unsigned int, 2> vertices = {{0, 0}}; ///< of the cell
  dealii::Tensor<1, dim> height;
  double half_turn = 0; ///< of the normal from one end to the other [rad]

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &vertices[0] & vertices[1] & height &half_turn;
  }
};

/// Of the straight faces of one side, by their index in SideFaces::faces; a face that has none is missing.
///
/// The normal at a vertex is the mean of those of its faces with the weights of Max (1999), exact on circles
/// and spheres: @f$ n \sim \sum e_1 \times e_2 / (|e_1|^2 |e_2|^2) @f$ with the edges e of a face at the
/// vertex, in 2D the sum of the normals over the lengths. Of the faces, only those count which a face meets
/// at less than 65 degrees. An edge of the length l is the chord of an arc that turns by a, of the height @f$
/// (l/2) \tan(a/4) @f$. sin(a/2) is the smaller one of what the normals at both ends say: a plane face beside
/// a round one stays plane.
template <int dim>
class Bulges
{
public:
  using OfFace = std::vector<Bulge<dim>>;

  /// Of the faces of this rank of which an edge turns by more than 2 degrees.
  Bulges(const Domain<dim> &domain, dealii::types::boundary_id id, const SideFaces<dim> &side);

  std::map<unsigned int, OfFace> of_face;

private:
  static dealii::Tensor<1, dim> weighted_normal(const dealii::CellAccessor<dim> &cell, unsigned int face_no,
                                                unsigned int v);
  std::optional<dealii::Tensor<1, dim>> normal(const typename SideFaces<dim>::Face &face,
                                               unsigned int v) const;
  Bulge<dim> bulge(const typename SideFaces<dim>::Face &face, unsigned int v, unsigned int w) const;

  std::map<unsigned int, std::vector<dealii::Tensor<1, dim>>> normals; ///< of the faces at a vertex, weighted
};

/// At a point of a face, in the coordinates of the unit cell: exact for parabolas.
template <int dim>
dealii::Tensor<1, dim> height_at(const dealii::Point<dim> &unit_point, const dealii::ReferenceCell &cell,
                                 const std::vector<Bulge<dim>> &bulges);

} // namespace dovetail
