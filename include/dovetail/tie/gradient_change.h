// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How far an update of Newton's method moves the bodies at an interface.

#pragma once

#include <dovetail/interface/interface.h>

#include <array>
#include <vector>

namespace dovetail {

/// The change of grad B at the points of an interface from one state to the next, of the fields at large
/// strain only: of the order of the change of the strain.
template <int dim>
class GradientChange
{
public:
  /// Remember a state.
  void start(const Interface<dim> &interface, const ValuesOf &unknowns);
  /// The mean of |grad B - grad B of the state before| over the points, the larger of both sides' [-]; the
  /// state is remembered. Collective.
  double advance(const Interface<dim> &interface, const ValuesOf &unknowns, const MPI_Comm &communicator);

private:
  using Gradients = std::array<std::vector<dealii::Tensor<1, dim>>, 2>; ///< by side: point, field, component
  Gradients gradients_at(const Interface<dim> &interface, const ValuesOf &unknowns) const;

  Gradients last;
};

} // namespace dovetail
