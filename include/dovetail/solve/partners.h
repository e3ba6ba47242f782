// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Messages between ranks that share unknowns.

#pragma once

#include <deal.II/base/mpi.h>

#include <map>
#include <vector>

namespace dovetail {

/// One of the numbers in several arrays.
struct SharedNumber
{
  unsigned int array, index;
};

/// What is shared with each of the other ranks, in the same order there.
using Partners = std::map<unsigned int, std::vector<SharedNumber>>;

/// @param asked by rank, places in its arrays. Collective. @return by rank, what it asks for here
Partners find_who_asks(const Partners &asked, const MPI_Comm &communicator);

/// Numbers at the places of @p from go to other ranks, one message to each; @p take gets the numbers at the
/// places of @p to, rank by rank, and what comes for them. Nobody waits for a rank that is no partner: an
/// import of Trilinos has all ranks wait for each other first.
template <typename Take>
void exchange_numbers(const std::vector<double *> &arrays, const Partners &from, const Partners &to,
                      const MPI_Comm &communicator, const Take &take)
{
  const int tag = 3141;
  std::vector<MPI_Request> requests(to.size() + from.size());
  std::vector<std::vector<double>> messages; // all memory is taken before MPI gets any of it
  messages.reserve(requests.size());
  for (const auto *partners : {&to, &from})
    for (const auto &[rank, places] : *partners)
      messages.emplace_back(places.size());
  unsigned int k = 0;
  for (const auto &[rank, places] : to) {
    MPI_Irecv(messages[k].data(), messages[k].size(), MPI_DOUBLE, rank, tag, communicator, &requests[k]);
    ++k;
  }
  for (const auto &[rank, places] : from) {
    for (unsigned int i = 0; i < places.size(); ++i)
      messages[k][i] = arrays[places[i].array][places[i].index];
    MPI_Isend(messages[k].data(), messages[k].size(), MPI_DOUBLE, rank, tag, communicator, &requests[k]);
    ++k;
  }
  MPI_Waitall(requests.size(), requests.data(), MPI_STATUSES_IGNORE);
  auto message = messages.begin();
  for (const auto &[rank, places] : to) {
    for (unsigned int i = 0; i < places.size(); ++i)
      take(arrays[places[i].array][places[i].index], (*message)[i]);
    ++message;
  }
}

} // namespace dovetail
