// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Files that are read: what is no file is found before it is opened.

#pragma once

#include <string>

namespace dovetail {

/// Bytes that no scene reaches which a person or a program has written on purpose.
constexpr unsigned long long largest_scene = 1ULL << 24;

/// Why @p file cannot be read, in words that follow its name ("is a directory."), or empty. A pipe or a
/// device is refused without being opened: whoever opens a pipe waits for a writer, and some devices never
/// end. For one process.
std::string obstacle_to_reading(const std::string &file, unsigned long long largest_size = -1ULL);

} // namespace dovetail
