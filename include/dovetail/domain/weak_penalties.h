// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Penalties of values that are prescribed by Nitsche's method.

#pragma once

#include <deal.II/base/types.h>

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace dovetail {

template <int dim>
class Domain;

/// gamma by field and active_cell_index of an owned cell.
using WeakPenalties = std::map<std::pair<std::string, unsigned int>, double>;

/// Set Domain::weak_penalties for all owned cells with faces on which a condition prescribes values weakly: a
/// lambda (CellEigenvalues) at the unknowns that @p unknowns gives, where coercivity asks for a > 1. If a law
/// is not defined there, at those that are zero.
template <int dim>
void freeze_weak_penalties(Domain<dim> &domain, double t,
                           const std::function<void(const std::vector<dealii::types::global_dof_index> &,
                                                    std::vector<double> &)> &unknowns);

} // namespace dovetail
