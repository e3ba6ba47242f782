// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/step_table.h>

#include <deal.II/base/exceptions.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

namespace dovetail {

namespace {

using nlohmann::ordered_json;

void add_columns(const std::string &name, const ordered_json &value, const std::string &axes,
                 const std::string &unit, std::vector<std::string> &names, std::vector<std::string> &texts)
{
  const std::string before = name.empty() ? "" : name + " ";
  if (value.is_object())
    for (const auto &[key, part] : value.items())
      add_columns(before + key, part, axes, unit, names, texts);
  else if (value.is_array())
    for (std::size_t i = 0; i < value.size(); ++i)
      add_columns(before + (value.size() <= 3 ? std::string(1, axes[i]) : std::to_string(i)), value[i], axes,
                  unit, names, texts);
  else {
    names.push_back(name + unit);
    texts.push_back(value.is_number() && std::isfinite(value.get<double>()) ? value.dump() : "");
  }
}

} // namespace

void StepTable::add(const double time, const std::vector<Columns> &columns, const ordered_json &balance,
                    const std::string &axes, const UnitsOfColumns &units)
{
  std::vector<std::string> names = {first_word + units.time}, texts = {ordered_json(time).dump()};
  for (const Columns &given : columns) {
    const std::size_t first = names.size();
    add_columns("", given.numbers, axes, "", names, texts);
    AssertDimension(names.size() - first, given.names.size());
    std::copy(given.names.begin(), given.names.end(), names.begin() + first);
  }
  for (const auto &[domain, fields] : balance.items())
    for (const auto &[field, numbers] : fields.items())
      add_columns("balance " + domain + " " + field, numbers, axes, units.flux(field), names, texts);
  const auto line = [](const std::vector<std::string> &cells) {
    std::string result;
    for (const std::string &cell : cells)
      result += (result.empty() ? "" : ",") + cell;
    return result + "\n";
  };
  set_header(line(names));
  rows += line(texts);
}

void StepTable::restore(const ordered_json &saved)
{
  header = saved["header"];
  rows = saved["rows"];
  n_kept = 0;
}

/// Earlier rows get its columns: what they do not have stays empty.
void StepTable::set_header(const std::string &line)
{
  if (line == header)
    return;
  const auto cells_of = [](std::string text) {
    text.pop_back(); // the end of the line
    std::vector<std::string> cells(1);
    for (const char c : text)
      if (c == ',')
        cells.emplace_back();
      else
        cells.back() += c;
    return cells;
  };
  std::istringstream earlier(rows);
  const std::vector<std::string> names = cells_of(line),
                                 old_names = header.empty() ? names : cells_of(header);
  header = line;
  rows.clear();
  n_kept = 0;
  for (std::string row; std::getline(earlier, row);) {
    const std::vector<std::string> cells = cells_of(row + "\n");
    for (const std::string &name : names) {
      rows += &name == &names[0] ? "" : ",";
      const auto place = std::find(old_names.begin(), old_names.end(), name) - old_names.begin();
      rows += place < static_cast<std::ptrdiff_t>(cells.size()) ? cells[place] : std::string();
    }
    rows += '\n';
  }
}

Obstacle StepTable::write(const std::string &name)
{
  const bool is_added = n_kept > 0 && append_to_file(name, header.size() + n_kept, rows.substr(n_kept));
  const Obstacle obstacle =
      is_added ? Obstacle() : write_file(name, first_word, header + rows, OnDisk::later);
  n_kept = obstacle ? 0 : rows.size();
  return obstacle;
}

} // namespace dovetail
