// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The content by its capacity, H(B) - H(B_0) = int_(B_0)^B c(b) db, and by a formula of its own.
//
// Reference: Piessens et al., QUADPACK (1983), on the rule of Gauss and Kronrod.

#include <dovetail/material/content.h>

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
  static constexpr std::array<double, 8> nodes = {
      {0.991455371120812639207, 0.949107912342758524526, 0.864864423359769072790, 0.741531185599394439864,
       0.586087235467691130294, 0.405845151377397166907, 0.207784955007898467601, 0}};
  static constexpr std::array<double, 8> weights = {
      {0.022935322010529224964, 0.063092092629978553291, 0.104790010322250183840, 0.140653259715525918745,
       0.169004726639267902827, 0.190350578064785409913, 0.204432940075298892414, 0.209482141084727828013}};
  static constexpr std::array<double, 4> gauss_weights = {
      {0.129484966168869693271, 0.279705391489276667901, 0.381830050505118944950, 0.417959183673469387755}};
  const double middle = (a + b) / 2, half = (b - a) / 2;
  Quadrature result;
  double gauss = 0;
  for (unsigned int i = 0; i < nodes.size(); ++i)
    for (const double sign : {-1., 1.}) {
      if (nodes[i] == 0 && sign > 0)
        continue;
      const double value = half * f(middle + sign * half * nodes[i]);
      result.value += weights[i] * value;
      result.size += weights[i] * std::abs(value);
      gauss += i % 2 == 1 ? gauss_weights[i / 2] * value : 0;
    }
  result.error = std::abs(result.value - gauss);
  return result;
}

/// int_a^b f on intervals that are halved until the error of all is small beside int |f|. Kinks of f (tables)
/// cost some halvings; where f is not finite, so is the result.
template <typename Function>
double integral(const Function &f, const double a, const double b, const double size,
                const unsigned int n_halvings)
{
  const Quadrature whole = gauss_kronrod(f, a, b);
  const double of_all = size > 0 ? size : whole.size;
  if (!(whole.error > 1e-12 * of_all) || n_halvings == 0)
    return whole.value;
  const double middle = (a + b) / 2;
  return integral(f, a, middle, of_all, n_halvings - 1) + integral(f, middle, b, of_all, n_halvings - 1);
}

template <typename Function>
double integral(const Function &f, const double a, const double b)
{
  const double middle = (a + b) / 2; // a peak is seen if it is not narrower than a twentieth
  return integral(f, a, middle, 0, 40) + integral(f, middle, b, 0, 40);
}

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
  ContentOfCapacity(const std::string &entry, const Expression &capacity_formula)
      : Content(entry), c(capacity_formula)
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
    return from == to ? 0 : integral(at, from, to);
  }

  const Expression c;
};

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
  double slope_of_change(const ScalarState &state, const double from, const unsigned int s) const override
  {
    const auto slope = [&](const auto &scalars) { return H.derivative(state.X, state.t, 0, scalars, s); };
    return slope(state.scalars) - at_other_value(state, from, slope);
  }

  std::string words_for_capacity() const override { return "grows with its field by "; }

  bool is_linear() const override { return H.is_affine_in_scalars(); }
  bool depends_on_scalar(const unsigned int s) const override { return H.depends_on_scalar(s); }
  bool depends_on_time() const override { return H.depends_on_time(); }
  bool depends_on_position() const override { return H.depends_on_position(); }

private:
  const Expression H;
};

} // namespace

std::unique_ptr<const Content> content_of_capacity(const std::string &entry, const Expression &capacity)
{
  return std::make_unique<ContentOfCapacity>(entry, capacity);
}

std::unique_ptr<const Content> content_of_formula(const std::string &entry, const Expression &content)
{
  return std::make_unique<ContentOfFormula>(entry, content);
}

} // namespace dovetail
