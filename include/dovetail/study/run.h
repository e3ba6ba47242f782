// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// One run of a study, before and after.

#pragma once

#include <nlohmann/json.hpp>

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace dovetail {

/// A variant at a level, on a number of ranks, for the n-th time.
struct StudyRun
{
  unsigned int variant = 0, level = 0, ranks = 1, repeat = 1;

  std::string directory;              ///< its own
  std::vector<std::string> overrides; ///< of the scene, as for --set
  std::string fingerprint;            ///< all that its numbers depend on; the same text: the same run

  /// "converged", "not converged", "wrong input" or "failed"; empty before it is done.
  std::string status;
  std::string message;                                       ///< if the input is wrong or the run failed
  double seconds = std::numeric_limits<double>::quiet_NaN(); ///< wall clock of the whole process
  nlohmann::ordered_json report;

  bool is_done() const { return !status.empty(); }
  bool is_converged() const { return status == "converged"; }
};

/// Take the results of a run that was done before with the same fingerprint, if there is one.
void recall(StudyRun &run);

/// Do the run in a process of its own and keep what came out in its directory. @p each_second is called
/// meanwhile.
void perform(StudyRun &run, const std::string &scene, const std::function<void()> &each_second);

/// The last words of a program that ended badly: what follows "Error:", else its last line.
std::string error_message(const std::string &error_file);

} // namespace dovetail
