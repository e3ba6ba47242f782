// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Updates of a scalar that is stored nonlinearly, as in melting.

#pragma once

#include <dovetail/material/material.h>

namespace dovetail {

/// Where Newton's method leads the value B of a node: not to B + d, but to the value B' at which what is
/// stored has grown by as much as it would with the capacity at B,
/// @f[ H(B') - H(B) = H'(B)\, d. @f]
/// That is Newton's method in the unknowns H(B_a). It steps neither over a peak of the capacity, as the
/// latent heat is, nor far out of one. Reference: Swaminathan & Voller, Int. J. Numer. Methods Heat Fluid
/// Flow 3 (1993), 233.
template <int dim>
class ContentUpdate
{
public:
  ContentUpdate(const Material<dim> &material, const unsigned int component);

  /// H is nonlinear, and one and the same function of B alone at all nodes.
  bool is_needed() const { return is_curved; }
  double after(double value, double change) const; ///< B' @pre is_needed()

private:
  double capacity(double value) const;
  double content(double value) const;

  const Material<dim> &material;
  const unsigned int component;
  bool is_curved;
  mutable State<dim> state;
  mutable Response<dim> response;
  mutable std::vector<double> memory;
};

} // namespace dovetail
