// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#pragma once

#include <string>

namespace dovetail {

/// A message for people: what stands between two ' has at most 200 characters, all of it at most 3000, and
/// nothing controls the terminal.
std::string shortened(const std::string &message);

} // namespace dovetail
