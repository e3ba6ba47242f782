// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "picture.h"
#include "process.h"
#include "progress.h"
#include "scene_of_study.h"
#include "table.h"
#include "variants.h"

#include <dovetail/output/directory_lock.h>
#include <dovetail/study/study.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <set>
#include <sstream>

namespace dovetail {

namespace {

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

std::string count_of(const std::size_t n, const std::string &singular)
{
  return std::to_string(n) + " " + singular + (n == 1 ? "" : "s");
}

class Study
{
public:
  Study(const std::string &file, const std::vector<std::string> &overrides);
  bool run();

private:
  void plan_runs();
  StudyRun make_run(unsigned int variant, unsigned int level, unsigned int n_ranks, unsigned int repeat);
  void do_run(StudyRun &run, StudyProgress &progress);
  void make_reference(StudyProgress &progress);
  void perform_runs();
  void announce_time(StudyProgress &progress) const;
  bool add_runs_of_verdicts();
  void repeat_deciding_runs(StudyProgress &progress);
  std::string describe(const StudyRun &run) const;
  unsigned int family_of(unsigned int variant) const;
  std::vector<StudyCurve> curves(std::string &against) const;
  std::string measure() const;
  std::string probe() const;
  std::string field_of_probe() const;
  std::string words_on_time() const;
  void write_table_of_runs() const;
  void keep(const std::string &name, const std::string &beginning, const std::string &text) const;
  void conclude() const;

  const SceneOfStudy scene;
  const StudyOptions &options;
  const std::string &directory;
  const unsigned int dim;
  std::vector<unsigned int> ranks;
  std::vector<Variant> variants;
  std::vector<StudyRun> runs;
  std::set<std::string> names_of_runs;
  std::string errors_against; ///< in words, or empty
  const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
};

Study::Study(const std::string &file, const std::vector<std::string> &overrides)
    : scene(file, overrides), options(scene.options), directory(scene.directory),
      dim(scene.section.dimension()), ranks(options.ranks)
{
  if (ranks.empty())
    ranks = {launched_ranks()};
}

StudyRun Study::make_run(const unsigned int v, const unsigned int level, const unsigned int n_ranks,
                         const unsigned int repeat)
{
  StudyRun run;
  run.variant = v;
  run.level = level;
  run.ranks = n_ranks;
  run.repeat = repeat;
  run.overrides = scene.overrides_of(variants[v], level);
  std::string name = plain(variants[v].name) + "_level_" + std::to_string(level);
  if (n_ranks > 1)
    name += "_ranks_" + std::to_string(n_ranks);
  if (repeat > 1)
    name += "_repeat_" + std::to_string(repeat);
  while (!names_of_runs.insert(name).second)
    name += "_";
  run.directory = directory + "/runs/" + name;
  if (!variants[v].complaint.empty()) {
    run.status = "wrong input";
    run.message = variants[v].complaint;
  }
  return run;
}

/// Small levels first; what is compared runs side by side in time.
void Study::plan_runs()
{
  for (const unsigned int level : options.levels)
    for (unsigned int repeat = 1; repeat <= options.n_repeats; ++repeat)
      for (unsigned int v = 0; v < variants.size(); ++v)
        for (const unsigned int n_ranks : ranks)
          runs.push_back(make_run(v, level, n_ranks, repeat));
}

std::string Study::describe(const StudyRun &run) const
{
  std::ostringstream words;
  words.precision(3);
  words << variants[run.variant].name << ", level " << run.level;
  if (ranks.size() > 1)
    words << ", " << count_of(run.ranks, "rank");
  if (options.n_repeats > 1 || run.repeat > 1)
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
  perform(result, scene.file, [&] { progress.tick(); });
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
    run->fingerprint = scene.fingerprint(run->overrides, run->ranks);
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
  if (!options.reference.empty())
    errors_against = options.reference;
  else if (!probe().empty())
    errors_against = "probe " + probe(); // its extrapolated value, once there are all runs
  else if (scene.has_exact())
    errors_against = "Exact";
  else if (options.levels.size() > 1)
    make_reference(progress);

  unsigned int n_recalled = 0;
  for (StudyRun &run : runs)
    if (!run.is_done()) {
      run.fingerprint = scene.fingerprint(run.overrides, run.ranks);
      recall(run);
      n_recalled += run.is_done();
    }
  if (n_recalled > 0)
    progress.line(std::to_string(n_recalled) + " of " + std::to_string(runs.size()) +
                  " runs were there already");
  unsigned int level = options.levels.front();
  for (StudyRun &run : runs)
    if (!run.is_done()) {
      if (run.level > level) {
        measure(); // an error before the finer runs, which take longer; one variant alone may not know it
        announce_time(progress);
      }
      level = run.level;
      do_run(run, progress);
    }
  repeat_deciding_runs(progress);
  write_table_of_runs();
}

void Study::announce_time(StudyProgress &progress) const
{
  double seconds = 0;
  unsigned int n_left = 0;
  for (const StudyRun &run : runs)
    if (!run.is_done()) {
      seconds += expected_seconds(run, runs, dim);
      ++n_left;
    }
  progress.line("about " + duration(seconds) + " for the other " + count_of(n_left, "run"));
}

/// Of points that a verdict rests on, until each has enough. @return whether there are any.
bool Study::add_runs_of_verdicts()
{
  std::string against;
  const auto all = curves(against);
  const std::size_t n_before = runs.size();
  for (const auto &[c, p] : deciding_points(all)) {
    const unsigned int variant = c / ranks.size(), n_ranks = ranks[c % ranks.size()];
    for (unsigned int n = all[c].points[p].n_runs; n < n_runs_of_verdict; ++n)
      runs.push_back(make_run(variant, all[c].points[p].level, n_ranks, n + 1));
  }
  for (std::size_t i = n_before; i < runs.size(); ++i) {
    const auto first = std::find_if(runs.begin(), runs.end(), [&](const StudyRun &run) {
      return run.variant == runs[i].variant && run.level == runs[i].level && run.ranks == runs[i].ranks;
    });
    for (const std::string &assignment : first->overrides) // those that compare
      if (assignment.rfind("Output/Reference=", 0) == 0 &&
          std::count(runs[i].overrides.begin(), runs[i].overrides.end(), assignment) == 0)
        runs[i].overrides.push_back(assignment);
  }
  return runs.size() > n_before;
}

/// Medians move while runs are repeated, and then others may decide.
void Study::repeat_deciding_runs(StudyProgress &progress)
{
  const unsigned int largest_number_of_rounds = 5;
  for (unsigned int round = 0; round < largest_number_of_rounds && add_runs_of_verdicts(); ++round) {
    progress.line("runs that decide who is first are repeated");
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < runs.size(); ++i)
      if (!runs[i].is_done()) {
        runs[i].fingerprint = scene.fingerprint(runs[i].overrides, runs[i].ranks);
        recall(runs[i]);
        if (!runs[i].is_done())
          open.push_back(i);
      }
    std::stable_sort(open.begin(), open.end(),
                     [this](const auto a, const auto b) { return runs[a].repeat < runs[b].repeat; });
    for (const std::size_t i : open) // side by side in time
      do_run(runs[i], progress);
  }
}

/// The name of the one whose error is shown, or empty.
std::string Study::probe() const
{
  const std::string prefix = "probe ";
  return options.measure.rfind(prefix, 0) == 0 ? options.measure.substr(prefix.size()) : "";
}

/// Of which the probe is a value; empty if it is a flux, an integral or a quantity.
std::string Study::field_of_probe() const
{
  const Section probes = scene.section.top();
  const std::string name = "Probe " + probe(), reduce = probes.peek(name, "Reduce");
  return (probes.peek(name, "Boundary").empty() || !reduce.empty()) && reduce != "integral"
             ? probes.peek(name, "Field")
             : "";
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
  if (!probe().empty()) {
    const auto names = scene.names("Probes");
    scene.section.check(std::count(names.begin(), names.end(), probe()) > 0, "Error",
                        "is '" + options.measure + "', but Probes names " +
                            (names.empty() ? "none" : comma_separated(names)) + ". " +
                            did_you_mean(probe(), names));
    return options.measure;
  }
  if (options.measure.empty())
    for (const std::string &name : known)
      if (name.size() > 3 && name.substr(name.size() - 3) == " L2")
        return name;
  scene.section.check(
      options.measure.empty() || known.empty() || std::count(known.begin(), known.end(), options.measure) > 0,
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

/// @p against: what their errors are measured against, in words.
std::vector<StudyCurve> Study::curves(std::string &against) const
{
  const std::string name_of_error = measure();
  std::vector<StudyCurve> result;
  for (unsigned int v = 0; v < variants.size(); ++v)
    for (const unsigned int n_ranks : ranks) {
      StudyCurve curve;
      curve.name = variants[v].name + (ranks.size() > 1 ? ", " + count_of(n_ranks, "rank") : "");
      curve.family = family_of(v);
      curve.is_adaptive = scene.refinement_of(variants[v]) == "adaptive";
      for (const unsigned int level : options.levels) {
        std::vector<const StudyRun *> repeats;
        for (const StudyRun &run : runs)
          if (run.variant == v && run.ranks == n_ranks && run.level == level)
            repeats.push_back(&run);
        curve.points.push_back(make_point(repeats, name_of_error));
      }
      result.push_back(curve);
    }
  against = probe().empty() ? errors_against : measure_by_probe(result, probe(), field_of_probe());
  return result;
}

/// How long runs and study took, and what of a run is the start of the program.
std::string Study::words_on_time() const
{
  std::vector<double> start_ups;
  double of_runs = 0;
  for (const StudyRun &run : runs) {
    of_runs += run.seconds > 0 ? run.seconds : 0;
    if (const double start_up = start_up_of(run); !std::isnan(start_up))
      start_ups.push_back(start_up);
  }
  std::ostringstream words;
  words.precision(2);
  if (!start_ups.empty())
    words << "  " << median(start_ups) << " s of the seconds of each run are the start of the program ("
          << *std::min_element(start_ups.begin(), start_ups.end()) << " to "
          << *std::max_element(start_ups.begin(), start_ups.end()) << ")\n";
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  words << "  all runs together took " << duration(of_runs) << ", this study " << duration(elapsed) << "\n";
  return words.str();
}

void Study::write_table_of_runs() const
{
  std::ostringstream table;
  write_csv(table, options.vary, variants, runs);
  keep("study.csv", "variant,", table.str());
}

void Study::keep(const std::string &name, const std::string &beginning, const std::string &text) const
{
  if (const Obstacle obstacle = write_file(directory + "/" + name, beginning, text))
    obstacle.raise(set_another_directory);
}

void Study::conclude() const
{
  std::string against;
  auto all = curves(against);
  const std::string measure_name = measure();
  const auto sentences = who_is_first(all);
  extrapolate_errors(all);
  std::string words = table_of(all, measure_name);
  words += against.empty() ? "\n  no errors: there is no Exact, no Reference and no finer level\n"
                           : "\n  errors against " + against + "\n";
  if (std::any_of(all.begin(), all.end(), [](const StudyCurve &curve) {
        return std::any_of(curve.points.begin(), curve.points.end(),
                           [](const StudyPoint &point) { return point.is_extrapolated; });
      }))
    words += "  ~: continued at the rate of the levels before\n";
  for (const std::string &sentence : sentences)
    words += "  " + sentence + "\n";
  words += words_on_time();
  keep("study.txt", "  variant", words);
  std::cout << '\n' << words << '\n';
  const std::string obstacle = draw_study(directory, scene.name, all, measure_name, dim);
  std::cout << "  results: " << directory << "/study.csv"
            << (obstacle.empty() ? ", study.txt, study.svg, study.png" : ", study.txt") << std::endl;
  if (!obstacle.empty())
    std::cout << "  " << obstacle << std::endl;
}

bool Study::run()
{
  if (const Obstacle obstacle = make_directories(directory + "/runs"))
    obstacle.raise(set_another_directory);
  const DirectoryLock lock(directory);
  if (lock.obstacle())
    lock.obstacle().raise(wait_for_the_other_run);
  std::cout << "\nDovetail " DOVETAIL_VERSION ": study of " << scene.file << std::endl;
  variants = checked_variants(scene);
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
