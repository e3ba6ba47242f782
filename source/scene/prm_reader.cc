// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// deal.II's .prm grammar, strictly and with locations: what is written twice in one file is an error.

#include "scene_tree.h"

#include <dovetail/scene/input_file.h>
#include <dovetail/scene/user_error.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

namespace dovetail {

using dealii::Utilities::trim;

namespace {

/// A line without its comment, joined with those that a final '\' continues it with.
struct LogicalLine
{
  unsigned int number;
  std::string keyword, rest;
};

std::vector<LogicalLine> logical_lines(const std::string &text)
{
  std::vector<LogicalLine> lines;
  std::istringstream stream(text);
  std::string physical, joined;
  unsigned int number = 0, first_number = 0;
  while (std::getline(stream, physical)) {
    ++number;
    if (joined.empty())
      first_number = number;
    std::replace(physical.begin(), physical.end(), '\t', ' ');
    physical = trim(physical);
    const bool continues = !physical.empty() && physical.back() == '\\' && !stream.eof();
    joined += continues ? physical.substr(0, physical.size() - 1) : physical;
    if (continues)
      continue;

    const std::string line = trim(joined.substr(0, joined.find('#')));
    joined.clear();
    if (line.empty())
      continue;
    const std::string keyword = line.substr(0, line.find(' '));
    lines.push_back({first_number, keyword, trim(line.substr(keyword.size()))});
  }
  return lines;
}

/// Under which the place of an included file is known.
std::string key_of_included(const std::string &name, const std::string &includes_it)
{
  return includes_it + '\n' + name;
}

void collect_files(const std::string &file, FileTexts &texts)
{
  if (texts.texts.count(file) > 0 || texts.obstacles.count(file) > 0)
    return;
  if (const std::string obstacle = obstacle_to_reading(file, largest_scene); !obstacle.empty()) {
    texts.obstacles[file] = obstacle;
    return;
  }
  texts.texts[file] = content_of(file);
  for (const LogicalLine &line : logical_lines(texts.texts[file]))
    if (line.keyword == "include") {
      const std::string place = first_that_exists(line.rest, {file});
      texts.places[key_of_included(line.rest, file)] = place;
      collect_files(place, texts);
    }
}

class PrmParser
{
public:
  PrmParser(SceneTree &tree, const FileTexts &texts) : tree(tree), texts(texts) {}

  void parse_file(const std::string &file);

private:
  void parse_line(const LogicalLine &line, const Location &location);
  void open_subsection(const std::string &name, const Location &location);
  void close_subsection(const Location &location);
  void set_entry(const std::string &assignment, const Location &location);
  void include(const std::string &name, const Location &location);
  bool is_being_read(const std::string &file) const;

  SceneTree &tree;
  const FileTexts &texts;
  std::string path;
  std::vector<std::string> files;   ///< the one being read is last, the ones that include it before
  std::vector<unsigned int> depths; ///< of the path where each of these files begins
  std::set<std::pair<std::string, std::string>> openings; ///< (file, path) of all subsections opened so far
};

unsigned int depth_of(const std::string &path)
{
  return path.empty() ? 0 : 1 + std::count(path.begin(), path.end(), '/');
}

void PrmParser::parse_file(const std::string &file)
{
  files.push_back(file);
  depths.push_back(depth_of(path));
  for (const LogicalLine &line : logical_lines(texts.texts.at(file)))
    parse_line(line, {file, line.number});

  if (depth_of(path) > depths.back()) {
    while (depth_of(path) > depths.back() + 1)
      path = parent_path(path);
    throw UserError(tree.location_of(path).text() + ": the subsection '" + path +
                    "', or one inside it, has no 'end'.");
  }
  files.pop_back();
  depths.pop_back();
}

void PrmParser::parse_line(const LogicalLine &line, const Location &location)
{
  const std::string keyword = line.keyword;
  if (keyword == "set")
    set_entry(line.rest, location);
  else if (keyword == "subsection")
    open_subsection(tidy_name(line.rest), location);
  else if (keyword == "end" && line.rest.empty())
    close_subsection(location);
  else if (keyword == "include")
    include(line.rest, location);
  else {
    const std::string text = trim(keyword + " " + line.rest);
    const std::string guess = did_you_mean(keyword, {"set", "subsection", "end", "include"});
    throw UserError(trim(
        location.text() + ": '" + text +
        "' is not understood. A line begins with set, subsection, end, include or #. " +
        (guess.empty() && text.find('=') != std::string::npos ? "Did you mean 'set " + text + "'?" : guess)));
  }
}

void PrmParser::open_subsection(const std::string &name, const Location &location)
{
  check_writable(name, "", location);
  path = join_path(path, name);
  check_depth(path, location);
  if (!openings.insert({location.file, path}).second)
    throw UserError(location.text() + ": the subsection '" + path +
                    "' is opened a second time; the first is in " + tree.location_of(path).text() +
                    ". Join the two or rename one.");
  tree.open(path, location);
}

void PrmParser::close_subsection(const Location &location)
{
  if (depth_of(path) == depths.back())
    throw UserError(location.text() + ": this 'end' has no 'subsection' that it could close.");
  path = parent_path(path);
}

void PrmParser::set_entry(const std::string &assignment, const Location &location)
{
  const std::size_t equal_sign = assignment.find('=');
  if (equal_sign == std::string::npos)
    throw UserError(location.text() + ": 'set " + assignment + "' has no '='. Write 'set name = value'.");
  const std::string name = tidy_name(assignment.substr(0, equal_sign));
  const std::string value = trim(assignment.substr(equal_sign + 1));
  check_writable(name, value, location);

  // A file may override what it has included, but not itself, nor may it be overridden by what it includes.
  const SceneTree::Entry *old = tree.find(path, name);
  if (old && is_being_read(old->location.file))
    throw UserError(location.text() + ": '" + name + "' is set a second time" +
                    (path.empty() ? "" : " in '" + path + "'") + "; the first is in " + old->location.text() +
                    ". Remove one" +
                    (old->location.file == location.file ? "." : ", or include the file first."));
  tree.set(path, {name, value, location});
}

void PrmParser::include(const std::string &name, const Location &location)
{
  const auto place = texts.places.find(key_of_included(name, location.file));
  const std::string file = place == texts.places.end() ? name : place->second;
  if (is_being_read(file))
    throw UserError(location.text() + ": '" + file + "' includes itself.");
  if (const auto found = texts.obstacles.find(file); found != texts.obstacles.end())
    throw UserError(
        location.text() + ": the file '" + file + "' " + found->second +
        " A relative path starts beside the file that includes it or in the directory in which the program "
        "was started.");
  parse_file(file);
}

bool PrmParser::is_being_read(const std::string &file) const
{
  return std::find(files.begin(), files.end(), file) != files.end();
}

} // namespace

FileTexts read_files(const std::string &file)
{
  FileTexts texts;
  collect_files(file, texts);
  return texts;
}

SceneTree parse_prm(const std::string &file, const FileTexts &texts)
{
  SceneTree tree(file);
  PrmParser(tree, texts).parse_file(file);
  return tree;
}

} // namespace dovetail
