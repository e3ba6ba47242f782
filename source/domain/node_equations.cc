// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Gauss-Jordan elimination at a node.

#include <dovetail/domain/node_equations.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {
constexpr double least_angle = 1e-3; ///< between planes that are not one
}

template <int dim>
NodeEquations<dim>::NodeEquations(const std::array<dealii::types::global_dof_index, dim> &dofs,
                                  const ConstraintLines &lines)
    : dofs(dofs)
{
  for (unsigned int c = 0; c < dim; ++c)
    if (const auto line = lines.find(dofs[c]); line != lines.end()) {
      is_open = is_open && line->second.is_of_condition;
      dealii::Tensor<1, dim> e;
      e[c] = 1;
      rows.push_back({c, e, line->second.inhomogeneity});
    }
}

template <int dim>
void NodeEquations<dim>::add(const dealii::Tensor<1, dim> &N, const double value)
{
  if (!is_open)
    return;
  Row added = {0, N, value};
  for (const Row &row : rows) {
    const double factor = added.N[row.component];
    added.N -= factor * row.N;
    added.N[row.component] = 0;
    added.value -= factor * row.value;
  }
  for (unsigned int c = 1; c < dim; ++c)
    if (std::abs(added.N[c]) > std::abs(added.N[added.component]))
      added.component = c;
  const double pivot = added.N[added.component];
  if (!(std::abs(pivot) > least_angle * N.norm()))
    return;
  added.N /= pivot;
  added.N[added.component] = 1;
  added.value /= pivot;
  for (Row &row : rows) {
    const double factor = row.N[added.component];
    row.N -= factor * added.N;
    row.N[added.component] = 0;
    row.value -= factor * added.value;
  }
  rows.push_back(added);
}

template <int dim>
void NodeEquations<dim>::add_lines(ConstraintLines &lines) const
{
  if (!is_open)
    return;
  for (const Row &row : rows) {
    ConstraintLine line;
    for (unsigned int c = 0; c < dim; ++c)
      if (c != row.component && row.N[c] != 0)
        line.entries.emplace_back(dofs[c], -row.N[c]);
    line.inhomogeneity = row.value;
    line.is_of_condition = true;
    lines[dofs[row.component]] = line;
  }
}

template class NodeEquations<2>;
template class NodeEquations<3>;

} // namespace dovetail
