// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "tape.h"

#include <cmath>

namespace dovetail {

const std::vector<Tape::Function> &Tape::functions()
{
  static const std::vector<Function> all = [] {
    std::vector<Function> result;
    for (const auto &group :
         {trigonometric_functions(), hyperbolic_functions(), exponential_functions(), step_functions()})
      result.insert(result.end(), group.begin(), group.end());
    return result;
  }();
  return all;
}

std::vector<Tape::Function> Tape::trigonometric_functions()
{
  using T = Tape;
  return {
      {"sin", [](double a) { return std::sin(a); }, [](T &t, Number a) { return t.apply("cos", a); }},
      {"cos", [](double a) { return std::cos(a); },
       [](T &t, Number a) { return t.times(t.add_constant(-1), t.apply("sin", a)); }},
      {"tan", [](double a) { return std::tan(a); },
       [](T &t, Number a) { return t.plus_square(1, 1, t.apply("tan", a)); }},
      {"asin", [](double a) { return std::asin(a); },
       [](T &t, Number a) { return t.quotient(1, t.apply("sqrt", t.plus_square(1, -1, a))); }},
      {"acos", [](double a) { return std::acos(a); },
       [](T &t, Number a) { return t.quotient(-1, t.apply("sqrt", t.plus_square(1, -1, a))); }},
      {"atan", [](double a) { return std::atan(a); },
       [](T &t, Number a) { return t.quotient(1, t.plus_square(1, 1, a)); }},
  };
}

std::vector<Tape::Function> Tape::hyperbolic_functions()
{
  using T = Tape;
  return {
      {"sinh", [](double a) { return std::sinh(a); }, [](T &t, Number a) { return t.apply("cosh", a); }},
      {"cosh", [](double a) { return std::cosh(a); }, [](T &t, Number a) { return t.apply("sinh", a); }},
      {"tanh", [](double a) { return std::tanh(a); },
       [](T &t, Number a) { return t.plus_square(1, -1, t.apply("tanh", a)); }},
      {"asinh", [](double a) { return std::asinh(a); },
       [](T &t, Number a) { return t.quotient(1, t.apply("sqrt", t.plus_square(1, 1, a))); }},
      {"acosh", [](double a) { return std::acosh(a); },
       [](T &t, Number a) { return t.quotient(1, t.apply("sqrt", t.plus_square(-1, 1, a))); }},
      {"atanh", [](double a) { return std::atanh(a); },
       [](T &t, Number a) { return t.quotient(1, t.plus_square(1, -1, a)); }},
  };
}

std::vector<Tape::Function> Tape::exponential_functions()
{
  using T = Tape;
  return {
      {"exp", [](double a) { return std::exp(a); }, [](T &t, Number a) { return t.apply("exp", a); }},
      {"ln", [](double a) { return std::log(a); }, [](T &t, Number a) { return t.quotient(1, a); }},
      {"log", [](double a) { return std::log(a); }, [](T &t, Number a) { return t.quotient(1, a); }},
      {"log10", [](double a) { return std::log10(a); },
       [](T &t, Number a) { return t.quotient(1 / std::log(10.), a); }},
      {"log2", [](double a) { return std::log2(a); },
       [](T &t, Number a) { return t.quotient(1 / std::log(2.), a); }},
      {"sqrt", [](double a) { return std::sqrt(a); },
       [](T &t, Number a) { return t.quotient(0.5, t.apply("sqrt", a)); }},
      // the logarithm where a power with a varying exponent has a derivative
      {"ln or 0", [](double a) { return a > 0 ? std::log(a) : 0.; },
       [](T &t, Number a) { return t.quotient(1, a); }},
  };
}

/// Beside their jumps they are constant.
std::vector<Tape::Function> Tape::step_functions()
{
  const auto zero = [](Tape &tape, Number) { return tape.add_constant(0); };
  return {
      {"abs", [](double a) { return std::abs(a); },
       [](Tape &tape, Number a) { return tape.apply("sign", a); }},
      {"sign", [](double a) { return a < 0   ? -1.
                                     : a > 0 ? 1.
                                             : a; }, zero}, // 0 or NaN
      {"rint", [](double a) { return std::floor(a + 0.5); }, zero},
      {"floor", [](double a) { return std::floor(a); }, zero},
      {"ceil", [](double a) { return std::ceil(a); }, zero},
  };
}

} // namespace dovetail
