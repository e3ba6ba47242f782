// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Products with the tangent of a domain's cells by sum factorisation, in place of its entries.

#pragma once

#include <dovetail/domain/cell_solves.h>
#include <dovetail/domain/domain.h>

#include <deal.II/lac/full_matrix.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// The tangent of one field of a domain in the cells that this rank owns,
/// @f[ (K x)_i = \int \nabla\phi_i\cdot(A\,\nabla x + V x) + \phi_i\,(W\cdot\nabla x + M x) \,dV, @f]
/// with the derivatives A, V of the flux and W, M of the source by gradient and by value at the points of
/// Domain::cell_quadrature(), which are stored once if they are the same everywhere. A product costs some
/// dim p operations per unknown, and an entry of the matrix is never formed (Kronbichler and Kormann 2012).
///
/// Vectors are arrays with the unknowns of these cells, in the numbering that number() has been told.
template <int dim>
class CellOperator
{
public:
  virtual ~CellOperator() = default;

  /// Why there is none for a field of a domain; empty if there is one.
  static std::string objection(const Domain<dim> &domain, const Field &field);
  /// @pre objection() is empty
  static std::unique_ptr<CellOperator> make(const Domain<dim> &domain, const Field &field);
  /// A copy that keeps its own derivatives.
  virtual std::unique_ptr<CellOperator> copy() const = 0;

  /// Calls @p visit with each unknown of the whole system that a cell has.
  virtual void for_each_unknown(const std::function<void(dealii::types::global_dof_index)> &visit) const = 0;
  /// @p index of each such unknown in the arrays.
  virtual void number(const std::function<int(dealii::types::global_dof_index)> &index) = 0;

  /// New derivatives follow, for every point of every cell, and then finish_tangent().
  virtual void begin_tangent() = 0;
  /// @p factor: the measure relative to that of the cell (2 pi r around an axis).
  virtual void set_tangent(unsigned int active_cell_index, unsigned int q, double factor,
                           const Response<dim> &response) = 0;
  virtual void finish_tangent() = 0;
  /// A += factor A of @p other, and so on; @p other: a copy of this one.
  virtual void add_tangent(double factor, const CellOperator &other) = 0;

  /// y += K x, or with the symmetric part of K.
  virtual void add_product(const double *x, double *y, bool of_symmetric_part) const = 0;
  /// With the symmetric part of K, in single precision cell by cell.
  virtual void add_rough_product(const double *x, double *y) const = 0;
  virtual void add_diagonal(double *diagonal) const = 0;
  /// += the number of cells of an unknown
  virtual void add_ones(double *numbers) const = 0;
  /// sums_i += sum over the cells of i, and there over the unknowns j, of x_j
  virtual void add_sums_over_cells(const double *x, double *sums) const = 0;
  /// @param is_held of unknowns that are not solved for
  /// @param further what others add to the diagonal. On a face without neighbour it is taken for that of a
  /// mass matrix.
  /// @param taken += what the solves contain of it
  virtual std::unique_ptr<CellSolves> solves(const std::vector<bool> &is_held, const double *further,
                                             double *taken, bool in_single_precision) const = 0;

  /// A row of P, by index of the unknown: columns and weights.
  struct Row
  {
    int n;
    const int *columns;
    const double *weights;
  };
  using Prolongation = std::function<Row(int index)>;
  /// Calls @p visit for each cell with the columns of P that are not zero there.
  virtual void for_each_cell(const Prolongation &P,
                             const std::function<void(const std::vector<int> &columns)> &visit) const = 0;
  /// Likewise, and with P^T K P on them, of the symmetric part of K.
  using VisitCell = std::function<void(const std::vector<int> &columns, const dealii::FullMatrix<double> &)>;
  virtual void for_each_restriction(const Prolongation &P, const VisitCell &visit) const = 0;
};

} // namespace dovetail
