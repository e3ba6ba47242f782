// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Paths of entries and subsections: names with '/' between them, "Interface seam/Theta".

#pragma once

#include <string>

namespace dovetail {

std::string join_path(const std::string &path, const std::string &name);
std::string parent_path(const std::string &path); ///< empty if there is none
std::string last_name(const std::string &path);

/// @p name without surrounding blanks and with single ones inside.
std::string tidy_name(const std::string &name);

} // namespace dovetail
