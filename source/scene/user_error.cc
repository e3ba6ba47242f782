// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/user_error.h>

#include <algorithm>
#include <cctype>

namespace dovetail {

namespace {

std::string lower_case(std::string word)
{
  for (char &letter : word)
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  return word;
}

/// How many letters must be inserted, deleted, replaced or swapped with their neighbour (Damerau 1964).
std::size_t edit_distance(const std::string &a, const std::string &b)
{
  std::vector<std::vector<std::size_t>> distance(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        distance[i][j] = i + j;
        continue;
      }
      const std::size_t replaced = distance[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      distance[i][j] = std::min({replaced, distance[i - 1][j] + 1, distance[i][j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        distance[i][j] = std::min(distance[i][j], distance[i - 2][j - 2] + 1);
    }
  return distance[a.size()][b.size()];
}

} // namespace

std::string did_you_mean(const std::string &word, const std::vector<std::string> &candidates)
{
  std::string nearest;
  std::size_t smallest_distance = std::string::npos;
  for (const std::string &candidate : candidates) {
    const std::size_t distance = edit_distance(lower_case(word), lower_case(candidate));
    const std::size_t shorter = std::min(word.size(), candidate.size());
    const std::size_t longer = std::max(word.size(), candidate.size());
    const bool is_near = distance < shorter && distance <= std::max<std::size_t>(1, longer / 3);
    if (candidate != word && is_near && distance < smallest_distance) {
      nearest = candidate;
      smallest_distance = distance;
    }
  }
  return nearest.empty() ? "" : "Did you mean '" + nearest + "'?";
}

std::string comma_separated(const std::vector<std::string> &words)
{
  if (words.empty())
    return "none";
  std::string text = words.front();
  for (std::size_t i = 1; i < words.size(); ++i)
    text += ", " + words[i];
  return text;
}

} // namespace dovetail
