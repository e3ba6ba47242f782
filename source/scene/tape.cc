// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "tape.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace dovetail {

std::optional<double> Tape::constant(const unsigned int formula) const
{
  const Node &node = nodes[formulas[formula].node];
  return node.operation == Operation::constant ? std::optional(node.constant) : std::nullopt;
}

std::vector<Tape::Table> Tape::tables_in(const unsigned int variable)
{
  std::vector<Table> tables;
  for (Number i = 0; i < nodes.size(); ++i) {
    const std::vector<bool> depends = nodes[i].depends; // on the argument's variables
    if (nodes[i].table && nodes[i].constant == 0 && depends[variable] &&
        std::count(depends.begin(), depends.end(), true) == 1)
      tables.push_back({add_formula(nodes[i].first), nodes[i].table->first(), nodes[i].table->last()});
  }
  return tables;
}

unsigned int Tape::add_formula(const Number node)
{
  Formula formula;
  formula.node = node;
  formula.derivatives.resize(names.size());
  std::vector<bool> is_needed(node + 1, false);
  is_needed[node] = true;
  for (Number i = node + 1; i-- > 0;)
    if (is_needed[i] && nodes[i].operation > Operation::variable)
      for (const Number operand : {nodes[i].first, nodes[i].second, nodes[i].third})
        is_needed[operand] = true;
  for (Number i = 0; i <= node; ++i)
    if (is_needed[i] && nodes[i].operation > Operation::variable)
      formula.needed.push_back(i);
  formulas.push_back(formula);
  return formulas.size() - 1;
}

// ---- operations ----

bool Tape::is_constant(const Number node, const double value) const
{
  return nodes[node].operation == Operation::constant && nodes[node].constant == value;
}

double Tape::value_of(const Operation operation, const double first, const double second)
{
  constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
  switch (operation) {
  case Operation::sum:
    return first + second;
  case Operation::difference:
    return first - second;
  case Operation::product:
    return first * second;
  case Operation::quotient:
    return first / second;
  case Operation::power:
    return second == 2 ? first * first : std::pow(first, second);
  case Operation::angle:
    return std::atan2(first, second);
  case Operation::less:
    return std::isunordered(first, second) ? not_a_number : first < second ? 1 : 0;
  case Operation::not_greater:
    return std::isunordered(first, second) ? not_a_number : first <= second ? 1 : 0;
  case Operation::equal:
    return std::isunordered(first, second) ? not_a_number : first == second ? 1 : 0;
  case Operation::both: // what one operand decides does not ask the other: x > 0 && ln(x) < 1
    return first == 0 || second == 0 ? 0 : std::isunordered(first, second) ? not_a_number : 1;
  default:
    return (first != 0 && !std::isnan(first)) || (second != 0 && !std::isnan(second)) ? 1
           : std::isunordered(first, second)                                          ? not_a_number
                                                                                      : 0;
  }
}

/// The node that stands there already, if there is one.
Tape::Number Tape::add_node(Node node)
{
  const auto same = std::find_if(nodes.begin(), nodes.end(), [&](const Node &other) {
    return other.operation == node.operation && other.first == node.first && other.second == node.second &&
           other.third == node.third && other.constant == node.constant && other.function == node.function &&
           other.table == node.table;
  });
  if (same != nodes.end())
    return same - nodes.begin();

  node.depends.assign(names.size(), false);
  if (node.operation == Operation::variable)
    node.depends[node.first] = true;
  else if (node.operation != Operation::constant)
    for (const Number operand : {node.first, node.second, node.third})
      for (unsigned int v = 0; v < names.size(); ++v)
        node.depends[v] = node.depends[v] || nodes[operand].depends[v];
  if (node.operation == Operation::function)
    node.known.assign(1u << log2_of_n_known, {std::nan(""), 0.});
  nodes.push_back(node);
  return nodes.size() - 1;
}

Tape::Number Tape::add_constant(const double value)
{
  Node node;
  node.constant = value;
  return add_node(node);
}

Tape::Number Tape::combine(const Operation operation, const Number first, const Number second)
{
  if (nodes[first].operation == Operation::constant && nodes[second].operation == Operation::constant) // 2*pi
    return add_constant(value_of(operation, nodes[first].constant, nodes[second].constant));
  Node node;
  node.operation = operation;
  node.first = node.third = first;
  node.second = second;
  return add_node(node);
}

Tape::Number Tape::apply(const Function &function, const Number argument)
{
  if (nodes[argument].operation == Operation::constant)
    return add_constant(function.value(nodes[argument].constant));
  Node node;
  node.operation = Operation::function;
  node.first = node.second = node.third = argument;
  node.function = &function;
  return add_node(node);
}

Tape::Number Tape::apply(const std::string &name, const Number argument)
{
  return apply(*std::find_if(functions().begin(), functions().end(),
                             [&](const Function &function) { return function.name == name; }),
               argument);
}

Tape::Number Tape::choose(const Number condition, const Number then, const Number otherwise)
{
  if (nodes[condition].operation == Operation::constant)
    return std::isnan(nodes[condition].constant) ? condition
           : nodes[condition].constant != 0      ? then
                                                 : otherwise;
  if (then == otherwise)
    return then;
  Node node;
  node.operation = Operation::choice;
  node.first = condition;
  node.second = then;
  node.third = otherwise;
  return add_node(node);
}

Tape::Number Tape::interpolate(const std::shared_ptr<const MonotoneCubic> &table, const unsigned int order,
                               const Number argument)
{
  Node node;
  node.operation = Operation::function;
  node.first = node.second = node.third = argument;
  node.table = table;
  node.constant = order;
  return add_node(node);
}

// Sums and products of derivatives, most of which are 0 or 1.
Tape::Number Tape::plus(const Number first, const Number second)
{
  return is_constant(first, 0)    ? second
         : is_constant(second, 0) ? first
                                  : combine(Operation::sum, first, second);
}

Tape::Number Tape::minus(const Number first, const Number second)
{
  return is_constant(second, 0)  ? first
         : is_constant(first, 0) ? times(add_constant(-1), second)
                                 : combine(Operation::difference, first, second);
}

Tape::Number Tape::times(const Number first, const Number second)
{
  return is_constant(first, 0) || is_constant(second, 0) ? add_constant(0)
         : is_constant(first, 1)                         ? second
         : is_constant(second, 1)                        ? first
                                                         : combine(Operation::product, first, second);
}

// ---- derivatives ----

unsigned int Tape::differentiate(const unsigned int formula, const unsigned int variable)
{
  if (!formulas[formula].derivatives[variable]) {
    std::vector<std::optional<Number>> known(nodes.size());
    const unsigned int result = add_formula(derivative(formulas[formula].node, variable, known));
    formulas[formula].derivatives[variable] = result;
  }
  return *formulas[formula].derivatives[variable];
}

/// @p known holds the derivatives that have been found already.
Tape::Number Tape::derivative(const Number number, const unsigned int variable,
                              std::vector<std::optional<Number>> &known)
{
  if (known[number])
    return *known[number];
  const Node node = nodes[number]; // a copy: nodes are appended below
  const auto of = [&](const Number operand) { return derivative(operand, variable, known); };
  Number result = add_constant(0);
  if (node.depends[variable])
    switch (node.operation) {
    case Operation::variable:
      result = add_constant(1);
      break;
    case Operation::sum:
      result = plus(of(node.first), of(node.second));
      break;
    case Operation::difference:
      result = minus(of(node.first), of(node.second));
      break;
    case Operation::product:
      result = plus(times(of(node.first), node.second), times(node.first, of(node.second)));
      break;
    case Operation::quotient: // (a' - q b')/b
      result =
          combine(Operation::quotient, minus(of(node.first), times(number, of(node.second))), node.second);
      break;
    case Operation::power:
      result = derivative_of_power(number, variable, known);
      break;
    case Operation::function:
      result = times(node.table ? interpolate(node.table, std::lround(node.constant) + 1, node.first)
                                : node.function->slope(*this, node.first),
                     of(node.first));
      break;
    case Operation::choice:
      result = choose(node.first, of(node.second), of(node.third));
      break;
    case Operation::angle: { // (x y' - y x')/(x² + y²)
      const Number y = node.first, x = node.second;
      const Number change = minus(times(x, of(y)), times(y, of(x)));
      result = combine(Operation::quotient, change, plus(times(x, x), times(y, y)));
      break;
    }
    default: // conditions are constant beside their jumps
      break;
    }
  known[number] = result;
  return result;
}

/// a^b: b a^(b-1) a' + a^b ln(a) b'
Tape::Number Tape::derivative_of_power(const Number number, const unsigned int variable,
                                       std::vector<std::optional<Number>> &known)
{
  const Number a = nodes[number].first, b = nodes[number].second;
  const Number reduced = is_constant(b, 2)   ? a
                         : is_constant(b, 1) ? add_constant(1)
                                             : combine(Operation::power, a, minus(b, add_constant(1)));
  const Number by_base = times(times(b, reduced), derivative(a, variable, known));
  return plus(by_base, times(times(number, apply("ln or 0", a)), derivative(b, variable, known)));
}

// ---- values ----

const double *Tape::values(const unsigned int formula, const std::vector<double> &variables,
                           const unsigned int n_points)
{
  if (n != n_points || numbers.size() != nodes.size() * n_points || variables.size() != present.size() ||
      std::memcmp(variables.data(), present.data(), variables.size() * sizeof(double)) != 0)
    set_variables(variables, n_points);
  for (const Number i : formulas[formula].needed)
    if (nodes[i].evaluation != evaluation) {
      evaluate(i);
      nodes[i].evaluation = evaluation;
    }
  return values_of(formulas[formula].node);
}

void Tape::set_variables(const std::vector<double> &variables, const unsigned int n_points)
{
  ++evaluation;
  present = variables;
  if (n != n_points || numbers.size() != nodes.size() * n_points) {
    n = n_points;
    numbers.resize(nodes.size() * n);
    variable_nodes.clear();
    for (Number i = 0; i < nodes.size(); ++i)
      if (nodes[i].operation == Operation::constant)
        std::fill_n(numbers.begin() + i * n, n, nodes[i].constant);
      else if (nodes[i].operation == Operation::variable)
        variable_nodes.push_back(i);
  }
  for (const Number i : variable_nodes)
    std::copy_n(present.begin() + nodes[i].first * n, n, numbers.begin() + i * n);
}

void Tape::evaluate(const Number number)
{
  Node &node = nodes[number];
  double *const __restrict__ value = numbers.data() + number * n;
  const double *const a = values_of(node.first), *const b = values_of(node.second),
                      *const c = values_of(node.third);
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
  case Operation::function:
    evaluate_function(node, a, value);
    break;
  case Operation::choice:
    for (unsigned int i = 0; i < n; ++i)
      value[i] = std::isnan(a[i]) ? a[i] : a[i] != 0 ? b[i] : c[i];
    break;
  default:
    for (unsigned int i = 0; i < n; ++i)
      value[i] = value_of(node.operation, a[i], b[i]);
  }
}

void Tape::evaluate_function(Node &node, const double *const arguments, double *const values)
{
  for (unsigned int i = 0; i < n; ++i) {
    Known &known = node.known[place_of(arguments[i])];
    if (known.argument != arguments[i])
      known = {arguments[i], node.table ? node.table->derivative(std::lround(node.constant), arguments[i])
                                        : node.function->value(arguments[i])};
    values[i] = known.value;
  }
}

} // namespace dovetail
