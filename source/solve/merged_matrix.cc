// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "merged_matrix.h"

#include <deal.II/base/mpi.h>

#include <Epetra_MpiComm.h>
#include <Epetra_Vector.h>

#include <algorithm>

namespace dovetail {

MergedMatrix::MergedMatrix(const BlockMatrix &matrix, const std::vector<unsigned int> &blocks)
    : block_numbers(blocks)
{
  first_local = {0};
  for (const unsigned int b : blocks)
    first_local.push_back(first_local.back() + matrix.block(b, b).trilinos_matrix().NumMyRows());
  if (blocks.size() == 1)
    single = &matrix.block(blocks[0], blocks[0]).trilinos_matrix();
  else
    merge_structure(matrix);
}

/// The rows of each rank lie one behind the other, block after block.
void MergedMatrix::number_rows(const BlockMatrix &matrix)
{
  const unsigned int n_blocks = block_numbers.size();
  std::vector<int> own;
  for (const unsigned int b : block_numbers)
    own.push_back(matrix.block(b, b).trilinos_matrix().NumMyRows());
  const auto sizes = dealii::Utilities::MPI::all_gather(matrix.block(0, 0).get_mpi_communicator(), own);
  begin_in_block.assign(n_blocks, std::vector<int>(1, 0));
  begin_merged.assign(n_blocks, {});
  int next = 0;
  for (const auto &rank_sizes : sizes)
    for (unsigned int i = 0; i < n_blocks; ++i) {
      begin_merged[i].push_back(next);
      begin_in_block[i].push_back(begin_in_block[i].back() + rank_sizes[i]);
      next += rank_sizes[i];
    }
}

void MergedMatrix::merge_structure(const BlockMatrix &matrix)
{
  const MPI_Comm communicator = matrix.block(0, 0).get_mpi_communicator();
  const auto block = [&](const unsigned int i, const unsigned int j) -> const Epetra_CrsMatrix & {
    return matrix.block(block_numbers[i], block_numbers[j]).trilinos_matrix();
  };
  const unsigned int n_blocks = block_numbers.size();
  number_rows(matrix);
  // columns: the own ones in the order of the rows, then those of other ranks
  const Epetra_MpiComm epetra_communicator(communicator);
  const int n_own = first_local.back();
  const Epetra_Map rows(-1, n_own, 0, epetra_communicator);
  const auto is_own = [&](const int index) { return rows.MyGID(index); };
  std::vector<int> foreign;
  std::vector<std::vector<std::vector<int>>> column_of(n_blocks); // by the position in columns_of
  for (unsigned int i = 0; i < n_blocks; ++i) {
    columns_of.emplace_back();
    for (unsigned int j = 0; j < n_blocks; ++j) {
      if (!matrix.has_block(block_numbers[i], block_numbers[j]))
        continue;
      columns_of[i].push_back(block_numbers[j]);
      column_of[i].emplace_back();
      for (int k = 0; k < block(i, j).ColMap().NumMyElements(); ++k) {
        const int index = global_row(j, block(i, j).ColMap().GID(k));
        column_of[i].back().push_back(index);
        if (!is_own(index))
          foreign.push_back(index);
      }
    }
  }
  std::sort(foreign.begin(), foreign.end());
  foreign.erase(std::unique(foreign.begin(), foreign.end()), foreign.end());
  std::vector<int> all_columns;
  for (int i = 0; i < n_own; ++i)
    all_columns.push_back(rows.GID(i));
  all_columns.insert(all_columns.end(), foreign.begin(), foreign.end());
  const Epetra_Map columns(-1, static_cast<int>(all_columns.size()), all_columns.data(), 0,
                           epetra_communicator);
  for (auto &row_columns : column_of)
    for (auto &block_columns : row_columns)
      for (int &index : block_columns)
        index = is_own(index)
                    ? rows.LID(index)
                    : n_own + (std::lower_bound(foreign.begin(), foreign.end(), index) - foreign.begin());

  std::vector<int> row_lengths(n_own, 0);
  for (unsigned int i = 0; i < n_blocks; ++i)
    for (const unsigned int j : columns_of[i])
      for (int row = 0; row < block(i, i).NumMyRows(); ++row)
        row_lengths[first_local[i] + row] +=
            matrix.block(block_numbers[i], j).trilinos_matrix().NumMyEntries(row);
  merged = std::make_unique<Epetra_CrsMatrix>(Copy, rows, columns, row_lengths.data(), true);
  fill_structure(matrix, column_of);
  merged->FillComplete(rows, rows);
  merged->OptimizeStorage();
}

void MergedMatrix::fill_structure(const BlockMatrix &matrix,
                                  const std::vector<std::vector<std::vector<int>>> &column_of)
{
  std::vector<std::pair<int, int>> sorted; // local column, number of the entry
  std::vector<int> indices, position_of;
  std::vector<double> zeros;
  for (unsigned int i = 0; i < block_numbers.size(); ++i)
    for (unsigned int row = 0; row < first_local[i + 1] - first_local[i]; ++row) {
      sorted.clear();
      for (unsigned int c = 0; c < columns_of[i].size(); ++c) {
        int n = 0, *local = nullptr;
        double *values = nullptr;
        matrix.block(block_numbers[i], columns_of[i][c])
            .trilinos_matrix()
            .ExtractMyRowView(row, n, values, local);
        for (int k = 0; k < n; ++k)
          sorted.emplace_back(column_of[i][c][local[k]], sorted.size());
      }
      const bool is_in_order = std::is_sorted(sorted.begin(), sorted.end());
      if (!is_in_order)
        std::sort(sorted.begin(), sorted.end());
      indices.resize(sorted.size());
      position_of.resize(sorted.size());
      zeros.resize(sorted.size(), 0.);
      for (unsigned int k = 0; k < sorted.size(); ++k) {
        indices[k] = sorted[k].first;
        position_of[sorted[k].second] = k;
      }
      merged->InsertMyValues(first_local[i] + row, indices.size(), zeros.data(), indices.data());
      in_order.push_back(is_in_order);
      if (!is_in_order)
        position.insert(position.end(), position_of.begin(), position_of.end());
    }
}

int MergedMatrix::global_row(const unsigned int i, const int index_in_block) const
{
  if (single)
    return index_in_block;
  const unsigned int rank =
      std::upper_bound(begin_in_block[i].begin(), begin_in_block[i].end(), index_in_block) -
      begin_in_block[i].begin() - 1;
  return begin_merged[i][rank] + index_in_block - begin_in_block[i][rank];
}

void MergedMatrix::copy_values(const BlockMatrix &matrix)
{
  if (single)
    return;
  auto next = position.begin();
  for (unsigned int i = 0; i < block_numbers.size(); ++i)
    for (unsigned int row = 0; row < first_local[i + 1] - first_local[i]; ++row) {
      int n = 0;
      double *values = nullptr;
      merged->ExtractMyRowView(first_local[i] + row, n, values);
      for (const unsigned int j : columns_of[i]) {
        int n_of_block = 0;
        double *block_columns = nullptr;
        matrix.block(block_numbers[i], j).trilinos_matrix().ExtractMyRowView(row, n_of_block, block_columns);
        if (in_order[first_local[i] + row])
          values = std::copy_n(block_columns, n_of_block, values);
        else
          for (int k = 0; k < n_of_block; ++k)
            values[*next++] = block_columns[k];
      }
    }
}

void MergedMatrix::gather(const BlockVector &from, GroupVector &to) const
{
  double *values = to.trilinos_vector()[0];
  for (unsigned int i = 0; i < block_numbers.size(); ++i) {
    const double *block_columns = from.block(block_numbers[i]).trilinos_vector()[0];
    std::copy(block_columns, block_columns + first_local[i + 1] - first_local[i], values + first_local[i]);
  }
}

void MergedMatrix::scatter(const GroupVector &from, BlockVector &to) const
{
  const double *values = from.trilinos_vector()[0];
  for (unsigned int i = 0; i < block_numbers.size(); ++i)
    std::copy(values + first_local[i], values + first_local[i + 1],
              to.block(block_numbers[i]).trilinos_vector()[0]);
}

GroupVector MergedMatrix::vector() const
{
  const Epetra_Map &rows = matrix()->RowMap();
  dealii::IndexSet owned(rows.NumGlobalElements());
  if (rows.NumMyElements() > 0)
    owned.add_range(rows.MinMyGID(), rows.MaxMyGID() + 1);
  const auto &communicator = dynamic_cast<const Epetra_MpiComm &>(rows.Comm());
  return GroupVector(owned, communicator.Comm());
}

void MergedMatrix::vmult(GroupVector &destination, const GroupVector &source) const
{
  matrix()->Multiply(false, source.trilinos_vector(), destination.trilinos_vector());
}

void MergedMatrix::diagonal(GroupVector &destination) const
{
  Epetra_Vector values(View, destination.trilinos_vector(), 0);
  matrix()->ExtractDiagonalCopy(values);
}

} // namespace dovetail
