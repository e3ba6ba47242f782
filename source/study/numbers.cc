// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/study/numbers.h>

#include <algorithm>
#include <array>
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

/// The L2 error of a scalar has no natural zero to be measured from (273 K is none): it is relative to the
/// range of its values in all domains, times the root of the volume.
void measure_by_range(const ordered_json &domains, Ratios &ratios)
{
  struct Range
  {
    double smallest = std::numeric_limits<double>::infinity(), largest = -smallest, volume = 0;
  };
  std::map<std::string, Range> ranges;
  for (const auto &domain : domains)
    if (domain.contains("range") && domain.contains("errors"))
      for (const auto &[field, range] : domain["range"].items())
        if (domain["errors"].contains(field)) {
          Range &all = ranges[field];
          all.smallest = std::min(all.smallest, number_at(domain["minimum"], field.c_str()));
          all.largest = std::max(all.largest, number_at(domain["maximum"], field.c_str()));
          all.volume += number_at(domain, "volume");
        }
  for (const auto &[field, all] : ranges)
    if (const auto ratio = ratios.find("error " + field + " L2");
        ratio != ratios.end() && all.largest > all.smallest)
      ratio->second.norm = std::pow(all.largest - all.smallest, 2) * all.volume;
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

/// Jumps against the largest value of the field, of a scalar its range, times the root of the area.
void add_jumps(const ordered_json &report, std::vector<std::string> &names, Ratios &ratios)
{
  std::map<std::string, double> largest, areas;
  std::map<std::string, std::array<double, 2>> extremes; // of scalars
  for (const auto &domain : report["domains"])
    if (domain.contains("range"))
      for (const auto &[field, range] : domain["range"].items()) {
        const double smallest = number_at(domain["minimum"], field.c_str()),
                     greatest = number_at(domain["maximum"], field.c_str());
        auto &both = extremes.try_emplace(field, std::array<double, 2>{{smallest, greatest}}).first->second;
        both = {{std::min(both[0], smallest), std::max(both[1], greatest)}};
      }
  for (const auto &domain : report["domains"])
    for (const char *extreme : {"maximum", "minimum"})
      if (domain.contains(extreme))
        for (const auto &[field, value] : domain[extreme].items())
          if (value.is_number())
            largest[field] = std::max(largest[field], std::abs(value.get<double>()));
  for (const auto &[field, both] : extremes)
    if (both[1] > both[0])
      largest[field] = both[1] - both[0];
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
  measure_by_range(report["domains"], ratios);
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

/// The coarsest point of a curve whose error is small enough; a finer one if that is faster beyond the noise.
const StudyPoint *first_below(const StudyCurve &curve, const double error)
{
  const StudyPoint *best = nullptr;
  for (const StudyPoint &point : curve.points)
    if (point.is_converged() && point.error + point.uncertainty <= error &&
        (best == nullptr || (point.n_runs > 1 && best->n_runs > 1 && point.slowest < best->fastest)))
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
  for (const char *part : {"domains", "interfaces", "probes", "probe errors", "spectrum", "counters"})
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

double start_up_of(const StudyRun &run)
{
  if (!run.report.is_object() || !run.report.contains("seconds"))
    return undefined;
  const auto &seconds = run.report["seconds"];
  return run.seconds - (number_at(seconds, "total") - seconds.value("comparison", 0.));
}

StudyPoint make_point(const std::vector<const StudyRun *> &repeats, const std::string &measure)
{
  StudyPoint point;
  point.level = repeats.front()->level;
  point.status = "converged";
  std::vector<double> seconds, shares, start_ups;
  for (const StudyRun *run : repeats) {
    if (!std::isnan(run->seconds))
      seconds.push_back(run->seconds);
    point.n_runs += run->is_done();
    if (!run->is_converged() && point.is_converged()) {
      point.status = run->is_done() ? run->status : "not done";
      point.message = run->message;
    }
    if (run->report.is_object()) {
      const Numbers numbers = numbers_of(run->report);
      shares.push_back(find_number(numbers, "seconds tie") / find_number(numbers, "seconds total"));
      start_ups.push_back(start_up_of(*run));
      if (point.numbers.empty())
        point.numbers = numbers;
    }
  }
  point.seconds = median(seconds);
  if (!seconds.empty()) {
    point.fastest = *std::min_element(seconds.begin(), seconds.end());
    point.slowest = *std::max_element(seconds.begin(), seconds.end());
  }
  point.start_up = median(start_ups);
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

namespace {

constexpr double percents[] = {1., 0.1, 0.01};

/// Of what an extrapolation adds to the finest value this is uncertain (Roache 1994), and this if the order
/// is that of a singular solution, or of meshes that are too coarse, and no fourth level confirms it
/// (Oberkampf and Roy 2010).
constexpr double usual_uncertainty = 0.25, largest_uncertainty = 2;

/// Those that reach an error, the fastest first: curve, and place of the point.
std::vector<std::pair<unsigned int, unsigned int>> reaching(const std::vector<StudyCurve> &curves,
                                                            const double error)
{
  std::vector<std::pair<unsigned int, unsigned int>> result;
  for (unsigned int c = 0; c < curves.size(); ++c)
    if (const StudyPoint *point = first_below(curves[c], error))
      result.emplace_back(c, point - curves[c].points.data());
  std::stable_sort(result.begin(), result.end(), [&](const auto &a, const auto &b) {
    return curves[a.first].points[a.second].seconds < curves[b.first].points[b.second].seconds;
  });
  return result;
}

std::string interval_text(const StudyPoint &point)
{
  if (point.n_runs < 2)
    return "one run";
  return to_text(point.fastest) + " to " + seconds_text(point.slowest) + ", " + std::to_string(point.n_runs) +
         " runs";
}

/// Of the fastest and the next one.
std::string compare(const StudyPoint &first, const StudyCurve &next_curve, const StudyPoint &next)
{
  const std::string name =
      next_curve.name + " (" + seconds_text(next.seconds) + ", " + interval_text(next) + ")";
  if (next.fastest <= first.slowest)
    return "; not distinguishable on this machine from " + name + ".";
  const double ratio = next.seconds / first.seconds;
  return ", " + to_text(ratio, ratio < 9.95 ? "%.2g" : "%.0f") + " times faster than the next, " + name + ".";
}

/// Of a vector the components. @p part: of the report.
std::vector<double> values_of_probe(const StudyPoint &point, const std::string &probe,
                                    const std::string &part = "probes/")
{
  const std::string path = part + probe;
  std::vector<double> values;
  for (const auto &[name, value] : point.numbers)
    if (name == path || name.rfind(path + "/", 0) == 0)
      values.push_back(value);
  return values;
}

double distance(const std::vector<double> &a, const std::vector<double> &b)
{
  double sum = 0;
  for (unsigned int i = 0; i < a.size(); ++i)
    sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

double n_unknowns_of(const StudyCurve &curve)
{
  double largest = 0;
  for (const StudyPoint &point : curve.points)
    if (point.is_converged())
      largest = std::max(largest, find_number(point.numbers, "dofs"));
  return largest;
}

std::string list_text(const std::vector<double> &values)
{
  std::string text;
  for (const double value : values)
    text += (text.empty() ? "" : "; ") + to_text(value, "%.8g");
  return text;
}

} // namespace

std::vector<std::string> who_is_first(const std::vector<StudyCurve> &curves)
{
  std::vector<std::string> sentences;
  const StudyCurve *most_exact = nullptr;
  const StudyPoint *least = nullptr;
  for (const StudyCurve &curve : curves)
    for (const StudyPoint &point : curve.points)
      if (point.is_on_curve() && (least == nullptr || point.error < least->error)) {
        least = &point;
        most_exact = &curve;
      }
  if (least == nullptr)
    return {};
  for (const double percent : percents) {
    const auto fastest = reaching(curves, percent / 100);
    std::string sentence = to_text(percent, "%g %%") + " is reached ";
    if (fastest.empty()) {
      sentences.push_back(
          sentence + "by none" + (least->error <= percent / 100 ? " for certain" : "") + "; nearest is " +
          most_exact->name + " at level " + std::to_string(least->level) + " with " +
          to_text(100 * least->error) + " % in " + seconds_text(least->seconds) +
          (std::isfinite(least->uncertainty) && least->uncertainty > 0
               ? " against a value that is uncertain by " + to_text(100 * least->uncertainty) + " %."
               : "."));
      break; // even less so what comes after it
    }
    const StudyCurve &curve = curves[fastest[0].first];
    const StudyPoint &point = curve.points[fastest[0].second];
    sentence += "first by " + curve.name + " at level " + std::to_string(point.level) + ": " +
                seconds_text(point.seconds) + " (" + interval_text(point) + ")";
    if (fastest.size() > 1)
      sentence +=
          compare(point, curves[fastest[1].first], curves[fastest[1].first].points[fastest[1].second]);
    else
      sentence += curves.size() > 1 ? "; no other reaches it." : ".";
    sentences.push_back(sentence);
  }
  return sentences;
}

std::set<std::pair<unsigned int, unsigned int>> deciding_points(const std::vector<StudyCurve> &curves)
{
  std::set<std::pair<unsigned int, unsigned int>> result;
  for (const double percent : percents) {
    const auto fastest = reaching(curves, percent / 100);
    for (unsigned int i = 0; fastest.size() > 1 && i < 2; ++i)
      result.insert(fastest[i]);
  }
  return result;
}

namespace {

/// The largest of the domains; 0: not known.
double degree_of(const StudyPoint &point)
{
  double degree = 0;
  for (const auto &[name, value] : point.numbers)
    if (name.rfind("domains", 0) == 0 && name.size() > 7 && name.compare(name.size() - 7, 7, "/degree") == 0)
      degree = std::max(degree, value);
  return degree;
}

/// A number that the solution gives converges with twice the degree at most, on smooth solutions (Aubin 1967,
/// Nitsche 1968; Babuska and Miller 1984); by chance between two levels somewhat faster.
double largest_order(const StudyPoint &point)
{
  const double degree = degree_of(point);
  return degree > 0 ? 2 * degree + 0.5 : std::numeric_limits<double>::infinity();
}

/// Of smooth solutions.
bool is_full_order(const double order, const StudyPoint &point)
{
  return degree_of(point) > 0 && order >= 1.5 * degree_of(point);
}

/// From three levels.
Extrapolation extrapolate(const StudyPoint *const *points, const std::string &probe)
{
  const std::vector<double> coarse = values_of_probe(*points[0], probe),
                            middle = values_of_probe(*points[1], probe),
                            fine = values_of_probe(*points[2], probe);
  Extrapolation result;
  result.value = fine;
  const unsigned int spacing = points[2]->level - points[1]->level;
  if (points[1]->level - points[0]->level != spacing)
    return result;
  const double order = rate(distance(coarse, middle), distance(middle, fine), spacing);
  if (!(order > 0.2)) // rounding, or not in the range of the asymptotic rate
    return result;
  if (order > largest_order(*points[2])) {
    result.too_large = order;
    return result;
  }
  result.order = order;
  for (unsigned int i = 0; i < fine.size(); ++i)
    result.value[i] += (fine[i] - middle[i]) / (std::pow(2., order * spacing) - 1);
  return result;
}

/// Those with a value of the probe.
std::vector<const StudyPoint *> points_with(const StudyCurve &curve, const std::string &probe)
{
  std::vector<const StudyPoint *> points;
  for (const StudyPoint &point : curve.points)
    if (point.is_converged() && !values_of_probe(point, probe).empty())
      points.push_back(&point);
  return points;
}

} // namespace

std::optional<Extrapolation> extrapolate(const StudyCurve &curve, const std::string &probe)
{
  const auto points = points_with(curve, probe);
  if (points.size() < 3)
    return {};
  const StudyPoint *const *last = points.data() + points.size() - 3;
  Extrapolation result = extrapolate(last, probe);
  const bool is_sure = points.size() > 3 || is_full_order(result.order, *points.back());
  result.uncertainty = (is_sure ? usual_uncertainty : largest_uncertainty) *
                       distance(result.value, values_of_probe(*points.back(), probe));
  if (points.size() > 3)
    result.uncertainty =
        std::max(result.uncertainty, distance(result.value, extrapolate(last - 1, probe).value));
  return result;
}

namespace {

/// What errors are measured against.
struct ValueOfStudy
{
  std::vector<double> value;
  double uncertainty = std::numeric_limits<double>::infinity();
  std::string words;
  const StudyPoint *finest = nullptr; ///< from which it comes
};

/// The finest value of a curve, with its estimated error added, if there is an estimate.
/// @param why no order is observed
ValueOfStudy finest_value(const StudyCurve &curve, const std::string &probe, const std::string &why)
{
  ValueOfStudy result;
  const auto points = points_with(curve, probe);
  if (points.empty())
    return result;
  result.finest = points.back();
  result.value = values_of_probe(*points.back(), probe);
  const std::vector<double> errors = values_of_probe(*points.back(), probe, "probe errors/");
  if (errors.size() == result.value.size()) {
    for (unsigned int i = 0; i < errors.size(); ++i)
      result.value[i] += errors[i];
    result.uncertainty = distance(errors, std::vector<double>(errors.size(), 0.));
  } else if (points.size() > 1)
    result.uncertainty = distance(result.value, values_of_probe(*points[points.size() - 2], probe));
  result.words = list_text(result.value) + " of probe " + probe + " at level " +
                 std::to_string(points.back()->level) + " of " + curve.name +
                 (errors.empty() ? why : ", its estimated error added");
  return result;
}

/// Extrapolated from the curve with the most unknowns that lets it, or else the finest value.
ValueOfStudy value_of_probe(const std::vector<StudyCurve> &curves, const std::string &probe)
{
  std::vector<const StudyCurve *> by_size;
  for (const StudyCurve &curve : curves)
    by_size.push_back(&curve);
  std::stable_sort(by_size.begin(), by_size.end(), [](const StudyCurve *a, const StudyCurve *b) {
    return n_unknowns_of(*a) > n_unknowns_of(*b);
  });
  std::string warning;
  for (const StudyCurve *curve : by_size)
    if (const auto extrapolated = extrapolate(*curve, probe); !extrapolated || curve->is_adaptive)
      continue;
    else if (extrapolated->too_large > 0)
      warning += "; " + curve->name + " seems to converge with the order " +
                 to_text(extrapolated->too_large, "%.2f") +
                 ", more than twice its degree: not asymptotic, hence not extrapolated";
    else if (extrapolated->order > 0)
      return {extrapolated->value, extrapolated->uncertainty,
              list_text(extrapolated->value) + " of probe " + probe +
                  ", extrapolated from the last three levels of " + curve->name +
                  " with the observed order " + to_text(extrapolated->order, "%.2f") + warning,
              points_with(*curve, probe).back()};
  const std::string why = warning.empty() ? ": no three levels converge, so no order is observed" : "";
  ValueOfStudy result;
  for (auto curve = by_size.begin(); result.value.empty() && curve != by_size.end(); ++curve)
    result = finest_value(**curve, probe, why);
  result.words += result.value.empty() ? "" : warning;
  return result;
}

/// max B - min B over all domains; 0 of what is no scalar.
double range_of(const StudyPoint &point, const std::string &field)
{
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto &[name, value] : point.numbers)
    if (const auto place = name.rfind("/minimum/" + field);
        name.rfind("domains/", 0) == 0 && place != std::string::npos) {
      const std::string domain = name.substr(0, place);
      if (std::isnan(find_number(point.numbers, domain + "/range/" + field)))
        continue; // of a vector
      low = std::min(low, value);
      high = std::max(high, find_number(point.numbers, domain + "/maximum/" + field));
    }
  return std::max(high - low, 0.);
}

} // namespace

std::string measure_by_probe(std::vector<StudyCurve> &curves, const std::string &probe,
                             const std::string &field)
{
  const ValueOfStudy exact = value_of_probe(curves, probe);
  if (exact.value.empty())
    return "";
  const double range = field.empty() ? 0. : range_of(*exact.finest, field),
               length = distance(exact.value, std::vector<double>(exact.value.size(), 0.)),
               size = range > 0    ? range
                      : length > 0 ? length
                                   : 1.;
  for (StudyCurve &curve : curves)
    for (StudyPoint &point : curve.points)
      if (const auto values = values_of_probe(point, probe); values.size() == exact.value.size()) {
        point.error = distance(values, exact.value) / size;
        point.uncertainty = exact.uncertainty / size;
      }
  return exact.words +
         (std::isfinite(exact.uncertainty) ? ", known to within " + to_text(exact.uncertainty, "%.2g")
                                           : ", of unknown error") +
         (range > 0 ? "; relative to the range of the " + field + ", " + to_text(range, "%.4g") : "");
}

void extrapolate_errors(std::vector<StudyCurve> &curves)
{
  for (StudyCurve &curve : curves)
    for (unsigned int i = 2; i < curve.points.size(); ++i) {
      const StudyPoint &coarse = curve.points[i - 2], &middle = curve.points[i - 1];
      StudyPoint &point = curve.points[i];
      if (!point.is_converged() || !std::isnan(point.error) || middle.is_extrapolated ||
          !coarse.is_on_curve() || !middle.is_on_curve())
        continue;
      const double observed = rate(coarse.error, middle.error, middle.level - coarse.level);
      if (!(observed > 0))
        continue;
      point.error = middle.error / std::pow(2., observed * (point.level - middle.level));
      point.is_extrapolated = true;
    }
}

} // namespace dovetail
