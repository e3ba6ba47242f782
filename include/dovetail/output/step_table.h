// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// probes.csv: numbers of one step after another.

#pragma once

#include <dovetail/output/new_file.h>

#include <nlohmann/json.hpp>

#include <functional>
#include <string>
#include <vector>

namespace dovetail {

/// Numbers of a row and what stands above each of them, "tip x [mm]".
struct Columns
{
  std::vector<std::string> names;
  nlohmann::ordered_json numbers; ///< one, or lists of as many as there are names
};

/// What stands behind a name: " [mm]", or nothing if no units are given.
struct UnitsOfColumns
{
  std::string time;
  std::function<std::string(const std::string &field)> flux; ///< of the fields of a balance
};

/// One row per step: the time, the columns that are given, and the numbers of the balance as in the report.
/// These are called by that word, by the keys that lead to the number and by an axis or the index in a list.
class StepTable
{
public:
  /// Of each step the same numbers. @p axes: the letters of three directions, xyz
  void add(double time, const std::vector<Columns> &columns, const nlohmann::ordered_json &balance,
           const std::string &axes, const UnitsOfColumns &units);

  bool is_empty() const { return rows.empty(); }
  /// What has come since the last time is added to the file; where this is not as it was left, all is written
  /// anew. On the disk later.
  Obstacle write(const std::string &name);
  static constexpr const char *first_word = "time", *file = "probes.csv";

  /// For a run that goes on. Its columns may be others.
  nlohmann::ordered_json save() const { return {{"header", header}, {"rows", rows}}; }
  void restore(const nlohmann::ordered_json &saved);

private:
  void set_header(const std::string &line);

  std::string header, rows;
  std::size_t n_kept = 0; ///< letters of rows in the file; 0 if it has another header
};

} // namespace dovetail
