// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The content by its capacity, H(B) - H(B_0) = int_(B_0)^B c(b) db, and by a formula of its own.
//
// Reference: Piessens et al., QUADPACK (1983), on the rule of Gauss and Kronrod.

#include <dovetail/material/content.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace dovetail {

namespace {

struct Quadrature
{
  double value = 0, size = 0; ///< of f and |f|
  double error = 0;           ///< against the rule of 7 points
};

/// The rule of 15 points on (a, b), which contains Gauss' rule of 7 points.
template <typename Function>
Quadrature gauss_kronrod(const Function &f, const double a, const double b)
{
  const double middle = (a + b) / 2, half = (b - a) / 2;
  const unsigned int no_halving = 0;
  Quadrature result;
  result.value = boost::math::quadrature::gauss_kronrod<double, 15>::integrate(
      [&](const double z) { return half * f(middle + half * z); }, -1., 1., no_halving, 0., &result.error,
      &result.size);
  return result;
}

/// int_a^b f on intervals that are halved until the error of all is small beside int |f|. Places that cost
/// many halvings, where f has a kink or a jump as tables do, are kept: the next intervals end there.
class Integrator
{
public:
  explicit Integrator(const bool keeps_kinks) : n_kept(keeps_kinks ? 200 : 0) {}

  /// Not finite where f is not or has a pole.
  template <typename Function>
  double integral(const Function &f, const double a, const double b) const
  {
    double from = a, size = 0;
    std::vector<Interval> intervals;
    for (const double to : ends(a, b)) {
      intervals.push_back({from, to, gauss_kronrod(f, from, to)});
      size += intervals.back().whole.size;
      from = to;
    }
    double sum = 0;
    for (const Interval &interval : intervals)
      sum += integral(f, interval, size, 0);
    return sum;
  }

private:
  struct Interval
  {
    double a, b;
    Quadrature whole;
  };
  static constexpr unsigned int most_halvings = 40, halvings_at_kink = 4;

  static bool is_good(const Interval &interval, const double size)
  {
    return !(interval.whole.error > 1e-12 * size); // also where nothing helps
  }

  /// Of the intervals from a to b: the kinks, the middle (a peak is seen if it is not narrower than a
  /// twentieth) and b.
  std::vector<double> ends(const double a, const double b) const
  {
    std::vector<double> result(std::upper_bound(kinks.begin(), kinks.end(), std::min(a, b)),
                               std::lower_bound(kinks.begin(), kinks.end(), std::max(a, b)));
    const double middle = (a + b) / 2;
    result.insert(std::lower_bound(result.begin(), result.end(), middle), middle);
    if (b < a)
      std::reverse(result.begin(), result.end());
    result.push_back(b);
    return result;
  }

  template <typename Function>
  double integral(const Function &f, const Interval &interval, const double size,
                  const unsigned int n_halvings) const
  {
    if (is_good(interval, size))
      return interval.whole.value;
    if (n_halvings == most_halvings) // a jump is no longer seen, a pole is
      return interval.whole.error > 1e-6 * size ? std::numeric_limits<double>::quiet_NaN()
                                                : interval.whole.value;
    const double middle = (interval.a + interval.b) / 2;
    const Interval left = {interval.a, middle, gauss_kronrod(f, interval.a, middle)},
                   right = {middle, interval.b, gauss_kronrod(f, middle, interval.b)};
    if (n_halvings >= halvings_at_kink && kinks.size() < n_kept && is_good(left, size) &&
        is_good(right, size))
      kinks.insert(std::lower_bound(kinks.begin(), kinks.end(), middle), middle);
    return integral(f, left, size, n_halvings + 1) + integral(f, right, size, n_halvings + 1);
  }

  const unsigned int n_kept;
  mutable std::vector<double> kinks; ///< sorted
};

/// f(scalars with another own one)
template <typename Function>
double at_other_value(const ScalarState &state, const double B, const Function &f)
{
  std::array<double, 8> small;
  std::vector<double> large;
  const unsigned int n = state.scalars.size();
  if (n > small.size())
    large.resize(n);
  double *values = n > small.size() ? large.data() : small.data();
  std::copy(state.scalars.begin(), state.scalars.end(), values);
  values[state.own] = B;
  return f(Expression::Scalars(values, n));
}

class ContentOfCapacity : public Content
{
public:
  ContentOfCapacity(const std::string &entry, const Expression &capacity_formula,
                    const bool depends_on_others)
      : Content(entry), c(capacity_formula),
        integrator(!c.depends_on_position() && !c.depends_on_time() && !depends_on_others) // kinks stay
  {
  }

  double change(const ScalarState &state, const double from) const override
  {
    return integrate(state, from, c.depends_on_scalar(state.own),
                     [&](const auto &scalars) { return c.value(state.X, state.t, 0, scalars); });
  }
  double capacity(const ScalarState &state) const override
  {
    return c.value(state.X, state.t, 0, state.scalars);
  }
  double slope_of_change(const ScalarState &state, const double from, const unsigned int s) const override
  {
    return integrate(state, from, c.depends_on_scalar(state.own),
                     [&](const auto &scalars) { return c.derivative(state.X, state.t, 0, scalars, s); });
  }

  bool is_linear() const override { return !c.depends_on_scalars(); }
  bool depends_on_scalar(const unsigned int s) const override { return c.depends_on_scalar(s); }
  bool depends_on_time() const override { return c.depends_on_time(); }
  bool depends_on_position() const override { return c.depends_on_position(); }

private:
  /// Of f(scalars) over the own scalar.
  template <typename Function>
  double integrate(const ScalarState &state, const double from, const bool depends_on_own,
                   const Function &f) const
  {
    const double to = state.value();
    const auto at = [&](const double B) { return at_other_value(state, B, f); };
    if (!depends_on_own)
      return (to - from) * at(to);
    return from == to ? 0 : integrator.integral(at, from, to);
  }

  const Expression c;
  const Integrator integrator;
};

/// H depends on its own scalar and the position only, else its differences were not what is stored.
class ContentOfFormula : public Content
{
public:
  ContentOfFormula(const std::string &entry, const Expression &content) : Content(entry), H(content) {}

  double change(const ScalarState &state, const double from) const override
  {
    const auto value = [&](const auto &scalars) { return H.value(state.X, state.t, 0, scalars); };
    return value(state.scalars) - at_other_value(state, from, value);
  }
  double capacity(const ScalarState &state) const override
  {
    return H.derivative(state.X, state.t, 0, state.scalars, state.own);
  }
  double slope_of_change(const ScalarState & /*state*/, double /*from*/, unsigned int /*s*/) const override
  {
    return 0;
  }
  bool is_flat(const ScalarState &state) const override
  {
    const double B = state.value(), d = 1e-6 * std::max(1., std::abs(B));
    return change(state, B - d) == 0 && change(state, B + d) == 0;
  }

  std::string words_for_capacity() const override { return "grows with its field by "; }

  bool is_linear() const override { return H.is_affine_in_scalars(); }
  bool depends_on_scalar(unsigned int /*s*/) const override { return false; }
  bool depends_on_time() const override { return false; }
  bool depends_on_position() const override { return H.depends_on_position(); }

private:
  const Expression H;
};

} // namespace

std::unique_ptr<const Content> content_of_capacity(const std::string &entry, const Expression &capacity,
                                                   const bool depends_on_others)
{
  return std::make_unique<ContentOfCapacity>(entry, capacity, depends_on_others);
}

std::unique_ptr<const Content> content_of_formula(const std::string &entry, const Expression &content)
{
  return std::make_unique<ContentOfFormula>(entry, content);
}

} // namespace dovetail
