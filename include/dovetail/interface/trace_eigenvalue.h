// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How much larger than its energy the flux of a cell can be on its tied faces.

#pragma once

#include <dovetail/interface/interface.h>

#include <array>
#include <vector>

namespace dovetail {

/// For a tied field and each cell behind the points of an interface (Pairing::cells, both sides), the largest
/// eigenvalue lambda of
/// @f[ \sum_q w_q\, |A(v)\cdot N|^2(x_q) = \lambda \int_K A(\nabla v):\nabla v \,dV @f]
/// with A linearised at the current state, over all functions v of the cell but those without energy
/// (constants; rigid motions about the current position). The sum runs over all points of the interface
/// behind which the cell lies, so over all its faces that are tied by it, with the weights of the assembly.
/// lambda has the unit of A/B. A cell with faces of n interfaces gets n times that, which bounds the
/// eigenvalue of all of them together. Where the tangent is not positive on the cell, the value is that of
/// the state in which all unknowns are zero; NaN if that is not positive, either.
///
/// The surface terms are sent to the rank that owns the cell; the eigenvalue comes back. Collective.
template <int dim>
std::array<std::vector<double>, 2> trace_eigenvalues(const Interface<dim> &interface, const TiedField &field,
                                                     double t, const typename Tie<dim>::Unknowns &unknowns,
                                                     const MPI_Comm &communicator);

/// The largest lambda of M x = lambda K x outside the kernel of K, which the columns of @p kernel span; K and
/// M are symmetric, M is not negative. NaN if K is not positive outside the kernel.
double largest_eigenvalue(const dealii::FullMatrix<double> &M, const dealii::FullMatrix<double> &K,
                          const std::vector<std::vector<double>> &kernel);

} // namespace dovetail
