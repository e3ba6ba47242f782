// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// Values and derivatives of expressions against those known by hand.

#include <dovetail/scene/expression.h>
#include <dovetail/scene/user_error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <iostream>

using namespace dovetail;
using dealii::Point;

namespace {

void show(const std::string &formula)
{
  std::cout << formula << " = " << Expression(formula, {3, {}}).value(Point<3>(2, 3, 5), 7) << '\n';
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

  const Expression vector("x*y; t; 0", {2, {}});
  std::cout << "components " << vector.n_components() << ": " << vector.value(Point<2>(2, 3), 7, 0) << ' '
            << vector.value(Point<2>(2, 3), 7, 1) << ' ' << vector.value(Point<2>(2, 3), 7, 2) << '\n';
  std::cout << "zero: " << Expression().is_zero() << Expression(3).is_zero()
            << Expression("0; 0", {}).is_zero() << " not zero: " << Expression("0; t", {}).is_zero()
            << Expression("1", {}).is_zero() << '\n';
}

/// An operand that is no number makes comparisons and choices no number, unless another one decides alone.
void not_a_number()
{
  std::cout << "not a number:\n";
  for (const char *formula :
       {"sqrt(1 - x) < 5", "sqrt(1 - x) >= 5", "sqrt(1 - x) == 1", "sqrt(1 - x) != 1", "sqrt(-1) < 5",
        "x > 3 && sqrt(1 - x) < 5", "x > 1 && sqrt(1 - x) < 5", "sqrt(1 - x) < 5 || x > 1",
        "sqrt(1 - x) < 5 || x > 3", "sqrt(1 - x) && 1", "min(x, sqrt(1 - x))", "max(sqrt(1 - x), x)",
        "if(sqrt(1 - x) < 5, 1, 2)", "if(x > 1, 4, sqrt(1 - x))", "sign(sqrt(1 - x))"}) {
    const double value = Expression(formula, {3, {}}).value(Point<3>(2, 3, 5), 7);
    std::cout << formula << " = " << (std::isnan(value) ? "none" : value == 0 ? "0" : "not 0") << '\n';
  }
}

void dependence()
{
  std::cout << "depends on position, time, temperature:\n";
  for (const char *formula : {"2*pi", "x", "t + 1", "T^2", "y*t*T"}) {
    const Expression expression(formula, {2, {"T"}});
    std::cout << formula << ": " << expression.depends_on_position() << expression.depends_on_time()
              << expression.depends_on_scalars() << '\n';
  }
}

void derivatives()
{
  const Expression quartic("x^4 + x*y^3*t", {2, {}}); // gradient (4 x^3 + y^3 t, 3 x y^2 t)
  std::cout << "gradient " << quartic.gradient(Point<2>(2, 3), 0.5, 0, 10.) << '\n';

  const Expression in_temperature("3*T^4 - T^2", {2, {"T"}}); // 12 T^3 - 2 T and 36 T^2 - 2
  const double T = 2;
  const Expression::Scalars scalars(&T, 1);
  std::cout << "d/dT " << in_temperature.derivative(Point<2>(), 0., 0, scalars, 0) << ", d2/dT2 "
            << in_temperature.second_derivative(Point<2>(), 0., 0, scalars, 0, 0) << '\n';
  const Expression none("x", {2, {"T"}});
  std::cout << "without T " << none.derivative(Point<2>(1, 1), 0., 0, scalars, 0) << ", "
            << none.second_derivative(Point<2>(1, 1), 0., 0, scalars, 0, 0) << '\n';
}

/// Of every operation and function, against differences of the values and of the first derivatives.
void derivatives_of_functions()
{
  double largest = 0;
  for (const char *formula : {"a*b - a/b",
                              "a^b",
                              "a^3 + b^2.5",
                              "-a^2",
                              "2^a",
                              "sin(a*b)",
                              "cos(a)",
                              "tan(a)",
                              "asin(a/3)",
                              "acos(a/3)",
                              "atan(a*b)",
                              "atan2(a, b)",
                              "sinh(a)",
                              "cosh(a)",
                              "tanh(a*b)",
                              "asinh(a)",
                              "acosh(1 + a)",
                              "atanh(a/3)",
                              "exp(-a*b)",
                              "ln(a)",
                              "log(a*b)",
                              "log10(a)",
                              "log2(a + b)",
                              "sqrt(a*b)",
                              "abs(a - 3*b)",
                              "min(a, b^2, 5)",
                              "max(a, 3*a*b)",
                              "sum(a, b, a*b)",
                              "avg(a, b*b)",
                              "if(a > b, a*a, b)",
                              "a < b ? a^2 : b^3*a",
                              "pow(a, 3)",
                              "a*(a >= b || b < 0) + b*(a != b && a <= 7) + a*(a == b)",
                              "sign(a)*floor(b) + ceil(a) + rint(b)",
                              "a*table(a, 0, 1, 0.5, 4, 2, 3, 5, 2)",
                              "table(a*b, 0, 1, 1, 2, 3, 4)*b",
                              "a + _pi*_e*pi"}) {
    const Expression expression(formula, {2, {"a", "b"}});
    const double h = 1e-5;
    const auto at = [&](const unsigned int order, const double a, const double b, unsigned int i = 0) {
      const std::array<double, 2> scalars = {{a, b}};
      return order == 0 ? expression.value(Point<2>(), 0., 0, {scalars.data(), 2})
                        : expression.derivative(Point<2>(), 0., 0, {scalars.data(), 2}, i);
    };
    for (const unsigned int order : {0, 1})
      for (unsigned int i = 0; i < 1 + order; ++i)
        for (const unsigned int j : {0, 1}) {
          const double a = 0.83, b = 1.37, da = j == 0 ? h : 0, db = j == 1 ? h : 0;
          const std::array<double, 2> scalars = {{a, b}};
          const double difference = (at(order, a + da, b + db, i) - at(order, a - da, b - db, i)) / (2 * h),
                       exact = order == 0 ? at(1, a, b, j)
                                          : expression.second_derivative(Point<2>(), 0., 0,
                                                                         {scalars.data(), 2}, i, j);
          const double error = std::abs(difference - exact) / (1 + std::abs(exact));
          largest = std::max(largest, error);
          if (!(error < 1e-8))
            std::cout << formula << ": derivative " << exact << ", difference " << difference << '\n';
        }
  }
  std::cout << "derivatives of functions: " << (largest < 1e-8 ? "ok" : "wrong") << '\n';
}

void tables()
{
  const Expression table("table(T, 300, 11, 600, 15.2, 900, 19)", {2, {"T"}});
  std::cout << "table:";
  for (const double T : {0., 300., 450., 600., 750., 900., 2000.})
    std::cout << ' ' << table.value(Point<2>(), 0., 0, {&T, 1});
  std::cout << '\n';
  show_error("table(T, 300, 11, 200, 12)", {2, {"T"}});
  show_error("table(T, 300)", {2, {"T"}});
}

void copies()
{
  Expression original("x + t", {2, {}}), copy = original;
  const double before = original.value(Point<2>(1, 0), 1.);
  copy.value(Point<2>(10, 0), 10.);
  std::cout << "copies: " << before << ' ' << original.value(Point<2>(1, 0), 1.) << '\n';
  copy = Expression("4", {2, {}});
  original = std::move(copy);
  std::cout << "assigned: " << original.value(Point<2>(), 0.) << '\n';
}

void errors()
{
  show_error("1 + z", {2, {}});
  show_error("1 + z", {3, {}});
  show_error("0; sni(x)", {2, {}});
  show_error("45 - 0.02*T", {2, {}});
  show_error("t = 1", {2, {}});
  show_error("t == 1 || t != 2 || t <= 3 || t >= 4", {2, {}});
  show_error("0, 1", {2, {}});
  show_error("1; ; 2", {2, {}});
  show_error("", {2, {}});
  show_error("2*(x + 1", {2, {}});
  show_error("1 +", {2, {}});
}

} // namespace

int main()
{
  std::cout << std::setprecision(7);
  values();
  not_a_number();
  dependence();
  derivatives();
  derivatives_of_functions();
  tables();
  copies();
  errors();
}
