// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Sentences that the program volunteers, and the names by which a scene silences them.

#pragma once

#include <map>
#include <string>
#include <vector>

namespace dovetail {

/// A sentence with the name under which `Silenced notes` knows it. Only a NoteName makes one from nothing.
class Note
{
public:
  const std::string &name() const { return note_name; }
  const std::string &text() const { return sentence; }
  /// The same, of the thing that stands before the colon.
  Note of(const std::string &what) const { return {note_name, what + ": " + sentence}; }

private:
  friend class NoteName;
  Note(const std::string &name, const std::string &text) : note_name(name), sentence(text) {}

  std::string note_name, sentence;
};

using NoteList = std::vector<Note>;

/// Stands where notes of this name are raised, as a constant of the file: no list elsewhere knows it. Several
/// files may have the same name.
class NoteName
{
public:
  /// @p occasion: when such a note is told, for the reference: "two sides that differ by more than …"
  NoteName(const std::string &name, const std::string &occasion);

  Note operator()(const std::string &text) const { return {name, text}; }

private:
  const std::string name;
};

/// The occasions of all names that there are, those of plugins that have been loaded included.
const std::map<std::string, std::vector<std::string>> &occasions_of_notes();

} // namespace dovetail
