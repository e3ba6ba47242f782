// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Motions that no condition resists, found from the geometry alone: nothing is assembled.

#pragma once

#include <dovetail/system/model.h>

#include <optional>
#include <string>
#include <vector>

namespace dovetail {

/// Motions of bodies that are tied to each other, which change no energy.
struct FreeMotion
{
  std::string field;
  std::vector<std::string> bodies;
  std::string kind; ///< "a translation along x and 1 rotation", "a constant"

  std::string in_words() const; ///< "the displacement of left, right against a translation along x"
};

/// With the constants or rigid motions z_k of bodies that ties hold together, and what conditions see of them
/// at the vertices of their faces, P_kl = sum_i z_k,i z_l,i: its null space. Values, springs and exchange
/// with a fluid resist a component, symmetry resists the normal one. Bodies that store a field are held by
/// its rate.
/// @param t with what is active then; nothing: with all of it. Collective. @pre The model is paired.
template <int dim>
std::vector<FreeMotion> find_free_motions(const Model<dim> &model, std::optional<double> t);

} // namespace dovetail
