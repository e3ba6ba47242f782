// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// The results of a study as text.

#pragma once

#include <dovetail/scene/study_options.h>
#include <dovetail/study/numbers.h>

#include <iosfwd>
#include <string>
#include <vector>

namespace dovetail {

/// One row per run, also for those that failed or are not done yet.
void write_csv(std::ostream &out, const std::vector<VariedEntries> &vary,
               const std::vector<Variant> &variants, const std::vector<StudyRun> &runs);

/// The curves with their rates, for people.
std::string table_of(const std::vector<StudyCurve> &curves, const std::string &measure);

} // namespace dovetail
