// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// Error against run time and against unknowns, drawn by gnuplot.

#pragma once

#include <dovetail/study/numbers.h>

#include <string>
#include <vector>

namespace dovetail {

/// Write study.gp, which holds its data, into the directory and let gnuplot make study.svg and study.png of
/// it.
/// @return what stands in the way, if anything does.
std::string draw_study(const std::string &directory, const std::string &title,
                       const std::vector<StudyCurve> &curves, const std::string &measure, unsigned int dim);

} // namespace dovetail
