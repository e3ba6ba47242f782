// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The evaluator of formulas: values at many points, and exact derivatives of any order.

#pragma once

#include <dovetail/scene/monotone_cubic.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dovetail {

/// Several formulas in common variables as one list of operations, each of which stands there once: what
/// formulas share (sin(pi*x) in all components of a force) is computed once per point, and a function whose
/// argument it had lately (points of a tensor product share coordinates) is not computed again.
///
/// A derivative is a formula as well: differentiate() appends its operations to the list, so derivatives of
/// any order are exact. Functions with jumps (sign, floor, comparisons) have the derivative 0 beside them.
///
/// It knows muParser's grammar, operators and functions, and `table(argument, x_1, y_1, x_2, y_2, …)`: the
/// monotone cubic through the pairs (Fritsch and Carlson 1980), constant outside.
class Tape
{
public:
  /// @param names of the variables, in the order of their values
  explicit Tape(std::vector<std::string> names) : names(std::move(names)) {}

  /// @return the number of the formula, or nothing if it does not parse.
  std::optional<unsigned int> add(const std::string &formula);
  /// The number of d(formula)/d(variable), the same whenever it is asked for.
  unsigned int differentiate(unsigned int formula, unsigned int variable);

  bool depends(const unsigned int formula, const unsigned int variable) const
  {
    return nodes[formulas[formula].node].depends[variable];
  }
  /// A table of the formulas: the formula of its argument, and the first and last argument that it has.
  struct Table
  {
    unsigned int argument;
    double first, last;
  };
  /// Those whose argument depends on @p variable and on no other one.
  std::vector<Table> tables_in(unsigned int variable);

  /// Its value if it is a number, whatever the variables.
  std::optional<double> constant(unsigned int formula) const;

  /// At @p n_points points, whose variables stand one variable after another: [variable][point]. They are
  /// compared with those of the call before. @return [point]
  const double *values(unsigned int formula, const std::vector<double> &variables, unsigned int n_points);

private:
  friend class TapeParser;
  enum class Operation {
    constant,
    variable,
    sum,
    difference,
    product,
    quotient,
    power,
    angle, ///< atan2
    less,  ///< this and the next four are 1 where they hold, else 0, and NaN where NaN leaves that open
    not_greater,
    equal,
    both,
    either,
    function,
    choice ///< first ? second : third
  };
  using Number = unsigned int; ///< of a node; operands come before their operation

  /// A function of one argument a: its value, and its derivative f'(a) as a node.
  struct Function
  {
    const char *name;
    double (*value)(double);
    Number (*slope)(Tape &tape, Number a);
  };

  /// What a function was last at an argument.
  struct Known
  {
    double argument, value;
  };

  struct Node
  {
    Operation operation = Operation::constant;
    Number first = 0, second = 0, third = 0; ///< operands; of a variable its number
    double constant = 0;                     ///< of a table: the order of the derivative
    const Function *function = nullptr;
    std::shared_ptr<const MonotoneCubic> table; ///< that the function interpolates in
    std::vector<bool> depends;                  ///< on each variable
    std::vector<Known> known;                   ///< of a function, at a place that the argument tells
    unsigned long evaluation = 0;               ///< the last one that it took part in
  };

  struct Formula
  {
    Number node;
    std::vector<Number> needed;                           ///< operations in the order of their evaluation
    std::vector<std::optional<unsigned int>> derivatives; ///< numbers of formulas, by variable
  };

  static constexpr unsigned int log2_of_n_known = 5;
  /// Among what is known: from the bits of the argument, mixed by the golden ratio (Knuth 1973, section 6.4).
  static std::size_t place_of(const double argument)
  {
    std::uint64_t bits;
    std::memcpy(&bits, &argument, sizeof bits);
    return (bits * 0x9E3779B97F4A7C15u) >> (64 - log2_of_n_known);
  }

  unsigned int add_formula(Number node);
  Number add_node(Node node);
  Number add_constant(double value);
  Number combine(Operation operation, Number first, Number second);
  Number apply(const Function &function, Number argument);
  Number apply(const std::string &function, Number argument);
  Number choose(Number condition, Number then, Number otherwise);
  Number interpolate(const std::shared_ptr<const MonotoneCubic> &table, unsigned int order, Number argument);
  Number plus(Number first, Number second);
  Number minus(Number first, Number second);
  Number times(Number first, Number second);
  Number derivative(Number node, unsigned int variable, std::vector<std::optional<Number>> &known);
  Number derivative_of_power(Number node, unsigned int variable, std::vector<std::optional<Number>> &known);
  bool is_constant(Number node, double value) const;
  static double value_of(Operation operation, double first, double second);
  void set_variables(const std::vector<double> &variables, unsigned int n_points);
  void evaluate(Number node);
  void evaluate_function(Node &node, const double *arguments, double *values);
  const double *values_of(const Number node) const { return numbers.data() + std::size_t(node) * n; }

  static const std::vector<Function> &functions();
  static std::vector<Function> trigonometric_functions();
  static std::vector<Function> hyperbolic_functions();
  static std::vector<Function> exponential_functions();
  static std::vector<Function> step_functions();
  /// factor / b, with a number above.
  Number quotient(double factor, Number b) { return combine(Operation::quotient, add_constant(factor), b); }
  /// c + factor a²
  Number plus_square(double c, double factor, Number a)
  {
    return plus(add_constant(c), times(add_constant(factor), times(a, a)));
  }

  std::vector<std::string> names;
  std::vector<Node> nodes;
  std::vector<Formula> formulas;
  std::vector<double> present;        ///< variables
  std::vector<double> numbers;        ///< [node][point]
  std::vector<Number> variable_nodes; ///< of these numbers
  unsigned int n = 0;                 ///< points
  unsigned long evaluation = 0;       ///< number of different sets of points so far
};

} // namespace dovetail
