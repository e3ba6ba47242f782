// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The tangent of the cells of several domains and of their ties on the constraints, without a matrix.

#pragma once

#include <dovetail/domain/cell_operator.h>
#include <dovetail/interface/tie_operator.h>
#include <dovetail/solve/column_exchange.h>
#include <dovetail/solve/part_operator.h>
#include <dovetail/solve/row_numbering.h>
#include <dovetail/system/model.h>

#include <deal.II/lac/affine_constraints.h>

#include <Epetra_Import.h>
#include <Epetra_Map.h>

#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace dovetail {

/// @f[ C^T K C @f] with the tangent K of the cells in one field of all bodies and of ties at points, and C,
/// which finds the constrained unknowns from those that they follow: hanging nodes and ties by constraints;
/// prescribed ones are zero. A constrained row is empty.
template <int dim>
class CellwiseTangent : public PartOperator
{
public:
  using FieldOfTie = std::pair<const Interface<dim> *, const TiedField *>;

  /// @p rows: of the blocks of the field; @p ties: those whose terms are a part of K,
  /// TieOperator::is_possible(). Collective.
  CellwiseTangent(const Model<dim> &model, const RowNumbering &rows,
                  const std::vector<FieldOfTie> &ties = {});

  CellOperator<dim> &of_domain(const unsigned int d) { return *operators.at(d); }
  bool has_domain(const unsigned int d) const { return operators.count(d) > 0; }
  /// nullptr: its terms are no part of K.
  TieOperator<dim> *of_tie(const Interface<dim> &interface, const TiedField &field)
  {
    for (auto &tie : ties)
      if (&tie.tied() == &interface && &tie.of_field() == &field)
        return &tie;
    return nullptr;
  }

  /// New derivatives follow, with these constraints. Collective.
  void begin(const dealii::AffineConstraints<double> &constraints);
  void finish(); ///< all of them are known; collective
  /// b -= C^T K g with the values g that @p constraints prescribe. Collective.
  void subtract_moves(const dealii::AffineConstraints<double> &constraints,
                      dealii::TrilinosWrappers::MPI::BlockVector &b) const;

  void add_product(double factor, const Epetra_Vector &x, Epetra_Vector &y,
                   bool of_symmetric_part) const override;
  void add_rough_product(const Epetra_Vector &x, Epetra_Vector &y) const override
  {
    add_product(rough, x, y);
  }
  void add_diagonal(Epetra_Vector &values) const override;
  void add_uncondensed_diagonal(Epetra_Vector &values) const override;
  void add_sizes_of_products(const Epetra_Vector &x, Epetra_Vector &sizes) const override;
  std::unique_ptr<Approximation> cellwise_approximation(const Epetra_Vector &all_diagonal,
                                                        bool in_single_precision) const override;
  std::unique_ptr<Epetra_CrsMatrix> restricted(const Prolongation &P,
                                               const Epetra_CrsMatrix &summand) const override;
  const std::vector<bool> &condensed() const override { return is_condensed; }
  const std::set<std::pair<unsigned int, unsigned int>> &coupled_blocks() const override
  {
    return block_pairs;
  }
  unsigned int row_length() const override;
  std::shared_ptr<PartOperator> with_followers(const std::vector<int> &rows,
                                               const Epetra_CrsMatrix &weights) const override;
  std::shared_ptr<PartOperator> copy() const override;
  void add(double factor, const PartOperator &other) override;

private:
  enum Kind { exact, symmetric, rough }; ///< of a product

  /// By domain; a copy has its own.
  struct CellOperators : std::map<unsigned int, std::shared_ptr<CellOperator<dim>>>
  {
    CellOperators() = default;
    CellOperators(const CellOperators &other) : std::map<unsigned int, std::shared_ptr<CellOperator<dim>>>()
    {
      for (const auto &[d, cells] : other)
        this->emplace(d, cells->copy());
    }
  };

  CellwiseTangent(const CellwiseTangent &other) = default;
  CellwiseTangent(const CellwiseTangent &other, const std::vector<int> &followers,
                  const Epetra_CrsMatrix &weights);   ///< shares the operators of @p other
  int row(dealii::types::global_dof_index dof) const; ///< global
  void collect_columns();
  void make_constraint_matrix(const dealii::AffineConstraints<double> &constraints);
  void add_followers(const std::vector<int> &followers, const Epetra_CrsMatrix &weights);
  void find_diagonal();
  std::vector<double> uncondensed_diagonal() const;
  void add_product(Kind kind, const Epetra_Vector &x, Epetra_Vector &y) const;
  void multiply_cells(Kind kind, const Epetra_Vector &all_values, Epetra_Vector &y) const;
  void multiply_here(Kind kind, const double *x, double *y) const;
  void condense(Epetra_Vector &y, const Epetra_CrsMatrix &weights,
                const std::vector<double> &replacement) const;

  const Model<dim> &model;
  const RowNumbering &rows;
  CellOperators operators;
  std::vector<TieOperator<dim>> ties;
  std::vector<unsigned int> place_of_block;       ///< among those of the part
  std::shared_ptr<Epetra_Map> own_rows, columns;  ///< the own ones first, then those of cells on other ranks
  std::shared_ptr<Epetra_Import> import;          ///< for what happens once
  std::shared_ptr<const ColumnExchange> exchange; ///< for products, of the same columns

  std::vector<int> constrained;             ///< local rows
  std::shared_ptr<Epetra_CrsMatrix> follow; ///< a row for each of them: those it follows; nullptr: K = 0 yet
  std::vector<bool> is_condensed;
  std::set<std::pair<unsigned int, unsigned int>> block_pairs;
  std::vector<double> diagonal;                                ///< of C^T K C
  std::vector<std::pair<unsigned int, double>> other_diagonal; ///< of K, in the own rows where that differs
};

} // namespace dovetail
