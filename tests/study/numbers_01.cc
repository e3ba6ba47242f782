// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a study makes of numbers: medians, rates, the Pareto front, combined errors, who is first and by how
// much, errors of probes against an extrapolated value: 2 + h^2 has the values 3, 2.25, 2.0625, so J = 2 with
// the order 2. 2 + h^4 is of the order 4, which elements of degree 2 can have and those of degree 1 cannot.
// Of a scalar they are relative to its range. Levels between which noise would have to decide: the coarsest.

#include <dovetail/study/numbers.h>

#include <cmath>
#include <iostream>

using namespace dovetail;

namespace {

StudyPoint point(const unsigned int level, const double seconds, const double error,
                 const std::string &status = "converged")
{
  StudyPoint result;
  result.level = level;
  result.seconds = seconds;
  result.fastest = 0.95 * seconds; // three runs with 5 % of noise
  result.slowest = 1.05 * seconds;
  result.n_runs = 3;
  result.error = error;
  result.status = status;
  return result;
}

StudyRun run(const double seconds, const std::string &status = "converged")
{
  StudyRun result;
  result.seconds = seconds;
  result.status = status;
  // two bodies: errors 3 and 4 of norms 30 and 40 are 0.1 together; jump 2 on an area of 4 where |T| <= 10 is
  // 0.1
  result.report = {
      {"dofs", 7},
      {"steps", {{{"newton iterations", 2}, {"linear iterations", {5, 6}}}}},
      {"seconds", {{"tie", 0.25}, {"total", 1}}},
      {"peak memory MiB", 100},
      {"domains",
       {{"a",
         {{"cells", 3},
          {"errors", {{"T", {{"L2", 3}}}}},
          {"norms", {{"T", {{"L2", 30}}}}},
          {"minimum", {{"T", -10}}}}},
        {"b", {{"cells", 4}, {"errors", {{"T", {{"L2", 4}}}}}, {"norms", {{"T", {{"L2", 40}}}}}}}}},
      {"interfaces", {{"seam", {{"covered source", 4}, {"jump L2", {{"T", 2}}}}}}},
      {"probes", {{"tip", {1, 2}}, {"gone", nullptr}}}};
  return result;
}

StudyPoint point_of_probe(const unsigned int level, const double dofs, const double x, const double y)
{
  StudyPoint result = point(level, 1, std::numeric_limits<double>::quiet_NaN());
  result.numbers = {{"dofs", dofs}, {"probes/tip/0", x}, {"probes/tip/1", y}, {"probes/tipple", 7}};
  return result;
}

/// 2 + h^4 by elements of this degree.
void extrapolate_fourth_order(const int degree)
{
  std::vector<StudyCurve> curves = {{"fast", 0, {}}};
  for (unsigned int level = 0; level < 3; ++level) {
    curves[0].points.push_back(point_of_probe(level, 8 << 2 * level, 2 + std::pow(2., -4. * level), 0));
    curves[0].points.back().numbers.emplace_back("domains/a/degree", degree);
  }
  std::cout << measure_by_probe(curves, "tip") << '\n';
}

/// Of levels with these values, which take as long as each other.
std::vector<StudyCurve> curve_of(const std::vector<double> &values)
{
  std::vector<StudyCurve> curves = {{"L-shape", 0, {}}};
  for (unsigned int level = 0; level < values.size(); ++level) {
    StudyPoint next = point(level, 1, std::numeric_limits<double>::quiet_NaN());
    next.numbers = {{"dofs", 8 << 2 * level},     {"domains/a/degree", 1},      {"domains/a/minimum/T", 300},
                    {"domains/a/maximum/T", 340}, {"domains/a/range/T", 40},    {"domains/b/minimum/T", 320},
                    {"domains/b/maximum/T", 364}, {"domains/b/range/T", 44},    {"domains/b/minimum/u", 0},
                    {"domains/b/maximum/u", 1},   {"probes/tip", values[level]}};
    curves[0].points.push_back(next);
  }
  return curves;
}

/// Four values of a scene whose exact one is 363.97207: the last three seem to converge to 363.95649, by
/// which the error of the finest would be twice as large as it is. Four values show it by what they have
/// converged to before, three by their order, two by their difference; of one, nothing is known.
void compare_uncertain_probes()
{
  const std::vector<double> values = {364.389256, 364.045939, 364.010721, 363.989369};
  for (const unsigned int n : {4, 3, 2, 1}) {
    auto curves = curve_of({values.end() - n, values.end()});
    std::cout << measure_by_probe(curves, "tip", "T") << '\n';
    for (const std::string &sentence : who_is_first(curves))
      std::cout << sentence << '\n';
  }
  auto curves = curve_of(values);
  std::cout << measure_by_probe(curves, "tip", "u") << '\n' << curves[0].points[3].error << '\n';
}

void compare_probes()
{
  std::vector<StudyCurve> curves = {
      {"fine",
       0,
       {point_of_probe(0, 8, 3, 0), point_of_probe(1, 32, 2.25, 0), point_of_probe(2, 128, 2.0625, 0)}},
      {"rough", 1, {point_of_probe(0, 4, 4, 0), point_of_probe(1, 16, 3, 0)}}};
  std::cout << measure_by_probe(curves, "tip") << '\n';
  for (const StudyCurve &curve : curves)
    for (const StudyPoint &p : curve.points)
      std::cout << curve.name << ' ' << p.level << ' ' << p.error << '\n';
  curves[0].points.pop_back();
  std::cout << measure_by_probe(curves, "tip") << '\n' << measure_by_probe(curves, "top").size() << '\n';

  curves = {{"fine", 0, {point(0, 1, 0.4), point(1, 1, 0.1), point_of_probe(2, 1, 1, 1)}}};
  extrapolate_errors(curves);
  std::cout << curves[0].points[2].error << ' ' << curves[0].points[2].is_extrapolated << '\n';
}

} // namespace

int main()
{
  std::cout << "median " << median({3, 1, 2}) << ' ' << median({4, 1, 2, 3}) << ' ' << median({}) << '\n';
  std::cout << "rate " << rate(8, 2, 1) << ' ' << rate(8, 2, 2) << ' ' << rate(8, 0, 1) << '\n';

  std::cout << "front";
  for (const unsigned int i : pareto_front({{2, 5}, {1, 9}, {3, 5}, {4, 1}, {2, 7}, {1, 9}}))
    std::cout << ' ' << i;
  std::cout << "\n\n";

  for (const auto &[name, value] : numbers_of(run(1).report))
    std::cout << name << " = " << value << '\n';

  const StudyRun first = run(1), second = run(3), third = run(2, "not converged");
  const StudyPoint good = make_point({&first, &second}, "T L2"),
                   bad = make_point({&first, &second, &third}, "T L2");
  std::cout << '\n'
            << good.status << ' ' << good.seconds << ' ' << good.fastest << ' ' << good.slowest << ' '
            << good.tie_share << ' ' << good.error << '\n'
            << bad.status << ' ' << bad.seconds << "\n\n";

  const std::vector<StudyCurve> curves = {
      {"mortar", 0, {point(0, 1, 0.1), point(1, 2, 0.005), point(2, 1.95, 0.004), point(3, 8, 0.0005)}},
      {"Nitsche", 1, {point(0, 1, 0.09), point(1, 2.01, 0.004), point(2, 5, 1e-5, "not converged")}},
      {"pointwise", 2, {point(0, 0.5, 0.08), point(1, 3, 0.01)}}};
  for (const std::string &sentence : who_is_first(curves))
    std::cout << sentence << '\n';
  std::cout << who_is_first({}).size() << '\n';
  for (const auto &[curve, place] : deciding_points(curves))
    std::cout << curves[curve].name << ' ' << place << '\n';
  std::cout << '\n';
  compare_probes();
  extrapolate_fourth_order(2);
  extrapolate_fourth_order(1);
  std::cout << '\n';
  compare_uncertain_probes();
  std::cout << std::flush;
}
