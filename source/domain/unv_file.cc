// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// I-DEAS' universal files (.unv): data sets between lines of -1, of which 2411 holds the nodes, 2412 the
// elements, 2467 or 2477 the groups (Universal File Datasets, Structural Dynamics Research Laboratory,
// University of Cincinnati). A group whose name is a number gives its
// elements this id, others the next free one; the id is 0 without a group.

#include <dovetail/domain/mesh_text.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>

namespace dovetail {

namespace {

struct UnvType
{
  unsigned int dim, n_nodes;
};

/// By the number of the finite element: rods and beams, triangles, quadrilaterals, solids, of first order and
/// "parabolic". Wedges are 112 and 113.
const std::map<std::int64_t, UnvType> unv_types = {
    {11, {1, 2}},   {21, {1, 2}},   {22, {1, 2}},  {24, {1, 3}},  {41, {2, 3}},  {51, {2, 3}},
    {61, {2, 3}},   {74, {2, 3}},   {91, {2, 3}},  {42, {2, 6}},  {52, {2, 6}},  {62, {2, 6}},
    {72, {2, 6}},   {92, {2, 6}},   {44, {2, 4}},  {54, {2, 4}},  {64, {2, 4}},  {94, {2, 4}},
    {45, {2, 8}},   {55, {2, 8}},   {65, {2, 8}},  {95, {2, 8}},  {111, {3, 4}}, {115, {3, 8}},
    {118, {3, 10}}, {116, {3, 20}}, {112, {3, 6}}, {113, {3, 15}}};

/// Nodes of second order stand between the vertices of a line or face. Those of a solid are its bottom so,
/// the middles of the edges up, and its top so. @return those of Gmsh's order, as positions in the file
std::vector<unsigned int> places_in_gmsh(const UnvType &type)
{
  static const std::map<std::pair<unsigned int, unsigned int>, std::vector<unsigned int>> places = {
      {{1, 3}, {0, 2, 1}},
      {{2, 6}, {0, 2, 4, 1, 3, 5}},
      {{2, 8}, {0, 2, 4, 6, 1, 3, 5, 7}},
      {{3, 10}, {0, 2, 4, 9, 1, 3, 5, 6, 8, 7}},
      {{3, 20}, {0, 2, 4, 6, 12, 14, 16, 18, 1, 7, 8, 3, 9, 5, 10, 11, 13, 19, 15, 17}}};
  const auto found = places.find({type.dim, type.n_nodes});
  return found == places.end() ? std::vector<unsigned int>() : found->second;
}

class UnvReader
{
public:
  UnvReader(MeshText &text, const unsigned int dim) : text(text), collector(text, dim), dim(dim) {}

  MeshFile read()
  {
    while (!text.peek().empty() && text.peek()[0] == '#') {
      text.word();
      text.rest_of_line();
    }
    while (!text.peek().empty()) {
      text.expect("-1");
      read_data_set(text.integer("the number of a data set", 1, INT32_MAX));
      text.expect("-1");
    }
    add_elements();
    return collector.finish();
  }

private:
  void read_data_set(const std::int64_t number)
  {
    if (number == 2411)
      read_nodes();
    else if (number == 2412)
      read_elements();
    else if (number == 2467 || number == 2477)
      read_groups();
    else
      while (text.peek() != "-1") // a word of data may be -1 too, but then a data set begins wrongly
        text.check(!text.word().empty(), "the data set " + std::to_string(number) + " does not end");
  }

  void read_integers(const unsigned int n)
  {
    for (unsigned int i = 0; i < n; ++i)
      text.integer("a whole number", INT32_MIN, INT32_MAX);
  }

  void read_nodes()
  {
    while (text.peek() != "-1") {
      const auto number = text.integer("the number of a node", 1, largest_mesh_number);
      read_integers(3);
      dealii::Point<3> position;
      for (unsigned int d = 0; d < 3; ++d)
        position[d] = text.number("a coordinate of the node " + std::to_string(number));
      collector.add_node(number, position);
    }
  }

  void read_elements()
  {
    while (text.peek() != "-1") {
      Element element;
      element.number = text.integer("the number of an element", 1, largest_mesh_number);
      const auto type = unv_types.find(text.integer("the type of an element", 1, INT32_MAX));
      text.check(type != unv_types.end(),
                 "the type of the element " + std::to_string(element.number) +
                     " is not read. Use lines, triangles, quadrilaterals, tetrahedra and hexahedra of first "
                     "or second order");
      read_integers(3); // property, material, colour
      text.check(text.integer("the number of nodes", 0, INT32_MAX) == type->second.n_nodes,
                 "the element " + std::to_string(element.number) + " should have " +
                     std::to_string(type->second.n_nodes) + " nodes");
      if (type->second.dim == 1)
        read_integers(3); // of beams
      element.dim = type->second.dim;
      for (unsigned int i = 0; i < type->second.n_nodes; ++i)
        element.nodes.push_back(collector.node(text.integer("the number of a node", 1, largest_mesh_number)));
      const std::vector<unsigned int> in_file = element.nodes, places = places_in_gmsh(type->second);
      for (std::size_t i = 0; i < places.size(); ++i)
        element.nodes[i] = in_file[places[i]];
      text.check(index.emplace(element.number, elements.size()).second,
                 "the element " + std::to_string(element.number) + " is given a second time");
      elements.push_back(element);
    }
  }

  void read_groups()
  {
    while (text.peek() != "-1") {
      read_integers(7);
      const std::size_t n_entities = text.count("the number of elements of a group");
      text.rest_of_line();
      const std::string name = dealii::Utilities::trim(std::string(text.rest_of_line()));
      text.check(!name.empty(), "expected the name of a group");
      groups.emplace_back(name, std::vector<std::size_t>());
      std::int64_t missing = 0;
      for (std::size_t i = 0; i < n_entities; ++i) {
        const auto type = text.integer("the type of an entity of a group", 0, INT32_MAX);
        const auto number = text.integer("the number of an entity of a group", 0, largest_mesh_number);
        read_integers(2);
        if (type != 8) // elements
          continue;
        if (const auto found = index.find(number); found != index.end())
          groups.back().second.push_back(found->second);
        else
          missing = number;
      }
      text.check(missing == 0 || groups.back().second.empty(), // Gmsh writes groups of points without these
                 "the group " + name + " has the element " + std::to_string(missing) +
                     ", which does not exist");
    }
  }

  /// Groups whose names are numbers have these ids, others the next that are free.
  void name_groups()
  {
    const auto is_number = [](const std::string &name) {
      return name.find_first_not_of("0123456789") == std::string::npos;
    };
    std::set<std::int64_t> taken = {0};
    for (const auto &[name, members] : groups)
      if (is_number(name))
        taken.insert(text.to_integer(name, "a group", 0, largest_mesh_id));
    std::int64_t next = 1;
    for (const auto &[name, members] : groups) {
      while (!is_number(name) && taken.count(next) > 0)
        ++next;
      const unsigned int id = is_number(name) ? text.to_integer(name, "a group", 0, largest_mesh_id) : next;
      taken.insert(id);
      if (!is_number(name))
        names.emplace(name, id);
      for (const std::size_t element : members)
        elements[element].ids.push_back(id);
    }
  }

  /// A face in several groups is there once for each; a cell has the id of the last.
  void add_elements()
  {
    name_groups();
    std::set<unsigned int> ids_of_faces;
    for (const Element &element : elements) {
      if (element.dim + 1 == dim)
        ids_of_faces.insert(element.ids.begin(), element.ids.end());
      if (element.dim == dim)
        for (const auto &[name, id] : names)
          if (std::count(element.ids.begin(), element.ids.end(), id) > 0)
            collector.file.volumes[name].push_back(collector.file.cells.size());
      collector.add_element(element.number, element.dim, element.ids.empty() ? 0 : element.ids.back(),
                            element.nodes);
      for (std::size_t i = 0; i + 1 < element.ids.size() && element.dim + 1 == dim; ++i)
        collector.add_element(element.number, element.dim, element.ids[i], element.nodes);
    }
    for (const auto &[name, id] : names)
      if (collector.file.volumes.count(name) == 0 || ids_of_faces.count(id) > 0)
        collector.file.boundary_names[name].push_back(id);
  }

  struct Element
  {
    std::int64_t number = 0;
    unsigned int dim = 0;
    std::vector<unsigned int> ids = {}; ///< of its groups
    std::vector<unsigned int> nodes = {};
  };

  std::vector<std::pair<std::string, std::vector<std::size_t>>> groups; ///< by name
  std::multimap<std::string, unsigned int> names;                       ///< that are no numbers
  MeshText &text;
  MeshCollector collector;
  const unsigned int dim;
  std::vector<Element> elements;
  std::unordered_map<std::int64_t, std::size_t> index;
};

} // namespace

MeshFile read_unv(MeshText &text, const unsigned int dim)
{
  return UnvReader(text, dim).read();
}

} // namespace dovetail
