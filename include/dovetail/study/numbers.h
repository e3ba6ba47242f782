// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The numbers of a study: columns of its table, medians, rates, who is best.

#pragma once

#include <dovetail/study/run.h>

#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace dovetail {

/// Name and value, in the order of the report.
using Numbers = std::vector<std::pair<std::string, double>>;

/// What a report says: counts, "seconds PHASE", "peak memory MiB", the combined relative errors ("error
/// temperature L2", …) and every number of domains, interfaces and probes under its path.
///
/// The combined error of a field in L2, H1 or energy is (sum of errors^2 / sum of norms^2)^1/2 over all
/// domains that have one; "flux" likewise over the interfaces; "jump" is
/// (sum of jumps^2)^1/2 / (max |B| (sum of areas)^1/2). A scalar has (max B - min B) (sum of volumes)^1/2 in
/// place of its L2 norm, and its range in place of max |B|.
Numbers numbers_of(const nlohmann::ordered_json &report);

/// NaN if it is not there.
double find_number(const Numbers &numbers, const std::string &name);

/// Of the middle two if their number is even; NaN of none.
double median(std::vector<double> values);

/// log2(coarse / fine) per level; NaN unless both errors are positive.
double rate(double coarse_error, double fine_error, unsigned int levels_between);

/// All runs of one variant, level and number of ranks.
struct StudyPoint
{
  unsigned int level = 0;
  std::string status;  ///< of the first run that is not converged, else "converged"
  std::string message; ///< of that run
  double seconds = std::numeric_limits<double>::quiet_NaN(); ///< median
  double fastest = std::numeric_limits<double>::quiet_NaN(), slowest = fastest;
  unsigned int n_runs = 0;      ///< that are done
  double start_up = fastest;    ///< what the process took beyond the program's own time, median
  double tie_share = fastest;   ///< of the program's own time, median
  double error = fastest;       ///< NaN if it is not known
  double uncertainty = 0;       ///< of the value that the error is measured against, relative as the error
  bool is_extrapolated = false; ///< the error, from those of coarser levels
  Numbers numbers;              ///< of the first run that has a report

  bool is_converged() const { return status == "converged"; }
  bool is_on_curve() const { return is_converged() && error > 0; } ///< something to plot
};

/// One line of the picture: a variant on a number of ranks, by level.
struct StudyCurve
{
  std::string name;
  unsigned int family = 0; ///< those with one value of the first varied list, which have one colour
  std::vector<StudyPoint> points;
  bool is_adaptive = false; ///< its levels are adaptive cycles, and no mesh sizes halve from one to the next
};

/// Seconds that the process took beyond the program's own: launch, libraries, MPI; NaN without a report.
double start_up_of(const StudyRun &run);

/// @p measure: "temperature L2".
StudyPoint make_point(const std::vector<const StudyRun *> &repeats, const std::string &measure);

/// Indices of the points that no other one beats in both: less of the first and not more of the second, or
/// the other way round. In the order of the first.
std::vector<unsigned int> pareto_front(const std::vector<std::pair<double, double>> &points);

/// "1 % is reached first by mortar at level 2: 0.31 s (0.30 to 0.33), 1.4 times faster than the next, Nitsche
/// (0.43 to 0.45 s)." for 1, 0.1 and 0.01 %. Two whose intervals overlap are not distinguishable. An error
/// that reaches these per cent does so with its uncertainty.
std::vector<std::string> who_is_first(const std::vector<StudyCurve> &curves);

/// What these verdicts rest on: curve, and place among its points, of the first and the next at each error.
std::set<std::pair<unsigned int, unsigned int>> deciding_points(const std::vector<StudyCurve> &curves);
/// A verdict rests on so many runs of a point, at least.
constexpr unsigned int n_runs_of_verdict = 3;

/// The value of a probe on meshes of no size, from the last three levels of a curve (Richardson 1911).
struct Extrapolation
{
  std::vector<double> value;
  double order = std::numeric_limits<double>::quiet_NaN(); ///< observed; NaN: the values do not converge yet
  double too_large = 0;   ///< an observed order beyond twice the degree, which is none
  double uncertainty = 0; ///< of the value
};
/// Nothing if fewer than three levels have converged. What the value adds to the finest one is uncertain by a
/// quarter (Roache 1994); if that is more, the value is by its change since the three levels before. Three
/// levels with an order below 1.5 times the degree leave twice of it uncertain (Oberkampf and Roy 2010).
std::optional<Extrapolation> extrapolate(const StudyCurve &curve, const std::string &probe);

/// Set the errors of all points to those of a probe, |J - J_h| / |J|, with the uncertainty of J. J is
/// extrapolated from the curve with the most unknowns of those that converge; without one it is the finest
/// value with its estimated error added, if there is an estimate. @param field of which the probe is a value:
/// if it is a scalar, its range takes the place of |J|. @return against what, in words; empty if there is no
/// such probe.
std::string measure_by_probe(std::vector<StudyCurve> &curves, const std::string &probe,
                             const std::string &field = "");

/// Give points without an error what the rate of the two levels before lets expect.
void extrapolate_errors(std::vector<StudyCurve> &curves);

} // namespace dovetail
