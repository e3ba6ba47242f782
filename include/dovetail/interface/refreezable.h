// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A tie that freezes something at the beginning of a step.

#pragma once

#include <dovetail/interface/interface.h>

namespace dovetail {

/// What Tie::begin_step() freezes may not fit the state at the end of the step any more. A tie to which that
/// can happen is also a Refreezable.
template <int dim>
class Refreezable
{
public:
  virtual ~Refreezable() = default;

  /// After a step has converged at time @p t: if what is frozen fits the solution no more, freeze it anew.
  /// Collective. @return whether it did, on all ranks alike: then the step must be solved on.
  virtual bool refreeze(const Interface<dim> &interface, double t,
                        const typename Tie<dim>::Unknowns &unknowns, const MPI_Comm &communicator) = 0;
};

} // namespace dovetail
