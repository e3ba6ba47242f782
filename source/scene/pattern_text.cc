// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "pattern_text.h"

#include <dovetail/scene/user_error.h>

#include <deal.II/base/utilities.h>

namespace dovetail {

namespace {

/// The part of @p text between @p begin and @p end.
std::string between(const std::string &text, const std::string &begin, const std::string &end)
{
  const std::size_t first = text.find(begin) + begin.size();
  return text.substr(first, text.rfind(end) - first);
}

bool starts_with(const std::string &text, const std::string &begin)
{
  return text.compare(0, begin.size(), begin) == 0;
}

/// @p interval: "0...MAX_DOUBLE". The smallest or largest number of a type means that there is no bound.
std::string readable_interval(const std::string &kind, const std::string &interval)
{
  const std::string lower = interval.substr(0, interval.find("..."));
  const std::string upper = interval.substr(interval.find("...") + 3);
  const bool has_lower = lower != "-MAX_DOUBLE" && lower != "-2147483648";
  const bool has_upper = upper != "MAX_DOUBLE" && upper != "2147483647";
  if (has_lower && has_upper)
    return kind + " from " + lower + " to " + upper;
  if (has_upper)
    return kind + " ≤ " + upper;
  if (!has_lower)
    return kind;
  // Patterns have no open intervals; a tiny lower bound is how "positive" is written.
  const double bound = dealii::Utilities::string_to_double(lower);
  return bound > 0 && bound < 1e-100 ? kind + " > 0" : kind + " ≥ " + lower;
}

std::string readable(const std::string &machine);

std::string readable_list(const std::string &machine)
{
  const std::string element = readable(between(machine, "<[", "]>").insert(0, "[").append("]"));
  std::string plural = element;
  if (starts_with(element, "a "))
    plural = element.substr(2);
  else if (starts_with(element, "an "))
    plural = element.substr(3);
  const std::size_t noun_end = plural.find(' ');
  if (starts_with(plural, "number") || starts_with(plural, "integer"))
    plural.insert(noun_end == std::string::npos ? plural.size() : noun_end, "s");
  else if (plural == "text")
    plural = "names";
  const bool is_separated_by_semicolons = machine.find("separated by <;>") != std::string::npos;
  return "a list of " + plural + (is_separated_by_semicolons ? " separated by ';'" : "");
}

std::vector<std::string> split_at_bars(const std::string &machine, const std::string &begin)
{
  return dealii::Utilities::split_string_list(between(machine, begin, "]"), '|');
}

std::string readable(const std::string &machine)
{
  if (starts_with(machine, "[Double"))
    return readable_interval("a number", between(machine, "[Double ", " (inclusive)"));
  if (starts_with(machine, "[Integer range"))
    return readable_interval("an integer", between(machine, "range ", " (inclusive)"));
  // Without a range: this is what deal.II makes of unsigned int, whose largest value does not fit its bounds.
  if (machine == "[Integer]")
    return "an integer ≥ 0";
  if (machine == "[Bool]")
    return "true or false";
  if (starts_with(machine, "[Selection")) {
    const std::vector<std::string> choices = split_at_bars(machine, "[Selection ");
    return choices.size() == 1 ? choices.front() + ", the only choice yet"
                               : "one of " + comma_separated(choices);
  }
  if (starts_with(machine, "[MultipleSelection"))
    return "a list of some of " + comma_separated(split_at_bars(machine, "[MultipleSelection "));
  if (starts_with(machine, "[List"))
    return readable_list(machine);
  if (starts_with(machine, "[FileName"))
    return "a file name";
  if (starts_with(machine, "[DirectoryName"))
    return "a directory";
  return machine == "[Anything]" ? "text" : machine;
}

} // namespace

std::string readable_range(const dealii::Patterns::PatternBase &pattern)
{
  return readable(pattern.description(dealii::Patterns::PatternBase::Machine));
}

std::vector<std::string> choices_of(const dealii::Patterns::PatternBase &pattern)
{
  const std::string machine = pattern.description(dealii::Patterns::PatternBase::Machine);
  return starts_with(machine, "[Selection") ? split_at_bars(machine, "[Selection ")
                                            : std::vector<std::string>();
}

} // namespace dovetail
