// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/generator.h>

#include <deal.II/base/utilities.h>
#include <deal.II/grid/grid_generator.h>

#include <cmath>
#include <map>

namespace dovetail {

namespace {

using Words = std::vector<std::string>;

/// How long the lists of a generator are; deal.II does not say it. 0 if there is none.
unsigned int length_of_list(const std::string &generator, const unsigned int dim)
{
  const std::map<std::string, unsigned int> lengths = {{"subdivided_hyper_rectangle", dim},
                                                       {"cheese", dim},
                                                       {"hyper_cross", 2 * dim},
                                                       {"simplex", dim + 1},
                                                       {"general_cell", 1u << dim}};
  const auto found = lengths.find(generator);
  return found == lengths.end() ? 0 : found->second;
}

/// The smallest counts, where 0 does not mean that the generator chooses.
unsigned int smallest_count(const std::string &generator)
{
  const std::map<std::string, unsigned int> smallest = {{"subdivided_hyper_rectangle", 1},
                                                        {"subdivided_hyper_cube", 1},
                                                        {"cheese", 1},
                                                        {"hyper_cube_with_cylindrical_hole", 1},
                                                        {"subdivided_cylinder", 1},
                                                        {"torus", 3},
                                                        {"moebius", 1}};
  const auto found = smallest.find(generator);
  return found == smallest.end() ? 0 : found->second;
}

bool begins_with(const std::string &text, const std::string &begin)
{
  return text.compare(0, begin.size(), begin) == 0;
}

/// The elements of "[Tuple of <n> elements <A>, <B>, …]", each in brackets of its own.
Words elements_of_tuple(const std::string &pattern)
{
  Words elements;
  unsigned int depth = 0;
  for (std::size_t i = pattern.find(" elements <"), begin = 0; i < pattern.size(); ++i)
    if (pattern[i] == '<' && depth++ == 0)
      begin = i + 1;
    else if (pattern[i] == '>' && depth > 0 && --depth == 0)
      elements.push_back(pattern.substr(begin, i - begin));
  return elements;
}

std::string info_of(const dealii::ExceptionBase &error)
{
  std::ostringstream text;
  error.print_info(text);
  return text.str();
}

} // namespace

template <int dim>
MeshGenerator<dim>::MeshGenerator(const Section &section, const std::string &name,
                                  const std::string &arguments)
    : section(section), name(name), arguments(arguments)
{
  check_arguments(ask_for_signature());
}

/// deal.II parses the arguments by a pattern, and shows this if they do not match, as no arguments never do.
template <int dim>
std::vector<std::string> MeshGenerator<dim>::ask_for_signature() const
{
  std::string reason;
  try {
    dealii::Triangulation<dim> nothing;
    dealii::GridGenerator::generate_from_name_and_arguments(nothing, name, "");
  } catch (const dealii::ExceptionBase &error) {
    reason = info_of(error);
  }
  const auto pattern = reason.find("[Tuple of <");
  if (pattern != std::string::npos)
    return elements_of_tuple(reason.substr(pattern));
  const std::string guess = did_you_mean(name, {"hyper_cube",
                                                "subdivided_hyper_cube",
                                                "hyper_rectangle",
                                                "subdivided_hyper_rectangle",
                                                "hyper_ball",
                                                "hyper_ball_balanced",
                                                "quarter_hyper_ball",
                                                "half_hyper_ball",
                                                "hyper_shell",
                                                "quarter_hyper_shell",
                                                "half_hyper_shell",
                                                "cylinder",
                                                "subdivided_cylinder",
                                                "cylinder_shell",
                                                "truncated_cone",
                                                "hyper_L",
                                                "hyper_cube_with_cylindrical_hole",
                                                "plate_with_a_hole",
                                                "channel_with_cylinder",
                                                "cheese",
                                                "simplex",
                                                "torus",
                                                "concentric_hyper_shells",
                                                "general_cell",
                                                "enclosed_hyper_cube",
                                                "hyper_cross"});
  section.fail("Generator", "names '" + name + "', which deal.II does not have in this dimension" +
                                (guess.empty() ? ": see GridGenerator in its documentation." : ". " + guess));
}

template <int dim>
void MeshGenerator<dim>::check_arguments(const std::vector<std::string> &kinds)
{
  const auto words = dealii::Utilities::split_string_list(arguments, ':');
  check(words.size() == kinds.size(),
        "it takes " + std::to_string(kinds.size()) + " arguments separated by ':', lists by ','.");
  for (unsigned int i = 0; i < words.size(); ++i)
    if (name == "subdivided_hyper_rectangle" && i == 0 && words[i].find(';') != std::string::npos)
      check_steps(words);
    else if (name == "subdivided_hyper_rectangle" && i == 0)
      check_argument("[List of <[Integer]", words[i]);
    else
      check_argument(kinds[i], words[i]);
  if (name == "subdivided_hyper_cube")
    cells = std::pow(cells, dim);
  if (name == "plate_with_a_hole") // else it never ends
    check(0 < to_number(words[0]) && to_number(words[0]) < to_number(words[1]),
          "the first radius should be larger than 0 and smaller than the second.");
  if (name == "concentric_hyper_shells" && dim == 3)
    check(words[5] == "0" || words[5] == "6" || words[5] == "12" || words[5] == "96",
          "a shell should have 6, 12 or 96 cells, or 0 for a number that it chooses.");
}

template <int dim>
void MeshGenerator<dim>::check_argument(const std::string &kind, const std::string &argument)
{
  const bool is_list_of_points = begins_with(kind, "[List of <[List of <[Double");
  const auto words = dealii::Utilities::split_string_list(argument, is_list_of_points ? ';' : ',');
  if (is_list_of_points || begins_with(kind, "[List of <[Integer")) {
    const unsigned int length = length_of_list(name, dim);
    check(length == 0 || words.size() == length,
          "'" + argument + "' should be " + std::to_string(length) +
              (is_list_of_points ? " points separated by ';'." : " whole numbers separated by ','."));
    for (const std::string &word : words)
      is_list_of_points ? check_argument("[List of <[Double", word) : count(word, smallest_count(name));
  } else if (begins_with(kind, "[List of <[Double")) {
    check(words.size() == dim,
          "'" + argument + "' should be a point, " + std::to_string(dim) + " numbers separated by ','.");
    for (const std::string &word : words)
      to_number(word);
  } else if (begins_with(kind, "[Integer"))
    count(argument, smallest_count(name));
  else if (begins_with(kind, "[Double"))
    to_number(argument);
  else if (begins_with(kind, "[Bool"))
    check(Patterns::Bool().match(argument), "'" + argument + "' should be true or false.");
}

/// The second form of subdivided_hyper_rectangle: the sizes of the cells in each direction, which must add up
/// to those of the box.
template <int dim>
void MeshGenerator<dim>::check_steps(const std::vector<std::string> &words)
{
  const auto lists = dealii::Utilities::split_string_list(words[0], ';');
  check(lists.size() == dim, "'" + words[0] + "' should be " + std::to_string(dim) +
                                 " lists of sizes separated by ';', one for each direction.");
  for (unsigned int i : {1, 2})
    check_argument("[List of <[Double", words[i]);
  for (unsigned int d = 0; d < dim; ++d) {
    const auto sizes = dealii::Utilities::split_string_list(lists[d], ',');
    double sum = 0;
    for (const std::string &size : sizes) {
      check(to_number(size) > 0, "the size of a cell, '" + size + "', should be larger than 0.");
      sum += to_number(size);
    }
    cells *= sizes.size();
    std::array<double, 2> corner;
    for (unsigned int i : {0, 1})
      corner[i] = to_number(dealii::Utilities::split_string_list(words[1 + i], ',')[d]);
    const double extent = std::abs(corner[1] - corner[0]);
    check(std::abs(sum - extent) <= 1e-12 * std::max({extent, std::abs(corner[0]), std::abs(corner[1])}),
          "the sizes '" + lists[d] + "' do not add up to that of the box in their direction.");
  }
}

template <int dim>
void MeshGenerator<dim>::count(const std::string &word, const unsigned int smallest)
{
  check(Patterns::Integer(smallest).match(word),
        "'" + word + "' should be a whole number, at least " + std::to_string(smallest) + ".");
  cells *= std::max(1., to_number(word));
}

template <int dim>
double MeshGenerator<dim>::to_number(const std::string &word) const
{
  check(Patterns::Double().match(word), "'" + word + "' should be a number.");
  return dealii::Utilities::string_to_double(word);
}

template <int dim>
void MeshGenerator<dim>::fail(const std::string &message) const
{
  section.fail("Arguments", "are '" + arguments + "', which do not fit the generator " + name + ": " +
                                message + " See the function of this name in deal.II's GridGenerator.");
}

template <int dim>
void MeshGenerator<dim>::make(dealii::Triangulation<dim> &mesh) const
{
  std::string reason;
  try {
    dealii::GridGenerator::generate_from_name_and_arguments(mesh, name, arguments);
    return;
  } catch (const dealii::ExceptionBase &error) {
    reason = info_of(error);
  }
  for (char &letter : reason)
    letter = letter == '\n' ? ' ' : letter;
  reason.erase(0, reason.find_first_not_of(' '));
  reason.erase(reason.find_last_not_of(' ') + 1);
  fail(reason.empty() ? "deal.II refuses them." : reason);
}

template class MeshGenerator<2>;
template class MeshGenerator<3>;

} // namespace dovetail
