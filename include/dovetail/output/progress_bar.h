// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How much is done, on a terminal.

#pragma once

#include <string>

namespace dovetail {

/// "  [##########..............................] " of a share between 0 and 1; what is outside, or no number,
/// is shown as the nearer of the two, or as 0.
std::string progress_bar(double share);

/// Back to the beginning of the line, which is empty then.
constexpr const char *erase_line = "\r\033[K";

/// Whether somebody looks who wants progress bars. mpirun gives the programs that it starts a terminal of
/// their own, wherever its output goes: then its own output is asked.
bool stdout_is_terminal();

} // namespace dovetail
