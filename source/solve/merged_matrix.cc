// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "merged_matrix.h"

#include <deal.II/base/mpi.h>

#include <Epetra_MpiComm.h>

#include <algorithm>

namespace dovetail {

MergedMatrix::MergedMatrix(const BlockMatrix &matrix, const std::vector<unsigned int> &blocks) : block_numbers(blocks)
{
  first_local = {0};
  for (const unsigned int b : blocks)
    first_local.push_back(first_local.back() + matrix.block(b, b).trilinos_matrix().NumMyRows());
  if (blocks.size() == 1)
    single = &matrix.block(blocks[0], blocks[0]).trilinos_matrix();
  else
    merge_structure(matrix);
}

void MergedMatrix::merge_structure(const BlockMatrix &matrix)
{
  const MPI_Comm communicator = matrix.block(0, 0).get_mpi_communicator();

  // where each rank's part of each block begins, in the block and in the merged numbering
  std::vector<int> own;
  for (const unsigned int b : block_numbers)
    own.push_back(matrix.block(b, b).trilinos_matrix().NumMyRows());
  const auto sizes = dealii::Utilities::MPI::all_gather(communicator, own);
  const unsigned int n_ranks = sizes.size(), n_blocks = block_numbers.size();
  std::vector<std::vector<int>> begin_in_block(n_blocks, std::vector<int>(1, 0)), begin_merged(n_blocks);
  int next = 0;
  for (unsigned int rank = 0; rank < n_ranks; ++rank)
    for (unsigned int i = 0; i < n_blocks; ++i)
      {
        begin_merged[i].push_back(next);
        begin_in_block[i].push_back(begin_in_block[i].back() + sizes[rank][i]);
        next += sizes[rank][i];
      }
  const auto merged_index = [&](const unsigned int i, const int index_in_block) {
    const unsigned int rank =
        std::upper_bound(begin_in_block[i].begin(), begin_in_block[i].end(), index_in_block) -
        begin_in_block[i].begin() - 1;
    return begin_merged[i][rank] + index_in_block - begin_in_block[i][rank];
  };

  // the local columns of each block in the merged numbering
  std::vector<std::vector<std::vector<int>>> column_of(n_blocks, std::vector<std::vector<int>>(n_blocks));
  for (unsigned int i = 0; i < n_blocks; ++i)
    for (unsigned int j = 0; j < n_blocks; ++j)
      {
        const Epetra_Map &columns =
            matrix.block(block_numbers[i], block_numbers[j]).trilinos_matrix().ColMap();
        for (int k = 0; k < columns.NumMyElements(); ++k)
          column_of[i][j].push_back(merged_index(j, columns.GID(k)));
      }

  const Epetra_Map rows(-1, static_cast<int>(first_local.back()), 0,
                        Epetra_MpiComm(communicator));
  std::vector<int> row_lengths;
  const auto for_each_row = [&](const auto &action) {
    for (unsigned int i = 0; i < n_blocks; ++i)
      for (unsigned int row = 0; row < first_local[i + 1] - first_local[i]; ++row)
        {
          std::vector<int> columns;
          for (unsigned int j = 0; j < n_blocks; ++j)
            {
              int n = 0, *local = nullptr;
              double *values = nullptr;
              matrix.block(block_numbers[i], block_numbers[j])
                  .trilinos_matrix()
                  .ExtractMyRowView(row, n, values, local);
              for (int k = 0; k < n; ++k)
                columns.push_back(column_of[i][j][local[k]]);
            }
          action(first_local[i] + row, columns);
        }
  };
  for_each_row([&](unsigned int, const std::vector<int> &columns) { row_lengths.push_back(columns.size()); });
  merged = std::make_unique<Epetra_CrsMatrix>(Copy, rows, row_lengths.data(), true);
  for_each_row([&](const unsigned int row, const std::vector<int> &columns) {
    const std::vector<double> zeros(columns.size(), 0.);
    merged->InsertGlobalValues(rows.GID(row), columns.size(), zeros.data(), columns.data());
  });
  merged->FillComplete();
  merged->OptimizeStorage();

  for_each_row([&](const unsigned int row, const std::vector<int> &columns) {
    int n = 0, *local = nullptr;
    double *values = nullptr;
    merged->ExtractMyRowView(row, n, values, local);
    std::vector<std::pair<int, int>> sorted; // global column, position
    for (int k = 0; k < n; ++k)
      sorted.emplace_back(merged->ColMap().GID(local[k]), k);
    std::sort(sorted.begin(), sorted.end());
    for (const int column : columns)
      position.push_back(std::lower_bound(sorted.begin(), sorted.end(), std::make_pair(column, 0))->second);
  });
}

void MergedMatrix::copy_values(const BlockMatrix &matrix)
{
  if (single)
    return;
  auto next = position.begin();
  for (unsigned int i = 0; i < block_numbers.size(); ++i)
    for (unsigned int row = 0; row < first_local[i + 1] - first_local[i]; ++row)
      {
        int n = 0;
        double *values = nullptr;
        merged->ExtractMyRowView(first_local[i] + row, n, values);
        for (const unsigned int j : block_numbers)
          {
            int n_of_block = 0;
            double *of_block = nullptr;
            matrix.block(block_numbers[i], j).trilinos_matrix().ExtractMyRowView(row, n_of_block, of_block);
            for (int k = 0; k < n_of_block; ++k)
              values[*next++] = of_block[k];
          }
      }
}

void MergedMatrix::gather(const BlockVector &from, dealii::TrilinosWrappers::MPI::Vector &to) const
{
  double *values = to.trilinos_vector()[0];
  for (unsigned int i = 0; i < block_numbers.size(); ++i)
    {
      const double *of_block = from.block(block_numbers[i]).trilinos_vector()[0];
      std::copy(of_block, of_block + first_local[i + 1] - first_local[i], values + first_local[i]);
    }
}

void MergedMatrix::scatter(const dealii::TrilinosWrappers::MPI::Vector &from, BlockVector &to) const
{
  const double *values = from.trilinos_vector()[0];
  for (unsigned int i = 0; i < block_numbers.size(); ++i)
    std::copy(values + first_local[i], values + first_local[i + 1],
              to.block(block_numbers[i]).trilinos_vector()[0]);
}

dealii::TrilinosWrappers::MPI::Vector MergedMatrix::vector() const
{
  const Epetra_Map &rows = matrix().RowMap();
  dealii::IndexSet owned(rows.NumGlobalElements());
  if (rows.NumMyElements() > 0)
    owned.add_range(rows.MinMyGID(), rows.MaxMyGID() + 1);
  const auto &communicator = dynamic_cast<const Epetra_MpiComm &>(rows.Comm());
  return dealii::TrilinosWrappers::MPI::Vector(owned, communicator.Comm());
}

} // namespace dovetail
