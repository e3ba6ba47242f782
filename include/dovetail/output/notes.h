// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a user should know about a run.

#pragma once

#include <dovetail/output/log.h>
#include <dovetail/scene/shortened.h>

#include <algorithm>
#include <string>
#include <vector>

namespace dovetail {

/// The only way of a warning: at once into the log, at the end into the report, and each sentence once.
class Notes
{
public:
  explicit Notes(Log &log) : log(log) {}

  void add(const std::string &text)
  {
    const std::string sentence = shortened(text);
    if (std::find(sentences.begin(), sentences.end(), sentence) != sentences.end())
      return;
    sentences.push_back(sentence);
    print(sentence);
    lines.push_back(log.n_lines());
  }
  void add(const std::vector<std::string> &texts)
  {
    for (const std::string &text : texts)
      add(text);
  }

  const std::vector<std::string> &all() const { return sentences; }
  /// Those of a run that goes on have been printed.
  void recall(const std::vector<std::string> &texts)
  {
    for (const std::string &text : texts)
      if (std::find(sentences.begin(), sentences.end(), text) == sentences.end()) {
        sentences.push_back(text);
        lines.push_back(log.n_lines());
      }
  }

  /// Print those again that a screen does not show any more.
  void repeat()
  {
    const unsigned int lines_of_screen = 24, n_lines = log.n_lines();
    for (unsigned int i = 0; i < sentences.size() && n_lines - lines[i] > lines_of_screen; ++i) {
      if (i == 0)
        log.line();
      print(sentences[i]);
    }
  }

private:
  void print(const std::string &sentence) { log.line("  note: " + sentence); }

  Log &log;
  std::vector<std::string> sentences;
  std::vector<unsigned int> lines; ///< of the log up to each of them
};

} // namespace dovetail
