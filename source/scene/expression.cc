// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/expression.h>
#include <dovetail/scene/user_error.h>

#include "tape.h"

#include <deal.II/base/numbers.h>
#include <deal.II/base/utilities.h>

#include <muParser.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <regex>

namespace dovetail {

using dealii::Point;
using dealii::Tensor;

struct Expression::Implementation
{
  struct Component
  {
    std::optional<double> constant; ///< if it uses no variable
    unsigned int number = 0;        ///< on the tape
  };

  Implementation(const std::string &text, const Variables &variables);

  Component compile(const std::string &formula);
  void define_names(mu::Parser &parser);
  void note_used_variables(const mu::Parser &parser);
  unsigned int add_to_tape(const std::string &formula, const mu::Parser &parser);
  template <int dim>
  void set_point(const Point<dim> &X, double t, Scalars scalars);
  template <int dim>
  void set_points(const std::vector<Point<dim>> &X, double t);
  double derivative(unsigned int component, unsigned int variable);

  unsigned int n_components() const { return components.size(); }
  static std::vector<std::string> names(const Variables &variables);
  /// Of a scalar, on the tape.
  static unsigned int variable(const unsigned int scalar) { return first_scalar + scalar; }
  static constexpr unsigned int time = 3, first_scalar = 4;

  Variables known;
  std::vector<Component> components;
  bool uses_position = false, uses_time = false;
  std::vector<bool> uses_scalar;
  Tape tape;
  std::vector<double> for_tape; ///< the values of its variables
};

namespace {

const std::array<const char *, 3> coordinate_names = {{"x", "y", "z"}};

// What muParser has under no name, for it to check formulas: their values come from the tape.
double if_then_else(double condition, double then, double otherwise)
{
  return condition != 0. ? then : otherwise;
}
double natural_logarithm(double x)
{
  return std::log(x);
}
double power(double base, double exponent)
{
  return std::pow(base, exponent);
}
double round_down(double x)
{
  return std::floor(x);
}
double round_up(double x)
{
  return std::ceil(x);
}
double table(const double *, int)
{
  return 1;
}

[[noreturn]] void fail(const std::string &formula, const std::string &message)
{
  throw UserError("has an error in '" + formula + "': " + dealii::Utilities::trim(message));
}

/// In figures, which nobody can misunderstand. Most formulas of a scene are one.
bool is_plain_number(const std::string &formula)
{
  if (formula.find_first_not_of("0123456789.-") == 0) // inf and nan are no figures
    return false;
  double value = 0;
  const auto [end, error] = std::from_chars(formula.data(), formula.data() + formula.size(), value);
  return error == std::errc() && end == formula.data() + formula.size();
}

/// muParser can assign to variables; "t = 1" would then be a condition that is always true.
void check_no_assignment(const std::string &formula)
{
  for (std::size_t i = 0; i < formula.size(); ++i) {
    if (formula[i] != '=')
      continue;
    const bool follows_comparison = i > 0 && std::string("<>!=").find(formula[i - 1]) != std::string::npos;
    if (!follows_comparison && (i + 1 == formula.size() || formula[i + 1] != '='))
      fail(formula, "'=' cannot be used in a formula; equality is written '=='.");
  }
}

std::string explain(const mu::Parser &parser, const mu::Parser::exception_type &error,
                    const std::string &variables, const bool has_z)
{
  if (error.GetCode() != mu::ecUNASSIGNABLE_TOKEN)
    return error.GetMsg();

  std::vector<std::string> functions;
  for (const auto &function : parser.GetFunDef())
    functions.push_back(function.first);
  const std::string token = dealii::Utilities::trim(error.GetToken());
  if (token[0] == '&' || token[0] == '|')
    return "'" + token.substr(0, 1) + "' is not known; 'and' is written '&&', 'or' is written '||'.";
  std::string message = "'" + token + "' is not known";
  if (token == "z" && !has_z)
    message += " in two dimensions";
  return message + "; the variables are " + variables + ". " + did_you_mean(token, functions);
}

} // namespace

std::vector<std::string> Expression::Implementation::names(const Variables &variables)
{
  std::vector<std::string> all(coordinate_names.begin(), coordinate_names.end());
  all.push_back("t");
  all.insert(all.end(), variables.scalars.begin(), variables.scalars.end());
  return all;
}

Expression::Implementation::Implementation(const std::string &text, const Variables &variables)
    : known(variables), uses_scalar(variables.scalars.size(), false), tape(names(variables))
{
  std::size_t begin = 0, end;
  do {
    end = text.find(';', begin);
    components.push_back(compile(dealii::Utilities::trim(text.substr(begin, end - begin))));
    begin = end + 1;
  } while (end != std::string::npos);
}

Expression::Implementation::Component Expression::Implementation::compile(const std::string &formula)
{
  if (formula.empty())
    throw UserError("has an empty component (components are separated by ';').");
  check_no_assignment(formula);

  Component component;
  for_tape.assign(first_scalar + known.scalars.size(), 0.);
  if (is_plain_number(formula))
    if (const auto number = tape.add(formula)) { // muParser, which takes a while to begin, would say the same
      component.number = *number;
      component.constant = *tape.values(*number, for_tape, 1);
      return component;
    }
  mu::Parser parser;
  define_names(parser);
  try {
    parser.SetExpr(formula);
    parser.Eval();
    if (parser.GetNumResults() > 1)
      fail(formula, "a formula is one number; components are separated by ';', decimals by '.'.");
    note_used_variables(parser);
    component.number = add_to_tape(formula, parser);
    if (parser.GetUsedVar().empty()) {
      for_tape.assign(first_scalar + known.scalars.size(), 0.);
      component.constant = *tape.values(component.number, for_tape, 1);
    }
  } catch (const mu::Parser::exception_type &error) {
    std::vector<std::string> variables = names(known);
    variables.erase(variables.begin() + known.dim, variables.begin() + time);
    fail(formula, explain(parser, error, comma_separated(variables), known.dim > 2));
  }
  return component;
}

void Expression::Implementation::define_names(mu::Parser &parser)
{
  for (unsigned int d = 0; d < known.dim; ++d)
    parser.DefineVar(coordinate_names[d], &for_tape[d]);
  parser.DefineVar("t", &for_tape[time]);
  for (unsigned int i = 0; i < known.scalars.size(); ++i)
    parser.DefineVar(known.scalars[i], &for_tape[variable(i)]);

  parser.DefineConst("pi", dealii::numbers::PI);
  parser.DefineConst("inf", std::numeric_limits<double>::infinity());
  parser.DefineFun("if", if_then_else);
  parser.DefineFun("log", natural_logarithm);
  parser.DefineFun("ln", natural_logarithm);
  parser.DefineFun("pow", power);
  parser.DefineFun("floor", round_down);
  parser.DefineFun("ceil", round_up);
  parser.DefineFun("table", table);
}

void Expression::Implementation::note_used_variables(const mu::Parser &parser)
{
  const std::vector<std::string> all = names(known);
  for (const auto &[name, address] : parser.GetUsedVar()) {
    const unsigned int number = std::find(all.begin(), all.end(), name) - all.begin();
    uses_position = uses_position || number < time;
    uses_time = uses_time || number == time;
    if (number >= first_scalar)
      uses_scalar[number - first_scalar] = true;
  }
}

/// muParser says what a formula means: the tape must agree, or say that an operand is no number, which
/// muParser's comparisons do not see.
unsigned int Expression::Implementation::add_to_tape(const std::string &formula, const mu::Parser &parser)
{
  const auto number = tape.add(formula);
  static const std::regex table("(^|[^A-Za-z0-9_])table\\s*\\(");
  const bool has_table = std::regex_search(formula, table);
  if (!number && has_table)
    fail(formula,
         "a table needs an argument and pairs of numbers, the first of which grow from pair to pair, as in "
         "table(T, 300, 11, 900, 19).");
  if (!number)
    fail(formula, "this formula cannot be evaluated.");
  for (const double sample : {0.37, 1.9, -0.43}) {
    if (has_table)
      break;
    for (unsigned int i = 0; i < for_tape.size(); ++i)
      for_tape[i] = i == 1 ? 0.7 - sample : i == 2 ? 1.1 * sample : i == time ? 1.7 * sample : sample;
    for (unsigned int i = 0; i < known.scalars.size(); ++i)
      for_tape[variable(i)] = 0.9 + 0.17 * i + sample;
    const double expected = parser.Eval(), value = *tape.values(*number, for_tape, 1);
    const bool agrees = std::isfinite(expected) && !std::isnan(value)
                            ? std::abs(value - expected) <= 1e-10 * std::abs(expected) + 1e-14
                            : !std::isfinite(value);
    if (!agrees)
      fail(formula, "two evaluators disagree about its meaning; please add parentheses.");
  }
  return *number;
}

std::vector<std::string> Expression::names_of_functions()
{
  std::vector<std::string> names;
  mu::Parser parser;
  Expression().implementation->define_names(parser);
  for (const auto &function : parser.GetFunDef())
    names.push_back(function.first);
  return names;
}

const std::vector<std::pair<std::string, std::string>> &Expression::functions()
{
  static const std::vector<std::pair<std::string, std::string>> all = {
      {"+, -, *, /, ^", "as usual; ^ associates to the right, and -x^2 is -(x^2)"},
      {"<, <=, >, >=, ==, !=", "1 where it holds, else 0; not a number where an operand is none"},
      {"&&, ||", "and, or"},
      {"a ? b : c", "b where a is not 0, else c"},
      {"if(a, b, c)", "the same"},
      {"table(a, x_1, y_1, x_2, y_2, ...)", "the monotone cubic through the pairs (Fritsch, Carlson 1980; "
                                            "Fritsch, Butland 1984), constant outside; "
                                            "the x grow"},
      {"table(a, file.csv)", "the same with the pairs from a file of two columns, separated by commas, "
                             "semicolons or blanks; the first "
                             "line may be a heading, # begins a comment"},
      {"min(a, ...), max(a, ...)", "smallest and largest of any number of arguments"},
      {"sum(a, ...), avg(a, ...)", "sum and mean of any number of arguments"},
      {"abs(a), sign(a)", "magnitude; -1, 0 or 1"},
      {"rint(a), floor(a), ceil(a)", "the nearest, next lower and next higher whole number"},
      {"sqrt(a), pow(a, b)", "square root; a to the power of b"},
      {"exp(a), ln(a), log(a)", "exponential; natural logarithm (both names)"},
      {"log2(a), log10(a)", "logarithms to the bases 2 and 10"},
      {"sin(a), cos(a), tan(a)", "of an angle in radians"},
      {"asin(a), acos(a), atan(a), atan2(a, b)", "in radians; atan2 is the angle of the point (b, a)"},
      {"sinh(a), cosh(a), tanh(a), asinh(a), acosh(a), atanh(a)", "hyperbolic functions and their inverses"},
      {"pi, _pi, _e, inf", "3.14159..., 2.71828..., infinity"}};
  return all;
}

Expression::Expression() : Expression(1) {}

Expression::Expression(const unsigned int n_components) : Expression("0", Variables())
{
  implementation->components.resize(n_components, implementation->components[0]);
}

Expression::Expression(const std::string &text, const Variables &variables)
    : implementation(std::make_unique<Implementation>(text, variables))
{
}

Expression::Expression(const Expression &other)
    : implementation(std::make_unique<Implementation>(*other.implementation))
{
}

Expression &Expression::operator=(const Expression &other)
{
  return *this = Expression(other);
}

Expression::Expression(Expression &&) noexcept = default;
Expression &Expression::operator=(Expression &&) noexcept = default;
Expression::~Expression() = default;

unsigned int Expression::n_components() const
{
  return implementation->components.size();
}
bool Expression::depends_on_position() const
{
  return implementation->uses_position;
}
bool Expression::depends_on_time() const
{
  return implementation->uses_time;
}
bool Expression::depends_on_scalars() const
{
  const auto &uses = implementation->uses_scalar;
  return std::find(uses.begin(), uses.end(), true) != uses.end();
}
bool Expression::depends_on_scalar(const unsigned int scalar) const
{
  return implementation->uses_scalar[scalar];
}

bool Expression::is_affine_in_scalars() const
{
  Tape &tape = implementation->tape;
  for (const auto &component : implementation->components)
    for (unsigned int i = 0; i < implementation->known.scalars.size(); ++i)
      for (unsigned int j = 0; j < implementation->known.scalars.size(); ++j)
        if (tape.depends(tape.differentiate(component.number, Implementation::variable(i)),
                         Implementation::variable(j)))
          return false;
  return true;
}

bool Expression::is_zero() const
{
  for (unsigned int c = 0; c < n_components(); ++c)
    if (!is_zero(c))
      return false;
  return true;
}

bool Expression::is_zero(const unsigned int component) const
{
  return implementation->components[component].constant == 0.;
}

template <int dim>
void Expression::Implementation::set_point(const Point<dim> &X, const double t, const Scalars scalars)
{
  for_tape.resize(first_scalar + known.scalars.size());
  for (unsigned int d = 0; d < 3; ++d)
    for_tape[d] = d < dim ? X[d] : 0;
  for_tape[time] = t;
  AssertThrow(scalars.size() == 0 || scalars.size() >= known.scalars.size(), dealii::ExcInternalError());
  for (unsigned int i = 0; i < known.scalars.size(); ++i)
    for_tape[variable(i)] = scalars.size() == 0 ? 0 : scalars[i];
}

template <int dim>
double Expression::value(const Point<dim> &X, const double t, const unsigned int component,
                         const Scalars scalars) const
{
  AssertIndexRange(component, n_components());
  const auto &formula = implementation->components[component];
  if (formula.constant)
    return *formula.constant;
  implementation->set_point(X, t, scalars);
  return *implementation->tape.values(formula.number, implementation->for_tape, 1);
}

/// At the points that are set.
double Expression::Implementation::derivative(const unsigned int component, const unsigned int variable)
{
  return *tape.values(tape.differentiate(components[component].number, variable), for_tape, 1);
}

template <int dim>
double Expression::derivative(const Point<dim> &X, const double t, const unsigned int component,
                              const Scalars scalars, const unsigned int scalar) const
{
  if (!depends_on_scalar(scalar))
    return 0;
  implementation->set_point(X, t, scalars);
  return implementation->derivative(component, Implementation::variable(scalar));
}

template <int dim>
double Expression::second_derivative(const Point<dim> &X, const double t, const unsigned int component,
                                     const Scalars scalars, const unsigned int first,
                                     const unsigned int second) const
{
  if (!depends_on_scalar(first) || !depends_on_scalar(second))
    return 0;
  implementation->set_point(X, t, scalars);
  Tape &tape = implementation->tape;
  const unsigned int slope =
      tape.differentiate(implementation->components[component].number, Implementation::variable(first));
  return *tape.values(tape.differentiate(slope, Implementation::variable(second)), implementation->for_tape,
                      1);
}

template <int dim>
double Expression::derivative(const Point<dim> &X, const double t, const unsigned int component,
                              const Scalars scalars, const std::vector<unsigned int> &by_scalars) const
{
  implementation->set_point(X, t, scalars);
  Tape &tape = implementation->tape;
  unsigned int formula = implementation->components[component].number;
  for (const unsigned int scalar : by_scalars)
    formula = tape.differentiate(formula, Implementation::variable(scalar));
  return *tape.values(formula, implementation->for_tape, 1);
}

template <int dim>
void Expression::Implementation::set_points(const std::vector<Point<dim>> &X, const double t)
{
  const unsigned int n = X.size();
  for_tape.resize((first_scalar + known.scalars.size()) * n);
  for (unsigned int d = 0; d < dim; ++d)
    for (unsigned int i = 0; i < n; ++i)
      for_tape[d * n + i] = X[i][d];
  std::fill(for_tape.begin() + dim * n, for_tape.end(), 0.);
  std::fill_n(for_tape.begin() + time * n, n, t);
}

template <int dim>
void Expression::values(const std::vector<Point<dim>> &X, const double t, const unsigned int component,
                        std::vector<double> &result) const
{
  const auto &formula = implementation->components[component];
  if (formula.constant) {
    result.assign(X.size(), *formula.constant);
    return;
  }
  result.resize(X.size());
  implementation->set_points(X, t);
  std::copy_n(implementation->tape.values(formula.number, implementation->for_tape, X.size()), X.size(),
              result.begin());
}

template <int dim>
void Expression::gradients(const std::vector<Point<dim>> &X, const double t, const unsigned int component,
                           const double length, std::vector<Tensor<1, dim>> &result) const
{
  result.assign(X.size(), Tensor<1, dim>());
  if (implementation->components[component].constant)
    return;
  Tape &tape = implementation->tape;
  implementation->set_points(X, t);
  for (unsigned int d = 0; d < dim; ++d) {
    const unsigned int slope = tape.differentiate(implementation->components[component].number, d);
    const double *values = tape.values(slope, implementation->for_tape, X.size());
    for (unsigned int i = 0; i < X.size(); ++i)
      result[i][d] = values[i];
  }
  for (unsigned int i = 0; i < X.size(); ++i)
    if (!std::isfinite(result[i].norm_square()))
      result[i] = gradient(X[i], t, component, length);
}

template <int dim>
Tensor<1, dim> Expression::gradient(const Point<dim> &X, const double t, const unsigned int component,
                                    const double length) const
{
  Tensor<1, dim> gradient;
  if (!depends_on_position() || implementation->components[component].constant)
    return gradient;

  implementation->set_point(X, t, {});
  for (unsigned int d = 0; d < dim; ++d)
    gradient[d] = implementation->derivative(component, d);
  if (std::isfinite(gradient.norm_square()))
    return gradient;

  const double h = 1e-3 * length;
  for (unsigned int d = 0; d < dim; ++d) {
    const auto shifted = [&](const double steps) {
      return value(X + steps * h * Point<dim>::unit_vector(d), t, component);
    };
    gradient[d] = (8. * (shifted(1) - shifted(-1)) - (shifted(2) - shifted(-2))) / (12. * h);
  }
  return gradient;
}

template double Expression::value(const Point<1> &, double, unsigned int, Scalars) const;
template double Expression::value(const Point<2> &, double, unsigned int, Scalars) const;
template double Expression::value(const Point<3> &, double, unsigned int, Scalars) const;
template Tensor<1, 1> Expression::gradient(const Point<1> &, double, unsigned int, double) const;
template Tensor<1, 2> Expression::gradient(const Point<2> &, double, unsigned int, double) const;
template Tensor<1, 3> Expression::gradient(const Point<3> &, double, unsigned int, double) const;
template void Expression::values(const std::vector<Point<1>> &, double, unsigned int,
                                 std::vector<double> &) const;
template void Expression::gradients(const std::vector<Point<1>> &, double, unsigned int, double,
                                    std::vector<Tensor<1, 1>> &) const;
template void Expression::values(const std::vector<Point<2>> &, double, unsigned int,
                                 std::vector<double> &) const;
template void Expression::gradients(const std::vector<Point<2>> &, double, unsigned int, double,
                                    std::vector<Tensor<1, 2>> &) const;
template void Expression::values(const std::vector<Point<3>> &, double, unsigned int,
                                 std::vector<double> &) const;
template void Expression::gradients(const std::vector<Point<3>> &, double, unsigned int, double,
                                    std::vector<Tensor<1, 3>> &) const;
template double Expression::derivative(const Point<1> &, double, unsigned int, Scalars, unsigned int) const;
template double Expression::derivative(const Point<2> &, double, unsigned int, Scalars, unsigned int) const;
template double Expression::derivative(const Point<3> &, double, unsigned int, Scalars, unsigned int) const;
template double Expression::second_derivative(const Point<1> &, double, unsigned int, Scalars, unsigned int,
                                              unsigned int) const;
template double Expression::second_derivative(const Point<2> &, double, unsigned int, Scalars, unsigned int,
                                              unsigned int) const;
template double Expression::second_derivative(const Point<3> &, double, unsigned int, Scalars, unsigned int,
                                              unsigned int) const;
template double Expression::derivative(const Point<2> &, double, unsigned int, Scalars,
                                       const std::vector<unsigned int> &) const;
template double Expression::derivative(const Point<3> &, double, unsigned int, Scalars,
                                       const std::vector<unsigned int> &) const;

} // namespace dovetail
