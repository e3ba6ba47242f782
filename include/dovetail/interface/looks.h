// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// On which fields of a side the terms of a tied scalar depend although they are not tied.

#pragma once

#include <dovetail/domain/domain.h>
#include <dovetail/interface/tie.h>

namespace dovetail {

/// Whether a tie looks at a field of a side (by number), or at one whose flux depends on it.
template <int dim>
bool looks_at(const Tie<dim> &tie, const Domain<dim> &side, const unsigned int field)
{
  for (unsigned int g = 0; g < side.fields().size(); ++g)
    if (tie.looks_at(side.fields()[g]) && side.material.flux_depends(g, field))
      return true;
  return false;
}

} // namespace dovetail
