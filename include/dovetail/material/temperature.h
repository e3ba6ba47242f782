// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The scalar that formulas outside of materials call T.

#pragma once

#include <string>

namespace dovetail {

inline bool is_temperature(const std::string &field)
{
  return field == "temperature";
}

} // namespace dovetail
