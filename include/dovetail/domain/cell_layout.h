// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The unknowns of one cell, and the shape functions that belong to them.

#pragma once

#include <dovetail/material/term.h>

#include <deal.II/fe/fe.h>
#include <deal.II/fe/fe_system.h>

#include <memory>
#include <vector>

namespace dovetail {

/// The space of each component of a domain. There are as many spaces as different scalar elements; space 0 is
/// the Lagrange element of the domain's degree, whether a field has it or not.
///
/// The local unknowns of a cell are ordered by component, then node: node a of component c has the index
/// first(c) + a. What is known of shape functions at a point is a flat array over all spaces, one after the
/// other: the function of that node is at first_shape(c) + a. With one space the array is that of the scalar
/// element.
template <int dim>
class CellLayout
{
public:
  /// @p simplices: the cells are triangles or tetrahedra. @pre The degree is at least the lowest_degree() of
  /// each field.
  CellLayout(const std::vector<Field> &fields, unsigned int degree, bool simplices);

  /// The lowest degree of a domain that can have a field.
  static unsigned int lowest_degree(const Field &field, bool simplices);

  unsigned int n_components() const { return components.size() - 1; }
  unsigned int n_spaces() const { return spaces.size(); }
  unsigned int space(const unsigned int c) const { return components[c].space; }
  unsigned int n_nodes(const unsigned int c) const { return components[c].n_nodes; } ///< of a component
  unsigned int first(const unsigned int c) const { return components[c].first; }     ///< c = n: size()
  unsigned int index(const unsigned int c, const unsigned int a) const { return components[c].first + a; }
  unsigned int size() const { return components.back().first; } ///< number of unknowns of a cell

  unsigned int n_shapes() const { return number_of_shapes; }
  unsigned int first_shape(const unsigned int c) const { return components[c].first_shape; }

  /// The scalar element of a component.
  const dealii::FiniteElement<dim> &element(const unsigned int c) const { return *spaces[space(c)].element; }
  const dealii::FiniteElement<dim> &element_of_space(const unsigned int s) const
  {
    return *spaces[s].element;
  }
  bool is_continuous_space(const unsigned int s) const { return spaces[s].is_continuous; }
  bool is_continuous(const unsigned int c) const { return spaces[space(c)].is_continuous; }
  /// The Lagrange element at whose nodes values of a component are looked at: its own, or of a discontinuous
  /// one, whose unknowns need not be values, that of space 0.
  const dealii::FiniteElement<dim> &nodal_element(const unsigned int c) const
  {
    return is_continuous(c) ? element(c) : *spaces[0].element;
  }
  /// The values of a component at these nodes, from the unknowns of a cell.
  void nodal_values(unsigned int c, const std::vector<double> &unknowns, std::vector<double> &values) const;
  /// The coefficients of the function that is 1.
  const std::vector<double> &unit(const unsigned int c) const { return spaces[space(c)].unit; }

  /// An element that has the functions of every space once, for FEValues; its own order is another one.
  const dealii::FiniteElement<dim> &shape_element() const
  {
    return shapes_of_all ? *shapes_of_all : *spaces[0].element;
  }
  /// The number in it of entry i of the flat array.
  unsigned int shape_index(const unsigned int i) const
  {
    return number_in_element.empty() ? i : number_in_element[i];
  }
  /// That of node a of component c.
  unsigned int shape_of_node(const unsigned int c, const unsigned int a) const
  {
    return shape_index(first_shape(c) + a);
  }

  /// The element of all components, for the DoFHandler, and the number in it of a local unknown.
  const dealii::FESystem<dim> &system_element() const { return *system; }
  unsigned int system_index(const unsigned int i) const { return number_in_system[i]; }

private:
  struct Space
  {
    std::unique_ptr<dealii::FiniteElement<dim>> element;
    int relative_degree;
    bool is_continuous;
    unsigned int first_shape;
    std::vector<double> unit;
  };
  struct Component
  {
    unsigned int space, first, n_nodes, first_shape;
  };

  unsigned int find_space(const Field &field, unsigned int degree, bool simplices);
  void make_systems(const std::vector<Field> &fields, bool simplices);

  std::vector<Space> spaces;
  std::vector<Component> components; ///< and one behind them
  unsigned int number_of_shapes = 0;
  std::unique_ptr<dealii::FESystem<dim>> system, shapes_of_all; ///< the second one with several spaces only
  std::vector<unsigned int> number_in_system, number_in_element;
};

} // namespace dovetail
