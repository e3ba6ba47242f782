// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/expression.h>
#include <dovetail/scene/user_error.h>

#include "tape.h"

#include <deal.II/base/numbers.h>
#include <deal.II/base/utilities.h>

#include <muParser.h>

#include <cmath>
#include <limits>

namespace dovetail {

using dealii::Point;
using dealii::Tensor;

struct Expression::Implementation
{
  struct Component
  {
    std::unique_ptr<mu::Parser> parser; ///< empty if the component is constant
    double constant = 0.;
    std::optional<unsigned int> on_tape; ///< if the tape knows all of the formula, its number there
  };

  Implementation(const std::string &text, Variables variables);

  Component compile(const std::string &formula);
  void define_names(mu::Parser &parser);
  void note_used_variables(const mu::Parser &parser);
  std::optional<unsigned int> put_on_tape(const mu::Parser &parser, const std::string &formula);
  const std::vector<double> &variables(); ///< for the tape
  template <int dim>
  void set_points(const std::vector<Point<dim>> &X, double t);
  std::string known_variables() const;

  std::string text;
  Variables known;
  std::vector<Component> components;
  bool uses_position = false, uses_time = false, uses_temperature = false;

  // The variables the parsers point at; hence copies compile their own parsers.
  std::array<double, 3> position{};
  double time = 0., temperature = 0.;

  Tape tape{{"x", "y", "z", "t", "T"}};
  std::vector<double> for_tape = std::vector<double>(5);
};

namespace {

const std::array<const char *, 3> coordinate_names = {{"x", "y", "z"}};

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

[[noreturn]] void fail(const std::string &formula, const std::string &message)
{
  throw UserError("has an error in '" + formula + "': " + dealii::Utilities::trim(message));
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

Expression::Implementation::Implementation(const std::string &text, const Variables variables)
    : text(text), known(variables)
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
  component.parser = std::make_unique<mu::Parser>();
  define_names(*component.parser);
  try {
    component.parser->SetExpr(formula);
    component.constant = component.parser->Eval();
    if (component.parser->GetNumResults() > 1)
      fail(formula, "a formula is one number; components are separated by ';', decimals by '.'.");
    note_used_variables(*component.parser);
    if (component.parser->GetUsedVar().empty())
      component.parser.reset();
    else
      component.on_tape = put_on_tape(*component.parser, formula);
  } catch (const mu::Parser::exception_type &error) {
    fail(formula, explain(*component.parser, error, known_variables(), known.dim > 2));
  }
  return component;
}

void Expression::Implementation::define_names(mu::Parser &parser)
{
  for (unsigned int d = 0; d < known.dim; ++d)
    parser.DefineVar(coordinate_names[d], &position[d]);
  parser.DefineVar("t", &time);
  if (known.with_temperature)
    parser.DefineVar("T", &temperature);

  parser.DefineConst("pi", dealii::numbers::PI);
  parser.DefineConst("inf", std::numeric_limits<double>::infinity());
  parser.DefineFun("if", if_then_else);
  parser.DefineFun("log", natural_logarithm);
  parser.DefineFun("ln", natural_logarithm);
  parser.DefineFun("pow", power);
  parser.DefineFun("floor", round_down);
  parser.DefineFun("ceil", round_up);
}

void Expression::Implementation::note_used_variables(const mu::Parser &parser)
{
  for (const auto &variable : parser.GetUsedVar())
    if (variable.first == "t")
      uses_time = true;
    else if (variable.first == "T")
      uses_temperature = true;
    else
      uses_position = true;
}

const std::vector<double> &Expression::Implementation::variables()
{
  for_tape.resize(5);
  std::copy(position.begin(), position.end(), for_tape.begin());
  for_tape[3] = time;
  for_tape[4] = temperature;
  return for_tape;
}

/// muParser says what a formula means: the tape takes part only if the two agree.
std::optional<unsigned int> Expression::Implementation::put_on_tape(const mu::Parser &parser,
                                                                    const std::string &formula)
{
  auto on_tape = tape.add(formula);
  for (const double sample : {0.37, 1.9, -0.43})
    if (on_tape) {
      position = {{sample, 0.7 - sample, 1.1 * sample}};
      time = 1.7 * sample;
      temperature = 0.9 + sample;
      const double expected = parser.Eval(), value = *tape.values(*on_tape, variables(), 1);
      const bool agrees = std::isfinite(expected)
                              ? std::abs(value - expected) <= 1e-10 * std::abs(expected) + 1e-14
                              : !std::isfinite(value);
      if (!agrees)
        on_tape.reset();
    }
  return on_tape;
}

std::string Expression::Implementation::known_variables() const
{
  std::vector<std::string> names(coordinate_names.begin(), coordinate_names.begin() + known.dim);
  names.push_back("t");
  if (known.with_temperature)
    names.push_back("T");
  return comma_separated(names);
}

Expression::Expression() : Expression(1) {}

Expression::Expression(const unsigned int n_components) : Expression("0", Variables())
{
  implementation->components.resize(n_components);
  for (unsigned int c = 1; c < n_components; ++c)
    implementation->text += "; 0";
}

Expression::Expression(const std::string &text, const Variables variables)
    : implementation(std::make_unique<Implementation>(text, variables))
{
}

Expression::Expression(const Expression &other)
    : Expression(other.implementation->text, other.implementation->known)
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
bool Expression::depends_on_temperature() const
{
  return implementation->uses_temperature;
}

bool Expression::is_zero() const
{
  for (const auto &component : implementation->components)
    if (component.parser || component.constant != 0.)
      return false;
  return true;
}

template <int dim>
double Expression::value(const Point<dim> &X, const double t, const unsigned int component,
                         const double T) const
{
  AssertIndexRange(component, n_components());
  const auto &formula = implementation->components[component];
  if (!formula.parser)
    return formula.constant;

  for (unsigned int d = 0; d < dim; ++d)
    implementation->position[d] = X[d];
  implementation->time = t;
  implementation->temperature = T;
  return formula.on_tape ? *implementation->tape.values(*formula.on_tape, implementation->variables(), 1)
                         : formula.parser->Eval();
}

template <int dim>
void Expression::Implementation::set_points(const std::vector<Point<dim>> &X, const double t)
{
  const unsigned int n = X.size();
  for_tape.resize(5 * n);
  for (unsigned int d = 0; d < 3; ++d)
    for (unsigned int i = 0; i < n; ++i)
      for_tape[d * n + i] = d < dim ? X[i][d] : 0;
  std::fill_n(for_tape.begin() + 3 * n, n, t);
  std::fill_n(for_tape.begin() + 4 * n, n, 0.);
}

template <int dim>
void Expression::values(const std::vector<Point<dim>> &X, const double t, const unsigned int component,
                        std::vector<double> &result) const
{
  result.resize(X.size());
  if (const auto on_tape = implementation->components[component].on_tape) {
    implementation->set_points(X, t);
    std::copy_n(implementation->tape.values(*on_tape, implementation->for_tape, X.size()), X.size(),
                result.begin());
  } else
    for (unsigned int i = 0; i < X.size(); ++i)
      result[i] = value(X[i], t, component);
}

template <int dim>
void Expression::gradients(const std::vector<Point<dim>> &X, const double t, const unsigned int component,
                           const double length, std::vector<Tensor<1, dim>> &result) const
{
  result.assign(X.size(), Tensor<1, dim>());
  const auto on_tape = implementation->components[component].on_tape;
  if (on_tape) {
    implementation->set_points(X, t);
    for (unsigned int d = 0; d < dim; ++d)
      if (const double *derivative =
              implementation->tape.derivatives(*on_tape, d, implementation->for_tape, X.size()))
        for (unsigned int i = 0; i < X.size(); ++i)
          result[i][d] = derivative[i];
  }
  for (unsigned int i = 0; i < X.size(); ++i)
    if (!on_tape || !std::isfinite(result[i].norm_square()))
      result[i] = gradient(X[i], t, component, length);
}

template <int dim>
Tensor<1, dim> Expression::gradient(const Point<dim> &X, const double t, const unsigned int component,
                                    const double length) const
{
  Tensor<1, dim> gradient;
  if (!depends_on_position() || !implementation->components[component].parser)
    return gradient;

  if (const auto on_tape = implementation->components[component].on_tape) {
    value(X, t, component);
    for (unsigned int d = 0; d < dim; ++d) {
      const double *derivative =
          implementation->tape.derivatives(*on_tape, d, implementation->variables(), 1);
      gradient[d] = derivative == nullptr ? 0 : *derivative;
    }
    if (std::isfinite(gradient.norm_square()))
      return gradient;
  }

  const double h = 1e-3 * length;
  for (unsigned int d = 0; d < dim; ++d) {
    const auto shifted = [&](const double steps) {
      return value(X + steps * h * Point<dim>::unit_vector(d), t, component);
    };
    gradient[d] = (8. * (shifted(1) - shifted(-1)) - (shifted(2) - shifted(-2))) / (12. * h);
  }
  return gradient;
}

template <int dim>
std::array<double, 2> Expression::temperature_derivatives(const Point<dim> &X, const double t,
                                                          const unsigned int component, const double T) const
{
  if (!depends_on_temperature())
    return {{0., 0.}};

  const double h = 1e-3 * std::abs(T) + 1e-4;
  const auto shifted = [&](const double steps) { return value(X, t, component, T + steps * h); };
  const double near_difference = shifted(1) - shifted(-1), far_difference = shifted(2) - shifted(-2);
  const double near_sum = shifted(1) + shifted(-1), far_sum = shifted(2) + shifted(-2);
  return {{(8. * near_difference - far_difference) / (12. * h),
           (16. * near_sum - far_sum - 30. * shifted(0)) / (12. * h * h)}};
}

template double Expression::value(const Point<1> &, double, unsigned int, double) const;
template double Expression::value(const Point<2> &, double, unsigned int, double) const;
template double Expression::value(const Point<3> &, double, unsigned int, double) const;
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
template std::array<double, 2> Expression::temperature_derivatives(const Point<1> &, double, unsigned int,
                                                                   double) const;
template std::array<double, 2> Expression::temperature_derivatives(const Point<2> &, double, unsigned int,
                                                                   double) const;
template std::array<double, 2> Expression::temperature_derivatives(const Point<3> &, double, unsigned int,
                                                                   double) const;

} // namespace dovetail
