// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A joint whose traction over opening and sliding a formula gives, T_n(n, s) along the normal and T_t(n, s)
// across it, for n, s >= 0. It unloads along the secants of the largest opening and the largest sliding so
// far,
//
//     t = (T_n(m_n, m_t)/m_n max(n, 0) + K_n min(n, 0),   T_t(m_n, m_t)/m_t s),   m = largest so far of n+,
//     |s|
//
// and is as stiff as `Joint stiffness` says in compression. While both grow t = (T_n(n, s), T_t(n, s)).
// Where m is 0 the secant is the tangent. What it dissipates per area is the work less what unloading gives
// back,
//
//     D = int T_n dm_n + T_t dm_t - (T_n m_n + T_t m_t)/2
//
// along straight lines of m from step to step. Reference for such laws: Xu and Needleman 1994.
//
//     subsection Interface glue
//       set Type            = contact resistance
//       set Joint           = formula
//       set Joint stiffness = 1e13                # Pa/m
//       set Traction        = 3e13*n*exp(-n/1e-6); 1e13*s*exp(-s/2e-6)
//     end

#include <dovetail/scene/undefined.h>
#include <dovetail/tie/joint_law.h>

#include <deal.II/base/quadrature_lib.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

using dealii::Tensor;

class FormulaJoint : public JointLaw
{
public:
  explicit FormulaJoint(const Section &section);

  std::vector<InternalVariable> internal_variables() const override
  {
    return {{"largest opening"}, {"largest sliding"}, {"dissipated energy"}}; // [m], [m], [J/m^2]
  }
  bool evaluate(const JointPlace &place, const Tensor<1, 3> &opening, JointResponse &response) const override;
  double softening(const JointPlace & /*place*/) const override { return steepest; }
  bool is_symmetric(bool /*has_one_stiffness*/) const override { return is_uncoupled; }

private:
  /// The secant stiffness of a component over m_n and m_t, and its derivatives by them.
  struct Secant
  {
    double value;
    std::array<double, 2> by_largest;
  };
  Secant secant(unsigned int component, const std::array<double, 2> &largest) const;
  double derivative(unsigned int component, const std::array<double, 2> &at, unsigned int by) const
  {
    return formula.derivative(dealii::Point<3>(), 0, component, {at.data(), 2}, by);
  }
  double value(unsigned int component, const std::array<double, 2> &at) const
  {
    return formula.value(dealii::Point<3>(), 0, component, {at.data(), 2});
  }
  double dissipated(const std::array<double, 2> &from, const std::array<double, 2> &to) const;
  double find_steepest() const;
  bool depends_crosswise() const;

  const Expression formula;
  const bool is_uncoupled; ///< T_n does not depend on s, and T_t not on n
  const double steepest;
  const dealii::QGauss<1> along_line = dealii::QGauss<1>(8);
};

FormulaJoint::FormulaJoint(const Section &section)
    : formula(section.require_expression(
          "Traction", {2}, "T_n; T_t over the opening n and the sliding s, both from 0 on, zero at rest [Pa]",
          {"n", "s"})),
      is_uncoupled(!section.documenting() && !depends_crosswise()),
      steepest(section.documenting() ? 0 : find_steepest())
{
  section.check(!formula.depends_on_position() && !formula.depends_on_time(), "Traction",
                "depends on place or time, but must be a formula in n and s only.");
  for (const unsigned int component : {0, 1})
    if (!section.documenting()) {
      const double at_rest = value(component, {{0, 0}});
      section.check(at_rest == 0, "Traction",
                    "is " + in_words(at_rest) + " at n = s = 0, but must be 0 there.");
    }
}

/// Looked for where the joint is open and slides by much or little, in whatever unit.
bool FormulaJoint::depends_crosswise() const
{
  for (double size = 1e-15; size < 1e15; size *= 10)
    if (derivative(0, {{size, size}}, 1) != 0 || derivative(1, {{size, size}}, 0) != 0)
      return true;
  return false;
}

/// Largest fall of the traction along straight lines, in whatever unit: of -D, symmetric part.
double FormulaJoint::find_steepest() const
{
  const unsigned int per_decade = 20;
  const double margin = 1.2;
  double result = 0;
  for (const double angle : {0., 0.1, 0.5, 0.785, 1.1, 1.47, 1.5707963267948966})
    for (int i = -15 * static_cast<int>(per_decade); i <= 15 * static_cast<int>(per_decade); ++i) {
      const double size = std::pow(10., i / static_cast<double>(per_decade));
      const std::array<double, 2> at = {{size * std::cos(angle), size * std::sin(angle)}};
      const double D_nn = derivative(0, at, 0), D_tt = derivative(1, at, 1),
                   D_nt = (derivative(0, at, 1) + derivative(1, at, 0)) / 2;
      const double least = (D_nn + D_tt) / 2 - std::hypot((D_nn - D_tt) / 2, D_nt);
      if (std::isfinite(least))
        result = std::max(result, -least);
    }
  return margin * result;
}

FormulaJoint::Secant FormulaJoint::secant(const unsigned int component,
                                          const std::array<double, 2> &largest) const
{
  const double own = largest[component];
  const unsigned int other = 1 - component;
  Secant result{};
  if (own > 0) {
    result.value = value(component, largest) / own;
    result.by_largest[component] = (derivative(component, largest, component) - result.value) / own;
    result.by_largest[other] = derivative(component, largest, other) / own;
  } else { // its limit; it multiplies a zero component
    result.value = derivative(component, largest, component);
    result.by_largest[other] =
        formula.second_derivative(dealii::Point<3>(), 0, component, {largest.data(), 2}, component, other);
  }
  return result;
}

/// From one pair of largest values to another. Nothing is lost where neither grows.
double FormulaJoint::dissipated(const std::array<double, 2> &from, const std::array<double, 2> &to) const
{
  if (from == to)
    return 0;
  double result = 0;
  for (const unsigned int c : {0, 1}) {
    result -= (value(c, to) * to[c] - value(c, from) * from[c]) / 2;
    for (unsigned int q = 0; q < along_line.size(); ++q) {
      const double share = along_line.point(q)[0];
      const std::array<double, 2> at = {
          {from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])}};
      result += along_line.weight(q) * value(c, at) * (to[c] - from[c]);
    }
  }
  return result;
}

bool FormulaJoint::evaluate(const JointPlace &place, const Tensor<1, 3> &opening,
                            JointResponse &response) const
{
  const double n = std::max(opening[0], 0.), s = std::hypot(opening[1], opening[2]);
  const std::array<double, 2> now = {{n, s}};
  std::array<double, 2> largest;
  std::array<Tensor<1, 3>, 2> largest_by_opening;
  for (const unsigned int i : {0, 1}) {
    largest[i] = std::max(place.memory.accepted[i], now[i]);
    place.memory.trial[i] = largest[i];
  }
  const std::array<double, 2> before = {{place.memory.accepted[0], place.memory.accepted[1]}};
  place.memory.trial[2] = place.memory.accepted[2] + dissipated(before, largest);
  if (n > place.memory.accepted[0])
    largest_by_opening[0][0] = 1;
  if (s > place.memory.accepted[1])
    for (const unsigned int i : {1, 2})
      largest_by_opening[1][i] = opening[i] / s;

  const std::array<Secant, 2> k = {{secant(0, largest), secant(1, largest)}};
  response = JointResponse();
  const std::array<double, 3> open = {{n, opening[1], opening[2]}};
  for (unsigned int i = 0; i < 3; ++i) {
    const Secant &k_i = k[i == 0 ? 0 : 1];
    response.traction[i] = k_i.value * open[i];
    response.by_opening[i][i] += k_i.value;
    for (const unsigned int l : {0, 1})
      response.by_opening[i] += open[i] * k_i.by_largest[l] * largest_by_opening[l];
  }
  if (opening[0] < 0) {
    response.traction[0] = place.stiffness[0] * opening[0];
    response.by_opening[0] = Tensor<1, 3>();
    response.by_opening[0][0] = place.stiffness[0];
  }
  return std::isfinite(response.traction.norm()) && std::isfinite(response.by_opening.norm()) &&
         std::isfinite(place.memory.trial[2]);
}

[[maybe_unused]] const bool registered = JointCatalogue::add<FormulaJoint>(
    "formula",
    "A joint whose traction is given over opening and sliding, with the memory of the largest ones.");

} // namespace

} // namespace dovetail
