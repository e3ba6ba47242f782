// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Several equations for the components of a vector at one node.

#pragma once

#include <dovetail/domain/constraint_lines.h>

#include <deal.II/base/tensor.h>

#include <array>
#include <vector>

namespace dovetail {

/// Equations N.B = g at a node, solved for as many components as there are independent ones (Gauss-Jordan;
/// each for the component with the largest factor).
template <int dim>
class NodeEquations
{
public:
  /// Begins with what conditions have prescribed of the node's unknowns in @p lines; if they have other lines
  /// (a hanging node), the node takes no equations.
  NodeEquations(const std::array<dealii::types::global_dof_index, dim> &dofs, const ConstraintLines &lines);

  /// Left out if it follows from those before, or contradicts them.
  void add(const dealii::Tensor<1, dim> &N, double value);

  /// Add or replace the lines of the components for which the equations have been solved.
  void add_lines(ConstraintLines &lines) const;

private:
  struct Row ///< N.B = value, with N = 1 for its own component and 0 for those of other rows
  {
    unsigned int component;
    dealii::Tensor<1, dim> N;
    double value;
  };
  const std::array<dealii::types::global_dof_index, dim> dofs;
  bool is_open = true;
  std::vector<Row> rows;
};

} // namespace dovetail
