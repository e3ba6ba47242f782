// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "progress.h"

#include <dovetail/output/progress_bar.h>
#include <dovetail/study/numbers.h>

#include <algorithm>
#include <cmath>
#include <iostream>

namespace dovetail {

namespace {

/// Median of the runs that are done and that @p fits.
template <typename Predicate>
double median_of_done(const std::vector<StudyRun> &runs, Predicate &&fits)
{
  std::vector<double> seconds;
  for (const StudyRun &run : runs)
    if (run.seconds > 0 && fits(run))
      seconds.push_back(run.seconds);
  return median(seconds);
}

/// From the finest pair of successive levels of one variant that is done.
double growth_per_level(const std::vector<StudyRun> &runs, const unsigned int dim)
{
  double growth = std::pow(2., dim);
  unsigned int finest = 0;
  for (const StudyRun &fine : runs)
    for (const StudyRun &coarse : runs)
      if (fine.seconds > 0 && coarse.seconds > 0 && fine.variant == coarse.variant &&
          fine.ranks == coarse.ranks && fine.level == coarse.level + 1 && fine.level >= finest) {
        finest = fine.level;
        growth = std::clamp(fine.seconds / coarse.seconds, 1., 4 * std::pow(2., dim));
      }
  return growth;
}

} // namespace

std::string duration(const double seconds)
{
  const unsigned long whole = std::lround(std::max(seconds, 0.));
  if (whole < 100)
    return std::to_string(whole) + " s";
  if (whole < 6000)
    return std::to_string((whole + 30) / 60) + " min";
  return std::to_string(whole / 3600) + " h " + std::to_string(whole % 3600 / 60) + " min";
}

double expected_seconds(const StudyRun &run, const std::vector<StudyRun> &runs, const unsigned int dim)
{
  const double growth = growth_per_level(runs, dim);
  for (const bool same_variant : {true, false})
    for (unsigned int below = 0; below <= run.level; ++below) {
      const double seconds = median_of_done(runs, [&](const StudyRun &other) {
        return other.level + below == run.level &&
               (!same_variant || (other.variant == run.variant && other.ranks == run.ranks));
      });
      if (!std::isnan(seconds))
        return seconds * std::pow(growth, below);
    }
  return std::pow(growth, run.level);
}

StudyProgress::StudyProgress(const std::vector<StudyRun> &runs, const unsigned int dim)
    : runs(runs), dim(dim), has_terminal(stdout_is_terminal())
{
}

StudyProgress::~StudyProgress()
{
  erase();
}

void StudyProgress::line(const std::string &text)
{
  erase();
  std::cout << text << '\n';
  draw();
  std::cout << std::flush;
}

void StudyProgress::begin(const StudyRun &run)
{
  current = &run;
  start = std::chrono::steady_clock::now();
  tick();
}

void StudyProgress::tick() const
{
  erase();
  draw();
}

void StudyProgress::end()
{
  erase();
  current = nullptr;
}

/// The bar shows time, not runs: the last runs take most of it.
void StudyProgress::draw() const
{
  if (!has_terminal || current == nullptr)
    return;
  double done = 0, left = 0;
  unsigned int n_done = 0;
  for (const StudyRun &run : runs) {
    const double seconds = run.is_done() ? run.seconds : expected_seconds(run, runs, dim);
    if (run.is_done()) {
      done += seconds > 0 ? seconds : 0.; // NaN: it was not run
      ++n_done;
    } else if (&run == current) {
      const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      done += elapsed;
      left += std::max(seconds - elapsed, 0.);
    } else
      left += seconds;
  }
  std::cout << progress_bar(done / (done + left)) << n_done << " of " << runs.size() << " runs, about "
            << duration(left) << " left" << std::flush;
}

void StudyProgress::erase() const
{
  if (has_terminal && current != nullptr)
    std::cout << erase_line << std::flush;
}

} // namespace dovetail
