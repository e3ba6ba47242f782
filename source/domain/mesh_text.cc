// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/mesh_text.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace dovetail {

namespace {

bool is_blank(const char letter)
{
  return letter == ' ' || letter == '\t' || letter == '\r' || letter == '\n' || letter == '\v' ||
         letter == '\f' || letter == '\0';
}

/// For messages; whatever a file holds, one line of it is enough.
std::string quoted(const std::string_view word)
{
  std::string text;
  for (const char letter : word.substr(0, 40))
    text += (letter >= ' ' && letter <= '~') ? letter : '?';
  return "'" + text + (word.size() > 40 ? "…'" : "'");
}

} // namespace

std::string_view MeshText::word()
{
  for (; position < content.size() && is_blank(content[position]); ++position)
    line += content[position] == '\n';
  line_of_last = line;
  const std::size_t begin = position;
  while (position < content.size() && !is_blank(content[position]))
    ++position;
  return std::string_view(content).substr(begin, position - begin);
}

std::string_view MeshText::peek()
{
  const std::size_t at = position, line_there = line;
  const std::string_view next = word();
  position = at;
  line = line_there;
  return next;
}

std::string_view MeshText::rest_of_line()
{
  const std::size_t begin = position;
  line_of_last = line;
  while (position < content.size() && content[position] != '\n')
    ++position;
  std::string_view rest = std::string_view(content).substr(begin, position - begin);
  if (position < content.size()) {
    ++position;
    ++line;
  }
  if (!rest.empty() && rest.back() == '\r')
    rest.remove_suffix(1);
  return rest;
}

bool MeshText::at_end()
{
  return position >= content.size();
}

void MeshText::expect(const std::string_view wanted)
{
  if (const auto found = word(); found != wanted)
    fail("expected " + std::string(wanted) + ", found " +
         (found.empty() ? "the end of the file" : quoted(found)));
}

void MeshText::fail_at(const std::string_view word, const std::string_view what, const char *remark) const
{
  fail("expected " + std::string(what) + ", found " +
       (word.empty() ? "the end of the file" : quoted(word) + remark));
}

std::int64_t MeshText::to_integer(const std::string_view word, const std::string_view what,
                                  const std::int64_t smallest, const std::int64_t largest) const
{
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || error != std::errc() || end != word.data() + word.size() || value < smallest ||
      value > largest)
    fail_at(word, what);
  return value;
}

std::int64_t MeshText::integer(const std::string_view what, const std::int64_t smallest,
                               const std::int64_t largest)
{
  return to_integer(word(), what, smallest, largest);
}

double MeshText::to_number(std::string_view word, const std::string_view what) const
{
  if (word.empty())
    fail_at(word, what);
  std::string c_like(word.substr(word[0] == '+' ? 1 : 0)); // Fortran writes +1.0D+00
  for (char &letter : c_like)
    if (letter == 'D' || letter == 'd')
      letter = 'e';
  double value = 0;
  const auto [end, error] = std::from_chars(c_like.data(), c_like.data() + c_like.size(), value);
  const bool is_number = end == c_like.data() + c_like.size() &&
                         (error == std::errc() || error == std::errc::result_out_of_range);
  if (!is_number)
    fail_at(word, what);
  if (error == std::errc::result_out_of_range) // also where it is nearly zero
    value = std::strtod(c_like.c_str(), nullptr);
  if (!std::isfinite(value))
    fail_at(word, what, ", which is not finite");
  return value;
}

double MeshText::number(const std::string_view what)
{
  return to_number(word(), what);
}

std::size_t MeshText::count(const std::string_view what)
{
  return to_count(integer(what, 0, largest_mesh_number), what);
}

std::size_t MeshText::to_count(const std::int64_t n, const std::string_view what) const
{
  check(n >= 0 && std::size_t(n) <= (content.size() - position) / 2 + 1,
        std::string(what) + " is " + std::to_string(n) + ", more than what is left of the file can hold");
  return n;
}

void MeshText::fail(const std::string &message) const
{
  throw MeshError((has_bytes ? "byte " + std::to_string(position) : "line " + std::to_string(line_of_last)) +
                  ": " + message + ".");
}

void MeshCollector::add_node(const std::int64_t number, const dealii::Point<3> &position)
{
  if (!index.emplace(number, file.nodes.size()).second)
    text.fail("the node " + std::to_string(number) + " is given a second time");
  file.nodes.push_back(position);
  file.node_numbers.push_back(number);
}

unsigned int MeshCollector::node(const std::int64_t number) const
{
  const auto found = index.find(number);
  if (found == index.end())
    text.fail("the node " + std::to_string(number) + " does not exist");
  return found->second;
}

template <typename Number>
void order_as_in_gmsh(std::vector<Number> &nodes)
{
  const std::vector<Number> in_file = nodes;
  static const std::vector<unsigned int> of_hexahedron = {8,  11, 16, 9,  17, 10, 18, 19, 12, 15,
                                                          13, 14, 24, 22, 20, 21, 23, 25, 26};
  if (nodes.size() == 10)
    std::swap(nodes[8], nodes[9]);
  else if (nodes.size() == 20 || nodes.size() == 27)
    for (std::size_t i = 8; i < nodes.size(); ++i)
      nodes[i] = in_file[of_hexahedron[i - 8]];
}

template void order_as_in_gmsh(std::vector<unsigned int> &);
template void order_as_in_gmsh(std::vector<std::int64_t> &);

void MeshCollector::add_element(const std::int64_t number, const unsigned int element_dim,
                                const unsigned int id, const std::vector<unsigned int> &nodes)
{
  if (element_dim > dim)
    text.fail("the element " + std::to_string(number) +
              " has three dimensions, but the scene has Dimension = 2");
  if (element_dim + 1 < dim)
    return;
  (element_dim == dim ? file.cells : file.faces).add(number, id, nodes);
}

MeshFile MeshCollector::finish()
{
  for (auto &[name, cells] : file.volumes) { // of several sets of one name
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  }
  if (file.cells.size() == 0)
    throw MeshError(
        dim == 2 ? "it has no triangles or quadrilaterals." +
                       std::string(file.faces.size() > 0
                                       ? " In Gmsh, mesh in two dimensions and, if curves have "
                                         "physical groups, give the surfaces one, too: only what is "
                                         "in a group is saved."
                                       : "")
                 : "it has no tetrahedra or hexahedra" +
                       std::string(
                           file.faces.size() > 0
                               ? ", only faces: is it made for Dimension = 2? Else, in Gmsh, mesh in three "
                                 "dimensions and, if surfaces have physical groups, give the volumes one, "
                                 "too: only what is in a group is saved."
                               : "."));
  return std::move(file);
}

} // namespace dovetail
