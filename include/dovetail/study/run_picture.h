// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// How one run went, drawn by gnuplot from what it wrote.

#pragma once

#include <iostream>
#include <string>

namespace dovetail {

/// Of report.json and probes.csv in the directory: residuals over the iterations, seconds by phase, and each
/// probe over time, as run.svg and run.png. What was drawn is said on @p out.
/// @throw UserError if there is no report, or no gnuplot.
void draw_run(const std::string &directory, std::ostream &out);

} // namespace dovetail
