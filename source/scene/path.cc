// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/path.h>

#include <sstream>

namespace dovetail {

std::string join_path(const std::string &path, const std::string &name)
{
  return path.empty() ? name : path + "/" + name;
}

std::string parent_path(const std::string &path)
{
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

std::string last_name(const std::string &path)
{
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

std::string tidy_name(const std::string &name)
{
  std::istringstream words(name);
  std::string word, tidy;
  while (words >> word)
    tidy += (tidy.empty() ? "" : " ") + word;
  return tidy;
}

} // namespace dovetail
