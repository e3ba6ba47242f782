// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a user should know about a run.

#pragma once

#include <dovetail/output/log.h>
#include <dovetail/scene/note.h>
#include <dovetail/scene/section.h>

#include <set>
#include <string>
#include <vector>

namespace dovetail {

/// The only way of a warning: at once into the log, at the end into the report, and each sentence once. Not
/// of a name that the scene silences. The log has the first sentences of each name alone.
class Notes
{
public:
  explicit Notes(Log &log) : log(log) {}

  /// Reads `Silenced notes` of the section `Output`. @pre The plugins are loaded.
  void read(const Section &output);

  void add(const Note &note);
  void add(const NoteList &notes);
  /// Those of a run that goes on, which have been printed.
  void recall(const std::vector<std::string> &names, const std::vector<std::string> &texts);

  const std::vector<std::string> &texts() const { return sentences; }
  const std::vector<std::string> &names() const { return names_of_sentences; }
  /// The silenced names under which something would have been told.
  std::vector<std::string> silenced() const { return {kept_back.begin(), kept_back.end()}; }

  /// Print those again that a screen does not show any more.
  void repeat();

private:
  static constexpr int most_of_name = 8; ///< in the log

  void print(std::size_t i);

  Log &log;
  std::vector<std::string> sentences, names_of_sentences;
  std::vector<unsigned int> lines; ///< of the log up to each of them
  std::set<std::string> silent, kept_back;
};

} // namespace dovetail
