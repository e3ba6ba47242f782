// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// Programs that are started, waited for and timed.

#pragma once

#include <functional>
#include <string>
#include <vector>

namespace dovetail {

struct Outcome
{
  int status = 0; ///< exit status; minus the signal's number if a signal ended it
  double seconds = 0;
};

/// Start @p command (its first word is looked for in PATH) with this process's environment as it was before a
/// launcher of ranks changed it, without a terminal, and wait. What it prints goes to the two files.
/// @p each_second is called while it runs. It ends when this process ends.
Outcome run_process(const std::vector<std::string> &command, const std::string &output_file,
                    const std::string &error_file, const std::function<void()> &each_second);

/// The place of this process among those that mpirun started together; 0 of 1 without mpirun. MPI need not be
/// initialized.
unsigned int launched_rank();
unsigned int launched_ranks();

/// The file of the program that runs now.
std::string this_program();

} // namespace dovetail
