// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "picture.h"
#include "gnuplot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <sstream>
#include <tuple>

namespace dovetail {

namespace {

constexpr std::array<unsigned int, 6> shapes{{7, 5, 9, 13, 11, 6}};

/// One of the two pictures: what is to the right in it.
struct Axis
{
  const char *label;
  unsigned int column; ///< of the data
  double (*value)(const StudyPoint &point);
  double least = 0, largest = 0; ///< with some room
};

double seconds_of(const StudyPoint &point)
{
  return point.seconds;
}
double unknowns_of(const StudyPoint &point)
{
  return find_number(point.numbers, "dofs");
}
double fastest_of(const StudyPoint &point)
{
  return point.fastest;
}
double slowest_of(const StudyPoint &point)
{
  return point.slowest;
}
double error_of(const StudyPoint &point)
{
  return point.error;
}

/// The range of what is plotted, on a logarithmic scale with room on both sides.
std::pair<double, double> range_of(const std::vector<StudyCurve> &curves,
                                   const std::vector<double (*)(const StudyPoint &)> &values,
                                   const double room)
{
  double least = std::numeric_limits<double>::max(), largest = 0;
  for (const StudyCurve &curve : curves)
    for (const StudyPoint &point : curve.points)
      for (const auto value : values)
        if (point.is_on_curve()) {
          least = std::min(least, value(point));
          largest = std::max(largest, value(point));
        }
  const double factor = std::pow(std::max(largest / least, 2.), room);
  return {least / factor, largest * factor};
}

/// Powers of ten as such.
std::string ticks_of_errors(const double least, const double largest)
{
  std::string list;
  const int step = std::ceil(std::log10(largest / least) / 12);
  for (int power = std::floor(std::log10(largest)); std::pow(10., power) >= least; power -= step)
    list +=
        (list.empty() ? "" : ", ") + ("\"10^{" + std::to_string(power) + "}\" 1e" + std::to_string(power));
  if (std::log10(largest / least) < 2) // percent then
    for (int power = std::floor(std::log10(least)); power <= std::log10(largest); ++power)
      for (const int digit : {2, 5}) {
        const std::string tick = std::to_string(digit) + "e" + std::to_string(power);
        list += (list.empty() ? "" : ", ") +
                ("\"" + std::to_string(digit) + "·10^{" + std::to_string(power) + "}\" " + tick);
      }
  return "(" + list + ")";
}

/// As many digits between the powers of ten as have room.
std::string ticks(const double least, const double largest)
{
  const double decades = std::log10(largest / least);
  const std::vector<double> digits =
      decades > 2.2   ? std::vector<double>{1}
      : decades > 0.8 ? std::vector<double>{1, 2, 5}
      : decades > 0.4 ? std::vector<double>{1, 1.5, 2, 3, 4, 5, 7}
                      : std::vector<double>{1, 1.2, 1.4, 1.6, 1.8, 2, 2.5, 3, 3.5, 4, 4.5, 5, 6, 7, 8, 9};
  std::string list;
  for (int power = std::floor(std::log10(least)); power <= std::log10(largest); ++power)
    for (const double digit : digits) {
      const double tick = digit * std::pow(10., power);
      if (tick >= least && tick <= largest)
        list += (list.empty() ? "" : ", ") + (power > -4 && power < 4
                                                  ? "\"" + number(tick) + "\" " + number(tick)
                                                  : "\"10^{" + std::to_string(power) + "}\" " + number(tick));
    }
  return "(" + list + ")";
}

/// The rates that the curves end with, rounded to whole numbers, and a curve that shows each best.
std::map<int, const StudyCurve *> rates_of(const std::vector<StudyCurve> &curves)
{
  std::map<int, std::pair<double, const StudyCurve *>> best;
  for (const StudyCurve &curve : curves) {
    std::vector<const StudyPoint *> points;
    for (const StudyPoint &point : curve.points)
      if (point.is_on_curve())
        points.push_back(&point);
    if (points.size() < 2)
      continue;
    const auto &coarse = *points[points.size() - 2], &fine = *points.back();
    const double last = rate(coarse.error, fine.error, fine.level - coarse.level);
    const int whole = std::lround(last);
    const double deviation = std::abs(last - whole);
    if (whole >= 1 && deviation < 0.25 && (best.count(whole) == 0 || deviation < best[whole].first))
      best[whole] = {deviation, &curve};
  }
  std::map<int, const StudyCurve *> result;
  for (const auto &[whole, curve] : best)
    result[whole] = curve.second;
  return result;
}

/// Right angle below to the left of the end of a curve, its hypotenuse as steep as h^rate for unknowns (or
/// times that grow like them) of h^-dim.
void write_triangles(std::ostream &out, const std::vector<StudyCurve> &curves, const Axis &axis,
                     const double least_error, const double largest_error, const unsigned int dim)
{
  const double width = std::pow(axis.largest / axis.least, 0.09);
  const double gap = std::pow(largest_error / least_error, 0.035);
  for (const auto &[whole, curve] : rates_of(curves)) {
    const StudyPoint *end = nullptr;
    for (const StudyPoint &point : curve->points)
      if (point.is_on_curve())
        end = &point;
    const double slope = static_cast<double>(whole) / dim;
    const double right = axis.value(*end) / std::pow(width, 0.3), left = right / width;
    const double low = end->error * std::pow(width, 0.3 * slope) / gap, high = low * std::pow(width, slope);
    out << "set object polygon from " << number(left) << "," << number(high) << " to " << number(left) << ","
        << number(low) << " to " << number(right) << "," << number(low) << " to " << number(left) << ","
        << number(high) << " fillstyle transparent solid 0.15 border lc rgb '#666666' fc rgb '#888888' lw 1\n"
        << "set label " << quoted("h^" + std::to_string(whole)) << " at " << number(left) << ","
        << number(std::sqrt(low * high)) << " right offset -0.4,0 tc rgb '#555555' font ',11'\n";
  }
}

/// Points that no other beats in time and error.
void write_front(std::ostream &out, const std::vector<StudyCurve> &curves)
{
  std::vector<std::pair<double, double>> points;
  for (const StudyCurve &curve : curves)
    for (const StudyPoint &point : curve.points)
      if (point.is_on_curve())
        points.emplace_back(point.seconds, point.error);
  out << "$front << END\n# seconds, error: no other point is faster and more exact\n";
  for (const unsigned int i : pareto_front(points))
    out << points[i].first << ' ' << points[i].second << '\n';
  out << "END\n\n";
}

void write_curves(std::ostream &out, const std::vector<StudyCurve> &curves)
{
  for (std::size_t c = 0; c < curves.size(); ++c) {
    out << "$curve_" << c + 1 << " << END\n# " << curves[c].name
        << "\n# level, unknowns, seconds (median, least, largest), error\n";
    bool is_empty = true;
    for (const StudyPoint &point : curves[c].points)
      if (point.is_on_curve()) {
        out << point.level << ' ' << unknowns_of(point) << ' ' << point.seconds << ' ' << point.fastest << ' '
            << point.slowest << ' ' << point.error << '\n';
        is_empty = false;
      }
    out << (is_empty ? "NaN NaN NaN NaN NaN NaN\n" : "") << "END\n\n";
  }
}

/// What the legend says: the name, and whether something went wrong.
std::string legend(const StudyCurve &curve)
{
  std::string levels, status;
  bool is_all = true;
  for (const StudyPoint &point : curve.points)
    if (point.is_converged())
      is_all = false;
    else {
      levels += (levels.empty() ? "" : ", ") + std::to_string(point.level);
      status = point.status == "not converged" ? "did not converge" : point.status;
    }
  const std::size_t longest = 60;
  const std::string name =
      curve.name.size() <= longest ? curve.name : curve.name.substr(0, longest - 3) + "...";
  return name + (levels.empty() ? "" : ": " + status + (is_all ? "" : " at level " + levels));
}

void write_plot(std::ostream &out, const std::vector<StudyCurve> &curves, const Axis &axis,
                const bool with_front, const bool with_legend)
{
  std::map<unsigned int, unsigned int> n_of_family;
  bool has_families = false;
  for (const StudyCurve &curve : curves)
    has_families = ++n_of_family[curve.family] > 1 || has_families;
  n_of_family.clear();

  out << "plot ";
  if (with_front)
    out << "$front using 1:2 with lines lw 9 lc rgb '#F0E0A0' notitle";
  for (std::size_t c = 0; c < curves.size(); ++c) {
    const StudyCurve &curve = curves[c];
    const unsigned int member = n_of_family[curve.family]++;
    const unsigned int shape = has_families ? member : curve.family;
    const std::string data = "$curve_" + std::to_string(c + 1);
    const std::string colour = "lc rgb '" + colour_of_curve(curve.family) + "'";
    const bool has_spread =
        std::any_of(curve.points.begin(), curve.points.end(),
                    [](const StudyPoint &point) { return point.slowest > point.fastest; });
    out << (c > 0 || with_front ? ", \\\n     " : "");
    if (with_front && has_spread)
      out << data << " using 3:6:4:5 with xerrorbars pt 0 lw 1 " << colour << " notitle, \\\n     ";
    out << data << " using " << axis.column << ":6 with linespoints " << colour << " dt " << 1 + member % 5
        << " pt " << shapes[shape % shapes.size()] << " ps " << number(1.6 - 0.2 * std::min(curve.family, 3U))
        << " lw " << number(3 - 0.5 * std::min(curve.family, 3U)) << " "
        << (with_legend ? "title " + quoted(legend(curve)) : "notitle");
  }
  if (with_legend)
    out << ", \\\n     NaN with lines lw 9 lc rgb '#F0E0A0' title 'Pareto front (left)'";
  out << "\n\n";
}

void write_script(std::ostream &out, const std::string &title, const std::vector<StudyCurve> &curves,
                  const std::string &measure, const unsigned int dim)
{
  Axis time{"run time [s]", 3, seconds_of}, unknowns{"unknowns", 2, unknowns_of};
  std::tie(time.least, time.largest) = range_of(curves, {fastest_of, slowest_of}, 0.06);
  std::tie(unknowns.least, unknowns.largest) = range_of(curves, {unknowns_of}, 0.06);
  const auto [least_error, largest_error] = range_of(curves, {error_of}, 0.05);
  std::size_t letters = 20; // the legend makes the picture as wide as it needs
  for (const StudyCurve &curve : curves)
    letters = std::max(letters, legend(curve).size());
  const double width = 1040 + 8.2 * letters, height = 560;
  const auto across = [&](const double position) { return number(position / width); };

  write_curves(out, curves);
  write_front(out, curves);
  begin_pictures(out, "study", width, height);
  out << "set logscale xy\n"
         "set tmargin at screen 0.88\n"
         "set bmargin at screen 0.14\n"
      << "set label 1 " << quoted(title + ": error against run time and unknowns") << " at screen "
      << across(88) << ",0.95 left font ',15' noenhanced\n"
      << "set yrange [" << number(least_error) << ":" << number(largest_error) << "]\n"
      << "set ytics " << ticks_of_errors(least_error, largest_error) << "\n\n";

  for (const Axis *axis : {&time, &unknowns}) {
    const bool is_first = axis == &time;
    out << "set lmargin at screen " << across(is_first ? 88 : 567) << "\nset rmargin at screen "
        << across(is_first ? 490 : 945) << "\nset xrange [" << number(axis->least) << ":"
        << number(axis->largest) << "]\nset xtics " << ticks(axis->least, axis->largest) << "\nset xlabel "
        << quoted(axis->label) << "\n";
    if (is_first)
      out << "set ylabel " << quoted("relative error: " + measure) << " noenhanced offset 0.5,0\nunset key\n";
    else
      out << "unset label 1\nunset ylabel\n"
             "set key at screen "
          << across(970) << ",0.88 left top Left reverse noenhanced samplen 2.2 spacing 1.25 font ',"
          << std::max(6, 12 * 14 / std::max(14, static_cast<int>(curves.size()))) << "'\n";
    if (axis->largest > 10 * axis->least) // else it is the start of the program that is seen
      write_triangles(out, curves, *axis, least_error, largest_error, dim);
    write_plot(out, curves, *axis, is_first, !is_first);
    out << "unset object\nunset label\n";
  }
  end_pictures(out);
}

} // namespace

std::string draw_study(const std::string &directory, const std::string &title,
                       const std::vector<StudyCurve> &curves, const std::string &measure,
                       const unsigned int dim)
{
  const auto has_points = [](const StudyCurve &curve) {
    return std::any_of(curve.points.begin(), curve.points.end(),
                       [](const StudyPoint &point) { return point.is_on_curve(); });
  };
  if (std::none_of(curves.begin(), curves.end(), has_points))
    return "No picture: no run has an error to show.";
  std::ostringstream text;
  write_script(text, title, curves, measure, dim);
  return draw_by_gnuplot(directory, "study", "Error against run time", text.str(),
                         "do this study again, which runs nothing twice.");
}

} // namespace dovetail
