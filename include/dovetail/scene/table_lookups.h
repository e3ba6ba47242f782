// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where formulas look up scalars in tables, and how far these reach.

#pragma once

#include <string>
#include <vector>

namespace dovetail {

/// An entry that looks up scalars in tables.
struct FormulaWithTables
{
  std::string path, entry; ///< section and name
  std::vector<std::string> scalars;
  std::string text; ///< with the pairs of tables from files
};

/// One table, asked while a scalar runs between two values.
struct TableLookup
{
  double first, last;       ///< arguments that the table has
  double smallest, largest; ///< those with which it is asked
};

/// Of the tables whose argument is a monotone formula of one of the scalars alone.
std::vector<TableLookup> lookups_in(const FormulaWithTables &formula, unsigned int scalar, double from,
                                    double to);

} // namespace dovetail
