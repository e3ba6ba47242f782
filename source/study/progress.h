// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// How far a study is: a line for every run, and on a terminal a bar with the time left.

#pragma once

#include <dovetail/study/run.h>

#include <chrono>
#include <string>
#include <vector>

namespace dovetail {

/// Seconds that a run is likely to take: as runs like it took, or those of the nearest level times the
/// growth seen from level to level (2^@p dim before anything is seen). @p runs may contain it.
double expected_seconds(const StudyRun &run, const std::vector<StudyRun> &runs, unsigned int dim);

std::string duration(double seconds); ///< "40 s", "12 min", "3 h 5 min"

class StudyProgress
{
public:
  StudyProgress(const std::vector<StudyRun> &runs, unsigned int dim);
  ~StudyProgress();

  void line(const std::string &text);
  void begin(const StudyRun &run); ///< it is started now
  void tick() const;               ///< draw the bar anew
  void end();                      ///< it is done

private:
  void draw() const;
  void erase() const;

  const std::vector<StudyRun> &runs;
  const unsigned int dim;
  const bool has_terminal;
  const StudyRun *current = nullptr;
  std::chrono::steady_clock::time_point start;
};

} // namespace dovetail
