// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// Values and derivatives of expressions against those known by hand.

#include <dovetail/scene/expression.h>
#include <dovetail/scene/user_error.h>

#include <iomanip>
#include <iostream>

using namespace dovetail;
using dealii::Point;

namespace {

void show(const std::string &formula)
{
  std::cout << formula << " = " << Expression(formula, {3, false}).value(Point<3>(2, 3, 5), 7) << '\n';
}

void show_error(const std::string &formula, const Expression::Variables variables)
{
  try {
    Expression(formula, variables);
    std::cout << formula << ": no error\n";
  } catch (const UserError &error) {
    std::cout << error.what() << '\n';
  }
}

void values()
{
  std::cout << "x = 2, y = 3, z = 5, t = 7\n";
  for (const char *formula :
       {"x + 10*y + 100*z + 1000*t", "-2^2", "2^3^2", "sin(pi/6)", "log(exp(2))", "ln(exp(3))", "log10(1000)",
        "if(x > 1, 4, 5)", "t >= 7 && t < 8", "x > 2 || y > 3", "x == 2 ? 8 : 9", "min(x, y, z)", "max(x, y)",
        "abs(-x)", "sign(-y)", "floor(-1.5)", "ceil(1.5)", "pow(x, y)", "1e-3*x"})
    show(formula);

  const Expression vector("x*y; t; 0", {2, false});
  std::cout << "components " << vector.n_components() << ": " << vector.value(Point<2>(2, 3), 7, 0) << ' '
            << vector.value(Point<2>(2, 3), 7, 1) << ' ' << vector.value(Point<2>(2, 3), 7, 2) << '\n';
  std::cout << "zero: " << Expression().is_zero() << Expression(3).is_zero()
            << Expression("0; 0", {}).is_zero() << " not zero: " << Expression("0; t", {}).is_zero()
            << Expression("1", {}).is_zero() << '\n';
}

void dependence()
{
  std::cout << "depends on position, time, temperature:\n";
  for (const char *formula : {"2*pi", "x", "t + 1", "T^2", "y*t*T"}) {
    const Expression expression(formula, {2, true});
    std::cout << formula << ": " << expression.depends_on_position() << expression.depends_on_time()
              << expression.depends_on_temperature() << '\n';
  }
}

void derivatives()
{
  const Expression quartic("x^4 + x*y^3*t", {2, false}); // gradient (4 x^3 + y^3 t, 3 x y^2 t)
  std::cout << "gradient " << quartic.gradient(Point<2>(2, 3), 0.5, 0, 10.) << '\n';

  const Expression in_temperature("3*T^4 - T^2", {2, true}); // 12 T^3 - 2 T and 36 T^2 - 2
  const auto [first, second] = in_temperature.temperature_derivatives(Point<2>(), 0., 0, 2.);
  std::cout << "d/dT " << first << ", d2/dT2 " << second << '\n';
  const auto none = Expression("x", {2, true}).temperature_derivatives(Point<2>(1, 1), 0., 0, 2.);
  std::cout << "without T " << none[0] << ", " << none[1] << '\n';
}

void copies()
{
  Expression original("x + t", {2, false}), copy = original;
  const double before = original.value(Point<2>(1, 0), 1.);
  copy.value(Point<2>(10, 0), 10.);
  std::cout << "copies: " << before << ' ' << original.value(Point<2>(1, 0), 1.) << '\n';
  copy = Expression("4", {2, false});
  original = std::move(copy);
  std::cout << "assigned: " << original.value(Point<2>(), 0.) << '\n';
}

void errors()
{
  show_error("1 + z", {2, false});
  show_error("1 + z", {3, false});
  show_error("0; sni(x)", {2, false});
  show_error("45 - 0.02*T", {2, false});
  show_error("t = 1", {2, false});
  show_error("t == 1 || t != 2 || t <= 3 || t >= 4", {2, false});
  show_error("0, 1", {2, false});
  show_error("1; ; 2", {2, false});
  show_error("", {2, false});
  show_error("2*(x + 1", {2, false});
  show_error("1 +", {2, false});
}

} // namespace

int main()
{
  std::cout << std::setprecision(7);
  values();
  dependence();
  derivatives();
  copies();
  errors();
}
