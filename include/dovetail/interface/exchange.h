// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What interfaces send from rank to rank, and a count of it.

#pragma once

#include <deal.II/base/mpi.h>

#include <map>
#include <vector>

namespace dovetail {

/// What an interface has cost this rank, beside sums over all ranks.
struct InterfaceWork
{
  unsigned long locators = 0;            ///< trees of faces built
  unsigned long eigenvalue_problems = 0; ///< of cells behind its points
  unsigned long faces = 0;               ///< received from other ranks, or asked for there
  unsigned long messages = 0;            ///< sent to other ranks
  unsigned long bytes = 0;               ///< in them

  InterfaceWork &operator+=(const InterfaceWork &other)
  {
    locators += other.locators;
    eigenvalue_problems += other.eigenvalue_problems;
    faces += other.faces;
    messages += other.messages;
    bytes += other.bytes;
    return *this;
  }
};

/// Numbers for, or from, each rank.
using OfRanks = std::map<unsigned int, std::vector<double>>;

/// Send numbers to other ranks. Those for this rank stay where they are, and if nobody has any for another
/// rank, nothing is sent at all. Collective. @return what came, by the rank it comes from
OfRanks exchange(OfRanks numbers, const MPI_Comm &communicator, InterfaceWork &work);

} // namespace dovetail
