// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Laws that remember solutions.

#pragma once

#include <dovetail/domain/cell_terms.h>
#include <dovetail/system/model.h>

#include <memory>
#include <vector>

namespace dovetail {

/// Whether a material or a tie remembers solutions.
template <int dim>
bool has_to_remember(const Model<dim> &model);

/// Let all laws remember a solution of time @p t, whose unknowns @p values_of gives. Nothing is remembered,
/// and false returned on all ranks alike, if one is not defined there. Points of interfaces that are switched
/// off belong to their bodies still. Collective.
template <int dim>
bool remember(Model<dim> &model, const std::vector<std::unique_ptr<CellTerms<dim>>> &cell_terms, double t,
              const ValuesOf &values_of);

/// Whether a material has to look at the state before the first step.
template <int dim>
bool has_to_look_at_start(const Model<dim> &model);

/// Let these materials remember it, and choose their phases of that step.
template <int dim>
void look_at_start(Model<dim> &model, const std::vector<std::unique_ptr<CellTerms<dim>>> &cell_terms,
                   const ValuesOf &values_of);

} // namespace dovetail
