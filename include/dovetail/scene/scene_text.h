// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The text of a scene (.prm or .json) as a tree of entries with the lines they stand in.

#pragma once

#include <dovetail/scene/section.h>
#include <dovetail/scene/table_lookups.h>

#include <functional>
#include <iosfwd>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// Reads a scene file and keeps, for every entry, its value and where it stands; records every entry that is
/// read through a Section, so that used.prm and the reference of all entries can be written.
///
/// .prm: deal.II's grammar (`subsection`/`end`, `set a = b`, `#` comments, `\` continuation, `include FILE`
/// beside the file or in the working directory). An entry set twice in one file, or a subsection opened
/// twice, is an error; a file may override what it includes. .json: the same tree as nested objects with
/// strings (numbers and booleans are accepted as values); arrays and duplicate keys are errors.
class SceneText
{
public:
  /// @p overrides: "PATH=value" with '/' between subsections, as given by --set; they win over the file.
  /// Rank 0 reads the file (and its includes) and broadcasts it; errors are thrown on all ranks.
  static std::shared_ptr<SceneText> from_file(const std::string &file_name,
                                              const std::vector<std::string> &overrides);
  /// For tests: prm text.
  static std::shared_ptr<SceneText> from_prm(const std::string &prm_text);
  /// For --parameters: everything is documented, nothing is required.
  static std::shared_ptr<SceneText> for_documentation();

  /// The section at the top of @p text.
  static Section root(const std::shared_ptr<SceneText> &text);

  /// @throw UserError naming the first entry or subsection that nobody has read, with its line and the
  /// nearest name that is known there (or what the section knows at all).
  void check_all_read() const;

  /// Every entry that was read, with its value, as a scene that gives the same run (used.prm).
  void print_used(std::ostream &out) const;
  /// The reference: one Markdown heading per section and Type, one table row per entry: name, default (or
  /// "required"), range, description with unit.
  void print_reference(std::ostream &out) const;

  /// Every entry that was read, with its value, by path; those of print_used().
  std::map<std::string, std::string> used() const;
  std::vector<std::string> tables() const; ///< contents of the files that formulas name
  /// @throw UserError for the first entry whose value is not that of @p before, from used() of another scene,
  /// and that @p may_differ does not allow. @p refusal ends the message.
  void check_unchanged(const std::map<std::string, std::string> &before,
                       const std::function<bool(const std::string &path)> &may_differ,
                       const std::string &refusal) const;

  /// The entries with tables that have been read as formulas of scalars.
  const std::vector<FormulaWithTables> &formulas_with_tables() const;

  const std::string &file_name() const;
  std::string name() const; ///< of the file, without folder and ending; names a directory

  /// What the file and the overrides set, by path: "Interface seam/Theta" -> "-1".
  std::map<std::string, std::string> given() const;

  /// The names that boundaries of a domain have, by files or by the scene. @pre The domain has been made.
  BoundaryNames boundary_names(const std::string &domain) const;

  /// One of its own, with what has been given and read so far.
  std::shared_ptr<SceneText> copy() const;

private:
  friend class Section;
  struct Implementation;
  explicit SceneText(std::unique_ptr<Implementation>);

public:
  ~SceneText();

private:
  std::unique_ptr<Implementation> implementation;
};

} // namespace dovetail
