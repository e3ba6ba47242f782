// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "scene_of_study.h"

#include <dovetail/scene/input_file.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <dlfcn.h>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace dovetail {

namespace {

using Given = std::map<std::string, std::string>; ///< path -> value

std::string find_given(const Given &given, const std::string &path, const std::string &otherwise = "")
{
  const auto found = given.find(path);
  return found == given.end() || found->second.empty() ? otherwise : found->second;
}

/// FNV-1a of what is in a file (Fowler, Noll and Vo 1991).
std::string content_hash(const std::string &file)
{
  static std::map<std::string, std::string> known;
  if (const auto found = known.find(file); found != known.end())
    return found->second;
  if (!obstacle_to_reading(file).empty())
    return known[file] = "cannot be read"; // the runs say so
  std::ifstream in(file, std::ios::binary);
  std::uint64_t hash = 14695981039346656037U;
  for (std::istreambuf_iterator<char> letter(in), end; letter != end; ++letter)
    hash = (hash ^ static_cast<unsigned char>(*letter)) * 1099511628211U;
  return known[file] = std::to_string(hash);
}

/// The version, and when the library that holds this function was built.
std::string stamp_of_program()
{
  std::string stamp = DOVETAIL_VERSION;
  Dl_info library;
  std::error_code error;
  if (dladdr(reinterpret_cast<void *>(&find_given), &library) != 0 && library.dli_fname != nullptr) {
    const auto time = std::filesystem::last_write_time(library.dli_fname, error);
    if (!error)
      stamp += " " + std::to_string(time.time_since_epoch().count());
  }
  return stamp;
}

} // namespace

SceneOfStudy::SceneOfStudy(const std::string &file, const std::vector<std::string> &overrides)
    : file(file), given_overrides(overrides), text(SceneText::from_file(file, overrides)),
      section(SceneText::root(text).subsection("Study")), given(text->given()), options(section),
      name(text->name()), directory(find_given(given, "Output/Directory", "output/" + name))
{
}

std::vector<std::string> SceneOfStudy::overrides_of(const Variant &variant, const unsigned int level) const
{
  std::vector<std::string> result = given_overrides;
  for (const std::string &path : variant.left_out)
    if (given.count(path) > 0)
      result.push_back(path + "=");
  for (const auto &[path, value] : variant.entries)
    result.push_back(path + "=" + value);
  const Given with_variant = SceneText::from_file(file, result)->given();
  add_level(variant, level, with_variant, result);
  if (find_given(with_variant, "Output/Paraview").empty())
    result.push_back("Output/Paraview=false");
  if (!options.reference.empty())
    result.push_back("Output/Reference=" + options.reference);
  return result;
}

/// Refinements of all cells, or adaptive cycles: then tolerances of probes choose what the cycles look at,
/// and are too small to end them. @p all: what is given, the variant included.
void SceneOfStudy::add_level(const Variant &variant, const unsigned int level,
                             const std::map<std::string, std::string> &all,
                             std::vector<std::string> &result) const
{
  const std::string refinement = refinement_of(variant);
  const bool is_adaptive = refinement == "adaptive" && level > 0;
  if (refinement != "as given") {
    result.push_back("Adaptive cycles=" + std::to_string(is_adaptive ? options.cycles_per_level * level : 0));
    for (const std::string &probe : dealii::Utilities::split_string_list(find_given(all, "Probes"), ','))
      if (const std::string path = "Probe " + probe + "/Tolerance";
          std::strtod(find_given(all, path).c_str(), nullptr) > 0)
        result.push_back(path + (is_adaptive ? "=1e-12" : "=0"));
  }
  if (level == 0 || is_adaptive)
    return;
  for (const std::string &domain : dealii::Utilities::split_string_list(find_given(all, "Domains"), ',')) {
    const std::string path = "Domain " + domain + "/Mesh/Refinements";
    const std::string own = find_given(all, path, "0");
    if (own.find_first_not_of("0123456789") == std::string::npos && own.size() < 4)
      result.push_back(path + "=" + std::to_string(std::stoul(own) + level));
  } // else the reader complains about it
}

std::string SceneOfStudy::fingerprint(const std::vector<std::string> &overrides,
                                      const unsigned int ranks) const
{
  std::string result = "program " + stamp_of_program() + "\nranks " + std::to_string(ranks) + "\n";
  for (const auto &[path, value] : SceneText::from_file(file, overrides)->given())
    if (path.rfind("Study/", 0) != 0 && path != "Output/Directory") {
      result += path + " = " + value + "\n";
      const std::string last = path.substr(path.rfind('/') + 1);
      if ((last == "File" || last == "Reference") && !value.empty())
        result += "  content " + content_hash(value) + "\n";
    }
  return result;
}

std::string SceneOfStudy::refinement_of(const Variant &variant) const
{
  for (const auto &[path, value] : variant.entries)
    if (path == path_of_refinement)
      return value;
  return options.refinement;
}

std::vector<std::string> SceneOfStudy::names(const std::string &plural) const
{
  return dealii::Utilities::split_string_list(find_given(given, plural), ',');
}

bool SceneOfStudy::has_exact() const
{
  return std::any_of(given.begin(), given.end(), [](const auto &entry) {
    return entry.first.find("/Exact/") != std::string::npos && !entry.second.empty();
  });
}

} // namespace dovetail
