// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Products with the tangent of a tie's terms at points, in fewer unknowns than the cells have.

#pragma once

#include <dovetail/domain/cell_operator.h>
#include <dovetail/interface/interface.h>

#include <deal.II/lac/full_matrix.h>

#include <array>
#include <functional>
#include <vector>

namespace dovetail {

/// The tangent of the PointTerms of an interface in the rows and columns of one tied field, in the groups of
/// this rank and before any constraint,
/// @f[ S = G^T T G, @f]
/// with T in the leading unknowns (leading_unknowns.h): those on the faces, and one for each line of nodes
/// into a cell, which neighbours share. T has three to nine times fewer entries than S for degree 4 in 3D. It
/// is stored in square blocks of the components at two nodes.
///
/// Vectors are arrays as those of CellOperator, with the unknowns of these groups.
template <int dim>
class TieOperator
{
public:
  /// Whether one can take the terms of a field of the interface.
  static bool is_possible(const Interface<dim> &interface, const TiedField &field);

  /// @pre is_possible()
  TieOperator(const Interface<dim> &interface, const TiedField &field);

  const Interface<dim> &tied() const { return *interface; }
  const TiedField &of_field() const { return *field; }
  /// Calls @p visit with each unknown of the field in the whole system that a group has.
  void for_each_unknown(const std::function<void(dealii::types::global_dof_index)> &visit) const;
  /// @p index of each such unknown in the arrays. Finds which blocks T has.
  void number(const std::function<int(dealii::types::global_dof_index)> &index);

  const LeadingUnknowns &leading(unsigned int group) const;
  void begin_tangent(); ///< T = 0; then add() for each group and finish_tangent()
  /// @p of_leading: all unknowns, those of other fields are left out
  void add(unsigned int group, const dealii::FullMatrix<double> &of_leading);
  /// Of a matrix in all unknowns of a group.
  void clear_own_entries(dealii::FullMatrix<double> &of_all) const;
  void finish_tangent();
  void add_tangent(double factor, const TieOperator &other); ///< @p other: a copy of this one

  /// y += S x, or with the symmetric part of S.
  void add_product(const double *x, double *y, bool of_symmetric_part) const;
  void add_diagonal(double *diagonal) const;

  /// P^T S P of the symmetric part of S, by the columns of P.
  struct Restriction
  {
    std::vector<int> rows;
    std::vector<std::vector<int>> columns; ///< of each row
    std::vector<std::vector<double>> values;
  };
  Restriction restricted(const typename CellOperator<dim>::Prolongation &P) const;

private:
  /// A leading node: the sum of the nodes it leads.
  struct Node
  {
    std::vector<int> index;      ///< of the unknowns of each node it leads, in the arrays
    std::vector<double> factors; ///< of each node
  };
  struct Summand ///< of a leading unknown
  {
    int index;
    unsigned int node, component;
    double factor;
  };

  void find_nodes(const std::function<int(dealii::types::global_dof_index)> &index);
  void find_blocks();
  bool has_rows_of_zero_sum() const;
  unsigned int position(unsigned int row, unsigned int column) const; ///< of a block; n_blocks: none
  double entry(unsigned int row, unsigned int c, unsigned int other, unsigned int d) const;
  /// Of the transposed of what is below the diagonal where block k is above.
  double lower_entry(const unsigned int k, const unsigned int c, const unsigned int d) const
  {
    return (lower.empty() ? upper : lower)[(k * n_components + c) * n_components + d];
  }
  template <int n>
  void multiply(const double *x, double *y, bool of_symmetric_part) const;

  unsigned int first_position(const unsigned int side) const ///< of the components of the field
  {
    return interface->position(side, field->first_component[side]);
  }
  unsigned int first_unknown(const unsigned int side) const ///< likewise, among those of a group
  {
    return interface->first_unknown(side, field->first_component[side]);
  }
  unsigned int n_unknowns(const unsigned int side) const { return n_components * field->n_nodes[side]; }

  const Interface<dim> *interface;
  const TiedField *field;
  unsigned int n_components;
  std::vector<Node> nodes;
  std::vector<std::vector<unsigned int>> nodes_of_group; ///< in the order of its leading unknowns
  std::vector<Summand> summands;                         ///< ascending by index
  std::vector<unsigned int> first_block, column; ///< of each node; of each block, on or above the diagonal
  std::vector<double> upper;                     ///< the blocks, row by row
  std::vector<double> lower; ///< the transposed of those across the diagonal; empty if they are the same
  bool keeps_translations = false;       ///< these cost nothing
  std::vector<unsigned int> position_of; ///< scratch: of the blocks of a row, by node
};

} // namespace dovetail
