// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "tape.h"

#include <deal.II/base/numbers.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>

namespace dovetail {

/// Recursive descent with muParser's precedences: signs bind less than powers, powers associate to the right.
class TapeParser
{
public:
  TapeParser(Tape &tape, const std::string &text) : tape(tape), next(text.c_str()) {}

  /// The node of the whole formula.
  std::optional<unsigned int> parse()
  {
    const unsigned int node = sum();
    skip_spaces();
    return is_known && *next == 0 ? std::optional<unsigned int>(node) : std::nullopt;
  }

private:
  using Operation = Tape::Operation;
  using Function = Tape::Function;

  void skip_spaces()
  {
    while (std::isspace(static_cast<unsigned char>(*next)))
      ++next;
  }

  bool take(const char character)
  {
    skip_spaces();
    if (*next != character)
      return false;
    ++next;
    return true;
  }

  unsigned int fail()
  {
    is_known = false;
    return 0;
  }

  unsigned int constant(const double value) { return tape.find_or_add(Operation::constant, 0, 0, value); }

  unsigned int binary(const Operation operation, const unsigned int first, const unsigned int second)
  {
    return is_known ? tape.find_or_add(operation, first, second) : 0;
  }

  unsigned int sum()
  {
    unsigned int left = product();
    while (is_known)
      if (take('+'))
        left = binary(Operation::sum, left, product());
      else if (take('-'))
        left = binary(Operation::difference, left, product());
      else
        break;
    return left;
  }

  unsigned int product()
  {
    unsigned int left = with_sign();
    while (is_known)
      if (take('*'))
        left = binary(Operation::product, left, with_sign());
      else if (take('/'))
        left = binary(Operation::quotient, left, with_sign());
      else
        break;
    return left;
  }

  unsigned int with_sign()
  {
    if (take('-'))
      return binary(Operation::product, constant(-1), with_sign());
    if (take('+'))
      return with_sign();
    const unsigned int base = primary();
    return is_known && take('^') ? binary(Operation::power, base, with_sign()) : base;
  }

  unsigned int primary()
  {
    skip_spaces();
    if (take('(')) {
      const unsigned int inside = sum();
      return take(')') ? inside : fail();
    }
    if (std::isdigit(static_cast<unsigned char>(*next)) || *next == '.') {
      char *end = nullptr;
      const double value = std::strtod(next, &end);
      if (end == next)
        return fail();
      next = end;
      return constant(value);
    }
    std::string name;
    while (std::isalnum(static_cast<unsigned char>(*next)) || *next == '_')
      name += *next++;
    return take('(') ? function(name) : variable(name);
  }

  unsigned int variable(const std::string &name)
  {
    if (name == "pi")
      return constant(dealii::numbers::PI);
    const auto position = std::find(tape.names.begin(), tape.names.end(), name);
    return position == tape.names.end()
               ? fail()
               : tape.find_or_add(Operation::variable, position - tape.names.begin());
  }

  unsigned int function(const std::string &name)
  {
    const unsigned int argument = sum();
    if (name == "pow" && is_known && take(',')) {
      const unsigned int exponent = sum();
      return take(')') ? binary(Operation::power, argument, exponent) : fail();
    }
    static const std::vector<std::pair<const char *, Function>> functions = {
        {"sin", Function::sine},      {"tan", Function::tangent},  {"exp", Function::exponential},
        {"log", Function::logarithm}, {"ln", Function::logarithm}, {"sqrt", Function::root},
        {"sinh", Function::sinh},     {"cosh", Function::cosh},    {"tanh", Function::tanh}};
    if (!is_known || !take(')'))
      return fail();
    if (name == "cos")
      return tape.find_or_add(Operation::slope,
                              tape.find_or_add(Operation::function, argument, 0, 0, Function::sine));
    for (const auto &[known, which] : functions)
      if (name == known)
        return tape.find_or_add(Operation::function, argument, 0, 0, which);
    return fail();
  }

  Tape &tape;
  const char *next;
  bool is_known = true;
};

std::optional<unsigned int> Tape::add(const std::string &formula)
{
  const unsigned int n_before = nodes.size();
  const auto node = TapeParser(*this, formula).parse();
  present.clear();
  if (!node) {
    nodes.resize(n_before);
    return {};
  }
  results.push_back(*node);
  return results.size() - 1;
}

double Tape::combine(const Operation operation, const double first, const double second)
{
  switch (operation) {
  case Operation::sum:
    return first + second;
  case Operation::difference:
    return first - second;
  case Operation::product:
    return first * second;
  case Operation::quotient:
    return first / second;
  default:
    return second == 2 ? first * first : std::pow(first, second);
  }
}

unsigned int Tape::find_or_add(const Operation operation, const unsigned int first, const unsigned int second,
                               const double constant, const Function function)
{
  const bool is_leaf = operation == Operation::constant || operation == Operation::variable;
  const bool is_binary = !is_leaf && operation != Operation::function && operation != Operation::slope;
  if (is_binary && nodes[first].operation == Operation::constant &&
      nodes[second].operation == Operation::constant) // 2*pi
    return find_or_add(Operation::constant, 0, 0,
                       combine(operation, nodes[first].constant, nodes[second].constant));
  for (unsigned int i = 0; i < nodes.size(); ++i)
    if (nodes[i].operation == operation && nodes[i].function == function && nodes[i].first == first &&
        nodes[i].second == second && nodes[i].constant == constant)
      return i;

  Node node;
  node.operation = operation;
  node.function = function;
  node.first = first;
  node.second = second;
  node.constant = constant;
  node.last_argument = std::nan("");
  for (unsigned int d = 0; d < 3; ++d)
    node.depends[d] = is_leaf ? operation == Operation::variable && first == d
                              : nodes[first].depends[d] || (is_binary && nodes[second].depends[d]);
  nodes.push_back(node);
  return nodes.size() - 1;
}

const double *Tape::values(const unsigned int result, const std::vector<double> &variables,
                           const unsigned int n_points)
{
  if (n != n_points || variables != present) {
    present = variables;
    n = n_points;
    n_values = n_gradients = 0;
  }
  for (; n_values <= results[result]; ++n_values)
    evaluate(nodes[n_values]);
  return nodes[results[result]].values.data();
}

const double *Tape::derivatives(const unsigned int result, const unsigned int variable,
                                const std::vector<double> &variables, const unsigned int n_points)
{
  values(result, variables, n_points);
  for (; n_gradients <= results[result]; ++n_gradients)
    differentiate(nodes[n_gradients]);
  const Node &node = nodes[results[result]];
  return node.depends[variable] ? node.gradient[variable].data() : nullptr;
}

void Tape::evaluate(Node &node)
{
  node.values.resize(n);
  double *const value = node.values.data();
  if (node.operation == Operation::constant) {
    std::fill(value, value + n, node.constant);
    return;
  }
  if (node.operation == Operation::variable) {
    std::copy_n(present.begin() + node.first * n, n, value);
    return;
  }
  if (node.operation == Operation::slope) {
    node.values = nodes[node.first].slopes;
    return;
  }
  if (node.operation == Operation::function) {
    evaluate_function(node, nodes[node.first].values);
    return;
  }
  const double *const a = nodes[node.first].values.data(), *const b = nodes[node.second].values.data();
  switch (node.operation) { // loops that the compiler vectorises
  case Operation::sum:
    for (unsigned int i = 0; i < n; ++i)
      value[i] = a[i] + b[i];
    break;
  case Operation::difference:
    for (unsigned int i = 0; i < n; ++i)
      value[i] = a[i] - b[i];
    break;
  case Operation::product:
    for (unsigned int i = 0; i < n; ++i)
      value[i] = a[i] * b[i];
    break;
  default:
    for (unsigned int i = 0; i < n; ++i)
      value[i] = combine(node.operation, a[i], b[i]);
  }
}

void Tape::evaluate_function(Node &node, const std::vector<double> &arguments)
{
  node.slopes.resize(n);
  double &value = node.last_value, &slope = node.last_slope;
  for (unsigned int i = 0; i < n; ++i) {
    const double a = arguments[i];
    if (a != node.last_argument) {
      node.last_argument = a;
      switch (node.function) {
      case Function::none:
        break;
      case Function::sine:
        value = std::sin(a); // the compiler makes one call of both
        slope = std::cos(a);
        break;
      case Function::tangent:
        value = std::tan(a);
        slope = 1 + value * value;
        break;
      case Function::exponential:
        value = slope = std::exp(a);
        break;
      case Function::logarithm:
        value = std::log(a);
        slope = 1 / a;
        break;
      case Function::root:
        value = std::sqrt(a);
        slope = 0.5 / value;
        break;
      case Function::sinh:
        value = std::sinh(a);
        slope = std::cosh(a);
        break;
      case Function::cosh:
        value = std::cosh(a);
        slope = std::sinh(a);
        break;
      case Function::tanh:
        value = std::tanh(a);
        slope = 1 - value * value;
        break;
      }
    }
    node.values[i] = value;
    node.slopes[i] = slope;
  }
}

/// The derivatives by the operands, then the chain rule.
void Tape::differentiate(Node &node)
{
  if (!node.depends[0] && !node.depends[1] && !node.depends[2])
    return;
  if (node.operation == Operation::variable) {
    node.gradient[node.first].assign(n, 1.);
    return;
  }
  const bool is_slope = node.operation == Operation::slope; // of a sine: the argument is the sine's
  const bool is_unary = is_slope || node.operation == Operation::function;
  const Node &first = nodes[is_slope ? nodes[node.first].first : node.first],
             &second = nodes[is_unary ? 0 : node.second];
  by_first.resize(n);
  by_second.resize(n);
  for (unsigned int i = 0; i < n; ++i) {
    const double a = first.values[i], b = is_unary ? 0 : second.values[i], value = node.values[i];
    switch (node.operation) {
    case Operation::sum:
    case Operation::difference:
      by_first[i] = 1;
      by_second[i] = node.operation == Operation::sum ? 1 : -1;
      break;
    case Operation::product:
      by_first[i] = b;
      by_second[i] = a;
      break;
    case Operation::quotient:
      by_first[i] = 1 / b;
      by_second[i] = -value / b;
      break;
    case Operation::power:
      by_first[i] = b == 2 ? 2 * a : b == 0 ? 0 : b * std::pow(a, b - 1);
      by_second[i] = a > 0 && second.operation != Operation::constant ? value * std::log(a) : 0;
      break;
    case Operation::function:
      by_first[i] = node.slopes[i];
      break;
    default:
      by_first[i] = -nodes[node.first].values[i];
    }
  }
  for (unsigned int d = 0; d < 3; ++d) {
    if (!node.depends[d])
      continue;
    node.gradient[d].assign(n, 0.);
    double *const result = node.gradient[d].data();
    if (first.depends[d])
      for (unsigned int i = 0; i < n; ++i)
        result[i] += by_first[i] * first.gradient[d][i];
    if (!is_unary && second.depends[d])
      for (unsigned int i = 0; i < n; ++i)
        result[i] += by_second[i] * second.gradient[d][i];
  }
}

} // namespace dovetail
