// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a run would begin with: sizes and masses of bodies, their boundaries, and what conditions act on.

#pragma once

#include <dovetail/system/model.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace dovetail {

template <int dim>
struct BodySize
{
  dealii::Point<dim> low, high; ///< of its box
  double volume = 0;            ///< with thickness, or around the axis
  std::map<dealii::types::boundary_id, double> areas;
};

/// Integrals over the undeformed body, by the mapping. Collective.
template <int dim>
BodySize<dim> measure_body(const Domain<dim> &domain, const MPI_Comm &communicator);

/// What a boundary condition acts on, over all ranks. Interfaces that are active take some of it over.
struct ActingOn
{
  unsigned long n_faces = 0;
  unsigned long n_prescribed = 0; ///< unknowns, if their values are
};

/// Collective.
template <int dim>
ActingOn find_what_it_acts_on(const Domain<dim> &domain, const Condition<dim> &condition,
                              const MPI_Comm &communicator);

} // namespace dovetail
