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
  struct End
  {
    double ratio = 0;     ///< of the length of a cell to that of this one; 0: there is none
    double stiffness = 0; ///< of a support, by the end's entry of K_k
  };
  typedef std::array<End, 2> Line;
  static constexpr double stiffness_of_held = 1e4;

  virtual ~CellSolves() = default;

  /// @p a: by direction, then m.
  virtual void set(unsigned int slot, unsigned int component, const std::vector<Line> &lines,
                   const std::vector<double> &a) = 0;

  /// z += the sum of the cells' B^-1 r
  virtual void add_solutions(const double *r, double *z) const = 0;

  /// Entries of the diagonals of K_k and M_k, without what the ends add.
  double stiffness_of_end() const { return stiffness[0]; }
  double mass_of(unsigned int node) const { return mass[node * (n + 1)]; }

protected:
  struct Pairs
  {
    std::vector<double> vectors, values; ///< [mode][node], with mass one
  };

  explicit CellSolves(unsigned int degree);
  const Pairs &pairs_of(const Line &line);

  const unsigned int n;

private:
  std::vector<double> stiffness, mass; ///< of a line of length one
  std::map<std::array<int, 4>, Pairs> known;
};

/// In double or in single precision.
template <typename Number>
class CellSolvesIn : public CellSolves
{
public:
  /// @p index: [batch][component][lexicographic node][lane], by reference
  CellSolvesIn(unsigned int dim, unsigned int n_components, unsigned int degree,
               std::shared_ptr<const std::vector<int>> index);

  void set(unsigned int slot, unsigned int component, const std::vector<Line> &lines,
           const std::vector<double> &a) override;
  void add_solutions(const double *r, double *z) const override;

private:
  const unsigned int dim, n_components, n_nodes;
  std::shared_ptr<const std::vector<int>> index;
  // [batch][component][direction]: vectors [mode][node], values [mode] times a; then m
  std::size_t size_of_component;
  std::vector<LanesOf<Number>> all;
};

} // namespace dovetail
