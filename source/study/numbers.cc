// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/study/numbers.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace dovetail {

using nlohmann::ordered_json;

namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

/// Longer lists hold no components of a vector or a tensor.
constexpr std::size_t longest_list = 9;

void add_leaves(const std::string &path, const ordered_json &value, Numbers &numbers)
{
  if (value.is_number())
    numbers.emplace_back(path, value.get<double>());
  else if (value.is_null())
    numbers.emplace_back(path, undefined);
  else if (value.is_object() || (value.is_array() && value.size() <= longest_list && !value.empty() &&
                                 (value[0].is_number() || value[0].is_null())))
    for (const auto &[name, part] : value.items())
      add_leaves(path + "/" + name, part, numbers);
}

double number_at(const ordered_json &object, const char *name)
{
  const auto found = object.find(name);
  return found != object.end() && found->is_number() ? found->get<double>() : undefined;
}

struct Ratio
{
  double error = 0, norm = 0; ///< squares
};
using Ratios = std::map<std::string, Ratio>;

/// One key of all domains: "errors" against "norms".
void add_domain_errors(const ordered_json &domains, std::vector<std::string> &names, Ratios &ratios)
{
  for (const auto &domain : domains)
    if (domain.contains("errors") && domain.contains("norms"))
      for (const auto &[field, errors] : domain["errors"].items())
        for (const auto &[norm, error] : errors.items()) {
          const std::string name = "error " + field + " " + norm;
          if (!domain["norms"].contains(field))
            continue;
          if (ratios.count(name) == 0)
            names.push_back(name);
          // what is undefined in one domain (null) is so in all
          ratios[name].error += std::pow(number_at(errors, norm.c_str()), 2);
          ratios[name].norm += std::pow(number_at(domain["norms"][field], norm.c_str()), 2);
        }
}

void add_interface_errors(const ordered_json &interfaces, std::vector<std::string> &names, Ratios &ratios)
{
  for (const auto &interface : interfaces)
    if (interface.contains("flux error L2") && interface.contains("flux norm L2"))
      for (const auto &[field, error] : interface["flux error L2"].items()) {
        const std::string name = "error " + field + " flux";
        if (ratios.count(name) == 0)
          names.push_back(name);
        ratios[name].error += std::pow(number_at(interface["flux error L2"], field.c_str()), 2);
        ratios[name].norm += std::pow(number_at(interface["flux norm L2"], field.c_str()), 2);
      }
}

/// Jumps against the largest value of the field times the root of the area.
void add_jumps(const ordered_json &report, std::vector<std::string> &names, Ratios &ratios)
{
  std::map<std::string, double> largest, areas;
  for (const auto &domain : report["domains"])
    for (const char *extreme : {"maximum", "minimum"})
      if (domain.contains(extreme))
        for (const auto &[field, value] : domain[extreme].items())
          if (value.is_number())
            largest[field] = std::max(largest[field], std::abs(value.get<double>()));
  for (const auto &interface : report["interfaces"])
    if (interface.contains("jump L2"))
      for (const auto &[field, jump] : interface["jump L2"].items())
        if (jump.is_number()) {
          const std::string name = "error " + field + " jump";
          if (ratios.count(name) == 0)
            names.push_back(name);
          ratios[name].error += std::pow(jump.get<double>(), 2);
          areas[field] += number_at(interface, "covered source");
          ratios[name].norm = std::pow(largest[field], 2) * areas[field];
        }
}

void add_combined_errors(const ordered_json &report, Numbers &numbers)
{
  std::vector<std::string> names;
  Ratios ratios;
  add_domain_errors(report["domains"], names, ratios);
  add_interface_errors(report["interfaces"], names, ratios);
  add_jumps(report, names, ratios);
  for (const std::string &name : names)
    numbers.emplace_back(name, std::sqrt(ratios[name].error / ratios[name].norm));
}

double sum_of(const ordered_json &list)
{
  double sum = 0;
  for (const auto &value : list)
    sum += value.get<double>();
  return sum;
}

void add_counts(const ordered_json &report, Numbers &numbers)
{
  double cells = 0, newton = 0, linear = 0;
  for (const auto &domain : report["domains"])
    cells += number_at(domain, "cells");
  for (const auto &step : report["steps"]) {
    newton += number_at(step, "newton iterations");
    linear += sum_of(step["linear iterations"]);
  }
  numbers.emplace_back("cells", cells);
  numbers.emplace_back("dofs", number_at(report, "dofs"));
  numbers.emplace_back("newton iterations", newton);
  numbers.emplace_back("linear iterations", linear);
}

std::string to_text(const double value, const char *format = "%.2g")
{
  char text[40];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

std::string seconds_text(const double seconds)
{
  return to_text(seconds, seconds < 10 ? "%.2g s" : "%.0f s");
}

/// The fastest point of a curve whose error is small enough.
const StudyPoint *first_below(const StudyCurve &curve, const double error)
{
  const StudyPoint *best = nullptr;
  for (const StudyPoint &point : curve.points)
    if (point.is_converged() && point.error <= error && (best == nullptr || point.seconds < best->seconds))
      best = &point;
  return best;
}

} // namespace

Numbers numbers_of(const ordered_json &report)
{
  Numbers numbers;
  add_counts(report, numbers);
  for (const auto &[phase, seconds] : report["seconds"].items())
    numbers.emplace_back("seconds " + phase, seconds.is_number() ? seconds.get<double>() : undefined);
  numbers.emplace_back("peak memory MiB", number_at(report, "peak memory MiB"));
  add_combined_errors(report, numbers);
  for (const char *part : {"domains", "interfaces", "probes", "spectrum", "counters"})
    if (report.contains(part))
      add_leaves(part, report[part], numbers);
  return numbers;
}

double find_number(const Numbers &numbers, const std::string &name)
{
  for (const auto &[candidate, value] : numbers)
    if (candidate == name)
      return value;
  return undefined;
}

double median(std::vector<double> values)
{
  if (values.empty())
    return undefined;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

double rate(const double coarse_error, const double fine_error, const unsigned int levels_between)
{
  if (!(coarse_error > 0) || !(fine_error > 0) || levels_between == 0)
    return undefined;
  return std::log2(coarse_error / fine_error) / levels_between;
}

StudyPoint make_point(const std::vector<const StudyRun *> &repeats, const std::string &measure)
{
  StudyPoint point;
  point.level = repeats.front()->level;
  point.status = "converged";
  std::vector<double> seconds, shares;
  for (const StudyRun *run : repeats) {
    seconds.push_back(run->seconds);
    if (!run->is_converged() && point.is_converged()) {
      point.status = run->is_done() ? run->status : "not done";
      point.message = run->message;
    }
    if (run->report.is_object()) {
      const Numbers numbers = numbers_of(run->report);
      shares.push_back(find_number(numbers, "seconds tie") / find_number(numbers, "seconds total"));
      if (point.numbers.empty())
        point.numbers = numbers;
    }
  }
  point.seconds = median(seconds);
  point.fastest = *std::min_element(seconds.begin(), seconds.end());
  point.slowest = *std::max_element(seconds.begin(), seconds.end());
  point.tie_share = median(shares);
  point.error = find_number(point.numbers, "error " + measure);
  return point;
}

std::vector<unsigned int> pareto_front(const std::vector<std::pair<double, double>> &points)
{
  std::vector<unsigned int> order(points.size()), front;
  for (unsigned int i = 0; i < order.size(); ++i)
    order[i] = i;
  std::sort(order.begin(), order.end(), [&](const auto a, const auto b) { return points[a] < points[b]; });
  double least = std::numeric_limits<double>::infinity();
  for (const unsigned int i : order)
    if (points[i].second < least) {
      front.push_back(i);
      least = points[i].second;
    }
  return front;
}

std::vector<std::string> who_is_first(const std::vector<StudyCurve> &curves)
{
  std::vector<std::string> sentences;
  for (const double percent : {1., 0.1, 0.01}) {
    std::vector<std::pair<const StudyCurve *, const StudyPoint *>> reaching;
    const StudyCurve *most_exact = nullptr;
    const StudyPoint *least = nullptr;
    for (const StudyCurve &curve : curves) {
      if (const StudyPoint *point = first_below(curve, percent / 100))
        reaching.emplace_back(&curve, point);
      for (const StudyPoint &point : curve.points)
        if (point.is_on_curve() && (least == nullptr || point.error < least->error)) {
          least = &point;
          most_exact = &curve;
        }
    }
    if (least == nullptr)
      return {};
    std::sort(reaching.begin(), reaching.end(),
              [](const auto &a, const auto &b) { return a.second->seconds < b.second->seconds; });
    std::string sentence = to_text(percent, "%g %%") + " is reached ";
    if (reaching.empty()) {
      sentences.push_back(sentence + "by none; nearest is " + most_exact->name + " at level " +
                          std::to_string(least->level) + " with " + to_text(100 * least->error) + " % in " +
                          seconds_text(least->seconds) + ".");
      break; // even less so what comes after it
    }
    const auto &[curve, point] = reaching.front();
    sentence += "first by " + curve->name + " at level " + std::to_string(point->level) + ": " +
                seconds_text(point->seconds);
    if (reaching.size() > 1) {
      const double ratio = reaching[1].second->seconds / point->seconds;
      sentence +=
          (ratio < 1.05 ? ", about as fast as"
                        : ", " + to_text(ratio, ratio < 9.95 ? "%.2g" : "%.0f") + " times faster than") +
          " the next, " + reaching[1].first->name + ".";
    } else
      sentence += curves.size() > 1 ? "; no other reaches it." : ".";
    sentences.push_back(sentence);
  }
  return sentences;
}

} // namespace dovetail
