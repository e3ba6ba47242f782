// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where something else lies on the boundary of a domain.

#pragma once

#include <deal.II/base/point.h>

#include <array>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace dovetail {

/// The part of a boundary that is tied: while that is active, boundary conditions on these fields act on the
/// rest only.
template <int dim>
struct Cover
{
  struct Face
  {
    double share = 0;                            ///< of its area that is covered
    std::vector<dealii::Point<dim>> unit_points; ///< a quadrature of that part, if it is not the whole
    std::vector<dealii::Tensor<1, dim>> N;       ///< outward normals there
    std::vector<double> JxW;
  };
  /// By active_cell_index and number of the face; owned cells only.
  using Faces = std::map<std::pair<unsigned int, unsigned int>, Face>;

  std::string interface; ///< its name
  bool is_permanent;     ///< no toggle switches it off
  std::function<bool(double t)> is_active;
  std::set<std::string> fields;
  Faces faces;
  /// Of owned and ghost cells: cell, face, space (CellLayout) and its node of the cell, where the face is
  /// covered all around the node.
  std::set<std::array<unsigned int, 4>> nodes;
};

} // namespace dovetail
