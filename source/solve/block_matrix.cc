// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/block_matrix.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/affine_constraints.templates.h>

#include <algorithm>

namespace dovetail {

namespace {

using Index = BlockMatrix::size_type;

/// The part of @p pattern in the rows of one block, by the block of the columns; the rows are emptied.
std::map<unsigned int, dealii::DynamicSparsityPattern> split_rows(const unsigned int row_block,
                                                                  const dealii::BlockIndices &indices,
                                                                  dealii::DynamicSparsityPattern &pattern)
{
  const Index begin = indices.block_start(row_block), end = begin + indices.block_size(row_block);
  const dealii::IndexSet rows = pattern.row_index_set().get_view(begin, end);
  std::map<unsigned int, dealii::DynamicSparsityPattern> parts;
  std::map<unsigned int, std::vector<Index>> columns;
  for (const Index row : rows) {
    columns.clear();
    for (unsigned int i = 0; i < pattern.row_length(begin + row); ++i) {
      const auto [block, column] = indices.global_to_local(pattern.column_number(begin + row, i));
      columns[block].push_back(column);
    }
    pattern.clear_row(begin + row);
    for (const auto &[block, block_rows] : columns)
      parts.try_emplace(block, indices.block_size(row_block), indices.block_size(block), rows)
          .first->second.add_entries(row, block_rows.begin(), block_rows.end(), true);
  }
  return parts;
}

/// The columns of the blocks that have entries on any rank, and that of the diagonal.
std::vector<unsigned int> all_columns(const unsigned int row_block,
                                      const std::map<unsigned int, dealii::DynamicSparsityPattern> &parts,
                                      const MPI_Comm &communicator)
{
  std::vector<unsigned int> own = {row_block}, all;
  for (const auto &part : parts)
    own.push_back(part.first);
  for (const auto &rank_part : dealii::Utilities::MPI::all_gather(communicator, own))
    all.insert(all.end(), rank_part.begin(), rank_part.end());
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

} // namespace

void BlockMatrix::clear()
{
  blocks.clear();
  indices = dealii::BlockIndices();
}

void BlockMatrix::reinit(const std::vector<dealii::IndexSet> &owned, dealii::DynamicSparsityPattern &pattern,
                         const MPI_Comm &communicator)
{
  clear();
  std::vector<size_type> sizes;
  for (const auto &block_rows : owned)
    sizes.push_back(block_rows.size());
  indices.reinit(sizes);
  blocks.resize(owned.size());
  for (unsigned int r = 0; r < owned.size(); ++r) {
    auto parts = split_rows(r, indices, pattern);
    const dealii::IndexSet rows =
        pattern.row_index_set().get_view(indices.block_start(r), indices.block_start(r) + sizes[r]);
    for (const unsigned int c : all_columns(r, parts, communicator)) {
      const auto part = parts.try_emplace(c, sizes[r], sizes[c], rows).first;
      blocks[r][c] = std::make_unique<Block>();
      blocks[r][c]->reinit(owned[r], owned[c], part->second, communicator, false);
      parts.erase(part);
    }
  }
}

BlockMatrix &BlockMatrix::operator=(const double zero)
{
  for (const auto &block_row : blocks)
    for (const auto &[column, block] : block_row)
      *block = zero;
  return *this;
}

void BlockMatrix::copy_from(const BlockMatrix &other)
{
  clear();
  indices = other.indices;
  blocks.resize(other.blocks.size());
  for (unsigned int row = 0; row < blocks.size(); ++row)
    for (const auto &[column, block] : other.blocks[row]) {
      blocks[row][column] = std::make_unique<Block>();
      blocks[row][column]->copy_from(*block);
    }
}

void BlockMatrix::add(const double factor, const BlockMatrix &other)
{
  for (unsigned int row = 0; row < blocks.size(); ++row)
    for (const auto &[column, block] : blocks[row])
      block->add(factor, other.block(row, column));
}

void BlockMatrix::add(const size_type row, const size_type n, const size_type *columns, const double *values,
                      const bool elide_zeros, const bool columns_are_sorted)
{
  const auto [row_block, row_in_block] = indices.global_to_local(row);
  for (size_type i = 0, end = 0; i < n; i = end) {
    const unsigned int column_block = indices.global_to_local(columns[i]).first;
    const size_type begin_of_block = indices.block_start(column_block),
                    end_of_block = begin_of_block + indices.block_size(column_block);
    local_columns.clear();
    for (; end < n && columns[end] >= begin_of_block && columns[end] < end_of_block; ++end)
      local_columns.push_back(columns[end] - begin_of_block);
    blocks[row_block]
        .at(column_block)
        ->add(row_in_block, end - i, local_columns.data(), values + i, elide_zeros, columns_are_sorted);
  }
}

void BlockMatrix::add(const size_type row, const size_type column, const double value)
{
  add(row, 1, &column, &value, false, true);
}

void BlockMatrix::compress(const dealii::VectorOperation::values operation)
{
  for (const auto &block_row : blocks)
    for (const auto &[column, block] : block_row)
      block->compress(operation);
}

void BlockMatrix::vmult(Vector &destination, const Vector &source) const
{
  for (unsigned int r = 0; r < blocks.size(); ++r) {
    destination.block(r) = 0;
    for (const auto &[column, block] : blocks[r])
      block->vmult_add(destination.block(r), source.block(column));
  }
}

double BlockMatrix::el(const size_type row, const size_type column) const
{
  const auto [row_block, row_in_block] = indices.global_to_local(row);
  const auto [column_block, column_in_block] = indices.global_to_local(column);
  return has_block(row_block, column_block) ? block(row_block, column_block).el(row_in_block, column_in_block)
                                            : 0.;
}

void distribute_local_to_global(const dealii::AffineConstraints<double> &constraints,
                                const dealii::FullMatrix<double> &local_matrix,
                                const dealii::Vector<double> &local_vector, const std::vector<Index> &dofs,
                                BlockMatrix &matrix, BlockMatrix::Vector &vector)
{
  constraints.distribute_local_to_global(local_matrix, local_vector, dofs, matrix, vector);
}

} // namespace dovetail
