// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/shortened.h>

#include <algorithm>
#include <cctype>

namespace dovetail {

namespace {

/// No letter of UTF-8 is cut in two.
std::string beginning_of(const std::string &text, std::size_t n)
{
  const auto is_continuation = [](const char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; };
  while (n > 0 && n < text.size() && is_continuation(text[n]))
    --n;
  return text.substr(0, n);
}

std::string limited(const std::string &text, const std::size_t largest)
{
  if (text.size() <= largest)
    return text;
  return beginning_of(text, largest - 40) + "... (" + std::to_string(text.size()) + " characters)";
}

} // namespace

std::string shortened(const std::string &message)
{
  std::string result;
  bool is_quoted = false;
  for (std::size_t begin = 0; begin <= message.size(); is_quoted = !is_quoted) {
    const std::size_t end = std::min(message.find('\'', begin), message.size());
    const std::string part = message.substr(begin, end - begin);
    result += (begin > 0 ? "'" : "") + (is_quoted ? limited(part, 200) : part);
    begin = end + 1;
  }
  for (char &letter : result)
    if (std::iscntrl(static_cast<unsigned char>(letter)) != 0 && letter != '\n' && letter != '\t')
      letter = '?';
  return limited(result, 3000);
}

} // namespace dovetail
