// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/input_file.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace dovetail {

std::string obstacle_to_reading(const std::string &file, const unsigned long long largest_size)
{
  struct stat status;
  if (stat(file.c_str(), &status) != 0)
    return errno == ENOENT ? "does not exist." : std::string("cannot be read: ") + std::strerror(errno) + ".";
  if (S_ISDIR(status.st_mode))
    return "is a directory.";
  if (!S_ISREG(status.st_mode))
    return "is no file but a pipe, a socket or a device.";
  if (static_cast<unsigned long long>(status.st_size) > largest_size)
    return "has " + std::to_string(status.st_size) + " bytes, but must have at most " +
           std::to_string(largest_size) + ".";
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0)
    return std::string("cannot be read: ") + std::strerror(errno) + ".";
  close(descriptor);
  return "";
}

} // namespace dovetail
