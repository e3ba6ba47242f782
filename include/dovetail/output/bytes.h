// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Numbers as bytes, one after the other, as this machine writes them.

#pragma once

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace dovetail {

/// Adds to @p bytes.
template <typename Number>
void add_number(const Number number, std::string &bytes)
{
  static_assert(std::is_arithmetic<Number>::value, "has no pointers");
  bytes.append(reinterpret_cast<const char *>(&number), sizeof(Number));
}

/// Reads what add_number() has written, which must outlive it.
class NumbersOfBytes
{
public:
  explicit NumbersOfBytes(const std::string &bytes) : bytes(bytes) {}

  bool is_at_end() const { return position == bytes.size(); }

  template <typename Number>
  Number next()
  {
    if (bytes.size() - position < sizeof(Number))
      throw std::runtime_error("a record ends too early");
    Number number;
    std::memcpy(&number, bytes.data() + position, sizeof(Number));
    position += sizeof(Number);
    return number;
  }

private:
  const std::string &bytes;
  std::size_t position = 0;
};

/// A checksum (FNV-1a of Fowler, Noll and Vo, 1991): two records that differ in a bit have different ones.
inline std::uint64_t checksum(const std::string &bytes)
{
  std::uint64_t sum = 14695981039346656037ULL;
  for (const char byte : bytes)
    sum = (sum ^ static_cast<unsigned char>(byte)) * 1099511628211ULL;
  return sum;
}

} // namespace dovetail
