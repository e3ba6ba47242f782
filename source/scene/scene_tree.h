// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// What a scene says, before anybody asks: entries and subsections with the lines they stand in.

#pragma once

#include <dovetail/scene/path.h>

#include <functional>
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
    bool is_in_si = false; ///< from a file of materials, to be converted to the Units of the scene
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

/// By the paths of files: their texts, and why some cannot be read, as of obstacle_to_reading(); and the
/// paths of included files by who includes them under which name.
struct FileTexts
{
  std::map<std::string, std::string> texts, obstacles, places = {};

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &texts &obstacles &places;
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

/// Take from the files that `Materials file` names what the scene does not say about its Materials
/// (materials_file.cc). Collective.
void read_materials_files(SceneTree &tree);

/// The path of a file: beside one of the other @p files, else as it is, in the working directory.
std::string first_that_exists(const std::string &name, const std::vector<std::string> &files);

/// The same for a file that is named at @p from: beside that file, beside the scene, in the working
/// directory, as the first rank sees it. Collective.
std::string find_file(const std::string &name, const Location &from, const SceneTree &tree);

/// The text of a .prm file and of all files it includes, for all ranks. Collective.
FileTexts read_files_on_first_rank(const std::string &file);
/// The texts of these files, for all ranks. Collective.
FileTexts read_on_first_rank(const std::vector<std::string> &files);

/// The content of a file, without the byte order mark that some editors and spreadsheets write.
std::string content_of(const std::string &file);

/// The texts of all tables that the formulas of a scene name, table(T, file.csv); the entries get the paths
/// where these files were found. Collective.
FileTexts read_tables(SceneTree &tree);

/// The value of an entry in SI, whose unit ends the @p description in brackets, in the Units of the scene; in
/// a formula, which the @p range tells, x, y, z and t are in SI, too.
std::string converted_from_si(const SceneTree::Entry &entry, const std::string &description,
                              const std::string &range, const SceneTree &tree);

/// A formula in which the parts between the names of files are replaced.
std::string replace_between_files(const std::string &formula,
                                  const std::function<std::string(const std::string &part)> &replace);

/// A formula with the numbers of its tables in the place of their files.
/// @throw UserError naming file and line
std::string with_tables(const std::string &formula, const FileTexts &tables);

/// @throw UserError if @p path is too deep.
void check_depth(const std::string &path, const Location &location);

/// @throw UserError unless @p name and @p value can be written to a .prm file and found by a path.
void check_writable(const std::string &name, const std::string &value, const Location &location);

} // namespace dovetail
