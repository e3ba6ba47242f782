// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The nodes of an element on each face of a cell. The element finds them by a search for each question, which
// is slow where every boundary face is asked in every step.

#pragma once

#include <deal.II/fe/fe.h>

#include <vector>

namespace dovetail {

/// In the order of the nodes, by the number of the face.
template <int dim>
std::vector<std::vector<unsigned int>> nodes_of_faces(const dealii::FiniteElement<dim> &element)
{
  std::vector<std::vector<unsigned int>> nodes(element.reference_cell().n_faces());
  for (unsigned int face = 0; face < nodes.size(); ++face)
    for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
      if (element.has_support_on_face(a, face))
        nodes[face].push_back(a);
  return nodes;
}

} // namespace dovetail
