// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/note.h>

#include <algorithm>

namespace dovetail {

namespace {

/// Made by the first name, whichever file that is in.
std::map<std::string, std::vector<std::string>> &names_of_notes()
{
  static std::map<std::string, std::vector<std::string>> names;
  return names;
}

} // namespace

NoteName::NoteName(const std::string &name, const std::string &occasion) : name(name)
{
  std::vector<std::string> &occasions = names_of_notes()[name];
  if (std::find(occasions.begin(), occasions.end(), occasion) == occasions.end())
    occasions.insert(std::upper_bound(occasions.begin(), occasions.end(), occasion), occasion);
}

const std::map<std::string, std::vector<std::string>> &occasions_of_notes()
{
  return names_of_notes();
}

} // namespace dovetail
