// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The formulas of a domain that are the same whatever is solved.

#pragma once

#include <dovetail/domain/domain.h>

namespace dovetail {

/// Whether sources (at the time of the first step), first guess and exact solution (at the last time) are
/// finite numbers at the points of the owned cells where they are needed. If not, the reason is left.
template <int dim>
bool has_finite_formulas(const Domain<dim> &domain, double first_time, double last_time);

} // namespace dovetail
