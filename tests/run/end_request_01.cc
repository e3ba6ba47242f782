// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A signal that asks for the end on the last rank is known on all of them, and once it is the next one does
// again what it did before; so does one after the end of the request.
//
// ranks: 1, 2, 3

#include <dovetail/run/end_request.h>

#include <csignal>
#include <iostream>

using namespace dovetail;

namespace {

volatile std::sig_atomic_t n_received = 0;

void receive(int)
{
  ++n_received;
}

} // namespace

int main(int argc, char **argv)
{
  const dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD),
                     n_ranks = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
  const auto say = [&](const char *when) {
    const int signal = EndRequest::signal(MPI_COMM_WORLD);
    const int n = dealii::Utilities::MPI::max(static_cast<int>(n_received), MPI_COMM_WORLD);
    if (rank == 0)
      std::cout << when << ": SIGTERM " << (signal == SIGTERM) << ", SIGUSR1 " << (signal == SIGUSR1)
                << ", none " << (signal == 0) << ", received " << n << std::endl;
  };
  std::signal(SIGTERM, receive);
  std::signal(SIGUSR1, receive);
  {
    const EndRequest request;
    say("at first");
    if (rank == n_ranks - 1)
      std::raise(SIGTERM);
    say("asked");
    if (rank == n_ranks - 1)
      std::raise(SIGTERM);
    say("asked twice");
  }
  {
    const EndRequest request;
    say("anew");
    std::raise(SIGUSR1);
    say("asked by all");
  }
  std::raise(SIGUSR1);
  say("after it");
}
