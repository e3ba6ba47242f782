// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Some parts of a block matrix as one operator.

#pragma once

#include "body_motions.h"

#include <dovetail/solve/block_matrix.h>
#include <dovetail/solve/group_solver.h>

#include <Epetra_CrsMatrix.h>

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace dovetail {

/// The square matrix of some blocks that are one or several whole parts, one after another. It multiplies
/// by the matrices of the parts. Several parts are copied to one matrix only for a solver that asks for it:
/// MUMPS, where there are multipliers.
class MergedMatrix : public GroupOperator
{
public:
  using BlockVector = dealii::TrilinosWrappers::MPI::BlockVector;

  /// @p matrix must stay where it is.
  MergedMatrix(const BlockMatrix &matrix, const std::vector<unsigned int> &blocks);
  /// The matrix has new values.
  void update();
  /// Asked with entries of a single part before they multiply: with what they shall, or nullptr. Collective.
  using MakeMotions = std::function<std::unique_ptr<BodyMotions>(const Epetra_CrsMatrix &entries)>;
  void set_motions(MakeMotions make) { make_motions = std::move(make); }

  GroupVector vector() const override;
  void vmult(GroupVector &destination, const GroupVector &source) const override;
  void diagonal(GroupVector &destination) const override;
  const Epetra_CrsMatrix *matrix() const override; ///< collective, if it has to be made
  const PartOperator *cells() const override;      ///< of a single part
  bool has_products() const;                       ///< of cells, in some part; then there is no matrix()
  const Epetra_CrsMatrix *entries() const override;

  /// What rounding leaves of K x, row by row: u |K| |x|. Collective.
  GroupVector rounding_of_product(const GroupVector &x) const;
  /// Of all rows: the largest sum of sizes of entries, and the largest number of entries. Collective.
  std::pair<double, double> largest_row() const;

  void gather(const BlockVector &from, GroupVector &to) const;
  void scatter(const GroupVector &from, BlockVector &to) const;
  const RowNumbering &numbering() const { return rows; }

private:
  struct Part
  {
    unsigned int number, first_block, first_local; ///< in the block matrix, here, here
  };

  const PartOperator *cells_of(const Part &part) const { return block_matrix.part_operator(part.number); }
  /// Calls @p visit with each pair of parts that has entries, and their matrix.
  template <typename Visit>
  void for_each_pair(const Visit &visit) const;
  void copy(const Part &row_part, const Part &column_part, const Epetra_CrsMatrix &from) const;
  void merge() const;

  const BlockMatrix &block_matrix;
  RowNumbering rows;
  std::vector<Part> parts;
  mutable std::unique_ptr<Epetra_CrsMatrix> merged;
  mutable bool has_values = false; ///< the present ones, merged
  MakeMotions make_motions;
  mutable std::optional<std::unique_ptr<BodyMotions>> motions; ///< nothing: of the values before
};

} // namespace dovetail
