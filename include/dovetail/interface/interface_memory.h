// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the laws of both sides, and that of a joint between them, remember at the points of an interface.

#pragma once

#include <dovetail/pairing/pairing.h>

#include <array>
#include <vector>

namespace dovetail {

/// The internal variables of the materials of both sides and of the tie at the points of this rank; none of a
/// side whose material remembers nothing, and of a tie that does not.
template <int dim>
class InterfaceMemory
{
public:
  static constexpr unsigned int joint = 2; ///< beside source and destination

  /// For the points of a pairing. What was remembered at others before goes over, each time from the nearest
  /// point of any rank. @param of_joint the numbers of the tie at a point before the first step. Collective.
  void set_points(const Pairing<dim> &pairing, const std::array<InterfaceSide<dim>, 2> &sides,
                  const std::vector<double> &of_joint, const MPI_Comm &communicator);

  bool empty() const { return variables[source].empty() && variables[destination].empty() && !has_joint(); }
  bool has_joint() const { return !variables[joint].empty(); }
  dealii::ArrayView<const double> accepted(const unsigned int side, const unsigned int q) const
  {
    return variables[side].accepted(q);
  }
  void set_trial(const unsigned int side, const unsigned int q, const dealii::ArrayView<double> &values)
  {
    variables[side].set_trial(q, values);
  }
  void keep_joint(unsigned int q); ///< its trial is what it remembers
  void accept();

  /// The accepted variables at a point: of the source, the destination and the joint.
  std::vector<double> pack(unsigned int q) const;
  void unpack(unsigned int q, const std::vector<double> &numbers);

private:
  void copy_from_nearest(unsigned int side, const InternalVariables &former,
                         const std::vector<dealii::Point<dim>> &former_points, const MPI_Comm &communicator);

  std::array<std::vector<dealii::Point<dim>>, 3> points;
  std::array<InternalVariables, 3> variables;
  bool has_points = false;
};

} // namespace dovetail
