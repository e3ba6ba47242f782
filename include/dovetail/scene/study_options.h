// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a study compares: `subsection Study` of a scene.

#pragma once

#include <dovetail/scene/section.h>

#include <set>
#include <string>
#include <utility>
#include <vector>

namespace dovetail {

/// Entries that take the same values together: "PATH, PATH : value | value".
struct VariedEntries
{
  std::vector<std::string> paths; ///< '/' between subsections
  std::vector<std::string> values;
};

/// "PATH, PATH : value | value ; PATH : value | value". Values may contain anything but '|' and ';'.
/// @throw UserError that says what is wrong, without a place.
std::vector<VariedEntries> parse_vary(const std::string &text);

/// One choice of values: what is set, path and value, in the order of `Vary`.
struct Variant
{
  std::string name;
  std::vector<std::pair<std::string, std::string>> entries;
  std::set<std::string> left_out; ///< paths that the scene or `Vary` sets and that it does not know
  std::string complaint;          ///< why it is no legal scene, or empty
  unsigned long n_unknowns = 0;   ///< at the coarsest level
};

/// The product of all values, the last list running fastest; not named yet.
std::vector<Variant> product(const std::vector<VariedEntries> &vary);

/// Names as short as they can be: the value for a `Type`, else "Theta = 1", with the whole path where two
/// lists end in the same word. A list with one value does not show. A study without `Vary` has one variant,
/// named @p name_of_scene.
void name_variants(const std::vector<VariedEntries> &vary, const std::string &name_of_scene,
                   std::vector<Variant> &variants);

/// The entry of variants that refine adaptively or not.
constexpr const char *path_of_refinement = "Study/Refinement";

struct StudyOptions
{
  /// Reads the section `Study`.
  explicit StudyOptions(const Section &section);

  std::vector<unsigned int> levels; ///< ascending
  std::vector<VariedEntries> vary;
  std::string refinement; ///< what a level is: as given, uniform or adaptive; of a variant that says nothing
  unsigned int cycles_per_level; ///< adaptive
  unsigned int n_repeats;
  std::vector<unsigned int> ranks; ///< empty: those of the launch
  std::string measure;             ///< "temperature L2"; empty: L2 of the first field
  std::string reference;           ///< file of samples; empty: Exact or the finest level
};

} // namespace dovetail
