// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What nothing holds: motions of bodies, or drifting temperatures, that change no energy.

#pragma once

#include <dovetail/system/model.h>

#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/trilinos_block_sparse_matrix.h>

#include <optional>
#include <string>

namespace dovetail {

/// Whether conditions and ties surely hold a field at time @p t without looking at any matrix: each of its
/// bodies has a condition that acts on all components, or a tie that lets nothing come apart to such a body.
/// Conditions on some components hold a body against translation, but perhaps not against rotation.
template <int dim>
bool is_surely_held(const Model<dim> &model, const std::string &field, double t);

/// A motion that nothing resists.
template <int dim>
struct FreeMotion
{
  std::string field;
  std::vector<const Domain<dim> *> bodies; ///< that move
  std::string kind;                        ///< "a rotation"

  std::string in_words() const; ///< "the displacement of left, right against a rotation"
};

/// With z_i the constants, or the rigid motions, of each body (zero where @p constraints prescribe),
/// G_ij = z_i.K z_j and M_ij = z_i.|diag K| z_j, it is an eigenvector of G v = lambda M v whose |lambda| is
/// rounding. Collective.
/// @param tangent K, assembled on @p constraints
/// @return nothing if there is none
template <int dim>
std::optional<FreeMotion<dim>> find_free_motion(const Model<dim> &model, const std::string &field,
                                                const dealii::TrilinosWrappers::BlockSparseMatrix &tangent,
                                                const dealii::AffineConstraints<double> &constraints);

} // namespace dovetail
