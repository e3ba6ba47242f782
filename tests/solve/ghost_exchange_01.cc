// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Ghosts get the values of those who own them, and sums of all ranks come to the owners, whatever a rank
// knows of others: every third unknown, also of ranks that own nothing of a block, or nothing at all.
//
// ranks: 1 2 3

#include <dovetail/solve/ghost_exchange.h>

#include <deal.II/base/mpi.h>

#include <iostream>

using namespace dovetail;
using Index = GhostExchange::Index;

namespace {

const std::vector<Index> sizes = {11, 7};

/// The last rank owns nothing of the second block.
Index first_of_rank(const unsigned int block, const unsigned int rank, const unsigned int n_ranks)
{
  const unsigned int n_owners = block == 0 || n_ranks == 1 ? n_ranks : n_ranks - 1;
  return rank >= n_owners ? sizes[block] : sizes[block] * rank / n_owners;
}

bool knows(const unsigned int rank, const Index index)
{
  return (index + rank) % 3 == 0;
}

void compare(const std::vector<bool> &knows_others)
{
  const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD),
                     rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD);
  std::vector<dealii::IndexSet> owned, relevant;
  for (unsigned int b = 0; b < sizes.size(); ++b) {
    owned.emplace_back(sizes[b]);
    owned[b].add_range(first_of_rank(b, rank, n_ranks), first_of_rank(b, rank + 1, n_ranks));
    relevant.push_back(owned[b]);
    for (Index i = 0; i < sizes[b]; ++i)
      if (knows_others[rank] && knows(rank, i))
        relevant[b].add_index(i);
  }
  const auto owner = [&](const unsigned int block, const Index index) {
    unsigned int result = 0;
    while (first_of_rank(block, result + 1, n_ranks) <= index)
      ++result;
    return result;
  };
  const GhostExchange exchange(owned, relevant, owner, MPI_COMM_WORLD);
  GhostExchange::Vector x(owned, MPI_COMM_WORLD), ghosted = exchange.ghosted_vector();
  SharedSums sums;
  bool is_right = true;
  for (const double factor : {1., 2.}) { // a second time, too
    sums.begin(exchange);
    for (unsigned int b = 0; b < sizes.size(); ++b) {
      for (const Index i : owned[b])
        x.block(b).trilinos_vector()[0][owned[b].index_within_set(i)] = factor * (100 * b + i);
      for (const Index i : relevant[b])
        sums(b * sizes[0] + i) += factor * (rank + 1) * (i + 1);
    }
    exchange.update(ghosted, x);
    sums.finish(x);
    for (unsigned int b = 0; b < sizes.size(); ++b) {
      for (const Index i : relevant[b])
        is_right = is_right && ghosted(b * sizes[0] + i) == factor * (100 * b + i);
      for (const Index i : owned[b]) {
        double sum = 0;
        for (unsigned int r = 0; r < n_ranks; ++r)
          sum += r == rank || (knows_others[r] && knows(r, i)) ? (r + 1) * (i + 1) : 0;
        is_right = is_right && x(b * sizes[0] + i) == factor * sum;
      }
    }
  }
  const bool all_right = dealii::Utilities::MPI::min(is_right ? 1 : 0, MPI_COMM_WORLD) == 1;
  if (rank == 0)
    std::cout << "values and sums: " << all_right << std::endl;
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  compare({true, true, true});
  compare({false, true, true});
  compare({true, false, false});
  compare({false, false, false});
}
