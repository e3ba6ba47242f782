// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Sums of unknowns of this rank with weights that do not change.

#pragma once

#include <dovetail/system/vector.h>

#include <vector>

namespace dovetail {

/// y_k = sum_j w_kj x_j of unknowns that this rank sees, for many short sums.
class LinearSums
{
public:
  /// The next sum. The unknowns of sums that follow one another are kept once if they are the same.
  void add(const std::vector<dealii::types::global_dof_index> &dofs,
           const std::vector<double> &weights_of_sum);
  /// After the last one: find each unknown once.
  void close();
  unsigned int size() const { return places_of.size(); }
  /// @p ghosted has all unknowns. @pre close()
  void evaluate(const Vector &ghosted, std::vector<double> &sums) const;

private:
  std::vector<dealii::types::global_dof_index> unknowns; ///< after close() each once, ascending
  std::vector<unsigned int> places;                      ///< in the unknowns, of one list after the other
  std::vector<std::size_t> places_of, weights_of;        ///< where those of a sum begin
  std::vector<unsigned int> lengths;
  std::vector<double> weights;
  std::vector<dealii::types::global_dof_index> last_list;
  mutable std::vector<double> values;
};

} // namespace dovetail
