// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/exchange.h>

namespace dovetail {

OfRanks exchange(OfRanks numbers, const MPI_Comm &communicator, InterfaceWork &work)
{
  if (dealii::Utilities::MPI::n_mpi_processes(communicator) == 1)
    return numbers;
  const auto own = numbers.extract(dealii::Utilities::MPI::this_mpi_process(communicator));
  for (const auto &[rank, of_rank] : numbers) {
    ++work.messages;
    work.bytes += of_rank.size() * sizeof(double);
  }
  OfRanks received;
  if (dealii::Utilities::MPI::max(numbers.empty() ? 0 : 1, communicator) > 0)
    received = dealii::Utilities::MPI::some_to_some(communicator, numbers);
  if (!own.empty())
    received[own.key()] = own.mapped();
  return received;
}

} // namespace dovetail
