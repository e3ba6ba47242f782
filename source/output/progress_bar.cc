// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/launcher.h>
#include <dovetail/output/progress_bar.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace dovetail {

namespace {

/// No, where the parent lives on another host, belongs to somebody else or does not say.
bool stdout_of_parent_is_terminal()
{
  const std::string name = "/proc/" + std::to_string(getppid()) + "/fd/1";
  char target[64] = "";
  if (readlink(name.c_str(), target, sizeof(target) - 1) < 0 || std::strncmp(target, "/dev/", 5) != 0)
    return false; // a pipe, a socket or a file is not opened
  const int descriptor = open(name.c_str(), O_WRONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  const bool result = descriptor >= 0 && isatty(descriptor) != 0;
  if (descriptor >= 0)
    close(descriptor);
  return result;
}

} // namespace

std::string progress_bar(const double share)
{
  const double width = 40;
  const auto filled = static_cast<unsigned int>(std::isnan(share) ? 0. : width * std::clamp(share, 0., 1.));
  return "  [" + std::string(filled, '#') + std::string(40 - filled, '.') + "] ";
}

bool stdout_is_terminal()
{
  const char *terminal = std::getenv("TERM");
  return terminal != nullptr && std::strcmp(terminal, "dumb") != 0 && isatty(1) != 0 &&
         (!is_launched() || stdout_of_parent_is_terminal());
}

} // namespace dovetail
