// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "picture.h"
#include "process.h"
#include "progress.h"
#include "table.h"

#include <dovetail/scene/scene_text.h>
#include <dovetail/study/study.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <dlfcn.h>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <sstream>

namespace dovetail {

namespace {

using Given = std::map<std::string, std::string>; ///< path -> value

std::string find_given(const Given &given, const std::string &path, const std::string &otherwise = "")
{
  const auto found = given.find(path);
  return found == given.end() || found->second.empty() ? otherwise : found->second;
}

/// For names of directories.
std::string plain(const std::string &name)
{
  std::string result;
  for (const char letter : name) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(letter)) != 0 ||
                          std::string("+-.").find(letter) != std::string::npos;
    if (is_plain)
      result += letter;
    else if (!result.empty() && result.back() != '_')
      result += '_';
  }
  result = result.substr(0, 80);
  return result.substr(0, result.find_last_not_of('_') + 1);
}

/// FNV-1a of what is in a file (Fowler, Noll and Vo 1991).
std::string content_hash(const std::string &file)
{
  static std::map<std::string, std::string> known;
  if (const auto found = known.find(file); found != known.end())
    return found->second;
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
  if (dladdr(reinterpret_cast<void *>(&run_study), &library) != 0 && library.dli_fname != nullptr) {
    const auto time = std::filesystem::last_write_time(library.dli_fname, error);
    if (!error)
      stamp += " " + std::to_string(time.time_since_epoch().count());
  }
  return stamp;
}

std::string fingerprint_of(const Given &given, const unsigned int ranks)
{
  std::string text = "program " + stamp_of_program() + "\nranks " + std::to_string(ranks) + "\n";
  for (const auto &[path, value] : given)
    if (path.rfind("Study/", 0) != 0 && path != "Output/Directory") {
      text += path + " = " + value + "\n";
      const std::string name = path.substr(path.rfind('/') + 1);
      if ((name == "File" || name == "Reference") && !value.empty())
        text += "  content " + content_hash(value) + "\n";
    }
  return text;
}

std::string count_of(const std::size_t n, const std::string &singular)
{
  return std::to_string(n) + " " + singular + (n == 1 ? "" : "s");
}

/// From the line "2D, 230 unknowns on 1 rank" of a log.
unsigned long count_of_unknowns(const std::string &log)
{
  std::ifstream in(log);
  for (std::string line; std::getline(in, line);)
    if (line.find(" unknowns on ") != std::string::npos && line.find("D, ") != std::string::npos)
      return std::strtoul(line.c_str() + line.find("D, ") + 3, nullptr, 10);
  return 0;
}

class Study
{
public:
  Study(const std::string &scene, const std::vector<std::string> &overrides);
  bool run();

private:
  std::vector<std::string> overrides_of(const Variant &variant, unsigned int level) const;
  void check(Variant &variant) const;
  void check_variants();
  bool leave_out_unknown_entry(Variant &variant) const;
  void plan_runs();
  void do_run(StudyRun &run, StudyProgress &progress);
  void make_reference(StudyProgress &progress);
  void perform_runs();
  std::string describe(const StudyRun &run) const;
  unsigned int family_of(unsigned int variant) const;
  std::vector<StudyCurve> curves() const;
  std::string measure() const;
  void write_table_of_runs() const;
  void conclude() const;

  const std::string scene;
  const std::vector<std::string> overrides;
  const std::shared_ptr<SceneText> text;
  const Section section;
  const Given given;
  StudyOptions options;
  const std::string directory;
  const unsigned int dim;
  std::vector<unsigned int> ranks;
  std::vector<Variant> variants;
  std::vector<StudyRun> runs;
  std::string errors_against; ///< in words, or empty
};

Study::Study(const std::string &scene, const std::vector<std::string> &overrides)
    : scene(scene), overrides(overrides), text(SceneText::from_file(scene, overrides)),
      section(SceneText::root(text).subsection("Study")), given(text->given()), options(section),
      directory(find_given(given, "Output/Directory", "output/" + text->name())), dim(section.dimension()),
      ranks(options.ranks), variants(product(options.vary))
{
  if (ranks.empty())
    ranks = {launched_ranks()};
  name_variants(options.vary, text->name(), variants);
}

/// What is set for a run besides what the person has set: refinements count from those of the variant.
std::vector<std::string> Study::overrides_of(const Variant &variant, const unsigned int level) const
{
  std::vector<std::string> result = overrides;
  for (const std::string &path : variant.left_out)
    if (given.count(path) > 0)
      result.push_back(path + "=");
  for (const auto &[path, value] : variant.entries)
    result.push_back(path + "=" + value);
  const Given with_variant = SceneText::from_file(scene, result)->given();
  if (level > 0)
    for (const std::string &domain :
         dealii::Utilities::split_string_list(find_given(with_variant, "Domains"), ',')) {
      const std::string path = "Domain " + domain + "/Mesh/Refinements";
      const std::string own = find_given(with_variant, path, "0");
      if (own.find_first_not_of("0123456789") == std::string::npos && own.size() < 4)
        result.push_back(path + "=" + std::to_string(std::stoul(own) + level));
    } // else the reader complains about it
  if (find_given(with_variant, "Output/Paraview").empty())
    result.push_back("Output/Paraview=false");
  if (!options.reference.empty())
    result.push_back("Output/Reference=" + options.reference);
  return result;
}

/// What `--check` says of a variant at the coarsest level.
void Study::check(Variant &variant) const
{
  std::vector<std::string> command = {this_program(), "--check"};
  for (const std::string &assignment : overrides_of(variant, options.levels.front()))
    command.insert(command.end(), {"--set", assignment});
  command.push_back(scene);
  const std::string log = directory + "/check.log", errors = directory + "/check.errors";
  const Outcome outcome = run_process(command, log, errors, [] {});
  variant.complaint = outcome.status == 1 ? last_words(errors) : "";
  variant.n_unknowns = count_of_unknowns(log);
  std::filesystem::remove(log);
  std::filesystem::remove(errors);
}

/// An entry that a variant does not know, like Theta of a mortar tie, is left out of that variant; variants
/// that are alike then are one. What no variant knows is an error, and so is an input that is wrong in all of
/// them.
void Study::check_variants()
{
  std::map<std::string, std::string> unknown; // and what was said about it
  for (Variant &variant : variants) {
    check(variant);
    while (leave_out_unknown_entry(variant)) {
      for (const std::string &path : variant.left_out)
        unknown.emplace(path, variant.complaint); // the last one is new
      check(variant);
    }
  }
  for (const auto &[path, complaint] : unknown)
    if (std::none_of(variants.begin(), variants.end(), [&, path = path](const Variant &variant) {
          return variant.complaint.empty() && variant.left_out.count(path) == 0;
        }))
      section.fail("Vary", "leaves '" + path + "' unknown in every variant. " + complaint);
  if (std::none_of(variants.begin(), variants.end(), [](const auto &v) { return v.complaint.empty(); }))
    throw UserError(variants.front().complaint);

  name_variants(options.vary, text->name(), variants);
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
  variants = different;
}

/// @return whether the complaint is about an entry that can be left out: one that the variant sets, or one of
/// the scene that belongs to another `Type` than the variant's.
bool Study::leave_out_unknown_entry(Variant &variant) const
{
  const std::string &complaint = variant.complaint;
  const std::string before = ": the entry '", after = "' is not known here";
  const std::size_t begin = complaint.find(before), end = complaint.find(after);
  if (end == std::string::npos)
    return false;
  for (auto entry = variant.entries.begin(); entry != variant.entries.end(); ++entry)
    if (complaint.find("--set '" + entry->first + "=" + entry->second + "'") != std::string::npos) {
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
  return varies_type && given.count(path) > 0 && variant.left_out.insert(path).second;
}

/// Small levels first; what is compared runs side by side in time.
void Study::plan_runs()
{
  std::set<std::string> names;
  for (const unsigned int level : options.levels)
    for (unsigned int repeat = 1; repeat <= options.n_repeats; ++repeat)
      for (unsigned int v = 0; v < variants.size(); ++v)
        for (const unsigned int n_ranks : ranks) {
          StudyRun run;
          run.variant = v;
          run.level = level;
          run.ranks = n_ranks;
          run.repeat = repeat;
          run.overrides = overrides_of(variants[v], level);
          std::string name = plain(variants[v].name) + "_level_" + std::to_string(level);
          if (n_ranks > 1)
            name += "_ranks_" + std::to_string(n_ranks);
          if (repeat > 1)
            name += "_repeat_" + std::to_string(repeat);
          while (!names.insert(name).second)
            name += "_";
          run.directory = directory + "/runs/" + name;
          if (!variants[v].complaint.empty()) {
            run.status = "wrong input";
            run.message = variants[v].complaint;
          }
          runs.push_back(run);
        }
}

std::string Study::describe(const StudyRun &run) const
{
  std::ostringstream words;
  words.precision(3);
  words << variants[run.variant].name << ", level " << run.level;
  if (ranks.size() > 1)
    words << ", " << count_of(run.ranks, "rank");
  if (options.n_repeats > 1)
    words << ", repeat " << run.repeat;
  words << ": " << run.seconds << " s";
  if (run.report.is_object())
    words << ", " << run.report.value("dofs", 0) << " unknowns";
  if (!run.is_converged())
    words << ", " << run.status << (run.message.empty() ? "" : ": ") << run.message;
  return words.str();
}

void Study::do_run(StudyRun &run, StudyProgress &progress)
{
  progress.begin(run);
  StudyRun result = run;
  perform(result, scene, [&] { progress.tick(); });
  progress.end();
  run = result;
  write_table_of_runs();
  const auto n_done =
      std::count_if(runs.begin(), runs.end(), [](const auto &other) { return other.is_done(); });
  progress.line("  " + std::to_string(n_done) + " of " + std::to_string(runs.size()) + "  " + describe(run));
}

/// Without anything else to measure errors against: the finest level of the variant with the most unknowns
/// that converges is done first, and all coarser runs are compared with it. At the finest level itself nobody
/// knows who is right.
void Study::make_reference(StudyProgress &progress)
{
  const std::string file = directory + "/reference.samples";
  std::vector<StudyRun *> candidates;
  for (StudyRun &run : runs)
    if (run.level == options.levels.back() && run.ranks == ranks.front() && run.repeat == 1 && !run.is_done())
      candidates.push_back(&run);
  std::stable_sort(candidates.begin(), candidates.end(), [this](const StudyRun *a, const StudyRun *b) {
    return variants[a->variant].n_unknowns > variants[b->variant].n_unknowns;
  });
  for (StudyRun *run : candidates) {
    run->overrides.push_back("Output/Samples=" + file);
    run->fingerprint = fingerprint_of(SceneText::from_file(scene, run->overrides)->given(), run->ranks);
    if (std::filesystem::exists(file))
      recall(*run);
    if (!run->is_done())
      do_run(*run, progress);
    if (run->is_converged()) {
      for (StudyRun &other : runs)
        if (other.level < options.levels.back())
          other.overrides.push_back("Output/Reference=" + file);
      errors_against = "level " + std::to_string(run->level) + " of " + variants[run->variant].name;
      return;
    }
  }
}

void Study::perform_runs()
{
  StudyProgress progress(runs, dim);
  const bool has_exact = std::any_of(given.begin(), given.end(), [](const auto &entry) {
    return entry.first.find("/Exact/") != std::string::npos && !entry.second.empty();
  });
  if (!options.reference.empty())
    errors_against = options.reference;
  else if (has_exact)
    errors_against = "Exact";
  else if (options.levels.size() > 1)
    make_reference(progress);

  unsigned int n_recalled = 0;
  for (StudyRun &run : runs)
    if (!run.is_done()) {
      run.fingerprint = fingerprint_of(SceneText::from_file(scene, run.overrides)->given(), run.ranks);
      recall(run);
      n_recalled += run.is_done();
    }
  if (n_recalled > 0)
    progress.line(std::to_string(n_recalled) + " of " + std::to_string(runs.size()) +
                  " runs were there already");
  for (StudyRun &run : runs)
    if (!run.is_done())
      do_run(run, progress);
  write_table_of_runs();
}

/// "temperature L2"
std::string Study::measure() const
{
  std::vector<std::string> known;
  for (const StudyRun &run : runs)
    if (run.report.is_object())
      for (const auto &number : numbers_of(run.report))
        if (number.first.rfind("error ", 0) == 0)
          known.push_back(number.first.substr(6));
  if (options.measure.empty())
    for (const std::string &name : known)
      if (name.size() > 3 && name.substr(name.size() - 3) == " L2")
        return name;
  section.check(options.measure.empty() || known.empty() ||
                    std::count(known.begin(), known.end(), options.measure) > 0,
                "Error",
                "is '" + options.measure + "', which no run has measured. Known: " + comma_separated([&] {
                  const std::set<std::string> names(known.begin(), known.end());
                  return std::vector<std::string>(names.begin(), names.end());
                }()) +
                    ".");
  return options.measure;
}

/// Which value of the first list it has.
unsigned int Study::family_of(const unsigned int variant) const
{
  for (const VariedEntries &list : options.vary)
    if (list.values.size() > 1)
      for (const auto &[path, value] : variants[variant].entries)
        if (path == list.paths.front())
          return std::find(list.values.begin(), list.values.end(), value) - list.values.begin();
  return 0;
}

std::vector<StudyCurve> Study::curves() const
{
  const std::string name_of_error = measure();
  std::vector<StudyCurve> result;
  for (unsigned int v = 0; v < variants.size(); ++v)
    for (const unsigned int n_ranks : ranks) {
      StudyCurve curve;
      curve.name = variants[v].name + (ranks.size() > 1 ? ", " + count_of(n_ranks, "rank") : "");
      curve.family = family_of(v);
      for (const unsigned int level : options.levels) {
        std::vector<const StudyRun *> repeats;
        for (const StudyRun &run : runs)
          if (run.variant == v && run.ranks == n_ranks && run.level == level)
            repeats.push_back(&run);
        curve.points.push_back(make_point(repeats, name_of_error));
      }
      result.push_back(curve);
    }
  return result;
}

void Study::write_table_of_runs() const
{
  std::ofstream file(directory + "/study.csv");
  write_csv(file, options.vary, variants, runs);
  file.close();
  if (!file)
    throw UserError("The file '" + directory + "/study.csv' cannot be written. Is the disk full?");
}

void Study::conclude() const
{
  const auto all = curves();
  const std::string measure_name = measure();
  std::string words = table_of(all, measure_name);
  words += errors_against.empty() ? "\n  no errors: there is no Exact, no Reference and no finer level\n"
                                  : "\n  errors against " + errors_against + "\n";
  const auto sentences = who_is_first(all);
  for (const std::string &sentence : sentences)
    words += "  " + sentence + "\n";
  std::ofstream(directory + "/study.txt") << words;
  std::cout << '\n' << words << '\n';
  const std::string obstacle = draw_study(directory, text->name(), all, measure_name, dim);
  std::cout << "  results: " << directory << "/study.csv"
            << (obstacle.empty() ? ", study.txt, study.svg, study.png" : ", study.txt") << std::endl;
  if (!obstacle.empty())
    std::cout << "  " << obstacle << std::endl;
}

bool Study::run()
{
  std::error_code error;
  std::filesystem::create_directories(directory + "/runs", error);
  if (error)
    throw UserError("The directory '" + directory + "' for the results cannot be made: " + error.message() +
                    ". Set Directory in the subsection Output to a place where you may write.");
  std::cout << "\nDovetail " DOVETAIL_VERSION ": study of " << scene << std::endl;
  check_variants();
  plan_runs();
  std::cout << count_of(variants.size(), "variant") << ", " << count_of(options.levels.size(), "level")
            << (ranks.size() > 1 ? ", " + count_of(ranks.size(), "number") + " of ranks" : "")
            << (options.n_repeats > 1 ? ", " + count_of(options.n_repeats, "repeat") : "") << ": "
            << count_of(runs.size(), "run") << (ranks.size() == 1 ? " on " + count_of(ranks[0], "rank") : "")
            << std::endl;
  perform_runs();
  conclude();
  return std::any_of(runs.begin(), runs.end(), [](const StudyRun &run) { return run.is_converged(); });
}

} // namespace

bool is_first_of_launched()
{
  return launched_rank() == 0;
}

bool run_study(const std::string &scene, const std::vector<std::string> &overrides)
{
  return !is_first_of_launched() || Study(scene, overrides).run();
}

} // namespace dovetail
