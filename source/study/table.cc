// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <tuple>

namespace dovetail {

namespace {

std::string csv_text(const std::string &text)
{
  if (text.find_first_of(",\"\n\r") == std::string::npos)
    return text;
  std::string result = "\"";
  for (const char letter : text)
    result += letter == '"' ? "\"\"" : letter == '\n' || letter == '\r' ? " " : std::string(1, letter);
  return result + "\"";
}

std::string number_text(const double value, const char *format)
{
  if (!std::isfinite(value))
    return "";
  char text[40];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

/// The names of all reports; one that only some have stands after the one it follows there.
std::vector<std::string> number_columns(const std::vector<Numbers> &all)
{
  std::vector<std::string> columns;
  for (const Numbers &numbers : all) {
    auto place = columns.begin();
    for (const auto &[name, value] : numbers) {
      const auto found = std::find(columns.begin(), columns.end(), name);
      place = found != columns.end() ? found + 1 : columns.insert(place, name) + 1;
    }
  }
  return columns;
}

/// With the seconds of the whole process before those of its phases.
Numbers all_numbers(const StudyRun &run)
{
  Numbers numbers = run.report.is_object() ? numbers_of(run.report) : Numbers();
  const auto first_seconds = [&numbers]() {
    return std::find_if(numbers.begin(), numbers.end(),
                        [](const auto &number) { return number.first.rfind("seconds ", 0) == 0; });
  };
  if (run.report.is_object())
    numbers.emplace(first_seconds(), "seconds start-up", start_up_of(run));
  if (run.seconds > 0)
    numbers.emplace(first_seconds(), "seconds wall", run.seconds);
  return numbers;
}

using Row = std::vector<std::string>;

/// The first column to the left, numbers to the right.
std::string align(const std::vector<Row> &rows)
{
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const Row &row : rows)
    for (unsigned int c = 0; c < row.size(); ++c)
      widths[c] = std::max(widths[c], row[c].size());
  std::string text;
  for (const Row &row : rows) {
    std::string line;
    for (unsigned int c = 0; c < row.size(); ++c) {
      const std::string blanks(widths[c] - row[c].size(), ' ');
      line += "  " + (c == 0 ? row[c] + blanks : c + 1 == row.size() ? row[c] : blanks + row[c]);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string seconds_text(const StudyPoint &point)
{
  std::string text = number_text(point.seconds, "%.3g");
  if (point.slowest > point.fastest)
    text += " (" + number_text(point.fastest, "%.3g") + " to " + number_text(point.slowest, "%.3g") + ")";
  return text;
}

} // namespace

void write_csv(std::ostream &out, const std::vector<VariedEntries> &vary,
               const std::vector<Variant> &variants, const std::vector<StudyRun> &runs)
{
  std::vector<const StudyRun *> sorted;
  for (const StudyRun &run : runs)
    sorted.push_back(&run);
  std::stable_sort(sorted.begin(), sorted.end(), [](const StudyRun *a, const StudyRun *b) {
    return std::tie(a->variant, a->ranks, a->level, a->repeat) <
           std::tie(b->variant, b->ranks, b->level, b->repeat);
  });
  std::vector<Numbers> numbers;
  for (const StudyRun *run : sorted)
    numbers.push_back(all_numbers(*run));
  const std::vector<std::string> columns = number_columns(numbers);

  out << "variant";
  for (const VariedEntries &list : vary)
    for (const std::string &path : list.paths)
      out << ',' << csv_text(path);
  out << ",level,ranks,repeat,status,message";
  for (const std::string &column : columns)
    out << ',' << csv_text(column);
  out << '\n';

  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const StudyRun &run = *sorted[i];
    const Variant &variant = variants[run.variant];
    out << csv_text(variant.name);
    for (const VariedEntries &list : vary)
      for (const std::string &path : list.paths) {
        const auto entry = std::find_if(variant.entries.begin(), variant.entries.end(),
                                        [&](const auto &candidate) { return candidate.first == path; });
        out << ',' << (entry == variant.entries.end() ? "" : csv_text(entry->second));
      }
    out << ',' << run.level << ',' << run.ranks << ',' << run.repeat << ','
        << (run.is_done() ? run.status : "not done") << ',' << csv_text(run.message);
    for (const std::string &column : columns)
      out << ',' << number_text(find_number(numbers[i], column), "%.12g");
    out << '\n';
  }
}

std::string table_of(const std::vector<StudyCurve> &curves, const std::string &measure)
{
  std::vector<Row> rows = {{"variant", "level", "unknowns", "seconds", "tie %", "MiB", "Newton", "linear",
                            measure.empty() ? "error" : "error of " + measure, "rate", ""}};
  for (const StudyCurve &curve : curves) {
    const StudyPoint *coarser = nullptr;
    for (const StudyPoint &point : curve.points) {
      const auto number = [&](const std::string &name, const char *format) {
        return number_text(find_number(point.numbers, name), format);
      };
      Row row = {&point == &curve.points.front() ? curve.name : "",
                 std::to_string(point.level),
                 number("dofs", "%.0f"),
                 seconds_text(point),
                 number_text(100 * point.tie_share, "%.0f"),
                 number("peak memory MiB", "%.0f"),
                 number("newton iterations", "%.0f"),
                 number("linear iterations", "%.0f"),
                 point.is_converged() ? number_text(point.error, point.is_extrapolated ? "~%.3e" : "%.3e")
                                      : "",
                 "",
                 ""};
      if (!point.is_converged())
        row.back() = point.status;
      else {
        if (coarser != nullptr)
          row[9] = number_text(rate(coarser->error, point.error, point.level - coarser->level), "%.2f");
        coarser = &point;
      }
      rows.push_back(row);
    }
  }
  return align(rows);
}

} // namespace dovetail
