// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// Pictures by gnuplot, which is a program of its own and may be missing.

#pragma once

#include <ostream>
#include <string>

namespace dovetail {

std::string number(double value);
/// A string of gnuplot's that means just itself.
std::string quoted(const std::string &text);
/// Told apart with every kind of colour blindness; there are seven.
std::string colour_of_curve(unsigned int number);

/// What a script begins and ends with, data aside: what is between is drawn as NAME.svg and as NAME.png, in
/// this size [points].
void begin_pictures(std::ostream &out, const std::string &name, double width, double height);
void end_pictures(std::ostream &out);

/// Write NAME.gp into the directory and let gnuplot make NAME.svg and NAME.png of it.
/// @param what the pictures show; with it the script begins
/// @param redo what to do once gnuplot is there
/// @return what stands in the way, if anything does.
std::string draw_by_gnuplot(const std::string &directory, const std::string &name, const std::string &what,
                            const std::string &script, const std::string &redo);

} // namespace dovetail
