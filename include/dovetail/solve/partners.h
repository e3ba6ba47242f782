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

/// Numbers at the places of @p from go to other ranks, one message to each; @p take gets each of the places
/// of
/// @p to, rank by rank, and the number that comes for it. Nobody waits for a rank that is no partner: an
/// import of Trilinos has all ranks wait for each other first.
template <typename Take>
void exchange_numbers(const std::vector<double *> &arrays, const Partners &from, const Partners &to,
                      const MPI_Comm &communicator, const Take &take)
{
  const int tag = 3141;
  std::vector<MPI_Request> requests;
  std::vector<std::vector<double>> messages;
  messages.reserve(to.size() + from.size());
  for (const auto &[rank, places] : to) {
    std::vector<double> &message = messages.emplace_back(places.size());
    MPI_Irecv(message.data(), message.size(), MPI_DOUBLE, rank, tag, communicator, &requests.emplace_back());
  }
  for (const auto &[rank, places] : from) {
    std::vector<double> &message = messages.emplace_back();
    message.reserve(places.size());
    for (const SharedNumber &place : places)
      message.push_back(arrays[place.array][place.index]);
    MPI_Isend(message.data(), message.size(), MPI_DOUBLE, rank, tag, communicator, &requests.emplace_back());
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
