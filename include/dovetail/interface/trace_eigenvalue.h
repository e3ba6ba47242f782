// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How much larger than its energy the flux of a cell can be on its tied faces.

#pragma once

#include <dovetail/interface/interface.h>

#include <array>
#include <vector>

namespace dovetail {

/// Of the cells behind the points of an interface (Pairing::cells, both sides).
struct TraceEigenvalues
{
  /// Of the tangent, infinite where that is not positive on the cell: no penalty is large enough.
  std::array<std::vector<double>, 2> tangent_values;
  /// To choose weights and penalty by, finite: the same but for cells on which the tangent has lost its
  /// positivity or is about to (see cell_eigenvalues.cc), and larger by half the ratio of tied faces to what
  /// is covered of them, if that is above one. NaN only where a law is not defined.
  std::array<std::vector<double>, 2> penalty_values;
  bool is_defined = true; ///< all laws are at the current state, on all ranks
};

/// For a tied field and each cell behind the points of an interface the largest eigenvalue lambda of
/// @f[ \sum_q w_q\, |A(v)\cdot N|^2(x_q) = \lambda \int_K A(\nabla v):\nabla v \,dV @f]
/// with A linearised at the current state, over all functions v of the cell but those without energy
/// (constants; rigid motions about the current position). The sum runs over all points of the interface
/// behind which the cell lies, so over all its faces that are tied by it, with the weights of the assembly.
/// lambda has the unit of A/B. A cell with faces of n interfaces (weak conditions count as one)
/// gets n times that, which bounds the eigenvalue of all of them together. If a law is not defined at the
/// current state, penalty_values is that of the state in which all unknowns are zero.
///
/// The rank that owns a cell is told the points on its faces, and answers with the eigenvalues. Collective.
template <int dim>
TraceEigenvalues trace_eigenvalues(const Interface<dim> &interface, const TiedField &field, double t,
                                   const ValuesOf &unknowns, const MPI_Comm &communicator);

} // namespace dovetail
