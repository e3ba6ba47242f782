// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Formulas as a list of operations, for speed.

#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace dovetail {

/// Several formulas in common variables as one list of operations, each of which stands there once: what
/// formulas share (sin(pi*x) in all components of a force) is computed once per point, and a function whose
/// argument is that of the point before (points of a tensor product share coordinates) is not computed again.
/// Gradients are exact, by forward differentiation.
///
/// It knows numbers, variables, pi, + - * / ^, unary signs, parentheses, and functions smooth where they are
/// defined: sin, cos, tan, exp, ln, log, sqrt, sinh, cosh, tanh, pow. Everything else is muParser's.
class Tape
{
public:
  /// @param names of the variables, in the order of their values
  explicit Tape(std::vector<std::string> names) : names(std::move(names)) {}

  /// @return the number of the formula's result, or nothing if it holds something the tape does not know.
  std::optional<unsigned int> add(const std::string &formula);

  /// At the given variables, which are compared with those of the call before.
  double value(unsigned int result, const std::vector<double> &variables);
  /// By the first three variables.
  std::array<double, 3> gradient(unsigned int result, const std::vector<double> &variables);

private:
  friend class TapeParser;
  /// slope: the derivative of function(@p of), which stands there already: cos for sin
  enum class Operation { constant, variable, sum, difference, product, quotient, power, function, slope };
  enum class Function { none, sine, tangent, exponential, logarithm, root, sinh, cosh, tanh };
  struct Node
  {
    Operation operation;
    Function function;
    unsigned int first, second; ///< numbers of nodes before this one, or of a variable
    double constant;
    double argument, slope; ///< of a function: those of its present value
  };

  unsigned int find_or_add(Operation operation, unsigned int first, unsigned int second = 0,
                           double constant = 0, Function function = Function::none);
  void move_to(const std::vector<double> &variables);
  void evaluate(Node &node, double &value);
  void differentiate(const Node &node, const double value, std::array<double, 3> &gradient) const;

  std::vector<std::string> names;
  std::vector<Node> nodes;
  std::vector<unsigned int> results;
  std::vector<double> present, values;
  std::vector<std::array<double, 3>> gradients;
  unsigned int n_values = 0, n_gradients = 0; ///< so many nodes are up to date
};

} // namespace dovetail
