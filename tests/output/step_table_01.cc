// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The file of a table holds its rows after each step: they are added, and all are written anew where somebody
// has changed the file, has taken it away or where the columns are others.

#include <dovetail/output/step_table.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

#include <sys/stat.h>

using namespace dovetail;

namespace {

unsigned long number_of_file()
{
  struct stat status;
  return stat(StepTable::file, &status) == 0 ? status.st_ino : 0;
}

void add(StepTable &table, const double t, const std::vector<std::string> &probes)
{
  std::vector<Columns> columns;
  for (const std::string &probe : probes)
    columns.push_back({{probe}, 10 * t});
  table.add(t, columns, nlohmann::ordered_json::object(), "xyz",
            {"", [](const std::string &) { return ""; }});
}

/// Whether the file is the one from before, and what it holds.
void write(StepTable &table, const std::string &what)
{
  const unsigned long before = number_of_file();
  const Obstacle obstacle = table.write(StepTable::file);
  std::ostringstream text;
  text << std::ifstream(StepTable::file).rdbuf();
  std::cout << what << ": " << (before != 0 && before == number_of_file() ? "added" : "written") << ' '
            << obstacle.text << std::endl
            << text.str();
}

} // namespace

int main()
{
  StepTable table;
  add(table, 1, {"a"});
  write(table, "first");
  add(table, 2, {"a"});
  write(table, "second");
  write(table, "nothing new");
  std::ofstream(StepTable::file, std::ios::app) << "scribble";
  add(table, 3, {"a"});
  write(table, "changed by somebody");
  std::filesystem::remove(StepTable::file);
  add(table, 4, {"a"});
  write(table, "taken away");
  add(table, 5, {"b", "a"});
  write(table, "other columns");
  add(table, 6, {"b", "a"});
  write(table, "more");

  StepTable other;
  other.restore(table.save());
  add(other, 7, {"b", "a"});
  write(other, "a run that goes on");
}
