// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/group_solver.h>

#include <stdexcept>

namespace dovetail {

bool Agreement::succeeds(const std::string &place, const std::function<void()> &action) const
{
  const auto is_agreed = [this](const auto &what) {
    bool is_good = true;
    try {
      what();
    } catch (...) { // no convergence, no preconditioner, no memory; Epetra throws numbers
      is_good = false;
    }
    return dealii::Utilities::MPI::min(static_cast<int>(is_good), communicator) == 1;
  };
  return (!fault || is_agreed([&]() { fault(place); })) && is_agreed(action);
}

void Agreement::run(const std::string &place, const std::function<void()> &action) const
{
  if (!succeeds(place, action))
    throw std::runtime_error(place + " failed");
}

} // namespace dovetail
