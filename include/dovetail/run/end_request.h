// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A person, or a batch system whose time is over, asks a run to end.

#pragma once

#include <deal.II/base/mpi.h>

namespace dovetail {

/// While it lives SIGINT (Ctrl-C), SIGTERM and SIGUSR1 do not end the process but wait until they are asked
/// for. The second one does what it did before. One at a time.
class EndRequest
{
public:
  EndRequest();
  ~EndRequest();
  EndRequest(const EndRequest &) = delete;
  EndRequest &operator=(const EndRequest &) = delete;

  /// The number of a signal that some rank has received; 0: none. Collective.
  static int signal(const MPI_Comm &communicator);
};

} // namespace dovetail
