// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Which unknowns of a cell count on one of its faces.

#pragma once

#include <deal.II/fe/fe.h>
#include <deal.II/lac/full_matrix.h>

#include <array>
#include <vector>

namespace dovetail {

template <int dim>
class Interface;

/// The unknowns of a group of points (Interface::group_dofs) from whose terms those of the others follow. On
/// a face of a quadrilateral or hexahedron the functions of the nodes on a line into the cell, other than the
/// node on the face, vanish, and their gradients are normal to it: at every point of the face
/// @f[ \nabla\varphi_k = \frac{l_k'}{l_1'} \nabla\varphi_1 @f]
/// with the derivatives at the face of the polynomials l along the line, also in curved cells. So the first
/// node inside leads the others. What depends on traces and gradients of u at the face depends on y = G u,
/// with 2 (p + 1)^(dim - 1) unknowns per component and side in place of (p + 1)^dim, where G adds the others
/// to their leaders with these factors; residual and tangent are G^T r and G^T T G.
struct LeadingUnknowns
{
  /// By side and component of Interface::components: the nodes that lead, and the number of the first one's
  /// unknown.
  std::array<std::vector<std::vector<unsigned int>>, 2> nodes;
  std::array<std::vector<unsigned int>, 2> first;
  std::array<unsigned int, 2> n_of_side = {{0, 0}};

  std::vector<unsigned int> leader; ///< of each unknown of the group
  std::vector<double> factor;       ///< likewise: l_k' / l_1', or 1

  unsigned int size() const { return n_of_side[0] + n_of_side[1]; }
  bool is_complete() const { return size() == leader.size(); } ///< all lead

  /// G^T r and G^T T G.
  void expand(const std::vector<double> &of_leaders, std::vector<double> &of_all) const;
  void expand(const dealii::FullMatrix<double> &of_leaders, dealii::FullMatrix<double> &of_all) const;
  /// |G^T T G| |x|, row by row.
  std::vector<double> sizes_of_products(const dealii::FullMatrix<double> &of_leaders,
                                        const std::vector<double> &x) const;
};

/// For points that lie on these faces of the two cells; invalid_unsigned_int: anywhere, all unknowns lead.
template <int dim>
LeadingUnknowns find_leading_unknowns(const Interface<dim> &interface,
                                      const std::array<unsigned int, 2> &faces);

/// The face of a cell on which all points of a group of a side lie, judged by the shape functions there;
/// invalid_unsigned_int if there is none, or no function there follows from another one.
template <int dim>
unsigned int face_of_group(const Interface<dim> &interface, unsigned int side, unsigned int begin,
                           unsigned int end);

} // namespace dovetail
