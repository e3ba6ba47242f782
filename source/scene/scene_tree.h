// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// What a scene says, before anybody asks: entries and subsections with the lines they stand in.

#pragma once

#include <dovetail/scene/path.h>

#include <map>
#include <string>
#include <unordered_map>
#include <vector>

namespace dovetail {

/// Where something stands: "scene.prm line 41"; only the file if the line is 0, as in JSON.
struct Location
{
  std::string file;
  unsigned int line = 0;

  std::string text() const { return line == 0 ? file : file + " line " + std::to_string(line); }
};

/// The entries and subsections of a scene in the order in which they were written.
class SceneTree
{
public:
  struct Entry
  {
    std::string name, value;
    Location location;
  };

  struct Subsection
  {
    std::string path; ///< '/' between the names; empty for the scene itself
    Location location;
    std::vector<Entry> entries;
    std::unordered_map<std::string, std::size_t> places = {}; ///< of the entries, by name
  };

  explicit SceneTree(const std::string &file = "");

  const Subsection *find(const std::string &path) const;
  const Entry *find(const std::string &path, const std::string &name) const;
  std::vector<std::string> names_of_subsections(const std::string &path) const;
  /// Where @p path was opened; if the scene does not have it, where the nearest section around it was.
  const Location &location_of(const std::string &path) const;
  const std::vector<Subsection> &subsections() const { return all_subsections; }

  /// Create the subsection, or note that it goes on at @p location.
  void open(const std::string &path, const Location &location);
  /// Set or replace an entry; its subsection must be open.
  void set(const std::string &path, const Entry &entry);
  /// Its subsection must be there.
  void remove(const std::string &path, const std::string &name);

private:
  Subsection *find_to_change(const std::string &path);

  std::vector<Subsection> all_subsections;
  std::unordered_map<std::string, std::size_t> places; ///< of the subsections, by path
};

/// By the names of files: their texts, and why some cannot be read, as of obstacle_to_reading().
struct FileTexts
{
  std::map<std::string, std::string> texts, obstacles;

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &texts &obstacles;
  }
};

/// Deeper ones are no scene.
constexpr unsigned int largest_depth_of_subsections = 20;

/// The text of @p file and of all files it includes.
FileTexts read_files(const std::string &file);

/// @throw UserError for whatever breaks the grammar, naming file and line.
SceneTree parse_prm(const std::string &file, const FileTexts &texts);
SceneTree parse_json(const std::string &file, const FileTexts &texts);

/// Apply "PATH=value" as given by --set; without a value an entry that is there is taken away.
void apply_override(SceneTree &tree, const std::string &assignment);

/// @throw UserError if @p path is too deep.
void check_depth(const std::string &path, const Location &location);

/// @throw UserError unless @p name and @p value can be written to a .prm file and found by a path.
void check_writable(const std::string &name, const std::string &value, const Location &location);

} // namespace dovetail
