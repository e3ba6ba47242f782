// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// deal.II's patterns in words that fit both a table and "Theta must be …".

#pragma once

#include <deal.II/base/patterns.h>

#include <string>
#include <vector>

namespace dovetail {

/// For instance "a number ≥ 0", "one of a, b", "a list of integers".
std::string readable_range(const dealii::Patterns::PatternBase &pattern);

/// The words among which a Selection selects; none for other patterns.
std::vector<std::string> choices_of(const dealii::Patterns::PatternBase &pattern);

} // namespace dovetail
