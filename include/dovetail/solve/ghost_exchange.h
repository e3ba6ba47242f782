// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What ranks tell each other of the unknowns that they share.

#pragma once

#include <dovetail/solve/partners.h>

#include <deal.II/base/index_set.h>
#include <deal.II/lac/block_indices.h>
#include <deal.II/lac/trilinos_parallel_block_vector.h>
#include <deal.II/lac/vector.h>

#include <functional>
#include <vector>

namespace dovetail {

/// Values of owned unknowns for ghosted vectors, and sums of ghosts for those who own them, by one message to
/// each rank that shares unknowns. Who they are is found out once; an assignment or compress() of Trilinos
/// vectors finds it out each time, and all ranks wait for each other up to a dozen times.
class GhostExchange
{
public:
  using Index = dealii::types::global_dof_index;
  using Vector = dealii::TrilinosWrappers::MPI::BlockVector;

  /// @param owned a contiguous range of each block, relative to it
  /// @param relevant likewise: all that this rank reads or adds to, owned or not
  /// @param owner the rank of an index of a block. Collective.
  GhostExchange(const std::vector<dealii::IndexSet> &owned, const std::vector<dealii::IndexSet> &relevant,
                const std::function<unsigned int(unsigned int block, Index index)> &owner,
                const MPI_Comm &communicator);

  Vector ghosted_vector() const;
  /// @p ghosted, of ghosted_vector(), gets the values of @p owned. Collective.
  void update(Vector &ghosted, const Vector &owned) const;

private:
  friend class SharedSums;

  std::vector<dealii::IndexSet> owned, relevant; ///< by block
  std::vector<std::size_t> first_owned;          ///< by block, its place among the relevant ones
  dealii::BlockIndices blocks;
  MPI_Comm communicator;
  Partners given, ghosts; ///< owned here and a ghost there, and the other way round; by block
};

/// Sums in the rows of unknowns, of which each rank adds parts to relevant rows, owned or not. For
/// distribute_local_to_global() it is a vector.
class SharedSums
{
public:
  using Index = GhostExchange::Index;
  using size_type = Index;
  using value_type = double;

  /// Zeros. @p exchange is kept by reference.
  void begin(const GhostExchange &exchange);
  /// @pre @p row is relevant
  double &operator()(Index row);
  template <typename Values>
  void add(const std::vector<Index> &rows, const Values &summands)
  {
    for (unsigned int i = 0; i < rows.size(); ++i)
      (*this)(rows[i]) += summands[i];
  }
  double *owned_rows(const unsigned int block) { return values[block].data() + exchange->first_owned[block]; }
  Index size() const { return exchange->blocks.total_size(); }
  /// @p owned gets the sums of all ranks. Collective.
  void finish(GhostExchange::Vector &owned);

private:
  const GhostExchange *exchange = nullptr;
  std::vector<std::vector<double>> values; ///< by block, of relevant rows
};

} // namespace dovetail
