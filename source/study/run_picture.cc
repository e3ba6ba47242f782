// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "gnuplot.h"

#include <dovetail/output/step_table.h>
#include <dovetail/scene/user_error.h>
#include <dovetail/study/run_picture.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <vector>

namespace dovetail {

namespace {

using nlohmann::ordered_json;

const unsigned int most_panels = 12;

struct Column
{
  std::string name, unit;          ///< of "tip x [mm]", with the brackets; perhaps empty
  std::vector<std::string> values; ///< as they are written, perhaps empty
};

std::vector<std::string> cells(const std::string &line)
{
  std::vector<std::string> result;
  std::istringstream rest(line);
  for (std::string cell; std::getline(rest, cell, ',');)
    result.push_back(cell);
  return result;
}

/// Of probes.csv; none if there is no such file.
std::vector<Column> read_columns(const std::string &file)
{
  std::vector<Column> columns;
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    const std::vector<std::string> row = cells(line);
    if (columns.empty())
      for (const std::string &name : row) {
        const auto bracket = name.empty() || name.back() != ']' ? std::string::npos : name.rfind(" [");
        columns.push_back(
            {name.substr(0, bracket), bracket == std::string::npos ? "" : name.substr(bracket + 1), {}});
      }
    else
      for (std::size_t c = 0; c < columns.size(); ++c)
        columns[c].values.push_back(c < row.size() ? row[c] : "");
  }
  return columns;
}

/// Whether all that is drawn is there.
bool is_report(const ordered_json &json)
{
  const auto has = [](const ordered_json &parent, const char *name, const auto &is_right) {
    return parent.is_object() && parent.contains(name) && is_right(parent[name]);
  };
  const auto is_list = [](const ordered_json &list) { return list.is_array(); };
  const auto are_steps = [&](const ordered_json &steps) {
    return steps.is_array() && std::all_of(steps.begin(), steps.end(), [&](const ordered_json &step) {
             return has(step, "residuals", is_list);
           });
  };
  const auto are_seconds = [](const ordered_json &seconds) {
    return seconds.is_object() && std::all_of(seconds.begin(), seconds.end(),
                                              [](const ordered_json &value) { return value.is_number(); });
  };
  return has(json, "steps", are_steps) && has(json, "seconds", are_seconds);
}

ordered_json read_report(const std::string &directory)
{
  const std::string file = directory + "/report.json";
  std::ifstream in(file);
  if (!in)
    throw UserError("--plot " + directory +
                    " finds no report.json there. Name the Directory of the Output "
                    "of a run that has ended.");
  const ordered_json report = ordered_json::parse(in, nullptr, false);
  const bool has_begun = report.is_object() && report.contains("seconds") && report["seconds"].is_object();
  if (has_begun && report["seconds"].empty())
    throw UserError("--plot " + directory + ": the run has not ended, " + file +
                    " tells nothing yet. Wait for its end.");
  if (!is_report(report))
    throw UserError("--plot " + directory + ": " + file + " is not the report of a run.");
  return report;
}

/// A panel of the picture, its data and what draws them.
struct Panel
{
  std::string title, data, settings, plot;
};

/// Residuals of zero, or that are no numbers, have no place on a logarithmic scale.
Panel draw_residuals(const ordered_json &steps)
{
  std::ostringstream data;
  data << "$residuals << END\n# iteration, largest residual of all fields and domains\n";
  unsigned int iteration = 0;
  for (const ordered_json &step : steps) {
    for (const ordered_json &residual : step["residuals"]) {
      const double value = residual.is_number() ? residual.get<double>() : 0;
      data << iteration++ << ' ' << (std::isfinite(value) && value > 0 ? number(value) : "NaN") << '\n';
    }
    data << '\n'; // the next step is a line of its own
  }
  data << "NaN NaN\nEND\n\n";
  const std::string name = steps.size() > 1 ? "Residual, all steps" : "Residual";
  return {
      name, data.str(),
      "set logscale y\nset format y '10^{%T}'\nset xlabel 'iteration'\nset ylabel 'of the forces at work'\n",
      "$residuals using 1:2 with linespoints pt 7 ps 0.6 lw 1.5 lc rgb '" + colour_of_curve(0) + "' notitle"};
}

Panel draw_seconds(const ordered_json &seconds)
{
  std::ostringstream data;
  data << "$seconds << END\n# phase, seconds\n";
  double total = 0;
  for (const auto &[phase, value] : seconds.items())
    if (phase != "total") {
      data << '"' << phase << "\" " << number(value.get<double>()) << '\n';
      total = std::max(total, value.get<double>());
    }
  data << "END\n\n";
  return {
      "Run time", data.str(),
      "set boxwidth 0.7\nset style fill solid 0.8 noborder\nset xtics rotate by 40 right\nset ylabel 's'\n"
      "set yrange [0:" +
          number(total > 0 ? 1.05 * total : 1) + "]\n",
      "$seconds using 0:2:xtic(1) with boxes lc rgb '" + colour_of_curve(2) + "' notitle"};
}

bool begins(const std::string &column, const std::string &name)
{
  return column == name || column.rfind(name + " ", 0) == 0;
}

/// The place of a minimum or maximum: "worst at x". @p places: by their names
bool is_of_place(const std::string &column, const ordered_json &places)
{
  const auto end = column.size();
  for (const auto &[extreme, place] : places.items())
    if (begins(column, extreme) && end >= extreme.size() + 5 && column.compare(end - 5, 4, " at ") == 0 &&
        std::string("xyzr").find(column[end - 1]) != std::string::npos)
      return true;
  return false;
}

ordered_json part_of(const ordered_json &report, const char *key)
{
  return report.contains(key) && report[key].is_object() ? report[key] : ordered_json::object();
}

/// Of a probe: those with its name, followed by that of a component, but not by the rest of another probe's,
/// nor places.
std::vector<const Column *> columns_of(const std::string &probe, const ordered_json &report,
                                       const std::vector<Column> &columns)
{
  const ordered_json probes = part_of(report, "probes"), places = part_of(report, "places of extremes");
  std::vector<const Column *> result;
  for (const Column &column : columns) {
    bool is_of_other = is_of_place(column.name, places) && column.name != probe;
    for (const auto &[other, value] : probes.items())
      is_of_other = is_of_other || (other.size() > probe.size() && begins(column.name, other));
    if (begins(column.name, probe) && !is_of_other)
      result.push_back(&column);
  }
  return result;
}

Panel draw_probe(const std::string &probe, const unsigned int place, const ordered_json &report,
                 const std::vector<Column> &columns)
{
  const auto components = columns_of(probe, report, columns);
  const std::string name = "$probe_" + std::to_string(place);
  std::ostringstream data, plot;
  data << name << " << END\n# time, then the components of " << probe << '\n';
  for (std::size_t row = 0; row < columns[0].values.size(); ++row) {
    data << columns[0].values[row];
    for (const Column *component : components)
      data << ' ' << (component->values[row].empty() ? "NaN" : component->values[row]);
    data << '\n';
  }
  data << "END\n\n";
  for (std::size_t c = 0; c < components.size(); ++c) {
    const std::string component =
        components[c]->name.substr(std::min(probe.size() + 1, components[c]->name.size()));
    plot << (c > 0 ? ", " : "") << name << " using 1:" << c + 2
         << " with linespoints pt 7 ps 0.4 lw 1.5 lc rgb '" << colour_of_curve(c) << "' "
         << (component.empty() ? "notitle" : "title " + quoted(component));
  }
  const std::string unit = components[0]->unit, unit_of_time = columns[0].unit;
  return {probe, data.str(),
          "set xlabel " + quoted(unit_of_time.empty() ? "t" : "t " + unit_of_time) + " noenhanced\n" +
              (unit.empty() ? "" : "set ylabel " + quoted(unit) + " noenhanced\n"),
          plot.str()};
}

void write_panel(std::ostream &out, const Panel &panel, const unsigned int column, const unsigned int row,
                 const double width, const double height)
{
  const double left = 90, right = 15, above = 45, below = 78, panel_width = 400, panel_height = 300;
  const double x = column * panel_width, y = height - (row + 1) * panel_height;
  out << "set lmargin at screen " << number((x + left) / width) << "\nset rmargin at screen "
      << number((x + panel_width - right) / width) << "\nset bmargin at screen "
      << number((y + below) / height) << "\nset tmargin at screen "
      << number((y + panel_height - above) / height) << "\nset title " << quoted(panel.title)
      << " noenhanced\nset key top left samplen 1.5 noenhanced\n"
      << panel.settings << "plot " << panel.plot
      << "\nunset logscale\nset format y '%g'\nunset xlabel\nunset ylabel\nset autoscale\nset xtics norotate "
         "autofreq\n\n";
}

std::string write_panels(const std::vector<Panel> &panels)
{
  const unsigned int n_columns = std::min<unsigned int>(3, panels.size()),
                     n_rows = (panels.size() + n_columns - 1) / n_columns;
  const double width = 400. * n_columns, height = 300. * n_rows;
  std::ostringstream out;
  for (const Panel &panel : panels)
    out << panel.data;
  begin_pictures(out, "run", width, height);
  for (unsigned int i = 0; i < panels.size(); ++i)
    write_panel(out, panels[i], i % n_columns, i / n_columns, width, height);
  end_pictures(out);
  return out.str();
}

} // namespace

void draw_run(const std::string &directory, std::ostream &out)
{
  const ordered_json report = read_report(directory);
  const std::vector<Column> columns = read_columns(directory + "/" + StepTable::file);
  std::vector<Panel> panels = {draw_residuals(report["steps"]), draw_seconds(report["seconds"])};
  std::vector<std::string> left_out;
  const ordered_json probes = part_of(report, "probes");
  const auto add_panel = [&](const std::string &name) {
    const bool is_history =
        !columns.empty() && columns[0].values.size() > 1 && !columns_of(name, report, columns).empty();
    if (is_history && panels.size() < most_panels)
      panels.push_back(draw_probe(name, panels.size(), report, columns));
    else
      left_out.push_back(name + (is_history ? " (no more room)" : " (no history)"));
  };
  for (const auto &[probe, value] : probes.items())
    add_panel(probe);
  if (const std::string energy = "energy";
      !probes.contains(energy) && !columns_of(energy, report, columns).empty())
    add_panel(energy);
  const std::string problem =
      draw_by_gnuplot(directory, "run", "How a run went", write_panels(panels), "try again.");
  if (!problem.empty())
    throw UserError(problem);
  out << directory << "/run.svg and run.png show";
  for (std::size_t i = 0; i < panels.size(); ++i)
    out << (i == 0 ? ": " : ", ") << panels[i].title;
  out << "\n";
  for (const std::string &probe : left_out)
    out << "not drawn: " << probe << "\n";
}

} // namespace dovetail
