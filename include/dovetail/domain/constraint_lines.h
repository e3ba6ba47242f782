// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Linear constraints between unknowns, before they are closed.

#pragma once

#include <deal.II/base/types.h>

#include <map>
#include <utility>
#include <vector>

namespace dovetail {

/// B_dof = sum weight * B_other + inhomogeneity.
struct ConstraintLine
{
  std::vector<std::pair<dealii::types::global_dof_index, double>> entries;
  double inhomogeneity = 0;
  int tie = -1;                 ///< the position in the scene of the interface that made it, if one did
  bool is_of_condition = false; ///< a boundary condition made it

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &entries &inhomogeneity &tie &is_of_condition;
  }
};
using ConstraintLines = std::map<dealii::types::global_dof_index, ConstraintLine>;

} // namespace dovetail
