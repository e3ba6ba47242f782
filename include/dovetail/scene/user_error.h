// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Errors of the person who wrote the scene, as opposed to our own (Assert).

#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace dovetail {

/// The input is wrong. The text says what, where in the scene, and what to do. It must be thrown on all ranks
/// alike (agree by a reduction first if only one rank knows); main prints it once and exits with status 1.
class UserError : public std::runtime_error
{
public:
  using std::runtime_error::runtime_error;
};

/// "Did you mean 'x'?" with the candidate nearest to @p word by edit distance; empty if none is near.
std::string did_you_mean(const std::string &word, const std::vector<std::string> &candidates);

/// "a, b, c" for messages; "none" if empty.
std::string comma_separated(const std::vector<std::string> &words);

} // namespace dovetail
