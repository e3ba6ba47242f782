// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What interfaces send from rank to rank, and a count of it.

#pragma once

#include <deal.II/base/index_set.h>
#include <deal.II/base/mpi.h>
#include <deal.II/base/utilities.h>

#include <boost/serialization/array.hpp>
#include <boost/serialization/map.hpp>
#include <boost/serialization/utility.hpp>
#include <boost/serialization/vector.hpp>

#include <map>
#include <set>
#include <utility>
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

/// What is for, or from, each rank.
template <typename T>
using RankMap = std::map<unsigned int, T>;

/// The ranks that own unknowns of a domain. Collective. @p owned: of this rank, as in the domain's
/// DoFHandler;
/// @p first_dof: what the numbers of @p dofs begin with.
std::map<dealii::types::global_dof_index, unsigned int>
owners(const std::set<dealii::types::global_dof_index> &dofs, dealii::types::global_dof_index first_dof,
       const dealii::IndexSet &owned, const MPI_Comm &communicator);

/// Send bytes to other ranks, and count them. If nobody has any, nothing is sent at all. Collective.
RankMap<std::vector<char>> exchange_bytes(const RankMap<std::vector<char>> &bytes,
                                          const MPI_Comm &communicator, InterfaceWork &work);

/// Send objects to other ranks; that for this rank stays where it is. T is a type that boost serialises: a
/// number, a class with serialize(), or a container of such. Collective. @return what came, by the rank it
/// comes from
template <typename T>
RankMap<T> exchange(RankMap<T> objects, const MPI_Comm &communicator, InterfaceWork &work)
{
  auto own = objects.extract(dealii::Utilities::MPI::this_mpi_process(communicator));
  RankMap<std::vector<char>> bytes;
  for (const auto &[rank, object] : objects)
    bytes[rank] = dealii::Utilities::pack(object, false);
  RankMap<T> received;
  for (const auto &[rank, message] : exchange_bytes(bytes, communicator, work))
    received[rank] = dealii::Utilities::unpack<T>(message, false);
  if (!own.empty())
    received.insert(std::move(own));
  return received;
}

} // namespace dovetail
