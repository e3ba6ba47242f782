// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What flows into a body through the parts of its boundary.

#pragma once

#include <dovetail/measure/trace_shares.h>
#include <dovetail/system/nodal_forces.h>

#include <array>
#include <map>
#include <set>
#include <vector>

namespace dovetail {

/// Resultants of the flux A.N (N outward: heat that leaves is negative) over boundaries and interfaces of a
/// solution, all of them algebraic: what conditions and ties put into the equations of the body. For each
/// body and field they add up, with the sources, to zero as exactly as the equations have been solved.
template <int dim>
class Reactions
{
public:
  /// @p solution is ghosted; the ties' multipliers are those of the solution. Collective. Model and solution
  /// are kept by reference.
  Reactions(const Model<dim> &model, const NodalForces<dim> &forces, const Vector &solution);

  /// A component of the part of a resultant that prescribed unknowns have, as a function of the solution B:
  /// R(B)(w) with the residual before constraints, and where other prescribed faces meet the boundary, with
  /// the shares s of the nodes there, int A.N g_0 dA over the prescribed faces with these ids and int A.N g_1
  /// dA over the others; g_0 = 1 - s and g_1 = -s at these nodes, and zero at all others (TraceShares).
  struct Lift
  {
    Vector w; ///< owned, as the others
    std::array<Vector, 2> g;
  };
  /// Collective.
  Lift lift(const Domain<dim> &domain, const std::set<dealii::types::boundary_id> &ids, const Field &field,
            unsigned int component) const;

  /// The resultant over all faces of a domain with these ids, by component: influxes given there, reactions
  /// of prescribed unknowns and what interfaces transmit there. Collective.
  std::vector<double> resultant(const Domain<dim> &domain, const std::set<dealii::types::boundary_id> &ids,
                                const Field &field) const;

  /// What each side of an interface gets, by component; zero while the interface is inactive.
  const std::array<std::vector<double>, 2> &interface_resultants(const Interface<dim> &interface,
                                                                 const unsigned int field) const
  {
    return resultants.at(&interface)[field];
  }
  /// The same by places of this rank.
  const std::vector<Transmission> &transmissions(const Interface<dim> &interface) const
  {
    return all_transmissions.at(&interface);
  }

  /// What a boundary condition that constrains an unknown puts into the body there.
  struct ForceAtNode
  {
    unsigned int component = 0; ///< of the field
    double force = 0;
  };
  /// By unknown that this rank owns. Where a plane that is not parallel to the axes holds the body, the
  /// unknown that its line B_k = sum_i w_i B_i + b constrains has the force r_k, and each other one -w_i r_k:
  /// none of them does work on a motion that the line allows.
  std::map<dealii::types::global_dof_index, ForceAtNode> at_nodes(const Domain<dim> &domain,
                                                                  const Field &field) const;
  const NodalForces<dim> &forces() const { return nodal; }

private:
  void share_with_held(const Interface<dim> &interface, const std::vector<HeldUnknown> &all_held);
  void add_up(const Interface<dim> &interface);
  void add_prescribed(const Domain<dim> &domain, const std::set<dealii::types::boundary_id> &ids,
                      const Field &field, std::vector<double> &sum) const;
  void add_given(const Domain<dim> &domain, const std::set<dealii::types::boundary_id> &ids,
                 const Field &field, std::vector<double> &sum) const;
  TraceShares<dim> shares_of(const Domain<dim> &domain, const std::set<dealii::types::boundary_id> &ids,
                             const Field &field) const;
  std::map<dealii::types::global_dof_index, unsigned int> components_at_nodes(const Domain<dim> &domain,
                                                                              const Field &field) const;
  std::vector<double> part_resultant(const Interface<dim> &interface, unsigned int field, unsigned int side,
                                     const std::set<dealii::types::boundary_id> &ids) const;

  const Model<dim> &model;
  NodalForces<dim> nodal; ///< with what walls and interfaces share
  const Vector &solution;
  std::map<const Interface<dim> *, std::vector<Transmission>> all_transmissions;
  std::map<const Interface<dim> *, std::vector<std::array<std::vector<double>, 2>>> resultants; ///< by field
};

} // namespace dovetail
