// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The words and numbers of a mesh file, each checked as it is taken, with the line for messages; and the
// elements as they come from there.

#pragma once

#include <dovetail/domain/mesh_file.h>

#include <cstring>
#include <string_view>
#include <unordered_map>

namespace dovetail {

/// A text from which one word after another is taken. Words are separated by blanks and ends of lines.
class MeshText
{
public:
  explicit MeshText(std::string content, std::string name = "")
      : content(std::move(content)), name(std::move(name))
  {
  }
  const std::string &file_name() const { return name; } ///< beside which others lie; empty: of no file

  /// The next word; empty at the end of the text.
  std::string_view word();
  std::string_view peek();
  /// The rest of the current line, without the end of the line.
  std::string_view rest_of_line();
  bool at_end();

  /// The next word, which must be this. @throw MeshError
  void expect(std::string_view wanted);
  /// The next word, which must be a whole number of this range. @p what names it in the message.
  std::int64_t integer(std::string_view what, std::int64_t smallest, std::int64_t largest);
  /// The next word, which must be a finite number.
  double number(std::string_view what);
  /// How many things follow: each needs at least two characters, so a text cannot announce more than it
  /// holds.
  std::size_t count(std::string_view what);

  /// From now on there are bytes between the words: messages name the byte, not the line.
  void begin_bytes() { has_bytes = true; }
  /// The next bytes as a number of this type.
  template <typename Number>
  Number bytes(std::string_view what)
  {
    if (content.size() - position < sizeof(Number))
      fail_at({}, what);
    Number number;
    std::memcpy(&number, content.data() + position, sizeof(Number));
    position += sizeof(Number);
    return number;
  }
  /// How many things follow, as of the section's head.
  std::size_t to_count(std::int64_t n, std::string_view what) const;

  std::int64_t to_integer(std::string_view word, std::string_view what, std::int64_t smallest,
                          std::int64_t largest) const;
  double to_number(std::string_view word, std::string_view what) const;

  /// @throw MeshError "line N: expected WHAT, found WORD"
  [[noreturn]] void fail_at(std::string_view word, std::string_view what, const char *remark = "") const;
  /// @throw MeshError "line N: MESSAGE"
  [[noreturn]] void fail(const std::string &message) const;
  void check(const bool condition, const std::string &message) const
  {
    if (!condition)
      fail(message);
  }

private:
  std::string content, name;
  std::size_t position = 0, line = 1;
  std::size_t line_of_last = 1; ///< word or rest of a line that was taken
  bool has_bytes = false;
};

/// The largest numbers of elements and nodes, and of material and boundary ids.
constexpr std::int64_t largest_mesh_number = 1'000'000'000'000'000'000, largest_mesh_id = INT32_MAX;

/// From the order in which Abaqus and VTK give the nodes of a tetrahedron or hexahedron of second order to
/// that of Gmsh: edges about the bottom, the top, then between both, in VTK followed by the nodes in the
/// middle of the faces x-, x+, y-, y+, z-, z+ and of the cell. Elements of another number of nodes stay.
template <typename Number>
void order_as_in_gmsh(std::vector<Number> &nodes);

/// Collects nodes and elements and knows the nodes by their numbers.
class MeshCollector
{
public:
  MeshCollector(const MeshText &text, unsigned int dim) : text(text), dim(dim) {}

  void add_node(std::int64_t number, const dealii::Point<3> &position);
  /// Index of a node. @throw MeshError if there is none with this number.
  unsigned int node(std::int64_t number) const;

  /// An element of @p element_dim dimensions: a cell, a face, nothing if it is smaller, an error if larger.
  void add_element(std::int64_t number, unsigned int element_dim, unsigned int id,
                   const std::vector<unsigned int> &nodes);
  MeshFile finish();

  MeshFile file;

private:
  const MeshText &text;
  const unsigned int dim;
  std::unordered_map<std::int64_t, unsigned int> index;
};

} // namespace dovetail
