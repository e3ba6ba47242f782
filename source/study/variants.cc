// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "variants.h"
#include "process.h"

#include <dovetail/scene/shortened.h>
#include <dovetail/scene/user_error.h>
#include <dovetail/study/run.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>

namespace dovetail {

namespace {

/// From the line "2D, 230 unknowns on 1 rank" of a log.
unsigned long count_of_unknowns(const std::string &log)
{
  std::ifstream in(log);
  for (std::string line; std::getline(in, line);)
    if (line.find(" unknowns on ") != std::string::npos && line.find("D, ") != std::string::npos)
      return std::strtoul(line.c_str() + line.find("D, ") + 3, nullptr, 10);
  return 0;
}

/// What `--check` says of a variant at the coarsest level.
void check(const SceneOfStudy &scene, Variant &variant)
{
  std::vector<std::string> command = {this_program(), "--check"};
  for (const std::string &assignment : scene.overrides_of(variant, scene.options.levels.front()))
    command.insert(command.end(), {"--set", assignment});
  command.push_back(scene.file);
  const std::string log = scene.directory + "/check.log", errors = scene.directory + "/check.errors";
  const Outcome outcome = run_process(command, log, errors, [] {});
  variant.complaint = outcome.status == 1 ? error_message(errors) : "";
  variant.n_unknowns = count_of_unknowns(log);
  std::filesystem::remove(log);
  std::filesystem::remove(errors);
}

/// @return whether the complaint is about an entry that can be left out: one that the variant sets, or one of
/// the scene that belongs to another `Type` than the variant's.
bool leave_out_unknown_entry(const SceneOfStudy &scene, Variant &variant)
{
  const std::string &complaint = variant.complaint;
  const std::string before = ": the entry '", after = "' is not known here";
  const std::size_t begin = complaint.find(before), end = complaint.find(after);
  if (end == std::string::npos)
    return false;
  for (auto entry = variant.entries.begin(); entry != variant.entries.end(); ++entry)
    if (complaint.find(shortened("--set '" + entry->first + "=" + entry->second + "'")) !=
        std::string::npos) {
      variant.left_out.insert(entry->first);
      variant.entries.erase(entry);
      return true;
    }
  if (begin == std::string::npos)
    return false;
  const std::string section_of_entry = complaint.substr(0, complaint.find(", "));
  const std::string path =
      section_of_entry + "/" + complaint.substr(begin + before.size(), end - begin - before.size());
  const bool varies_type =
      std::any_of(variant.entries.begin(), variant.entries.end(),
                  [&](const auto &entry) { return entry.first == section_of_entry + "/Type"; });
  return varies_type && scene.given.count(path) > 0 && variant.left_out.insert(path).second;
}

} // namespace

std::vector<Variant> checked_variants(const SceneOfStudy &scene)
{
  std::vector<Variant> variants = product(scene.options.vary);
  std::map<std::string, std::string> unknown; // and what was said about it
  for (Variant &variant : variants) {
    check(scene, variant);
    while (leave_out_unknown_entry(scene, variant)) {
      for (const std::string &path : variant.left_out)
        unknown.emplace(path, variant.complaint); // the last one is new
      check(scene, variant);
    }
  }
  for (const auto &[path, complaint] : unknown)
    if (std::none_of(variants.begin(), variants.end(), [&, path = path](const Variant &variant) {
          return variant.complaint.empty() && variant.left_out.count(path) == 0;
        }))
      scene.section.fail("Vary", "leaves '" + path + "' unknown in every variant. " + complaint);
  if (std::none_of(variants.begin(), variants.end(), [](const auto &v) { return v.complaint.empty(); }))
    throw UserError(variants.front().complaint);

  name_variants(scene.options.vary, scene.name, variants);
  std::vector<Variant> different;
  for (const Variant &variant : variants)
    if (std::none_of(different.begin(), different.end(),
                     [&](const Variant &other) { return other.entries == variant.entries; })) {
      different.push_back(variant);
      for (const std::string &path : variant.left_out)
        std::cout << "  left out: " << path << " of " << variant.name << ", which does not know it\n";
      if (!variant.complaint.empty())
        std::cout << "  " << variant.name << ": wrong input: " << variant.complaint << '\n';
    }
  return different;
}

} // namespace dovetail
