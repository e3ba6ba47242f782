// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Units of the materials' files: SI, where a scene may have any consistent set. The units of entries stand in
// brackets at the end of their descriptions, [W/(m K)]. Factors: Bureau international des poids et mesures,
// The International System of Units (2019); inch, foot and pound by definition.

#include "scene_tree.h"

#include <dovetail/scene/units.h>
#include <dovetail/scene/user_error.h>

#include <deal.II/base/utilities.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <vector>

namespace dovetail {

namespace {

using Powers = std::vector<int>; ///< of length, mass, time and temperature

/// In m, kg, s, K.
const std::map<std::string, Powers> known_units = {
    {"m", {1, 0, 0, 0}},   {"kg", {0, 1, 0, 0}},   {"s", {0, 0, 1, 0}},  {"K", {0, 0, 0, 1}},
    {"N", {1, 1, -2, 0}},  {"Pa", {-1, 1, -2, 0}}, {"J", {2, 1, -2, 0}}, {"W", {2, 1, -3, 0}},
    {"Hz", {0, 0, -1, 0}}, {"rad", {0, 0, 0, 0}},  {"-", {0, 0, 0, 0}},  {"1", {0, 0, 0, 0}}};

const std::array<std::map<std::string, double>, 4> known_bases = {
    {{{"m", 1}, {"mm", 1e-3}, {"cm", 1e-2}, {"um", 1e-6}, {"km", 1e3}, {"in", 0.0254}, {"ft", 0.3048}},
     {{"kg", 1}, {"g", 1e-3}, {"t", 1e3}, {"mg", 1e-6}, {"lb", 0.45359237}},
     {{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"min", 60}, {"h", 3600}},
     {{"K", 1}}}};

/// A product of units and of quotients in parentheses: "W/(m K)", "kg/m^3", "1/K". Returns no value for what
/// it does not know.
class UnitParser
{
public:
  explicit UnitParser(const std::string &text) : text(text) {}

  std::optional<Powers> parse()
  {
    Powers powers(4, 0);
    add_product(1, powers);
    return is_known && position == text.size() ? std::optional(powers) : std::nullopt;
  }

private:
  void add_product(const int sign, Powers &powers)
  {
    int side = sign;
    while (is_known && position < text.size() && text[position] != ')') {
      if (text[position] == ' ')
        ++position;
      else if (text[position] == '/') {
        ++position;
        add_factor(-side, powers);
      } else
        add_factor(side, powers);
    }
  }

  void add_factor(const int sign, Powers &powers)
  {
    if (position < text.size() && text[position] == '(') {
      ++position;
      add_product(sign, powers);
      is_known = is_known && position < text.size() && text[position++] == ')';
      return;
    }
    const std::size_t end = std::min(text.find_first_of(" /()^", position), text.size());
    const auto unit = known_units.find(text.substr(position, end - position));
    is_known = is_known && unit != known_units.end();
    position = end;
    int power = 1;
    if (position < text.size() && text[position] == '^') {
      char *after = nullptr;
      power = std::strtol(text.c_str() + position + 1, &after, 10);
      position = after - text.c_str();
    }
    for (unsigned int i = 0; is_known && i < 4; ++i)
      powers[i] += sign * power * unit->second[i];
  }

  const std::string text;
  std::size_t position = 0;
  bool is_known = true;
};

std::string digits_of(const double value)
{
  char text[64];
  std::snprintf(text, sizeof(text), "%.15g", value);
  return text;
}

} // namespace

Units::Units(const std::string &text)
{
  const auto words = dealii::Utilities::split_string_list(text, ',');
  for (unsigned int i = 0; i < 4 && i < words.size(); ++i)
    if (const auto base = known_bases[i].find(words[i]); base != known_bases[i].end()) {
      names[i] = words[i];
      in_si[i] = base->second;
    } else {
      std::vector<std::string> names;
      for (const auto &[name, factor] : known_bases[i])
        names.push_back(name);
      throw UserError("has '" + words[i] + "' as the unit of " +
                      std::array<const char *, 4>{{"lengths", "masses", "times", "temperatures"}}[i] +
                      ". Known are " + comma_separated(names) + ".");
    }
  if (words.size() != 4)
    throw UserError("needs four units: of length, mass, time and temperature, for instance mm, t, s, K.");
}

std::optional<double> Units::from_si(const std::string &unit) const
{
  const auto powers = UnitParser(unit).parse();
  if (!powers)
    return {};
  double factor = 1;
  for (unsigned int i = 0; i < 4; ++i)
    factor *= std::pow(in_si[i], -(*powers)[i]);
  return factor;
}

std::string Units::of(const std::string &unit) const
{
  const auto powers = UnitParser(unit).parse();
  if (!powers)
    return "";
  if (unit == "N" || unit == "Pa" || unit == "J" || unit == "W" || unit == "Hz")
    for (const auto &[prefix, size] : {std::pair("m", 1e-3), std::pair("", 1.), std::pair("k", 1e3),
                                       std::pair("M", 1e6), std::pair("G", 1e9)})
      if (std::abs(*from_si(unit) * size - 1) < 1e-12)
        return prefix + unit;
  const auto product = [&](const int sign) {
    std::string words;
    for (const unsigned int i : {1, 0, 2, 3}) // masses first: kg m/s^2
      if (const int power = sign * (*powers)[i]; power > 0)
        words += (words.empty() ? "" : " ") + names[i] + (power > 1 ? "^" + std::to_string(power) : "");
    return words;
  };
  const std::string above = product(1), below = product(-1);
  const bool is_single = below.find(' ') == std::string::npos;
  return below.empty() ? above
                       : (above.empty() ? "1" : above) + "/" + (is_single ? below : "(" + below + ")");
}

namespace {

/// Component by component.
std::string convert_formula(const std::string &formula, const std::string &factor)
{
  std::string converted;
  for (const std::string &component : dealii::Utilities::split_string_list(formula, ';'))
    converted += (converted.empty() ? "" : "; ") + factor + " * (" + component + ")";
  return converted;
}

/// With x, y, z and t in SI, too; they stand for numbers in the units of the scene.
std::string with_variables_in_si(const std::string &formula, const Units &units)
{
  const std::string letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
  std::string converted;
  for (std::size_t begin = 0; begin < formula.size();) {
    const std::size_t end =
        std::max(begin + 1, std::min(formula.find_first_not_of(letters, begin), formula.size()));
    const std::string word = formula.substr(begin, end - begin);
    const bool is_length = word == "x" || word == "y" || word == "z";
    const double per_si = is_length || word == "t" ? *units.from_si(is_length ? "m" : "s") : 1.;
    converted += per_si == 1 ? word : "(" + word + "/" + digits_of(per_si) + ")";
    begin = end;
  }
  return converted;
}

} // namespace

std::string converted_from_si(const SceneTree::Entry &entry, const std::string &description,
                              const std::string &range, const SceneTree &tree)
{
  const SceneTree::Entry *units = tree.find("", "Units");
  if (units == nullptr || units->value.empty())
    return entry.value;
  const auto bracket = description.rfind('[');
  const std::string unit = description.substr(bracket + 1, description.rfind(']') - bracket - 1);
  std::optional<double> factor;
  std::string value = entry.value;
  try {
    const Units in_scene(units->value);
    factor = in_scene.from_si(unit);
    if (range.find("formula") != std::string::npos || range.find("number") != std::string::npos)
      value = replace_between_files(
          value, [&](const std::string &part) { return with_variables_in_si(part, in_scene); });
  } catch (const UserError &error) {
    throw UserError("The scene, " + units->location.text() + ": Units " + error.what());
  }
  if (!factor)
    throw UserError(entry.location.text() + ": '" + entry.name + "' has the unit [" + unit +
                    "], which cannot be converted to the Units of the scene. Set the entry in the scene.");
  if (std::abs(*factor - 1) < 1e-14)
    return value;
  std::string numbers; // of a list
  for (const std::string &word : dealii::Utilities::split_string_list(value, ',')) {
    char *end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    if (end == word.c_str() || *end != 0)
      return convert_formula(value, digits_of(*factor));
    numbers += (numbers.empty() ? "" : ", ") + digits_of(number * *factor);
  }
  return numbers;
}

} // namespace dovetail
