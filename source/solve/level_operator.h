// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a level of multigrid smooths: a matrix, or products.

#pragma once

#include "compact_matrix.h"

#include <dovetail/solve/approximation.h>
#include <dovetail/solve/part_operator.h>
#include <dovetail/solve/prolongation.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Vector.h>

#include <memory>
#include <utility>

namespace dovetail {

/// A symmetric positive definite operator A on the own rows of this rank, as a smoother sees it.
class LevelProducts
{
public:
  virtual ~LevelProducts() = default;

  virtual const Epetra_Map &rows() const = 0;
  virtual void vmult(Epetra_Vector &y, const Epetra_Vector &x) const = 0;
  virtual void diagonal(Epetra_Vector &values) const = 0;
  /// Better than diag(A) where cells are stretched. Collective. nullptr: none.
  virtual std::unique_ptr<Approximation> approximation() const { return nullptr; }
};

/// With what a coarser level is made of.
class LevelOperator : public LevelProducts
{
public:
  virtual std::unique_ptr<Epetra_CrsMatrix> restricted(const Prolongation &P) const = 0; ///< P^T A P
  /// Whether the unknown of an own row follows from others, so that it is alone in its row.
  virtual bool is_condensed(unsigned int row) const = 0;
};

/// With entries, of which an approximation can be made.
class LevelEntries : public LevelProducts
{
public:
  /// @param A by reference
  explicit LevelEntries(const Epetra_CrsMatrix &A) : A(&A) {}
  explicit LevelEntries(CompactMatrix A) : compact(std::make_shared<const CompactMatrix>(std::move(A))) {}

  const Epetra_Map &rows() const override { return compact ? compact->rows() : A->OperatorDomainMap(); }
  void vmult(Epetra_Vector &y, const Epetra_Vector &x) const override;
  void diagonal(Epetra_Vector &values) const override;
  /// From now on, products are made with it.
  std::shared_ptr<const CompactMatrix> single_precision() const
  {
    if (!compact)
      compact = std::make_shared<const CompactMatrix>(*A);
    return compact;
  }

private:
  const Epetra_CrsMatrix *A = nullptr;
  mutable std::shared_ptr<const CompactMatrix> compact; ///< instead
};

/// What own rows have, at the columns of a matrix. Collective.
Epetra_MultiVector at_columns(const Epetra_CrsMatrix &A, const Epetra_MultiVector &of_rows);
Epetra_Vector at_columns(const Epetra_CrsMatrix &A, const Epetra_Vector &of_rows);
/// By own row its column; -1: none.
std::vector<int> columns_of_rows(const Epetra_CrsMatrix &A);

class MatrixLevel : public LevelOperator
{
public:
  /// @param A by reference
  explicit MatrixLevel(const Epetra_CrsMatrix &A) : A(A), of_products(A) {}

  /// From now on, products are those of the present entries in single precision, or those of A.
  void round(const bool in_single_precision)
  {
    of_products = LevelEntries(A);
    if (in_single_precision)
      of_products.single_precision();
  }
  const Epetra_Map &rows() const override { return A.OperatorDomainMap(); }
  void vmult(Epetra_Vector &y, const Epetra_Vector &x) const override { of_products.vmult(y, x); }
  void diagonal(Epetra_Vector &values) const override { LevelEntries(A).diagonal(values); }
  /// Those of products. Who makes them single precision while products are not has a copy.
  LevelEntries entries() const { return of_products; }
  std::unique_ptr<Epetra_CrsMatrix> restricted(const Prolongation &P) const override;
  bool is_condensed(const unsigned int row) const override { return A.NumMyEntries(row) <= 1; }

private:
  const Epetra_CrsMatrix &A;
  LevelEntries of_products;
};

/// A + R^T R
class AugmentedLevel : public MatrixLevel
{
public:
  /// @param A and R by reference
  AugmentedLevel(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &R) : MatrixLevel(A), R(R) {}

  void vmult(Epetra_Vector &y, const Epetra_Vector &x) const override;
  void diagonal(Epetra_Vector &values) const override;
  std::unique_ptr<Epetra_CrsMatrix> restricted(const Prolongation &P) const override;

private:
  const Epetra_CrsMatrix &R;
};

/// P^T A P
std::unique_ptr<Epetra_CrsMatrix> restrict_matrix(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &P);
/// P^T S P, where S is symmetric and most of its rows are zero, which take no memory here.
std::unique_ptr<Epetra_CrsMatrix> restrict_few_rows(const Epetra_CrsMatrix &S, const Prolongation &P);

/// R R^T. Collective.
std::unique_ptr<Epetra_CrsMatrix> product_with_transposed(const Epetra_CrsMatrix &R);
/// A + R^T R. Collective.
std::unique_ptr<Epetra_CrsMatrix> with_added_rows(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &R);
/// y += R^T R x
void add_product(const Epetra_CrsMatrix &R, const Epetra_Vector &x, Epetra_Vector &y);
/// += diag(R^T R)
void add_diagonal(const Epetra_CrsMatrix &R, Epetra_Vector &values);

/// (A + A^T) / 2 within each field, and nothing between fields, whose units differ: what is left is positive
/// definite if the fields are by themselves. An entry without a partner across the diagonal is left out too.
std::unique_ptr<Epetra_CrsMatrix> make_symmetric_part(const Epetra_CrsMatrix &A,
                                                      const std::vector<int> &field_of_row);
/// The symmetric part of what has no entries, and symmetric @p entries beside it, as one matrix. Collective.
std::unique_ptr<Epetra_CrsMatrix> make_matrix(const PartOperator &cells, const Epetra_CrsMatrix &entries);

} // namespace dovetail
