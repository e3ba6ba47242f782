// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "tape.h"

#include <dovetail/scene/table_lookups.h>

#include <deal.II/base/utilities.h>

#include <algorithm>

namespace dovetail {

std::vector<TableLookup> lookups_in(const FormulaWithTables &formula, const unsigned int scalar,
                                    const double from, const double to)
{
  std::vector<std::string> names = {"x", "y", "z", "t"};
  const unsigned int variable = names.size() + scalar;
  names.insert(names.end(), formula.scalars.begin(), formula.scalars.end());
  Tape tape(names);
  for (const std::string &component : dealii::Utilities::split_string_list(formula.text, ';'))
    tape.add(component);
  std::vector<double> variables(names.size(), 0.);
  const auto argument = [&](const unsigned int of_table, const double value) {
    variables[variable] = value;
    return *tape.values(of_table, variables, 1);
  };
  std::vector<TableLookup> lookups;
  for (const Tape::Table &table : tape.tables_in(variable)) {
    const double one = argument(table.argument, from), other = argument(table.argument, to);
    lookups.push_back({table.first, table.last, std::min(one, other), std::max(one, other)});
  }
  return lookups;
}

} // namespace dovetail
