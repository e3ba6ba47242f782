// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/shared_file.h>

#include <algorithm>
#include <vector>

namespace dovetail {

namespace {

constexpr int tag = 2718;
/// Bytes of one message, and all that the first rank holds of what the others write.
constexpr unsigned long long largest_message = 1 << 24;

} // namespace

SharedFile::SharedFile(const std::string &name, const std::string &beginning, const MPI_Comm &communicator)
    : communicator(communicator), rank(dealii::Utilities::MPI::this_mpi_process(communicator)),
      n_ranks(dealii::Utilities::MPI::n_mpi_processes(communicator))
{
  if (rank == 0)
    file = std::make_unique<NewFile>(name, beginning);
}

void SharedFile::append(const char *bytes, const std::size_t n_bytes)
{
  if (rank > 0)
    send(bytes, n_bytes);
  else {
    file->append(bytes, n_bytes);
    for (int other = 1; other < n_ranks; ++other)
      receive(other);
  }
}

void SharedFile::send(const char *bytes, const std::size_t n_bytes) const
{
  const unsigned long long n = n_bytes;
  MPI_Send(&n, 1, MPI_UNSIGNED_LONG_LONG, 0, tag, communicator);
  for (unsigned long long begin = 0; begin < n; begin += largest_message)
    MPI_Send(bytes + begin, std::min(largest_message, n - begin), MPI_CHAR, 0, tag, communicator);
}

/// Also what can no longer be written: the other rank waits until it is taken.
void SharedFile::receive(const int other)
{
  unsigned long long n_bytes = 0;
  MPI_Recv(&n_bytes, 1, MPI_UNSIGNED_LONG_LONG, other, tag, communicator, MPI_STATUS_IGNORE);
  std::vector<char> message(std::min(largest_message, n_bytes));
  for (unsigned long long begin = 0; begin < n_bytes; begin += largest_message) {
    const auto n = std::min(largest_message, n_bytes - begin);
    MPI_Recv(message.data(), n, MPI_CHAR, other, tag, communicator, MPI_STATUS_IGNORE);
    file->append(message.data(), n);
  }
}

Obstacle SharedFile::finish(const OnDisk on_disk)
{
  return agree(rank == 0 ? file->finish(on_disk) : Obstacle(), communicator);
}

Obstacle agree(const Obstacle &found, const MPI_Comm &communicator)
{
  if (!dealii::Utilities::MPI::broadcast(communicator, static_cast<bool>(found))) // as a rule, so no texts
    return {};
  return {dealii::Utilities::MPI::broadcast(communicator, found.text),
          dealii::Utilities::MPI::broadcast(communicator, found.is_of_place)};
}

std::string first_problem(const std::string &own, const MPI_Comm &communicator)
{
  if (dealii::Utilities::MPI::max(own.empty() ? 0U : 1U, communicator) == 0)
    return "";
  const auto gathered = dealii::Utilities::MPI::all_gather(communicator, own);
  return *std::find_if(gathered.begin(), gathered.end(),
                       [](const auto &problem) { return !problem.empty(); });
}

Obstacle write_on_first_rank(const std::string &name, const std::string &beginning, const std::string &text,
                             const MPI_Comm &communicator, const OnDisk on_disk)
{
  const bool is_first = dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
  return agree(is_first ? write_file(name, beginning, text, on_disk) : Obstacle(), communicator);
}

Obstacle bring_to_disk(const MPI_Comm &communicator)
{
  const bool is_first = dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
  return agree(is_first ? bring_to_disk() : Obstacle(), communicator);
}

} // namespace dovetail
