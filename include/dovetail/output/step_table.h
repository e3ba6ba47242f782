// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// probes.csv: numbers of one step after another.

#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace dovetail {

/// One row per step: the time, and the numbers of probes and balance as in the report. A column is called by
/// the keys that lead to its number, those of the balance after that word, and by x, y, z or the index in a
/// list.
class StepTable
{
public:
  /// Of each step the same numbers.
  void add(double time, const nlohmann::ordered_json &probes, const nlohmann::ordered_json &balance);

  bool is_empty() const { return rows.empty(); }
  std::string text() const { return header + rows; }
  static constexpr const char *first_word = "time";

private:
  std::string header, rows;
};

} // namespace dovetail
