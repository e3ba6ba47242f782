// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The pressure of a mixed formulation at a boundary or an interface.

#pragma once

#include <dovetail/domain/domain.h>

#include <optional>

namespace dovetail {

/// The component of a domain's pressure, if the flux A of a field has a part of it. The part is linear in the
/// pressure.
template <int dim>
std::optional<unsigned int> pressure_of_flux(const Domain<dim> &domain, const unsigned int field)
{
  const auto &fields = domain.fields();
  for (unsigned int g = 0; g < fields.size() && fields[field].n_components > 1; ++g)
    if (fields[g].is_multiplier && domain.material.flux_depends(field, g))
      return fields[g].first_component;
  return {};
}

} // namespace dovetail
