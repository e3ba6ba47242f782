// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/end_request.h>

#include <array>
#include <csignal>

namespace dovetail {

namespace {

const std::array<int, 3> requests = {{SIGINT, SIGTERM, SIGUSR1}};
std::array<struct sigaction, 3> before;
volatile std::sig_atomic_t received = 0;

void restore()
{
  for (unsigned int i = 0; i < requests.size(); ++i)
    sigaction(requests[i], &before[i], nullptr);
}

void keep(const int number)
{
  received = number;
  restore();
}

} // namespace

EndRequest::EndRequest()
{
  received = 0;
  struct sigaction action = {};
  action.sa_handler = keep;
  action.sa_flags = SA_RESTART; // what is being written goes on
  sigemptyset(&action.sa_mask);
  for (unsigned int i = 0; i < requests.size(); ++i)
    sigaction(requests[i], &action, &before[i]);
}

EndRequest::~EndRequest()
{
  restore();
}

int EndRequest::signal(const MPI_Comm &communicator)
{
  return dealii::Utilities::MPI::max(static_cast<int>(received), communicator);
}

} // namespace dovetail
