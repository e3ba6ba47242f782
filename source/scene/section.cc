// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "pattern_text.h"
#include "scene_state.h"

#include <deal.II/base/utilities.h>

#include <boost/algorithm/string/predicate.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <set>

namespace dovetail {

using dealii::Point;
using dealii::Utilities::split_string_list;
using dealii::Utilities::trim;

namespace {

std::string to_text(const std::string &value)
{
  return value;
}
std::string to_text(const bool value)
{
  return value ? "true" : "false";
}
std::string to_text(const int value)
{
  return std::to_string(value);
}
std::string to_text(const unsigned int value)
{
  return std::to_string(value);
}

/// The shortest text that reads as exactly this number.
std::string to_text(const double value)
{
  char text[32];
  for (int digits = 6; digits <= 17; ++digits) {
    std::snprintf(text, sizeof(text), "%.*g", digits, value);
    if (std::strtod(text, nullptr) == value)
      break;
  }
  return text;
}

template <typename T>
std::string to_text(const std::vector<T> &values)
{
  std::string text;
  for (const T &value : values)
    text += (text.empty() ? "" : ", ") + to_text(value);
  return text;
}

std::string to_text(const Point<3> &point, const unsigned int dim)
{
  std::string text = to_text(point[0]);
  for (unsigned int d = 1; d < dim; ++d)
    text += "; " + to_text(point[d]);
  return text;
}

/// deal.II's pattern of unsigned numbers lets a minus sign pass.
template <typename T>
bool is_negative_unsigned(const std::string &text)
{
  constexpr bool is_unsigned =
      std::is_same<T, unsigned int>::value || std::is_same<T, std::vector<unsigned int>>::value;
  return is_unsigned && text.find('-') != std::string::npos;
}

template <typename T>
T to_value(const Section &section, const std::string &name, const std::string &text,
           const Patterns::PatternBase &pattern)
{
  if (!pattern.match(text) || is_negative_unsigned<T>(text)) {
    const std::vector<std::string> choices = choices_of(pattern);
    section.fail(name, (text.empty() ? "is empty" : "is '" + text + "'") + ", but must be " +
                           readable_range(pattern) + ". " +
                           (choices.size() == 1 ? "" : did_you_mean(text, choices)));
  }
  return Patterns::Tools::Convert<T>::to_value(text, pattern);
}

/// "2", "1 or 4", "1, 2 or 4".
std::string alternatives(const std::vector<unsigned int> &numbers)
{
  std::string text = std::to_string(numbers.front());
  for (std::size_t i = 1; i < numbers.size(); ++i)
    text += (i + 1 == numbers.size() ? " or " : ", ") + std::to_string(numbers[i]);
  return text;
}

std::string formula_range(const bool is_scalar, const unsigned int dim,
                          const std::vector<std::string> &scalars)
{
  return std::string(is_scalar ? "a formula in " : "formulas separated by ';' in ") +
         (dim == 2 ? "x, y, t" : "x, y, z, t") + (scalars.empty() ? "" : ", " + comma_separated(scalars));
}

/// Keeps a formula if it has tables, once.
void note_tables(const FormulaWithTables &formula, std::vector<FormulaWithTables> &known)
{
  const bool has_tables = formula.text.find("table") != std::string::npos;
  const bool is_known = std::any_of(known.begin(), known.end(), [&](const FormulaWithTables &other) {
    return other.path == formula.path && other.entry == formula.entry;
  });
  if (has_tables && !is_known)
    known.push_back(formula);
}

Expression parse_expression(const Section &section, const std::string &name, const std::string &text,
                            const std::vector<unsigned int> &n_components,
                            const std::vector<std::string> &scalars, SceneState &state)
{
  if (text.empty())
    return Expression(n_components.front());
  Expression expression;
  try {
    const std::string formula = with_tables(text, state.tables);
    expression = Expression(formula, {section.dimension(), scalars});
    if (expression.depends_on_scalars() && !section.documenting())
      note_tables({section.path(), name, scalars, formula}, state.formulas_with_tables);
  } catch (const UserError &error) {
    section.fail(name, error.what());
  }

  const unsigned int n = expression.n_components();
  const bool fits = std::find(n_components.begin(), n_components.end(), n) != n_components.end();
  section.check(fits, name,
                "needs " + alternatives(n_components) +
                    (n_components.back() == 1 ? " component" : " components separated by ';'") + ", not " +
                    std::to_string(n) + ".");
  return expression;
}

Point<3> parse_point(const Section &section, const std::string &name, const std::string &text)
{
  const unsigned int dim = section.dimension();
  const std::vector<std::string> components = split_string_list(text, ';');
  const bool has_zero_z =
      dim == 2 && components.size() == 3 && std::strtod(components[2].c_str(), nullptr) == 0.;
  section.check(components.size() == dim || has_zero_z, name,
                "is '" + text + "', but needs " + std::to_string(dim) + " numbers separated by ';'.");
  Point<3> point;
  for (unsigned int d = 0; d < std::min<std::size_t>(components.size(), 3); ++d)
    point[d] = to_value<double>(section, name, components[d], Patterns::Double());
  return point;
}

bool is_id(const std::string &text)
{
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos &&
         Patterns::Integer(0).match(text);
}

/// The boundary ids that the @p text names, an id or a name; capitals count only where names differ by them.
std::vector<unsigned int> ids_of_boundary(const Section &section, const std::string &entry,
                                          const std::string &text, const BoundaryNames &names,
                                          const std::string &domain)
{
  if (const auto found = names.find(text); found != names.end())
    return found->second;
  if (is_id(text))
    return {static_cast<unsigned int>(std::stoul(text))};
  std::vector<std::string> known, similar;
  for (const auto &[name, ids] : names) {
    if (!is_id(name))
      known.push_back(name);
    if (boost::algorithm::iequals(name, text))
      similar.push_back(name);
  }
  if (similar.size() == 1)
    return names.at(similar[0]);
  section.check(
      !known.empty(), entry,
      "has '" + text + "', but the boundaries of the mesh of domain " + domain +
          " have no names. Give their boundary ids, name these by Boundary names in the subsection Mesh, "
          "or name boundaries in the file (Gmsh: physical groups, Abaqus: surfaces).");
  const auto unwritable = std::find_if(known.begin(), known.end(), [](const std::string &name) {
    return name.find_first_of(",#") != std::string::npos;
  });
  section.fail(entry,
               "has '" + text + "', which is no boundary of the mesh of domain " + domain +
                   ". Its names are " + comma_separated(known) + ". " +
                   (unwritable == known.end()
                        ? did_you_mean(text, known)
                        : "A name with ',' or '#' cannot be written in a scene: give its id another name in "
                          "the subsection Mesh, Boundary names = " +
                              std::to_string(names.at(*unwritable).front()) + " : NAME."));
}

/// Of the list @p text.
std::vector<unsigned int> parse_boundary_ids(const Section &section, const std::string &entry,
                                             const std::string &text, const BoundaryNames &names,
                                             const std::string &domain)
{
  std::set<unsigned int> ids;
  std::set<std::string> parts;
  for (const std::string &part : split_string_list(text, ',')) {
    section.check(parts.insert(part).second, entry,
                  "is '" + text + "' and names " + (is_id(part) ? "a boundary id" : "a boundary") +
                      " twice.");
    for (const unsigned int id : ids_of_boundary(section, entry, part, names, domain))
      ids.insert(id);
  }
  return {ids.begin(), ids.end()};
}

Section::BoundaryReference parse_boundary(const Section &section, const std::string &name,
                                          const std::string &text,
                                          const std::map<std::string, BoundaryNames> &names)
{
  const std::size_t colon = text.rfind(':');
  const std::string domain = trim(text.substr(0, colon));
  const std::string ids = colon == std::string::npos ? "" : trim(text.substr(colon + 1));
  const auto parts = split_string_list(ids, ',');
  const bool has_names = names.count("Domain " + domain) > 0;
  const bool is_list = !parts.empty() && std::none_of(parts.begin(), parts.end(), [&](const auto &part) {
    return part.empty() || part[0] == '-' || (names.empty() && !is_id(part));
  });
  section.check(!domain.empty() && is_list, name,
                "is '" + text +
                    "', but must be 'domain : boundary ids', for instance 'left : 1' or 'left : 0, 2'.");
  section.check(domain.find(':') == std::string::npos, name, "is '" + text + "', but must have one ':'.");
  if (section.documenting() || (!has_names && !is_id(parts[0])))
    return {domain, {}}; // who asks knows that there is no such domain
  return {domain, parse_boundary_ids(section, name, ids,
                                     has_names ? names.at("Domain " + domain) : BoundaryNames(), domain)};
}

/// "Domain left" of "Domain left/Mesh".
std::string first_name(const std::string &path)
{
  return path.substr(0, path.find('/'));
}

/// A description without its unit in brackets: "The material of this body".
std::string without_unit(const std::string &description)
{
  return trim(description.substr(0, description.rfind('[')));
}

/// What the person may have written instead of @p name.
std::string unread_entry_near(const SceneState &state, const std::string &path, const std::string &name)
{
  std::vector<std::string> unread;
  if (const SceneTree::Subsection *subsection = state.tree.find(path))
    for (const SceneTree::Entry &entry : subsection->entries)
      if (!state.declarations.has_entry(path, entry.name))
        unread.push_back(entry.name);
  for (const std::string &candidate : unread)
    if (!did_you_mean(name, {candidate}).empty())
      return " Is it misspelt as '" + candidate + "' in " +
             state.tree.find(path, candidate)->location.text() + "?";
  return "";
}

void check_announced(const Section &scene, const SceneState &state, const std::vector<std::string> &names,
                     const std::string &plural, const std::string &singular)
{
  const std::vector<std::string> subsections = state.tree.names_of_subsections(scene.path());
  const std::set<std::string> present(subsections.begin(), subsections.end());
  std::set<std::string> expected;
  for (const std::string &name : names) { // the messages are long: only an error pays for them
    if (name.empty() && !scene.documenting())
      scene.fail(plural, "has an empty name: '" + comma_separated(names) + "'.");
    scene.check(name.find_first_of("/:;|=") == std::string::npos, plural,
                "has the name '" + name + "'; names may not contain any of / : ; | =.");
    scene.check(expected.insert(singular + " " + name).second, plural, "has the name '" + name + "' twice.");
  }
  for (const std::string &subsection : expected)
    if (present.count(subsection) == 0 && !scene.documenting())
      scene.fail(plural, "names '" + subsection.substr(singular.size() + 1) +
                             "', but there is no subsection '" + subsection + "'. " +
                             did_you_mean(subsection, subsections));
  for (const std::string &subsection : subsections)
    if (subsection.rfind(singular + " ", 0) == 0 && expected.count(subsection) == 0)
      Section(scene)
          .subsection(subsection)
          .fail("", "nothing announces this subsection. Add '" + subsection.substr(singular.size() + 1) +
                        "' to '" + plural + "' (now " + comma_separated(names) + ") or remove it." +
                        unread_entry_near(state, scene.path(), plural));
}

} // namespace

Section::Section(std::shared_ptr<SceneText> text, std::string path)
    : Section(std::move(text), std::move(path), "")
{
}

Section::Section(std::shared_ptr<SceneText> text, std::string path, std::string variant)
    : text(std::move(text)), section_path(std::move(path)), variant_name(std::move(variant))
{
  state().declarations.add_section(section_path);
  state().declarations.add_section(section_path, variant_name);
}

SceneState &Section::state() const
{
  return *text->implementation;
}

std::string Section::declare(const std::string &name, const std::optional<std::string> &default_text,
                             const std::string &description, const std::string &range) const
{
  const SceneTree::Entry *entry = state().tree.find(section_path, name);
  if (entry != nullptr && entry->is_in_si && !documenting()) {
    SceneTree::Entry converted = *entry;
    converted.value = converted_from_si(*entry, description, range, state().tree);
    converted.is_in_si = false;
    state().tree.set(section_path, converted);
    entry = state().tree.find(section_path, name);
  }
  const std::string value = entry ? entry->value : default_text.value_or("");
  state().declarations.add({section_path, variant_name, name, default_text, range, description, value});

  if (!default_text && value.empty())
    check(false, name,
          std::string(entry ? "is empty" : "is missing") + (range == "text" ? "" : "; it must be " + range) +
              " (" + without_unit(description) + ")." + unread_entry_near(state(), section_path, name));
  return value;
}

template <typename T>
T Section::read(const std::string &name, const T &default_value, const std::string &description,
                const Patterns::PatternBase &pattern) const
{
  const std::string value = declare(name, to_text(default_value), description, readable_range(pattern));
  return to_value<T>(*this, name, value, pattern);
}

template <typename T>
T Section::require(const std::string &name, const std::string &description,
                   const Patterns::PatternBase &pattern) const
{
  const std::string value = declare(name, {}, description, readable_range(pattern));
  return documenting() ? T() : to_value<T>(*this, name, value, pattern);
}

unsigned int Section::choose(const std::string &name, const std::vector<std::string> &choices,
                             const unsigned int default_choice, const std::string &description) const
{
  AssertIndexRange(default_choice, choices.size());
  std::string alternatives = choices.front();
  for (std::size_t i = 1; i < choices.size(); ++i)
    alternatives += "|" + choices[i];
  const auto chosen =
      read<std::string>(name, choices[default_choice], description, Patterns::Selection(alternatives));
  return std::find(choices.begin(), choices.end(), chosen) - choices.begin();
}

Expression Section::read_expression(const std::string &name, const std::string &default_text,
                                    const std::vector<unsigned int> &n_components,
                                    const std::string &description,
                                    const std::vector<std::string> &scalars) const
{
  const std::string range = formula_range(n_components.back() == 1, dimension(), scalars);
  const std::string value = declare(name, default_text, description, range);
  return parse_expression(*this, name, value, n_components, scalars, state());
}

Expression Section::require_expression(const std::string &name, const std::vector<unsigned int> &n_components,
                                       const std::string &description,
                                       const std::vector<std::string> &scalars) const
{
  const std::string range = formula_range(n_components.back() == 1, dimension(), scalars);
  const std::string value = declare(name, {}, description, range);
  return parse_expression(*this, name, value, n_components, scalars, state());
}

Point<3> Section::read_point(const std::string &name, const Point<3> &default_value,
                             const std::string &description) const
{
  const std::string range = std::to_string(dimension()) + " numbers separated by ';'";
  return parse_point(*this, name, declare(name, to_text(default_value, dimension()), description, range));
}

Point<3> Section::require_point(const std::string &name, const std::string &description) const
{
  const std::string range = std::to_string(dimension()) + " numbers separated by ';'";
  const std::string value = declare(name, {}, description, range);
  return documenting() ? Point<3>() : parse_point(*this, name, value);
}

std::vector<std::string> Section::announce(const std::string &plural, const std::string &singular,
                                           const std::string &description) const
{
  const std::string value =
      declare(plural, "", description, "names, each with a subsection '" + singular + " NAME'");
  if (documenting())
    return {"NAME"};
  const std::string misspelt = unread_entry_near(state(), section_path, plural);
  check(!value.empty() || misspelt.empty(), plural, "is missing." + misspelt);
  const std::vector<std::string> names = split_string_list(value, ',');
  check_announced(*this, state(), names, plural, singular);
  return names;
}

Section::BoundaryReference Section::require_boundary(const std::string &name,
                                                     const std::string &description) const
{
  return parse_boundary(*this, name, declare(name, {}, description, "'domain : boundary ids or names'"),
                        state().boundary_names);
}

Section::BoundaryReference Section::read_boundary(const std::string &name,
                                                  const std::string &description) const
{
  const std::string value = declare(name, "", description, "'domain : boundary ids or names'");
  return value.empty() ? BoundaryReference() : parse_boundary(*this, name, value, state().boundary_names);
}

std::vector<unsigned int> Section::require_boundary_ids(const std::string &name,
                                                        const std::string &description) const
{
  declare(name, {}, description, "boundary ids or names");
  return read_boundary_ids(name, description);
}

std::vector<unsigned int> Section::read_boundary_ids(const std::string &name,
                                                     const std::string &description) const
{
  const std::string value = declare(name, "", description, "boundary ids or names");
  if (value.empty() || documenting())
    return {};
  const std::string domain = first_name(section_path);
  const auto names = state().boundary_names.find(domain);
  return parse_boundary_ids(*this, name, value,
                            names == state().boundary_names.end() ? BoundaryNames() : names->second,
                            domain.substr(std::min(domain.size(), domain.find(' ') + 1)));
}

void Section::name_boundaries(const BoundaryNames &names) const
{
  BoundaryNames &known = state().boundary_names[first_name(section_path)];
  for (const auto &[name, ids] : names)
    known[name] = ids;
}

std::string Section::read_file_name(const std::string &name, const std::string &description) const
{
  if (const SceneTree::Entry *entry = state().tree.find(section_path, name);
      entry != nullptr && !entry->value.empty() && !documenting()) {
    SceneTree::Entry found = *entry;
    found.value = find_file(entry->value, entry->location, state().tree);
    state().tree.set(section_path, found);
  }
  return read<std::string>(name, "", description);
}

Section Section::top() const
{
  return Section(text, "");
}

Section Section::subsection(const std::string &name) const
{
  return Section(text, join_path(section_path, name), variant_name);
}

bool Section::has_subsection(const std::string &name) const
{
  state().declarations.add_known_subsection(section_path, name);
  return documenting() || state().tree.find(join_path(section_path, name)) != nullptr;
}

Section Section::variant(const std::string &type, const std::string &help, const std::string &entry) const
{
  if (!documenting())
    return *this;
  const std::string name = (variant_name.empty() ? "" : variant_name + ", ") + entry + " = " + type;
  state().declarations.add_section(section_path, name, help);
  return Section(text, section_path, name);
}

bool Section::is_set(const std::string &name) const
{
  return !peek(name).empty();
}

std::string Section::peek(const std::string &name) const
{
  return peek("", name);
}

std::string Section::peek(const std::string &subsection, const std::string &name) const
{
  const std::string path = subsection.empty() ? section_path : join_path(section_path, subsection);
  state().declarations.add_known_entry(path, name);
  const SceneTree::Entry *entry = state().tree.find(path, name);
  try {
    return entry ? with_tables(entry->value, state().tables) : "";
  } catch (const UserError &error) {
    Section(text, path).fail(name, error.what());
  }
}

void Section::give(const std::string &subsection, const std::string &name, const std::string &value,
                   const std::string &reason) const
{
  const std::string path = subsection.empty() ? section_path : join_path(section_path, subsection);
  if (state().tree.find(path) == nullptr)
    state().tree.open(path, {reason, 0});
  state().tree.set(path, {name, value, {reason, 0}});
}

Section Section::in_copy_of_scene() const
{
  return Section(text->copy(), section_path);
}

bool Section::documenting() const
{
  return state().is_documenting;
}

unsigned int Section::dimension() const
{
  const auto dimension = Section(text, "").require<std::string>("Dimension", "The dimension of space [-]",
                                                                Patterns::Selection("2|3"));
  return dimension == "2" ? 2 : 3;
}

const std::string &Section::path() const
{
  return section_path;
}

void Section::fail(const std::string &entry, const std::string &message) const
{
  state().refuse_misspelt_subsection();
  throw UserError(state().where(section_path, entry) + trim(entry + " " + message));
}

void Section::check(const bool condition, const std::string &entry, const std::string &message) const
{
  if (!condition && !documenting())
    fail(entry, message);
}

template std::string Section::read(const std::string &, const std::string &, const std::string &,
                                   const Patterns::PatternBase &) const;
template bool Section::read(const std::string &, const bool &, const std::string &,
                            const Patterns::PatternBase &) const;
template int Section::read(const std::string &, const int &, const std::string &,
                           const Patterns::PatternBase &) const;
template unsigned int Section::read(const std::string &, const unsigned int &, const std::string &,
                                    const Patterns::PatternBase &) const;
template double Section::read(const std::string &, const double &, const std::string &,
                              const Patterns::PatternBase &) const;
template std::vector<std::string> Section::read(const std::string &, const std::vector<std::string> &,
                                                const std::string &, const Patterns::PatternBase &) const;
template std::vector<double> Section::read(const std::string &, const std::vector<double> &,
                                           const std::string &, const Patterns::PatternBase &) const;
template std::vector<unsigned int> Section::read(const std::string &, const std::vector<unsigned int> &,
                                                 const std::string &, const Patterns::PatternBase &) const;
template std::string Section::require(const std::string &, const std::string &,
                                      const Patterns::PatternBase &) const;
template bool Section::require(const std::string &, const std::string &, const Patterns::PatternBase &) const;
template int Section::require(const std::string &, const std::string &, const Patterns::PatternBase &) const;
template unsigned int Section::require(const std::string &, const std::string &,
                                       const Patterns::PatternBase &) const;
template double Section::require(const std::string &, const std::string &,
                                 const Patterns::PatternBase &) const;
template std::vector<std::string> Section::require(const std::string &, const std::string &,
                                                   const Patterns::PatternBase &) const;
template std::vector<double> Section::require(const std::string &, const std::string &,
                                              const Patterns::PatternBase &) const;
template std::vector<unsigned int> Section::require(const std::string &, const std::string &,
                                                    const Patterns::PatternBase &) const;

} // namespace dovetail
