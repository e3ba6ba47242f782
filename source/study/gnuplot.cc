// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "gnuplot.h"
#include "process.h"

#include <dovetail/output/new_file.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <unistd.h>

namespace dovetail {

namespace {

/// From the folder where gnuplot has made them, if they are whole.
/// @return what stands in the way, if anything does.
std::string take_pictures(const std::string &folder, const std::string &directory, const std::string &name)
{
  struct Kind
  {
    std::string ending, beginning, end;
  };
  for (const Kind &kind : {Kind{"svg", "<?xml", "</svg>"}, Kind{"png", "\x89PNG", "IEND"}}) {
    const std::string file = "/" + name + "." + kind.ending;
    std::ostringstream picture;
    picture << std::ifstream(folder + file, std::ios::binary).rdbuf();
    const std::size_t end = picture.str().rfind(kind.end);
    if (end == std::string::npos || end + kind.end.size() + 8 < picture.str().size())
      return "No picture: that of gnuplot is not whole. Is the disk full?";
    if (const Obstacle obstacle = write_file(directory + file, kind.beginning, picture.str()))
      return "No picture: " + obstacle.text;
  }
  return "";
}

} // namespace

std::string number(const double value)
{
  std::ostringstream text;
  text.precision(6);
  text << value;
  return text.str();
}

std::string quoted(const std::string &text)
{
  std::string result = "'";
  for (const char letter : text)
    result += letter == '\'' ? "''" : std::string(1, letter);
  return result + "'";
}

/// Okabe and Ito 2008, without their yellow.
std::string colour_of_curve(const unsigned int number)
{
  constexpr std::array<const char *, 7> colours{
      {"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#444444"}};
  return colours[number % colours.size()];
}

void begin_pictures(std::ostream &out, const std::string &name, const double width, const double height)
{
  const double enlargement = 1.5;
  out << "set encoding utf8\n"
         "do for [kind in 'svg png'] {\n"
         "if (kind eq 'svg') { set terminal svg size "
      << number(width) << "," << height
      << " dynamic background 'white' "
         "font 'DejaVu Sans,Helvetica,sans-serif,13' }\n"
         "if (kind eq 'png') { set terminal pngcairo size "
      << number(std::round(enlargement * width)) << "," << enlargement * height
      << " fontscale 1.4 linewidth 1.4 pointscale 1.4 font 'DejaVu Sans,13' }\n"
         "set output folder.'/"
      << name
      << ".'.kind\n"
         "set multiplot\n"
         "set border 3 lc rgb '#444444'\n"
         "set tics nomirror scale 0.6 tc rgb '#222222'\n"
         "set grid xtics ytics lc rgb '#C8C8C8' lw 0.8 dt 1\n";
}

void end_pictures(std::ostream &out)
{
  out << "unset multiplot\nunset output\n}\n";
}

std::string draw_by_gnuplot(const std::string &directory, const std::string &name, const std::string &what,
                            const std::string &script, const std::string &redo)
{
  const std::string file = directory + "/" + name + ".gp", errors = directory + "/gnuplot.txt",
                    first_words = "# " + what;
  if (const Obstacle obstacle =
          write_file(file, first_words,
                     first_words + ": gnuplot " + name + ".gp writes " + name + ".svg and " + name +
                         ".png.\nif (!exists('folder')) folder = '.'\n\n" + script))
    obstacle.raise(set_another_directory);
  const std::string folder = directory + "/" + unfinished_prefix(host_name(), getpid()) + "pictures";
  if (const Obstacle obstacle = make_directories(folder))
    obstacle.raise(set_another_directory);
  const Outcome outcome =
      run_process({"gnuplot", "-e", "folder=" + quoted(folder), file}, "/dev/null", errors, [] {});
  const std::string problem = outcome.status == 0 ? take_pictures(folder, directory, name) : "";
  std::error_code error;
  std::filesystem::remove_all(folder, error);
  if (outcome.status == 0) {
    remove_file(errors, "");
    return problem;
  }
  if (outcome.status == 127)
    return "No picture: gnuplot was not found. Install it (Debian, Ubuntu: apt-get install gnuplot-nox) "
           "and " +
           redo;
  return "No picture: gnuplot failed, " + errors + " says why.";
}

} // namespace dovetail
