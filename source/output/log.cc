// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/gaps.h>
#include <dovetail/output/log.h>
#include <dovetail/output/progress_bar.h>

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

/// Columns as wide as their widest entry; the first row is the heading.
std::vector<std::string> align(const std::vector<std::vector<std::string>> &rows)
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

Log::Log(const MPI_Comm &communicator)
    : is_speaking(dealii::Utilities::MPI::this_mpi_process(communicator) == 0),
      has_terminal(is_speaking && stdout_is_terminal())
{
}

Log::~Log()
{
  erase_bar();
}

void Log::line(const std::string &text)
{
  ++count_of_lines;
  if (!is_speaking)
    return;
  erase_bar();
  std::cout << text << '\n';
  draw_bar();
  std::cout << std::flush;
}

void Log::draw_bar() const
{
  if (has_bar)
    std::cout << progress_bar(time_done / end_time) << "t = " << to_text(time_done) << " of "
              << to_text(end_time) << std::flush;
}

void Log::erase_bar() const
{
  if (has_bar)
    std::cout << erase_line << std::flush;
}

void Log::title(const std::string &scene)
{
  line();
  line("Dovetail " DOVETAIL_VERSION ": " + scene);
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

void Log::plan(const Plan &plan)
{
  line();
  using Part = std::pair<const char *, const std::vector<std::string> *>;
  for (const auto &[heading, sentences] : {Part("plan", &plan.needed), Part("left out", &plan.left_out)})
    for (std::size_t i = 0; i < sentences->size(); ++i) {
      char text[16];
      std::snprintf(text, sizeof(text), "  %-10s", i == 0 ? heading : "");
      line(text + (*sentences)[i]);
    }
}

void Log::step_begins(const unsigned int step, const unsigned int n_steps, const double time,
                      const double end_time)
{
  has_bar = has_terminal && n_steps != 1;
  this->end_time = end_time;
  time_of_step = time;
  line();
  if (n_steps != 1)
    line("Step " + std::to_string(step) + (step > n_steps ? "" : " of " + std::to_string(n_steps)) +
         ", t = " + to_text(time, "%.6g"));
}

void Log::newton_iteration(const unsigned int iteration, const double residual,
                           const unsigned int linear_iterations, const double damping)
{
  char text[120];
  std::snprintf(text, sizeof(text), "  Newton %2u   residual %.3e   linear iterations %3u", iteration,
                residual, linear_iterations);
  line(text + (damping == 1 ? std::string() : "   damping " + to_text(damping)));
}

void Log::step_ends(const std::string &remark)
{
  if (!remark.empty())
    line("  " + remark);
  else if (is_speaking) {
    erase_bar();
    time_done = time_of_step;
    draw_bar();
  }
}

void Log::cycle(const unsigned int n_done, const unsigned int n_cycles, const unsigned long n_unknowns,
                const double estimated_error)
{
  line("Adaptive cycle " + std::to_string(n_done) + " of " + std::to_string(n_cycles) + ": " +
       std::to_string(n_unknowns) + " unknowns, estimated error " +
       to_text(100 * estimated_error, "%.3g %% of the energy norm"));
}

void Log::finish(const nlohmann::ordered_json &report, const std::string &directory)
{
  erase_bar();
  has_bar = false;
  std::vector<std::vector<std::string>> rows;
  for (const auto &[name, value] : report["probes"].items())
    rows.push_back({name, to_text(value)});
  for (const auto &[domain, numbers] : report["domains"].items())
    if (numbers.contains("errors"))
      for (const auto &[field, errors] : numbers["errors"].items())
        rows.push_back({"error of " + field + " in " + domain,
                        "L2 " + to_text(errors["L2"]) + ", H1 " + to_text(errors["H1"])});
  for (const auto &[interface, numbers] : report["interfaces"].items())
    if (numbers.contains("jump L2"))
      for (const auto &[field, jump] : numbers["jump L2"].items())
        rows.push_back({"jump of " + field + " at " + interface, "L2 " + to_text(jump)});
  line();
  if (!rows.empty())
    for (const std::string &row : align(rows))
      line(row);

  std::string seconds;
  for (const auto &[phase, value] : report["seconds"].items())
    seconds += (seconds.empty() ? "" : ", ") + phase + " " + to_text(value.template get<double>(), "%.3g");
  line();
  line("  seconds: " + (seconds.empty() ? "none" : seconds));
  line("  memory:  " + to_text(report["peak memory MiB"].template get<double>(), "%.0f") + " MiB");
  line("  results: " + directory);
}

template void Log::cost_of_pairing(const Model<2> &);
template void Log::cost_of_pairing(const Model<3> &);
template void Log::summary(const Model<2> &);
template void Log::summary(const Model<3> &);

} // namespace dovetail
