// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the laws of both sides remember at the points of an interface.

#pragma once

#include <dovetail/pairing/pairing.h>

#include <array>
#include <vector>

namespace dovetail {

/// The internal variables of the materials of both sides at the points of this rank; none of a side whose
/// material remembers nothing.
template <int dim>
class InterfaceMemory
{
public:
  /// For the points of a pairing. What was remembered at others before goes over, each time from the nearest
  /// point of any rank. Collective.
  void set_points(const Pairing<dim> &pairing, const std::array<InterfaceSide<dim>, 2> &sides,
                  const MPI_Comm &communicator);

  bool empty() const { return variables[source].empty() && variables[destination].empty(); }
  dealii::ArrayView<const double> accepted(const unsigned int side, const unsigned int q) const
  {
    return variables[side].accepted(q);
  }
  void set_trial(const unsigned int side, const unsigned int q, const dealii::ArrayView<double> &values)
  {
    variables[side].set_trial(q, values);
  }
  void accept();

  /// The accepted variables at a point, those of the source first.
  std::vector<double> pack(unsigned int q) const;
  void unpack(unsigned int q, const std::vector<double> &numbers);

private:
  void copy_from_nearest(unsigned int side, const InternalVariables &former,
                         const std::vector<dealii::Point<dim>> &former_points, const MPI_Comm &communicator);

  std::array<std::vector<dealii::Point<dim>>, 2> points;
  std::array<InternalVariables, 2> variables;
  bool has_points = false;
};

} // namespace dovetail
