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
  const auto nodes_before = nodes;
  const auto node = TapeParser(*this, formula).parse();
  if (!node)
    nodes = nodes_before;
  else
    results.push_back(*node);
  present.clear();
  for (Node &each : nodes)
    each.argument = std::nan("");
  values.resize(nodes.size());
  gradients.resize(nodes.size());
  return node ? std::optional<unsigned int>(results.size() - 1) : std::nullopt;
}

unsigned int Tape::find_or_add(const Operation operation, const unsigned int first, const unsigned int second,
                               const double constant, const Function function)
{
  const auto is_constant = [this](const unsigned int node) {
    return nodes[node].operation == Operation::constant;
  };
  Node node = {operation, function, first, second, constant, std::nan(""), 0};
  const bool is_binary = operation != Operation::constant && operation != Operation::variable &&
                         operation != Operation::function && operation != Operation::slope;
  if (is_binary && is_constant(first) && is_constant(second)) { // 2*pi
    values.assign(nodes.size(), 0.);
    for (const unsigned int of : {first, second})
      values[of] = nodes[of].constant;
    double value = 0;
    evaluate(node, value);
    return find_or_add(Operation::constant, 0, 0, value);
  }
  for (unsigned int i = 0; i < nodes.size(); ++i)
    if (nodes[i].operation == operation && nodes[i].function == function && nodes[i].first == first &&
        nodes[i].second == second && nodes[i].constant == constant)
      return i;
  nodes.push_back(node);
  return nodes.size() - 1;
}

void Tape::move_to(const std::vector<double> &variables)
{
  if (variables != present) {
    present = variables;
    n_values = n_gradients = 0;
  }
}

double Tape::value(const unsigned int result, const std::vector<double> &variables)
{
  move_to(variables);
  for (; n_values <= results[result]; ++n_values)
    evaluate(nodes[n_values], values[n_values]);
  return values[results[result]];
}

std::array<double, 3> Tape::gradient(const unsigned int result, const std::vector<double> &variables)
{
  value(result, variables);
  for (; n_gradients <= results[result]; ++n_gradients)
    differentiate(nodes[n_gradients], values[n_gradients], gradients[n_gradients]);
  return gradients[results[result]];
}

void Tape::evaluate(Node &node, double &value)
{
  const double a =
      node.operation == Operation::constant || node.operation == Operation::variable ? 0 : values[node.first];
  switch (node.operation) {
  case Operation::constant:
    value = node.constant;
    return;
  case Operation::variable:
    value = present[node.first];
    return;
  case Operation::sum:
    value = a + values[node.second];
    return;
  case Operation::difference:
    value = a - values[node.second];
    return;
  case Operation::product:
    value = a * values[node.second];
    return;
  case Operation::quotient:
    value = a / values[node.second];
    return;
  case Operation::power:
    value = values[node.second] == 2 ? a * a : std::pow(a, values[node.second]);
    return;
  case Operation::slope:
    value = nodes[node.first].slope;
    return;
  case Operation::function:
    break;
  }
  if (a == node.argument)
    return; // value and slope are right
  node.argument = a;
  switch (node.function) {
  case Function::none:
    break;
  case Function::sine:
    value = std::sin(a); // the compiler makes one call of both
    node.slope = std::cos(a);
    break;
  case Function::tangent:
    value = std::tan(a);
    node.slope = 1 + value * value;
    break;
  case Function::exponential:
    value = node.slope = std::exp(a);
    break;
  case Function::logarithm:
    value = std::log(a);
    node.slope = 1 / a;
    break;
  case Function::root:
    value = std::sqrt(a);
    node.slope = 0.5 / value;
    break;
  case Function::sinh:
    value = std::sinh(a);
    node.slope = std::cosh(a);
    break;
  case Function::cosh:
    value = std::cosh(a);
    node.slope = std::sinh(a);
    break;
  case Function::tanh:
    value = std::tanh(a);
    node.slope = 1 - value * value;
    break;
  }
}

void Tape::differentiate(const Node &node, const double value, std::array<double, 3> &gradient) const
{
  const auto combine = [&](const double by_first, const double by_second) {
    for (unsigned int d = 0; d < 3; ++d)
      gradient[d] = by_first * gradients[node.first][d] + by_second * gradients[node.second][d];
  };
  const auto chain = [&](const double slope, const unsigned int argument) {
    for (unsigned int d = 0; d < 3; ++d)
      gradient[d] = slope * gradients[argument][d];
  };
  switch (node.operation) {
  case Operation::constant:
    gradient = {};
    return;
  case Operation::variable:
    gradient = {};
    if (node.first < 3)
      gradient[node.first] = 1;
    return;
  case Operation::sum:
    return combine(1, 1);
  case Operation::difference:
    return combine(1, -1);
  case Operation::product:
    return combine(values[node.second], values[node.first]);
  case Operation::quotient:
    return combine(1 / values[node.second], -value / values[node.second]);
  case Operation::power: {
    const double base = values[node.first], exponent = values[node.second];
    const double by_base = exponent == 0 ? 0 : exponent * std::pow(base, exponent - 1);
    if (nodes[node.second].operation == Operation::constant)
      return chain(by_base, node.first);
    return combine(by_base, base > 0 ? value * std::log(base) : 0);
  }
  case Operation::function:
    return chain(node.slope, node.first);
  case Operation::slope: // of a sine
    return chain(-values[node.first], nodes[node.first].first);
  }
}

} // namespace dovetail
