// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/free_memory.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>

#ifdef __GLIBC__ // which the headers above define
#include <malloc.h>
#endif
#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace dovetail {

namespace {

constexpr double unknown = std::numeric_limits<double>::infinity();

/// The number behind @p name in a file of names and numbers; without a name the first one.
double number_in(const std::string &file_name, const std::string &name)
{
  std::ifstream file(file_name);
  std::string word;
  double number = unknown;
  if (name.empty())
    return file >> number ? number : unknown; // memory.max may be "max"
  while (file >> word)
    if (word == name)
      return file >> number ? number : unknown;
  return unknown;
}

/// Of the control group in @p directory, in bytes; pages of files can be given up.
double left_in_group(const std::string &directory)
{
  const double files = number_in(directory + "/memory.stat", "inactive_file");
  return number_in(directory + "/memory.max", "") - number_in(directory + "/memory.current", "") +
         (files < unknown ? files : 0);
}

/// The control groups of this process, the innermost first (version 2 of the interface).
std::string innermost_group()
{
  std::ifstream file("/proc/self/cgroup");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("0::/", 0) == 0)
      return line.substr(3);
  return "";
}

} // namespace

double free_memory()
{
  const double KiB_per_MiB = 1024, bytes_per_MiB = 1024 * 1024;
  double least = number_in("/proc/meminfo", "MemAvailable:") / KiB_per_MiB;
  for (std::string group = innermost_group(); !group.empty(); group.erase(group.rfind('/')))
    if (const double left = left_in_group("/sys/fs/cgroup" + group); left < unknown) // not if NaN
      least = std::min(least, left / bytes_per_MiB);
  return least;
}

void give_back_freed_memory()
{
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

void give_back_pages([[maybe_unused]] void *const begin, [[maybe_unused]] void *const end)
{
#ifdef __linux__
  const auto size = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE)),
             first = (reinterpret_cast<std::uintptr_t>(begin) + size - 1) / size * size,
             last = reinterpret_cast<std::uintptr_t>(end) / size * size;
  if (first < last)
    madvise(reinterpret_cast<void *>(first), last - first, MADV_DONTNEED);
#endif
}

} // namespace dovetail
