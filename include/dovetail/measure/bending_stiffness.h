// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Bodies that are stiffer than they should be because their cells cannot bend.

#pragma once

#include <dovetail/scene/note.h>
#include <dovetail/system/model.h>

namespace dovetail {

/// The share of the strain energy of a solid of degree 1 in which a discrete strain E and the continuous one
/// E*, which has at each vertex the mean of the cells around it, differ:
/// @f[ \int (E - E^*) : D : (E - E^*) \Big/ \int E : D : E, @f]
/// with the tangent D at rest and, of a law of large strain, the Green strain (Zienkiewicz and Zhu 1987). A
/// cell of degree 1 bends with a shear strain that grows along it and jumps to the next one: with s = G /
/// (lambda + 2 G) (l/h)^2 of cells of length l in a beam of height h this share is s / (1 + s), about how
/// much too small the displacement is. 0 in a uniform strain. Where a body becomes warm, its strain E_T
/// without stress would hide how it bends: E - E_T does not. Of the cells of this rank; collective.
struct StiffnessShare
{
  double jumping = 0, all = 0; ///< energies
  double across = 0;           ///< that of the stress across the plane of a body in plane strain at E_T
  double with_stress = 0;      ///< that of E - E_T
  double varying = 0;          ///< that of E_T less its mean in each cell
  double of_gradients = 0;     ///< that of a strain as large as its gradients and itself in a cell
};
template <int dim>
StiffnessShare stiffness_share(const Domain<dim> &domain, const Field &displacement, const Vector &solution,
                               double t, const MPI_Comm &communicator);

/// About solids of degree 1 in which this share is larger than largest_stiffness_share; about others whose
/// free expansion varies within cells so much that this makes as large a share of the energy of their stress:
/// the strain of a triangle or tetrahedron of degree 1 is constant, so a temperature that differs by dT
/// within it makes a stress of the order of E alpha dT, also in a body that expands freely. Collective; @p
/// solution is ghosted.
template <int dim>
NoteList explain_stiffness(const Model<dim> &model, const Vector &solution, double t);
constexpr double largest_stiffness_share = 0.15;

} // namespace dovetail
