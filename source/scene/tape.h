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

  /// At @p n_points points, whose variables stand one variable after another: [variable][point]. They are
  /// compared with those of the call before. @return [point]
  const double *values(unsigned int result, const std::vector<double> &variables, unsigned int n_points);
  /// By one of the first three variables. @return [point], or nullptr if the result does not depend on it.
  const double *derivatives(unsigned int result, unsigned int variable, const std::vector<double> &variables,
                            unsigned int n_points);

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
    bool depends[3] = {false, false, false};         ///< on the first three variables
    double last_argument, last_value, last_slope;    ///< of a function, where it was evaluated last
    std::vector<double> values, slopes, gradient[3]; ///< [point]
  };

  unsigned int find_or_add(Operation operation, unsigned int first, unsigned int second = 0,
                           double constant = 0, Function function = Function::none);
  static double combine(Operation operation, double first, double second);
  void evaluate(Node &node);
  void evaluate_function(Node &node, const std::vector<double> &arguments);
  void differentiate(Node &node);

  std::vector<std::string> names;
  std::vector<Node> nodes;
  std::vector<unsigned int> results;
  std::vector<double> present, by_first, by_second;
  unsigned int n = 0;                         ///< points
  unsigned int n_values = 0, n_gradients = 0; ///< so many nodes are up to date
};

} // namespace dovetail
