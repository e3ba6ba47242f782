// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Tables in files: table(T, file.csv) means table(T, x_1, y_1, x_2, y_2, ...) with the two columns of the
// file.

#include "scene_tree.h"

#include <dovetail/scene/user_error.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>
#include <sstream>

namespace dovetail {

namespace {

/// Of the name of a file in a formula.
struct Place
{
  std::size_t begin, length;
};

bool is_number(const std::string &text)
{
  char *end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return end != text.c_str() && *end == 0 && std::isfinite(value);
}

/// Whether a table( begins before the parenthesis at @p open.
bool is_table(const std::string &formula, const std::size_t open)
{
  std::size_t end = open;
  while (end > 0 && formula[end - 1] == ' ')
    --end;
  const bool fits = end >= 5 && formula.compare(end - 5, 5, "table") == 0;
  return fits && (end == 5 ||
                  (!std::isalnum(static_cast<unsigned char>(formula[end - 6])) && formula[end - 6] != '_'));
}

/// The last argument of a table, if it is the second and no number: "T, file.csv)".
std::vector<Place> files_in(const std::string &formula)
{
  std::vector<Place> files;
  for (std::size_t open = formula.find('('); open != std::string::npos; open = formula.find('(', open + 1)) {
    if (!is_table(formula, open))
      continue;
    std::vector<std::size_t> commas;
    std::size_t i = open + 1;
    for (int depth = 1; i < formula.size() && depth > 0; ++i) {
      depth += formula[i] == '(' ? 1 : formula[i] == ')' ? -1 : 0;
      if (depth == 1 && formula[i] == ',')
        commas.push_back(i);
    }
    if (commas.size() != 1)
      continue;
    const std::size_t begin = formula.find_first_not_of(' ', commas[0] + 1);
    const std::size_t last = formula.find_last_not_of(' ', i - 2);
    if (begin != std::string::npos && last != std::string::npos && last >= begin && last < i &&
        !is_number(formula.substr(begin, last + 1 - begin)))
      files.push_back({begin, last + 1 - begin});
  }
  std::sort(files.begin(), files.end(), [](const Place &a, const Place &b) { return a.begin < b.begin; });
  return files;
}

std::vector<std::string> words_of(std::string line)
{
  line = line.substr(0, line.find('#'));
  for (char &letter : line)
    if (letter == ',' || letter == ';' || letter == '\t' || letter == '\r')
      letter = ' ';
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;)
    words.push_back(word);
  return words;
}

/// "x_1, y_1, x_2, y_2, …" of two columns; the first line may be a heading without a number.
std::string pairs_of(const std::string &file, const std::string &text)
{
  std::istringstream lines(text);
  std::string pairs, line;
  unsigned int number = 0, n_pairs = 0;
  double last = 0;
  bool may_be_heading = true;
  while (std::getline(lines, line)) {
    ++number;
    const auto words = words_of(line);
    if (words.empty())
      continue;
    const auto fail = [&](const std::string &message) {
      throw UserError("names the table " + file + ", whose line " + std::to_string(number) + " " + message);
    };
    const bool has_numbers = std::all_of(words.begin(), words.end(), is_number);
    const bool is_heading = may_be_heading && std::none_of(words.begin(), words.end(), is_number);
    may_be_heading = false;
    if (is_heading)
      continue;
    if (words.size() != 2 || !has_numbers)
      fail("is '" + dealii::Utilities::trim(line).substr(0, 40) +
           "', but must be two numbers: argument, value. Decimals are written with a point.");
    const double x = std::strtod(words[0].c_str(), nullptr);
    if (n_pairs++ > 0 && !(x > last))
      fail("has an argument that is not larger than the one before. Sort the lines.");
    last = x;
    pairs += (pairs.empty() ? "" : ", ") + words[0] + ", " + words[1];
  }
  if (n_pairs < 2)
    throw UserError("names the table " + file + ", which has " + std::to_string(n_pairs) +
                    " pairs of numbers, but needs two or more.");
  return pairs;
}

} // namespace

FileTexts read_tables(SceneTree &tree)
{
  std::set<std::string> files;
  std::vector<std::pair<std::string, SceneTree::Entry>> changed;
  for (const SceneTree::Subsection &subsection : tree.subsections())
    for (const SceneTree::Entry &entry : subsection.entries) {
      auto places = files_in(entry.value);
      SceneTree::Entry found = entry;
      std::reverse(places.begin(), places.end());
      for (const Place &place : places) {
        const std::string path =
            find_file(entry.value.substr(place.begin, place.length), entry.location, tree);
        found.value.replace(place.begin, place.length, path);
        files.insert(path);
      }
      if (!places.empty())
        changed.emplace_back(subsection.path, found);
    }
  for (const auto &[path, entry] : changed)
    tree.set(path, entry);
  return files.empty() ? FileTexts() : read_on_first_rank({files.begin(), files.end()});
}

std::string replace_between_files(const std::string &formula,
                                  const std::function<std::string(const std::string &part)> &replace)
{
  std::string replaced;
  std::size_t begin = 0;
  for (const Place &file : files_in(formula)) {
    replaced += replace(formula.substr(begin, file.begin - begin)) + formula.substr(file.begin, file.length);
    begin = file.begin + file.length;
  }
  return replaced + replace(formula.substr(begin));
}

std::string with_tables(const std::string &formula, const FileTexts &tables)
{
  auto places = files_in(formula);
  std::string result = formula;
  std::reverse(places.begin(), places.end());
  for (const Place &place : places) {
    const std::string file = formula.substr(place.begin, place.length);
    if (const auto obstacle = tables.obstacles.find(file); obstacle != tables.obstacles.end())
      throw UserError("names the table " + file + ", which " + obstacle->second +
                      " A relative path starts beside the scene or in the working directory.");
    if (const auto text = tables.texts.find(file); text != tables.texts.end())
      result.replace(place.begin, place.length, pairs_of(file, text->second));
  }
  return result;
}

} // namespace dovetail
