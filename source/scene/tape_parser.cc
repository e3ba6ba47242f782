// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "tape.h"

#include <deal.II/base/numbers.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <limits>

namespace dovetail {

/// Recursive descent with muParser's precedences: a ? b : c, ||, &&, comparisons, sums, products, signs,
/// powers, which associate to the right.
class TapeParser
{
public:
  TapeParser(Tape &tape, const std::string &text) : tape(tape), next(text.c_str()) {}

  /// The node of the whole formula.
  std::optional<unsigned int> parse()
  {
    const Number node = choice();
    skip_spaces();
    return is_known && *next == 0 ? std::optional<unsigned int>(node) : std::nullopt;
  }

private:
  using Operation = Tape::Operation;
  using Number = Tape::Number;

  void skip_spaces()
  {
    while (std::isspace(static_cast<unsigned char>(*next)))
      ++next;
  }

  bool take(const char *token)
  {
    skip_spaces();
    if (!is_known || std::strncmp(next, token, std::strlen(token)) != 0)
      return false;
    next += std::strlen(token);
    return true;
  }

  Number fail()
  {
    is_known = false;
    return 0;
  }

  Number constant(const double value) { return tape.add_constant(value); }
  Number binary(const Operation operation, const Number first, const Number second)
  {
    return is_known ? tape.combine(operation, first, second) : 0;
  }
  Number choose(const Number condition, const Number then, const Number otherwise)
  {
    return is_known ? tape.choose(condition, then, otherwise) : 0;
  }
  Number negation(const Number condition) { return choose(condition, constant(0), constant(1)); }

  Number choice()
  {
    const Number condition = disjunction();
    if (!take("?"))
      return condition;
    const Number then = choice();
    return take(":") ? choose(condition, then, choice()) : fail();
  }

  Number disjunction()
  {
    Number left = conjunction();
    while (take("||"))
      left = binary(Operation::either, left, conjunction());
    return left;
  }

  Number conjunction()
  {
    Number left = comparison();
    while (take("&&"))
      left = binary(Operation::both, left, comparison());
    return left;
  }

  Number comparison()
  {
    Number left = sum();
    while (is_known)
      if (take("<="))
        left = binary(Operation::not_greater, left, sum());
      else if (take(">=")) {
        const Number right = sum();
        left = binary(Operation::not_greater, right, left);
      } else if (take("=="))
        left = binary(Operation::equal, left, sum());
      else if (take("!="))
        left = negation(binary(Operation::equal, left, sum()));
      else if (take("<"))
        left = binary(Operation::less, left, sum());
      else if (take(">")) {
        const Number right = sum();
        left = binary(Operation::less, right, left);
      } else
        break;
    return left;
  }

  Number sum()
  {
    Number left = product();
    while (is_known)
      if (take("+"))
        left = binary(Operation::sum, left, product());
      else if (take("-"))
        left = binary(Operation::difference, left, product());
      else
        break;
    return left;
  }

  Number product()
  {
    Number left = with_sign();
    while (is_known)
      if (take("*"))
        left = binary(Operation::product, left, with_sign());
      else if (take("/"))
        left = binary(Operation::quotient, left, with_sign());
      else
        break;
    return left;
  }

  Number with_sign()
  {
    if (take("-"))
      return binary(Operation::product, constant(-1), with_sign());
    if (take("+"))
      return with_sign();
    const Number base = primary();
    return take("^") ? binary(Operation::power, base, with_sign()) : base;
  }

  Number primary()
  {
    skip_spaces();
    if (take("(")) {
      const Number inside = choice();
      return take(")") ? inside : fail();
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
    return take("(") ? function(name) : variable(name);
  }

  Number variable(const std::string &name)
  {
    if (name == "pi" || name == "_pi")
      return constant(dealii::numbers::PI);
    if (name == "_e")
      return constant(dealii::numbers::E);
    if (name == "inf")
      return constant(std::numeric_limits<double>::infinity());
    const auto position = std::find(tape.names.begin(), tape.names.end(), name);
    if (position == tape.names.end())
      return fail();
    Tape::Node node;
    node.operation = Operation::variable;
    node.first = position - tape.names.begin();
    return tape.add_node(node);
  }

  Number function(const std::string &name)
  {
    std::vector<Number> arguments;
    do
      arguments.push_back(choice());
    while (take(","));
    if (!take(")"))
      return fail();
    for (const Tape::Function &known : Tape::functions())
      if (name == known.name && arguments.size() == 1)
        return tape.apply(known, arguments[0]);
    if (name == "table")
      return table(arguments);
    if (name == "if" && arguments.size() == 3)
      return choose(arguments[0], arguments[1], arguments[2]);
    if (name == "pow" && arguments.size() == 2)
      return binary(Operation::power, arguments[0], arguments[1]);
    if (name == "atan2" && arguments.size() == 2)
      return binary(Operation::angle, arguments[0], arguments[1]);
    return reduction(name, arguments);
  }

  /// Of any number of arguments.
  Number reduction(const std::string &name, const std::vector<Number> &arguments)
  {
    if (name != "min" && name != "max" && name != "sum" && name != "avg")
      return fail();
    Number result = arguments[0];
    for (std::size_t i = 1; i < arguments.size(); ++i)
      if (name == "min")
        result = choose(binary(Operation::less, arguments[i], result), arguments[i], result);
      else if (name == "max")
        result = choose(binary(Operation::less, result, arguments[i]), arguments[i], result);
      else
        result = binary(Operation::sum, result, arguments[i]);
    return name == "avg" ? binary(Operation::quotient, result, constant(arguments.size())) : result;
  }

  /// table(argument, x_1, y_1, x_2, y_2, …)
  Number table(const std::vector<Number> &arguments)
  {
    std::vector<double> x, y;
    for (std::size_t i = 1; i < arguments.size(); ++i) {
      const Tape::Node &node = tape.nodes[arguments[i]];
      if (node.operation != Operation::constant)
        return fail();
      (i % 2 == 1 ? x : y).push_back(node.constant);
    }
    if (!MonotoneCubic::why_invalid(x, y).empty())
      return fail();
    return tape.interpolate(std::make_shared<const MonotoneCubic>(x, y), 0, arguments[0]);
  }

  Tape &tape;
  const char *next;
  bool is_known = true;
};

std::optional<unsigned int> Tape::add(const std::string &formula)
{
  const auto node = TapeParser(*this, formula).parse();
  return node ? std::optional(add_formula(*node)) : std::nullopt;
}

} // namespace dovetail
