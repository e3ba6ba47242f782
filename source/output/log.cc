// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/gaps.h>
#include <dovetail/output/log.h>
#include <dovetail/output/phases.h>
#include <dovetail/output/progress_bar.h>

#include <cmath>
#include <cstdio>
#include <iostream>
#include <sstream>

namespace dovetail {

namespace {

std::string to_text(const double value, const char *format = "%.4g")
{
  char text[40];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

/// A number, or components.
std::string to_text(const nlohmann::ordered_json &value)
{
  if (value.is_null())
    return "undefined";
  if (!value.is_array())
    return to_text(value.template get<double>(), "%.6g");
  std::string text;
  for (const auto &component : value)
    text += (text.empty() ? "" : "; ") + to_text(component);
  return text;
}

/// A duration that is easy to read: "0.5 s", "3 min 20 s", "2 h 5 min".
std::string in_seconds(const double seconds)
{
  const auto whole = static_cast<unsigned long>(std::min(1e9, std::max(0., seconds)) + 0.5);
  if (whole < 100)
    return to_text(seconds, seconds < 10 ? "%.2g s" : "%.0f s");
  if (whole < 6000)
    return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(whole / 3600) + " h " + std::to_string(whole % 3600 / 60) + " min";
}

nlohmann::ordered_json absolute(const nlohmann::ordered_json &value)
{
  if (value.is_null())
    return value;
  if (value.is_number())
    return std::abs(value.template get<double>());
  auto result = nlohmann::ordered_json::array();
  for (const auto &component : value)
    result.push_back(absolute(component));
  return result;
}

/// Of a probe, and where it is; the error is an estimate, if there is one.
std::string value_and_error(const nlohmann::ordered_json &report, const std::string &probe)
{
  std::string value = to_text(report["probes"][probe]);
  if (const auto places = report.find("places of extremes");
      places != report.end() && places->contains(probe) && (*places)[probe][0].is_number() &&
      std::isfinite((*places)[probe][0].get<double>()))
    value += " at " + to_text((*places)[probe]);
  const auto errors = report.find("probe errors");
  if (errors == report.end() || !errors->contains(probe))
    return value;
  return value + " +- " + to_text(absolute((*errors)[probe]));
}

template <int dim>
std::string to_text(const InterfaceSide<dim> &side)
{
  std::string ids;
  for (const auto id : side.boundary_ids)
    ids += (ids.empty() ? "" : ", ") + std::to_string(id);
  std::string materials;
  for (const auto id : side.material_ids)
    materials += (materials.empty() ? " (material " : ", ") + std::to_string(id);
  return side.domain->name + " : " + ids + materials + (materials.empty() ? "" : ")");
}

template <int dim>
std::vector<std::string> table_of_domains(const Model<dim> &model)
{
  std::vector<std::vector<std::string>> rows = {
      {"domain", "material", "cells", "degree", "unknowns", "fields"}};
  for (const auto &domain : model.domains) {
    std::vector<std::string> fields;
    for (const Field &field : domain->fields())
      fields.push_back(field.name);
    rows.push_back({domain->name, domain->material.name,
                    std::to_string(domain->mesh().n_global_active_cells()), std::to_string(domain->degree),
                    std::to_string(domain->dof_handler().n_dofs()), comma_separated(fields)});
  }
  return align(rows);
}

template <int dim>
std::vector<std::string> table_of_interfaces(const Model<dim> &model)
{
  std::vector<std::vector<std::string>> rows = {
      {"interface", "tie", "source", "destination", "points", "covered", "largest gap", "overlap", "angle"}};
  for (const auto &interface : model.interfaces) {
    const Coverage &coverage = interface->pairing().coverage();
    const Gaps gaps = find_gaps(*interface, model.communicator);
    const double rounding = 1e-12 * interface->sides[source].domain->typical_length();
    const auto distance = [&](const double value) { return to_text(value < rounding ? 0. : value); };
    const auto covered = [&](const unsigned int side) {
      return to_text(100 * coverage.covered[side] / coverage.area[side], "%.4g %%");
    };
    rows.push_back({interface->name, interface->section.peek("Type"), to_text(interface->sides[source]),
                    to_text(interface->sides[destination]), std::to_string(coverage.n_points),
                    covered(source) + " / " + covered(destination), distance(gaps.largest_gap),
                    distance(gaps.largest_overlap),
                    to_text(180 / dealii::numbers::PI * coverage.largest_angle, "%.3g deg")});
  }
  return align(rows);
}

} // namespace

std::vector<std::string> align(const Table &rows)
{
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const auto &row : rows)
    for (unsigned int c = 0; c < row.size(); ++c)
      widths[c] = std::max(widths[c], row[c].size());
  std::vector<std::string> lines;
  for (const auto &row : rows) {
    std::string line;
    for (unsigned int c = 0; c < row.size(); ++c)
      line += "  " + row[c] + (c + 1 < row.size() ? std::string(widths[c] - row[c].size(), ' ') : "");
    lines.push_back(line);
  }
  return lines;
}

Log::Log(const MPI_Comm &communicator, const Detail detail)
    : communicator(communicator), level(detail),
      is_speaking(dealii::Utilities::MPI::this_mpi_process(communicator) == 0),
      has_terminal(is_speaking && stdout_is_terminal())
{
}

Log::~Log()
{
  erase_bar();
}

void Log::line(const std::string &text)
{
  if (level != Detail::quiet)
    tell(text);
}

void Log::tell(const std::string &text)
{
  ++count_of_lines;
  if (!is_speaking)
    return;
  erase_bar();
  std::cout << text << '\n';
  draw_bar();
  std::cout << std::flush;
}

void Log::detail(const std::string &text)
{
  if (is_brief)
    kept_back.push_back(text);
  else
    line(text);
}

void Log::show_details()
{
  for (const std::string &text : kept_back)
    line(text);
  kept_back.clear();
}

std::string Log::time_left() const
{
  if (!(time_done > 0) || time_done >= end_time)
    return {};
  return "about " + in_seconds(since_steps_began.wall_time() * (end_time / time_done - 1)) + " left";
}

void Log::draw_bar() const
{
  if (!has_bar)
    return;
  const std::string left = time_left();
  std::cout << progress_bar(time_done / end_time) << "t = " << to_text(time_done) << " of "
            << to_text(end_time) << (left.empty() ? "" : ", ") << left << std::flush;
}

void Log::erase_bar() const
{
  if (has_bar)
    std::cout << erase_line << std::flush;
}

void Log::table(const Table &rows)
{
  line();
  for (const std::string &row : align(rows))
    line(row);
}

void Log::title(const std::string &scene)
{
  tell();
  tell("Dovetail " DOVETAIL_VERSION ": " + scene);
}

template <int dim>
void Log::summary(const Model<dim> &model)
{
  const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(model.communicator);
  line(std::to_string(dim) + "D, " + std::to_string(model.numbering->n_dofs()) + " unknowns on " +
       std::to_string(n_ranks) + (n_ranks == 1 ? " rank" : " ranks"));
  line();
  for (const std::string &row : table_of_domains(model))
    line(row);
  if (model.interfaces.empty())
    return;
  line();
  for (const std::string &row : table_of_interfaces(model))
    line(row);
}

template <int dim>
void Log::cost_of_pairing(const Model<dim> &model)
{
  unsigned long n_points = 0, n_segments = 0;
  double bytes = 0;
  for (const auto &interface : model.interfaces) {
    const Coverage &coverage = interface->pairing().coverage();
    n_points += coverage.n_points;
    n_segments += coverage.n_segments;
    // weight; on each side position, normal, and values (twice over a gap) and gradients of the shape
    // functions
    unsigned int n_doubles = 1;
    for (const auto &side : interface->sides)
      n_doubles += 2 * dim + side.domain->layout().n_shapes() * (2 + dim);
    bytes += static_cast<double>(coverage.n_points) * n_doubles * sizeof(double);
  }
  const double pairing = dealii::Utilities::MPI::max(model.pairing_seconds, model.communicator);
  const double search = dealii::Utilities::MPI::max(model.search_seconds, model.communicator);
  if (n_points == 0)
    return;
  std::ostringstream words;
  words.precision(3);
  words << "pairing: " << n_points << " points in " << pairing << " s, " << 1e6 * pairing / n_points
        << " microseconds a point (the search alone " << 1e6 * search / n_points << "), " << bytes / n_points
        << " bytes a point";
  if (n_segments > 0)
    words << "; " << n_segments << " segments, " << 1e6 * pairing / n_segments << " microseconds and "
          << bytes / n_segments << " bytes a segment";
  line(words.str());
}

/// Of parts with a line for each of many interfaces the first and the last ones.
void Log::plan(const Plan &plan)
{
  const std::size_t most_lines = 24, n_last = 4;
  line();
  using Part = std::pair<const char *, const std::vector<std::string> *>;
  for (const auto &[heading, sentences] : {Part("plan", &plan.needed), Part("left out", &plan.left_out)})
    for (std::size_t i = 0, n = sentences->size(); i < n; ++i) {
      char text[16];
      std::snprintf(text, sizeof(text), "  %-10s", i == 0 ? heading : "");
      const bool is_gap = n > most_lines && i + n_last + 1 == most_lines;
      line(text + (is_gap ? "… and " + std::to_string(n - most_lines + 1) + " more, which the report has"
                          : (*sentences)[i]));
      if (is_gap)
        i = n - n_last - 1;
    }
}

void Log::step_begins(const unsigned int step, const unsigned int n_steps, const double time,
                      const double end_time)
{
  if (!(time_done > 0))
    since_steps_began.restart();
  has_bar = has_terminal && n_steps != 1 && level != Detail::quiet;
  is_brief = level == Detail::usual && (n_steps == 0 || n_steps > most_steps_in_full);
  this->end_time = end_time;
  time_of_step = time;
  n_iterations = 0;
  kept_back.clear();
  name_of_step = "Step " + std::to_string(step) + (step > n_steps ? "" : " of " + std::to_string(n_steps)) +
                 ", t = " + to_text(time, "%.6g");
  if (!is_brief || step == 1)
    line();
  if (is_brief || n_steps == 1)
    return;
  const std::string left = time_left();
  line(name_of_step + (left.empty() ? "" : ", " + left));
}

void Log::newton_iteration(const unsigned int iteration, const double residual,
                           const unsigned int linear_iterations, const double damping)
{
  char text[120];
  std::snprintf(text, sizeof(text), "  Newton %2u   residual %.3e   linear iterations %3u", iteration,
                residual, linear_iterations);
  detail(text + (damping == 1 ? std::string() : "   damping " + to_text(damping)));
  ++n_iterations;
  last_residual = residual;
}

std::string Log::summary_of_step() const
{
  return name_of_step + ": " + std::to_string(n_iterations) +
         (n_iterations == 1 ? " iteration" : " iterations") +
         (n_iterations == 0 ? "" : ", residual " + to_text(last_residual, "%.1e"));
}

void Log::step_ends(const std::string &remark)
{
  if (!remark.empty()) {
    line(is_brief ? summary_of_step() + "; " + remark : "  " + remark);
    return;
  }
  if (is_speaking)
    erase_bar();
  time_done = time_of_step;
  if (is_brief) {
    const double memory = dealii::Utilities::MPI::sum(peak_memory_of_process(), communicator);
    const std::string left = time_left();
    line(summary_of_step() + "; " + in_seconds(since_steps_began.wall_time()) +
         (left.empty() ? "" : ", " + left) + ", " + to_text(memory, "%.0f MiB"));
  } else if (is_speaking)
    draw_bar();
}

void Log::cycle(const unsigned int n_done, const unsigned int n_cycles, const unsigned long n_unknowns,
                const double estimated_error)
{
  is_brief = false;
  line("Adaptive cycle " + std::to_string(n_done) + " of " + std::to_string(n_cycles) + ": " +
       std::to_string(n_unknowns) + " unknowns, estimated error " +
       to_text(100 * estimated_error, "%.3g %% of the energy norm"));
}

void Log::cycle(const unsigned int n_done, const unsigned int n_cycles, const unsigned long n_unknowns,
                const nlohmann::ordered_json &report)
{
  line("Adaptive cycle " + std::to_string(n_done) + " of at most " + std::to_string(n_cycles) + ": " +
       std::to_string(n_unknowns) + " unknowns");
  std::vector<std::vector<std::string>> rows;
  for (const auto &[name, estimate] : report["probe estimates"].items())
    rows.push_back({name, value_and_error(report, name),
                    to_text(100 * estimate["relative error"].template get<double>(), "%.3g %%") +
                        " of tolerated " +
                        to_text(100 * estimate["tolerance"].template get<double>(), "%.3g %%") +
                        ", corrected " + to_text(estimate["corrected value"])});
  for (const std::string &row : align(rows))
    line("  " + row);
}

void Log::finish(const nlohmann::ordered_json &report, const std::string &directory)
{
  erase_bar();
  has_bar = false;
  std::vector<std::vector<std::string>> rows;
  for (const auto &[name, value] : report["probes"].items())
    rows.push_back({name, value_and_error(report, name)});
  for (const auto &[domain, numbers] : report["domains"].items())
    if (numbers.contains("errors"))
      for (const auto &[field, errors] : numbers["errors"].items())
        rows.push_back({"error of " + field + " in " + domain,
                        "L2 " + to_text(errors["L2"]) + ", H1 " + to_text(errors["H1"])});
  for (const auto &[interface, numbers] : report["interfaces"].items())
    if (numbers.contains("jump L2"))
      for (const auto &[field, jump] : numbers["jump L2"].items())
        rows.push_back({"jump of " + field + " at " + interface, "L2 " + to_text(jump)});
  tell();
  if (!rows.empty())
    for (const std::string &row : align(rows))
      tell(row);

  std::string seconds;
  for (const auto &[phase, value] : report["seconds"].items())
    seconds += (seconds.empty() ? "" : ", ") + phase + " " + to_text(value.template get<double>(), "%.3g");
  tell();
  tell("  seconds: " + (seconds.empty() ? "none" : seconds));
  tell("  memory:  " + to_text(report["peak memory MiB"].template get<double>(), "%.0f") + " MiB");
  tell("  results: " + directory);
}

template void Log::cost_of_pairing(const Model<2> &);
template void Log::cost_of_pairing(const Model<3> &);
template void Log::summary(const Model<2> &);
template void Log::summary(const Model<3> &);

} // namespace dovetail
