// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Marking: the cells above the threshold hold the share asked for, one less does not; cells that are equal
// but for rounding are marked together; the ranks do not matter.
//
// ranks: 1 2 3

#include "scene_model.h"

#include <dovetail/measure/error_estimate.h>

#include <numeric>

using namespace test;

/// Those of this rank, in turns.
std::vector<double> own(const std::vector<double> &all)
{
  const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
  std::vector<double> result;
  for (unsigned int i = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD); i < all.size();
       i += n_ranks)
    result.push_back(all[i]);
  return result;
}

void mark(const std::string &name, const std::vector<double> &all, const double share)
{
  const double threshold = marking_threshold(own(all), share, MPI_COMM_WORLD);
  double held = 0, smallest = 1e300, n = 0;
  for (const double square : all)
    if (square >= threshold) {
      held += square;
      smallest = std::min(smallest, square);
      ++n;
    }
  const double total = std::accumulate(all.begin(), all.end(), 0.);
  print(name, {share, n, held / total});
  report("  enough", held >= share * total * (1 - 1e-10));
  report("  no more than needed", held - smallest < share * total);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  mark("1 ... 4", {1, 2, 3, 4}, 0.4);
  mark("1 ... 4", {1, 2, 3, 4}, 0.41);
  mark("1 ... 4", {1, 2, 3, 4}, 1);
  mark("one large", {1e-20, 5, 1e-20, 1e-20, 1e-20}, 0.99);
  std::vector<double> many;
  for (unsigned int i = 0; i < 1000; ++i)
    many.push_back(std::exp(10 * noise(i)));
  for (const double share : {0.1, 0.5, 0.9})
    mark("many", many, share);

  // half of four equal ones: all four
  const std::vector<double> equal = {3, 1, 3 * (1 + 1e-9), 1, 3 * (1 - 1e-8), 3};
  const double threshold = marking_threshold(own(equal), 0.5, MPI_COMM_WORLD);
  print("equal ones", {double(std::count_if(equal.begin(), equal.end(),
                                            [&](const double square) { return square >= threshold; }))});

  // nothing to mark
  report("no error", marking_threshold(own({0, 0, 0, 0}), 0.5, MPI_COMM_WORLD) >= 0);
  report("no cells", marking_threshold({}, 0.5, MPI_COMM_WORLD) >= 0);
}
