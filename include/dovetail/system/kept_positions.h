// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where the matrices of a domain's cells go: searched once, then kept.

#pragma once

#include <dovetail/domain/domain.h>
#include <dovetail/solve/block_matrix.h>
#include <dovetail/solve/ghost_exchange.h>

#include <cstdint>
#include <vector>

namespace dovetail {

/// Adds the local matrix and vector of one cell after another, as distribute_local_to_global(), in some of
/// the fields of a domain. The components of a field at a node follow each other in the matrix, so that one
/// position is looked up for each pair of nodes. From keep() on it is kept, which takes two bytes. Cells with
/// unknowns that follow others or are moved, of several parts, or of another rank are not added.
template <int dim>
class KeptPositions
{
public:
  /// @p fields: of the domain, ascending; @p matrix: with these entries as long as this object lives.
  KeptPositions(const Domain<dim> &domain, const std::vector<unsigned int> &fields,
                const BlockMatrix &matrix);

  /// From now on the cells are expected to come again.
  void keep();

  /// @return false, and nothing is added, if the cell needs the general way.
  bool add(unsigned int cell_index, const std::vector<BlockMatrix::size_type> &dofs,
           const dealii::AffineConstraints<double> &constraints,
           const dealii::FullMatrix<double> &local_matrix, const std::vector<double> &local_residual,
           SharedSums &right_hand_side);

  /// Asks for the memory to which the next add() of this cell goes, which takes longer than the sums.
  void prefetch(unsigned int cell_index) const;

private:
  using Index = BlockMatrix::size_type;

  /// Compressed rows of this rank.
  struct Rows
  {
    int *first, *columns;
    double *values;
    bool exist; ///< in this form
  };
  Rows rows() const;
  bool find_rows(const std::vector<Index> &dofs, int *row_of_dof, int *column_of_dof) const;
  bool find(const std::vector<Index> &dofs, int *row_of_dof, std::uint16_t *positions);

  const BlockMatrix &matrix;
  unsigned int n_local = 0;                     ///< unknowns of a cell in these fields
  std::vector<std::vector<unsigned int>> nodes; ///< their components of one field
  unsigned int part = 0;
  bool columns_are_rows = true; ///< the numbers of the rows are those of their own columns
  bool has_one_part = true;
  struct BlockOfDofs ///< of the fields
  {
    Index begin, end;
    unsigned int number, first_row; ///< among all blocks; of this rank in the part
    Index begin_owned, end_owned;   ///< of this rank, all of the range
  };
  std::vector<BlockOfDofs> blocks;

  enum class Way : char { unknown, kept, general };
  const std::size_t n_cells;
  bool keeps = false;
  std::vector<Way> way;                 ///< by cell
  std::vector<int> all_rows;            ///< [cell][unknown]; of the last cell, unless they are kept
  std::vector<std::uint16_t> positions; ///< in the row, [cell][node of the row][node of the column]; likewise
  std::vector<int> columns;             ///< scratch, [unknown]
};

} // namespace dovetail
