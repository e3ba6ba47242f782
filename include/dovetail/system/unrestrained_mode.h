// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What nothing holds: motions of bodies, or drifting temperatures, that change no energy.

#pragma once

#include <dovetail/solve/block_matrix.h>
#include <dovetail/system/model.h>

#include <deal.II/lac/affine_constraints.h>

#include <optional>
#include <string>

namespace dovetail {

/// Whether conditions and ties surely hold a field at time @p t without looking at any matrix, so that the
/// answer does not depend on stiffness and mesh. Bodies between which each motion is resisted move as one,
/// with the rigid motions z_k; these are held if the constraints i see each of them: P_kl = sum_i
/// z_k,i z_l,i is regular. Collective.
/// @param constraints in which prescribed unknowns have no entries
/// @param do_rates_hold bodies that store the field, as they resist all motions in time
template <int dim>
bool is_surely_held(const Model<dim> &model, const std::string &field, double t,
                    const dealii::AffineConstraints<double> &constraints, bool do_rates_hold);

/// A motion that nothing resists.
template <int dim>
struct UnrestrainedMode
{
  std::string field;
  std::vector<const Domain<dim> *> bodies; ///< that move
  std::string kind;                        ///< "a rotation"

  std::string in_words() const; ///< "the displacement of left, right against a rotation"
};

/// With z_i the constants, or the rigid motions, of the bodies that move as one (zero where @p constraints
/// prescribe), G_ij = z_i.K z_j and M_ij = z_i.|diag K| z_j, it is an eigenvector of G v = lambda M v whose
/// |lambda| is rounding. The motions are kept where they are not zero, on their own bodies. Collective.
/// @param tangent K, assembled on @p constraints
/// @return nothing if there is none
template <int dim>
std::optional<UnrestrainedMode<dim>>
find_unrestrained_mode(const Model<dim> &model, const std::string &field, double t,
                       const BlockMatrix &tangent, const dealii::AffineConstraints<double> &constraints);

} // namespace dovetail
