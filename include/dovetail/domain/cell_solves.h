// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Solves with an approximation of the tangent in the closure of each quadrilateral or hexahedron.

#pragma once

#include <dovetail/domain/sum_factorisation.h>

#include <array>
#include <map>
#include <memory>
#include <vector>

namespace dovetail {

/// In each cell, for each component,
/// @f[ B = a_1 K_1 \otimes M_2 \otimes M_3 + a_2 M_1 \otimes K_2 \otimes M_3 + \ldots + m\, M_1 \otimes M_2
/// \otimes M_3 @f]
/// with stiffness and mass of the cell's polynomials along a line, to which the ends add what they have in
/// the neighbours. With the eigenvectors of K_k by M_k, B is solved direction by direction (Lynch, Rice,
/// Thomas 1964).
class CellSolves
{
public:
  /// What is beyond an end of a line.
  enum class End { free, cell, held };
  struct Line
  {
    std::array<End, 2> ends;
    std::array<double, 2> ratios; ///< of cells beyond: length by that of this one
  };

  /// @p index: [batch][component][lexicographic node][lane], by reference
  CellSolves(unsigned int dim, unsigned int n_components, unsigned int degree,
             std::shared_ptr<const std::vector<int>> index);

  /// @p a: by direction, then m.
  void set(unsigned int slot, unsigned int component, const std::vector<Line> &lines,
           const std::vector<double> &a);

  /// z += the sum of the cells' B^-1 r
  void add_solutions(const double *r, double *z) const;

private:
  struct Pairs
  {
    std::vector<double> vectors, values; ///< [mode][node], with mass one
  };
  const Pairs &pairs_of(const Line &line);

  const unsigned int dim, n_components, n, n_nodes;
  std::shared_ptr<const std::vector<int>> index;
  std::vector<double> stiffness, mass; ///< of a line of length one
  std::map<std::array<int, 2>, Pairs> known;
  // [batch][component][direction]: vectors [mode][node], values [mode] times a; then m
  std::size_t size_of_component;
  std::vector<Lanes> all;
};

} // namespace dovetail
