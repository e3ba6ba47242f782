// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a part of a block matrix has beside its entries.

#pragma once

#include <dovetail/solve/approximation.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Vector.h>

#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace dovetail {

class Prolongation;

/// A summand of a square matrix that knows products and no entries. Rows are those of the part; vectors have
/// the own ones.
class PartOperator
{
public:
  virtual ~PartOperator() = default;

  /// y += factor K x, or with the symmetric part of K. Collective.
  virtual void add_product(double factor, const Epetra_Vector &x, Epetra_Vector &y,
                           bool of_symmetric_part) const = 0;
  virtual void add_diagonal(Epetra_Vector &values) const = 0;
  /// Of what K is condensed from: before unknowns follow others.
  virtual void add_uncondensed_diagonal(Epetra_Vector &values) const = 0;
  /// Of each row, sizes += about the sum of |K_ij x_j|, which says what rounding leaves of K x. Collective.
  virtual void add_sizes_of_products(const Epetra_Vector &x, Epetra_Vector &sizes) const = 0;
  /// An approximation of the symmetric part of K and the rest of a matrix with this @p diagonal, better than
  /// the diagonal in stretched cells. Collective. nullptr: none.
  virtual std::unique_ptr<Approximation> cellwise_approximation(const Epetra_Vector &diagonal,
                                                                bool in_single_precision) const = 0;
  /// P^T K P + @p summand, of the symmetric part of K. Collective.
  virtual std::unique_ptr<Epetra_CrsMatrix> restricted(const Prolongation &P,
                                                       const Epetra_CrsMatrix &summand) const = 0;
  /// Of each own row: whether its unknown follows from others or is prescribed, so that the row is empty.
  virtual const std::vector<bool> &condensed() const = 0;
  /// Pairs of different blocks, by number of the block, that would have entries on any rank.
  virtual const std::set<std::pair<unsigned int, unsigned int>> &coupled_blocks() const = 0;
  /// The largest number of entries that a row would have.
  virtual unsigned int row_length() const = 0;

  /// Z^T K Z, where further own @p rows follow others: the k-th one by the k-th row of @p weights, whose
  /// columns are rows here that are not empty. Has the derivatives of this one. Collective.
  virtual std::shared_ptr<PartOperator> with_followers(const std::vector<int> &rows,
                                                       const Epetra_CrsMatrix &weights) const = 0;

  virtual std::shared_ptr<PartOperator> copy() const = 0;
  virtual void add(double factor, const PartOperator &other) = 0; ///< @p other: a copy of this one

  /// y += K x, with the symmetric part of K, cell by cell in single precision. CG and flexible
  /// GMRES bear that in their preconditioners. Collective.
  virtual void add_rough_product(const Epetra_Vector &x, Epetra_Vector &y) const = 0;
};

} // namespace dovetail
