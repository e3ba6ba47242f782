// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/row_numbering.h>

#include <deal.II/base/mpi.h>

#include <algorithm>

namespace dovetail {

namespace {

/// The last entry that is not larger than @p value.
unsigned int interval_of(const std::vector<RowNumbering::Index> &begins, const RowNumbering::Index value)
{
  return std::upper_bound(begins.begin(), begins.end(), value) - begins.begin() - 1;
}

} // namespace

RowNumbering::RowNumbering(const std::vector<dealii::IndexSet> &owned,
                           const std::vector<unsigned int> &blocks, const MPI_Comm &communicator)
    : block_numbers(blocks), first_local(1, 0),
      this_rank(dealii::Utilities::MPI::this_mpi_process(communicator)), first_of_rank(1, 0),
      first_unknown(blocks.size(), std::vector<Index>(1, 0))
{
  std::vector<Index> n_own;
  for (const unsigned int b : blocks) {
    n_own.push_back(owned[b].n_elements());
    first_local.push_back(first_local.back() + n_own.back());
  }
  for (const auto &n_of_rank : dealii::Utilities::MPI::all_gather(communicator, n_own)) {
    Index next = first_of_rank.back();
    first_row.emplace_back();
    for (unsigned int i = 0; i < blocks.size(); ++i) {
      first_row.back().push_back(next);
      first_unknown[i].push_back(first_unknown[i].back() + n_of_rank[i]);
      next += n_of_rank[i];
    }
    first_of_rank.push_back(next);
  }
}

dealii::IndexSet RowNumbering::owned() const
{
  dealii::IndexSet set(size());
  set.add_range(first_of_rank[this_rank], first_of_rank[this_rank + 1]);
  return set;
}

RowNumbering::Index RowNumbering::row(const unsigned int i, const Index index_in_block) const
{
  const std::vector<Index> &first = first_unknown[i];
  const bool is_own = index_in_block >= first[this_rank] && index_in_block < first[this_rank + 1];
  const unsigned int rank = is_own ? this_rank : interval_of(first, index_in_block);
  return first_row[rank][i] + index_in_block - first[rank];
}

std::pair<unsigned int, RowNumbering::Index> RowNumbering::unknown(const Index row) const
{
  const unsigned int rank = interval_of(first_of_rank, row);
  const unsigned int i = interval_of(first_row[rank], row);
  return {i, first_unknown[i][rank] + row - first_row[rank][i]};
}

void RowNumbering::gather(const BlockVector &from, double *to) const
{
  for (unsigned int i = 0; i < block_numbers.size(); ++i) {
    const double *values = from.block(block_numbers[i]).trilinos_vector()[0];
    std::copy_n(values, first_local[i + 1] - first_local[i], to + first_local[i]);
  }
}

void RowNumbering::scatter(const double *from, BlockVector &to) const
{
  for (unsigned int i = 0; i < block_numbers.size(); ++i)
    std::copy(from + first_local[i], from + first_local[i + 1],
              to.block(block_numbers[i]).trilinos_vector()[0]);
}

} // namespace dovetail
