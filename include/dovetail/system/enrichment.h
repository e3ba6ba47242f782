// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A solution among functions of one degree more, for the dual problems of error estimates.

#pragma once

#include <dovetail/system/block_system.h>

#include <vector>

namespace dovetail {

/// The equations of a model with elements of degree p + 1 on the same meshes, their tangent at a solution of
/// degree p, transposed, and what leads from one space to the other. The ties are made anew from the scene:
/// penalties and multipliers are those of degree p + 1.
///
/// Lives while the meshes of the model stay as they are. All functions are collective.
template <int dim>
class Enrichment
{
public:
  /// At a static solution @p x of time @p t. @p coarse_model and @p coarse_system are kept by reference.
  Enrichment(const Model<dim> &coarse_model, const BlockSystem<dim> &coarse_system, double t,
             const Vector &x);

  /// Assemble K(x)^T. @return whether all laws are defined.
  bool assemble() { return fine_system.assemble(state, true); }

  const Model<dim> &model() const { return fine_model; }
  const BlockSystem<dim> &system() const { return fine_system; }
  const double t;
  /// The solution among the functions of degree p + 1, owned. It need not satisfy their constraints.
  const Vector &x() const { return state; }
  const Vector &ghosted_x() const { return ghosted_state; }
  /// What must be added to x to satisfy them.
  Vector distance_to_constraints();
  /// What holds constrained unknowns at x.
  NodalForces<dim> nodal_forces() { return fine_system.nodal_forces(state); }

  /// A function of degree p, owned, as one of degree p + 1.
  Vector raised(const Vector &coarse) const;
  /// The function of degree p that interpolates one of degree p + 1 and is zero where the coarse model
  /// prescribes values; ties by constraints hold.
  Vector lowered(const Vector &fine) const;

  /// C^T v: what acts on constrained unknowns goes to those they follow. Of the fine model.
  Vector condensed(const Vector &v) const;
  /// C z: constrained unknowns follow, or are zero.
  void distribute(Vector &z) const;

private:
  const Model<dim> &coarse_model;
  const BlockSystem<dim> &coarse_system;
  Model<dim> fine_model;
  BlockSystem<dim> fine_system;
  Vector state, ghosted_state;
};

} // namespace dovetail
