// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A picture of a run, from a report of two steps and a table of two probes, one with components and a gap:
// the data that gnuplot gets, the units on the axes, and that it draws them. A probe with a single row, or
// none, is not drawn. What is no report is an error.

#include <dovetail/scene/user_error.h>
#include <dovetail/study/run_picture.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

using namespace dovetail;

namespace {

void write(const std::string &file, const std::string &text)
{
  std::ofstream(file) << text;
}

/// The lines between "$name << END" and END.
void print_data(const std::string &script, const std::string &name)
{
  std::ifstream in(script);
  bool is_inside = false;
  for (std::string line; std::getline(in, line);) {
    is_inside = is_inside ? line != "END" : line.rfind("$" + name + " ", 0) == 0;
    if (is_inside)
      std::cout << line << '\n';
  }
}

/// Of the axes of probes.
void print_labels(const std::string &script)
{
  std::ifstream in(script);
  for (std::string line; std::getline(in, line);)
    if (line.rfind("set xlabel 't", 0) == 0 || line.rfind("set ylabel '[", 0) == 0)
      std::cout << line << '\n';
}

void print_beginning(const std::string &file)
{
  std::ifstream in(file, std::ios::binary);
  std::string beginning(5, ' ');
  in.read(&beginning[0], 5);
  std::cout << file << ": "
            << (beginning == "<?xml" || beginning.substr(1, 3) == "PNG" ? "drawn" : "not drawn") << '\n';
}

void try_to_draw(const std::string &directory)
{
  try {
    draw_run(directory, std::cout);
  } catch (const UserError &error) {
    std::cout << error.what() << '\n';
  }
}

} // namespace

int main()
{
  try_to_draw("nowhere");
  std::filesystem::create_directory("run");
  write("run/report.json", "[1, 2]");
  try_to_draw("run");
  for (const std::string text :
       {"not json", R"({"steps": [{}], "seconds": {}})", R"({"steps": [], "seconds": {"mesh": null}})"}) {
    write("run/report.json", text);
    try_to_draw("run");
  }
  write("run/report.json", R"({"steps": [{"residuals": [1, 1e-3, 0]}, {"residuals": [0.5, null]}],
                              "seconds": {"mesh": 0.25, "solve": 1.5, "total": 1.75},
                              "probes": {"force": [1, 2], "force at end": 7, "tip's": 3, "new": 4}})");
  try_to_draw("run");
  write("run/probes.csv",
        "time [s],force x [N],force y [N],force at end,tip's\n0.5,1,2,7,3\n1,1.5,,8,3.25\n");
  try_to_draw("run");
  for (const std::string name : {"residuals", "seconds", "probe_2", "probe_3", "probe_4"})
    print_data("run/run.gp", name);
  print_labels("run/run.gp");

  // A probe whose name ends in "at", beside an extreme; twelve panels, and no room for energies.
  std::string probes = R"("T": 1, "T at": 2, "v at": [3, 4])",
              names = "time,T,T at x,T at y,T at,v at x,v at y",
              rows[2] = {"0,1,0.5,0.25,2,3,4", "1,1.5,0.5,0.75,2.5,3.5,4.5"};
  for (const std::string i : {"1", "2", "3", "4", "5", "6", "7"}) {
    probes += ", \"p" + i + "\": 0";
    names += ",p" + i;
    for (std::string &row : rows)
      row += ",0";
  }
  write("run/report.json", R"({"steps": [{"residuals": [1, 1e-3]}], "seconds": {"mesh": 0.25, "total": 0.25},
                              "probes": {)" +
                               probes + R"(}, "places of extremes": {"T": [0.5, 0.75]}})");
  write("run/probes.csv", names + ",energy kinetic\n" + rows[0] + ",1\n" + rows[1] + ",2\n");
  try_to_draw("run");
  for (const std::string name : {"probe_2", "probe_3", "probe_4"})
    print_data("run/run.gp", name);
  print_beginning("run/run.svg");
  print_beginning("run/run.png");
}
