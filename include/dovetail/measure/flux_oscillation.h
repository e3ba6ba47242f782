// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How much an error on an interface alternates from face to face.

#pragma once

#include <dovetail/interface/interface.h>

#include <array>
#include <map>
#include <utility>
#include <vector>

namespace dovetail {

/// The oscillation of errors e(X) on an interface: with the means e_f over the faces f of the finer side (the
/// one with more faces; the source if they have equally many), their covered areas |f| and the faces g that
/// share a whole edge with f (in 2D: a corner),
/// @f[ o^2 = \frac14 \sum_f |f| \,\Big| e_f - \frac{\sum_g |g| e_g}{\sum_g |g|} \Big|^2 @f]
/// A checkerboard +a, -a has o = a |Gamma|^(1/2), its L2 norm; an error that varies affinely over equal faces
/// has only the share of the faces at the rim, and a smooth one falls with the size of the faces.
template <int dim>
class FluxOscillation
{
public:
  explicit FluxOscillation(const Interface<dim> &interface);

  /// The error of a field, component by component, at a point of this rank.
  void add(unsigned int field, unsigned int q, const std::vector<double> &error);

  /// o of each field, on all ranks. Collective.
  std::vector<double> evaluate(const MPI_Comm &communicator) const;

private:
  using Key = std::pair<unsigned int, unsigned int>; ///< rank that owns a face, its number there

  /// The covered area, then the integrals of the errors, field by field and component by component.
  using Sums = std::vector<double>;

  /// Of one side on the first rank: the sums of each covered face, and the middles of its edges.
  struct Faces
  {
    std::vector<Sums> sums;
    std::vector<std::vector<dealii::Point<dim>>> edges;
  };
  Faces gather(unsigned int side, const MPI_Comm &communicator) const;
  static std::vector<std::vector<unsigned int>> neighbours(const Faces &faces);
  std::vector<double> oscillations(const Faces &faces) const;

  const Interface<dim> &interface;
  std::vector<unsigned int> group_of_point;
  std::vector<unsigned int> first; ///< of each field among the sums
  std::array<std::map<Key, Sums>, 2> sums;
};

} // namespace dovetail
