// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The pressure of a mixed formulation at an interface.

#pragma once

#include <dovetail/interface/interface.h>

#include <optional>

namespace dovetail {

/// The component of a side's pressure, if the flux A of a tied field has a part of it. The part is linear in
/// the pressure.
template <int dim>
std::optional<unsigned int> pressure_of_flux(const Interface<dim> &interface, const TiedField &tied,
                                             const unsigned int side)
{
  const Domain<dim> &domain = *interface.sides[side].domain;
  const auto &fields = domain.fields();
  for (unsigned int g = 0; g < fields.size() && tied.n_components > 1; ++g)
    if (fields[g].is_multiplier && domain.material.flux_depends(tied.field[side], g))
      return fields[g].first_component;
  return {};
}

} // namespace dovetail
