// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Tables of the log.

#pragma once

#include <string>
#include <vector>

namespace dovetail {

/// Rows of equally many entries; the first one is the heading.
using Table = std::vector<std::vector<std::string>>;

/// A line for each row, with columns as wide as their widest entry.
std::vector<std::string> align(const Table &rows);

} // namespace dovetail
