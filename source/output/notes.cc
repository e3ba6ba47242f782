// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/notes.h>
#include <dovetail/scene/shortened.h>

#include <algorithm>

namespace dovetail {

void Notes::read(const Section &output)
{
  std::vector<std::string> known;
  for (const auto &[name, occasions] : occasions_of_notes())
    known.push_back(name);
  for (const std::string &name :
       output.read<std::vector<std::string>>("Silenced notes", {},
                                             "Names of notes that are neither printed nor reported; the log "
                                             "shows the name of each note, and the end of this page lists "
                                             "all of them [-]",
                                             Patterns::List(Patterns::Anything()))) {
    output.check(std::find(known.begin(), known.end(), name) != known.end(), "Silenced notes",
                 "has '" + name + "', but there are no notes of this name. " + did_you_mean(name, known) +
                     " The names are " + comma_separated(known) + ".");
    silent.insert(name);
  }
}

void Notes::add(const Note &note)
{
  if (silent.count(note.name()) > 0) {
    kept_back.insert(note.name());
    return;
  }
  const std::string sentence = shortened(note.text());
  if (std::find(sentences.begin(), sentences.end(), sentence) != sentences.end())
    return;
  sentences.push_back(sentence);
  names_of_sentences.push_back(note.name());
  print(sentences.size() - 1);
  lines.push_back(log.n_lines());
}

void Notes::add(const NoteList &notes)
{
  for (const Note &note : notes)
    add(note);
}

void Notes::recall(const std::vector<std::string> &names, const std::vector<std::string> &texts)
{
  for (std::size_t i = 0; i < texts.size(); ++i)
    if (silent.count(names[i]) > 0)
      kept_back.insert(names[i]);
    else if (std::find(sentences.begin(), sentences.end(), texts[i]) == sentences.end()) {
      sentences.push_back(texts[i]);
      names_of_sentences.push_back(names[i]);
      lines.push_back(log.n_lines());
    }
}

void Notes::repeat()
{
  const unsigned int lines_of_screen = 24, n_lines = log.n_lines();
  for (std::size_t i = 0; i < sentences.size() && n_lines - lines[i] > lines_of_screen; ++i) {
    if (i == 0)
      log.tell();
    print(i);
  }
}

/// Hundreds of interfaces may have the same to tell, each in its own words.
void Notes::print(const std::size_t i)
{
  const auto end = names_of_sentences.begin() + i;
  const auto n_before = std::count(names_of_sentences.begin(), end, names_of_sentences[i]);
  if (n_before <= most_of_name)
    log.tell(
        "  note (" + names_of_sentences[i] + "): " +
        (n_before < most_of_name ? sentences[i] : "there are more of this name; the report has all of them"));
}

} // namespace dovetail
