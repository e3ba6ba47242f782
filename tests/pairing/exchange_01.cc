// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What ranks send to each other is counted; what they have for themselves is neither sent nor counted.
//
// ranks: 1 2 3

#include <dovetail/pairing/exchange.h>

#include <cmath>
#include <iostream>
#include <limits>

using namespace dovetail;

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const MPI_Comm world = MPI_COMM_WORLD;
  const unsigned int n = dealii::Utilities::MPI::n_mpi_processes(world),
                     me = dealii::Utilities::MPI::this_mpi_process(world);
  InterfaceWork alone, together, of_lines;

  using Numbers = RankMap<std::vector<double>>;
  const Numbers own = exchange(Numbers{{me, {1. + me, 7.}}}, world, alone);
  bool is_right = own == Numbers{{me, {1. + me, 7.}}} && alone.messages == 0 && alone.bytes == 0;
  is_right = exchange(Numbers(), world, alone).empty() && alone.messages == 0 && is_right;

  Numbers to_all;
  for (unsigned int rank = 0; rank < n; ++rank)
    to_all[rank].assign(rank + 1, 10. * me + rank);
  const Numbers from_all = exchange(to_all, world, together);
  is_right = from_all.size() == n && is_right;
  for (const auto &[rank, numbers] : from_all)
    is_right = numbers == std::vector<double>(me + 1, 10. * rank + me) && is_right;
  // all lists are n (1 + ... + n) numbers long, those to oneself 1 + ... + n; each begins with its length
  const auto messages = dealii::Utilities::MPI::sum(together.messages, world),
             bytes = dealii::Utilities::MPI::sum(together.bytes, world);
  is_right = messages == n * (n - 1) &&
             bytes == (n - 1) * n * (n + 1) / 2 * sizeof(double) + messages * sizeof(std::size_t) && is_right;

  // an object of several lists, with indices as integers
  const dealii::types::global_dof_index index = std::numeric_limits<unsigned int>::max() - me;
  RankMap<std::map<dealii::types::global_dof_index, std::pair<bool, std::vector<double>>>> lines;
  lines[(me + 1) % n][index] = {true, {0.1, -0.}};
  lines = exchange(std::move(lines), world, of_lines);
  const unsigned int before = (me + n - 1) % n;
  const auto &[of_index, line] = *lines.at(before).begin();
  is_right = lines.size() == 1 && of_index == std::numeric_limits<unsigned int>::max() - before &&
             line.first && line.second[0] == 0.1 && std::signbit(line.second[1]) && is_right;

  if (dealii::Utilities::MPI::min(is_right ? 1 : 0, world) == 1 && me == 0)
    std::cout << "ok" << std::endl;
}
