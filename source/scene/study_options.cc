// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/path.h>
#include <dovetail/scene/study_options.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <set>

namespace dovetail {

using dealii::Utilities::trim;

namespace {

/// Every part, also empty ones, without blanks around it.
std::vector<std::string> split(const std::string &text, const char separator)
{
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(trim(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return parts;
}

/// 'Interface seam / Theta' as 'Interface seam/Theta'.
std::string tidy_path(const std::string &text)
{
  std::string path;
  for (const std::string &name : split(text, '/')) {
    if (name.empty())
      throw UserError(
          "has the path '" + text +
          "', which is not understood. Write it as for --set, for instance Interface seam/Theta.");
    path = join_path(path, tidy_name(name));
  }
  return path;
}

VariedEntries parse_list(const std::string &text)
{
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos)
    throw UserError("has '" + text +
                    "', which is not understood. Write PATH : value | value, for instance "
                    "Interface seam/Theta : 1 | 0 | -1; a ';' separates two such lists.");
  VariedEntries result;
  for (const std::string &path : split(text.substr(0, colon), ','))
    result.paths.push_back(tidy_path(path));
  for (const std::string &value : split(text.substr(colon + 1), '|')) {
    if (value.empty())
      throw UserError("has an empty value in '" + text + "'. Remove a '|' or say what stands there.");
    if (std::count(result.values.begin(), result.values.end(), value) > 0)
      throw UserError("has the value '" + value + "' twice in '" + text + "'.");
    result.values.push_back(value);
  }
  return result;
}

template <typename T>
bool has_twice(const std::vector<T> &list)
{
  return std::set<T>(list.begin(), list.end()).size() != list.size();
}

} // namespace

std::vector<VariedEntries> parse_vary(const std::string &text)
{
  std::vector<VariedEntries> result;
  std::set<std::string> paths;
  if (trim(text).empty())
    return result;
  for (const std::string &list : split(text, ';')) {
    if (list.empty())
      throw UserError("has a ';' with nothing before or after it. Remove it.");
    result.push_back(parse_list(list));
    for (const std::string &path : result.back().paths) {
      if (!paths.insert(path).second)
        throw UserError("has the path '" + path + "' twice. Join the two lists.");
      if (path.rfind("Study/", 0) == 0 || path == "Output/Directory" || path == "Dimension")
        throw UserError("cannot vary '" + path + "', which all runs share. Remove it.");
    }
  }
  return result;
}

std::vector<Variant> product(const std::vector<VariedEntries> &vary)
{
  std::vector<Variant> variants(1);
  for (const VariedEntries &list : vary) {
    std::vector<Variant> longer;
    for (const Variant &variant : variants)
      for (const std::string &value : list.values) {
        longer.push_back(variant);
        for (const std::string &path : list.paths)
          longer.back().entries.emplace_back(path, value);
      }
    variants = std::move(longer);
  }
  return variants;
}

void name_variants(const std::vector<VariedEntries> &vary, const std::string &name_of_scene,
                   std::vector<Variant> &variants)
{
  for (Variant &variant : variants) {
    variant.name.clear();
    for (const VariedEntries &list : vary) {
      const auto entry = std::find_if(variant.entries.begin(), variant.entries.end(), [&](const auto &of) {
        return std::count(list.paths.begin(), list.paths.end(), of.first) > 0;
      });
      if (entry == variant.entries.end() || list.values.size() == 1)
        continue;
      const std::string last = last_name(list.paths.front());
      const bool is_alone = std::count_if(vary.begin(), vary.end(), [&](const auto &other) {
                              return other.values.size() > 1 && last_name(other.paths.front()) == last;
                            }) == 1;
      variant.name += (variant.name.empty() ? "" : ", ") +
                      (is_alone ? (last == "Type" ? "" : last + " = ") : list.paths.front() + " = ") +
                      entry->second;
    }
    if (variant.name.empty())
      variant.name = name_of_scene;
  }
}

StudyOptions::StudyOptions(const Section &section)
    : levels(section.read<std::vector<unsigned int>>(
          "Levels", {0, 1, 2}, "--study: refinements of every domain beyond those of the scene [-]",
          Patterns::List(Patterns::Integer(0, 20), 1))),
      refinement(section.read<std::string>(
          "Refinement", "as given",
          "--study: what the levels are: refinements of all cells, with the Adaptive cycles and Tolerances "
          "of "
          "the scene as they are (as given) or without (uniform); Adaptive cycles, with the Tolerances of "
          "probes as their aim (adaptive); or two variants, uniform and adaptive (both) [-]",
          Patterns::Selection("as given|uniform|adaptive|both"))),
      cycles_per_level(section.read<unsigned int>(
          "Cycles per level", 2, "--study: adaptive cycles that make a level [-]", Patterns::Integer(1, 50))),
      n_repeats(section.read<unsigned int>("Repeat", 1,
                                           "--study: number of repetitions of each run; times are the "
                                           "median. What decides who is first is done "
                                           "three times in any case [-]",
                                           Patterns::Integer(1))),
      ranks(section.read<std::vector<unsigned int>>("Ranks", {},
                                                    "--study: numbers of ranks, each with its own curve; if "
                                                    "empty, the number of ranks of the launch [-]",
                                                    Patterns::List(Patterns::Integer(1), 0))),
      measure(
          section.read<std::string>("Error", "",
                                    "--study: the error that is shown, for instance temperature H1, or probe "
                                    "NAME for the error against its extrapolated value; if empty, L2 of "
                                    "the first field [-]")),
      reference(section.read<std::string>(
          "Reference", "",
          "--study: the Samples of a run against which errors are measured; if empty, Exact, or if no domain "
          "has Exact, the finest level of the variant with the most unknowns [-]"))
{
  const auto text = section.read<std::string>(
      "Vary", "",
      "--study: PATH : value | value ; PATH : value | value …, where every combination is a variant. PATH is "
      "written as for --set; several paths separated by ',' take the same value [-]");
  section.check(!has_twice(levels), "Levels", "has a level twice.");
  section.check(!has_twice(ranks), "Ranks", "has a number twice.");
  std::sort(levels.begin(), levels.end());
  try {
    vary = parse_vary(text);
  } catch (const UserError &error) {
    section.fail("Vary", error.what());
  }
  if (refinement == "both")
    vary.push_back({{path_of_refinement}, {"uniform", "adaptive"}});
}

} // namespace dovetail
