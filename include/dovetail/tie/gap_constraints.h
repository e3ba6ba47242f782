// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Constraints of destination unknowns whose own gradient bridges a gap.

#pragma once

#include <dovetail/interface/tie.h>
#include <dovetail/pairing/exchange.h>

#include <map>

namespace dovetail {

/// What an unknown of the destination is set to, sum_k weight_k B_k + offset.
struct GapLine
{
  std::map<dealii::types::global_dof_index, double> from_source, from_destination;
  double offset = 0; ///< by a prescribed jump

  void add(double factor, const GapLine &other);
  ConstraintLine as_constraint() const;
  double source_weight() const;      ///< the share of its force that goes to the source
  double destination_weight() const; ///< and to other unknowns of the destination
};

/// An unknown B_i that follows the source. `first` is its line if the source's gradient bridges the whole
/// gap, and then the destination's unknowns in it do not follow the source. `wanted` has the destination's
/// gradient (own_share_of_gap), which is that of B_i and other constrained: B_i = sum_k weight_k B_k with i
/// among the k.
struct Follower
{
  GapLine first, wanted;
};

/// Lines without constrained. To solve the equations `wanted` of all constrained together would couple the
/// whole interface; each is solved for its own unknown with the lines before in place of the other
/// constrained, twice, from `first` on (Jacobi). As all lines are exact for affine fields, so is every sweep,
/// and what remains of the source's gradient falls by gap/(cell size) in each. Where the followers' weights
/// are larger than 1/2 in sum (cells thinner than the gap), the equation is mixed with `first`, as much as
/// that takes.
///
/// A line keeps `first` if an unknown of the destination in it is led by another tie: two interfaces of a
/// thin body must not lead each other in a circle. Collective. @p constrained: those that this rank owns, by
/// unknown.
template <int dim>
std::map<dealii::types::global_dof_index, GapLine>
gap_constraints(const std::map<dealii::types::global_dof_index, GapConstraint> &constrained,
                const Domain<dim> &destination, const TieConstraints &constraints,
                const MPI_Comm &communicator, InterfaceWork &work);

} // namespace dovetail
