// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// The scene of a study, from which those of its runs are made.

#pragma once

#include <dovetail/scene/scene_text.h>
#include <dovetail/scene/study_options.h>

#include <map>
#include <string>
#include <vector>

namespace dovetail {

class SceneOfStudy
{
public:
  /// @throw UserError if the file or its section `Study` cannot be read.
  SceneOfStudy(const std::string &file, const std::vector<std::string> &overrides);

  /// All that is set for a run besides what the file says, as for --set; refinements count from those of the
  /// variant.
  std::vector<std::string> overrides_of(const Variant &variant, unsigned int level) const;
  /// A text that holds all that the numbers of a run depend on: what is set, the content of the files named
  /// there, the ranks and the program.
  std::string fingerprint(const std::vector<std::string> &overrides, unsigned int ranks) const;
  bool has_exact() const;                                          ///< an exact solution somewhere
  std::string refinement_of(const Variant &variant) const;         ///< as StudyOptions::refinement
  std::vector<std::string> names(const std::string &plural) const; ///< that an entry of the scene announces

  const std::string file;

private:
  void add_level(const Variant &variant, unsigned int level, const std::map<std::string, std::string> &all,
                 std::vector<std::string> &result) const;

  const std::vector<std::string> given_overrides;
  const std::shared_ptr<SceneText> text;

public:
  const Section section;                          ///< `Study`, for error messages
  const std::map<std::string, std::string> given; ///< path -> value, without those of variants
  const StudyOptions options;
  const std::string name;      ///< of the file, without folder and ending
  const std::string directory; ///< of the results
};

} // namespace dovetail
