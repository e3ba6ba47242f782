// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a tie gives to the bodies it ties.

#pragma once

#include <deal.II/base/types.h>

#include <array>
#include <utility>
#include <vector>

namespace dovetail {

/// What a tie gives its sides somewhere: the influx into a component of a field of each.
struct Transmission
{
  unsigned int field, component; ///< among Interface::fields, and of that field
  std::array<double, 2> influx;
};

/// An unknown of the destination that would follow the source if it were not prescribed, and the source's
/// traces at the same place.
struct HeldUnknown
{
  dealii::types::global_dof_index dof;
  unsigned int field, component;
  std::vector<std::pair<dealii::types::global_dof_index, double>> source;
};

} // namespace dovetail
