// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// I-DEAS' universal files (.unv): data sets between lines of -1, of which 2411 holds the nodes, 2412 the
// elements, 2467 or 2477 the groups (Universal File Datasets, Structural Dynamics Research Laboratory,
// University of Cincinnati). The name of a group is the id of its elements, 0 without one.

#include <dovetail/domain/mesh_text.h>

#include <map>
#include <unordered_map>

namespace dovetail {

namespace {

struct UnvType
{
  unsigned int dim, n_nodes;
};

/// By the number of the finite element: rods and beams, triangles, quadrilaterals, solids of first order.
const std::map<std::int64_t, UnvType> unv_types = {
    {11, {1, 2}}, {21, {1, 2}}, {22, {1, 2}}, {41, {2, 3}}, {51, {2, 3}}, {61, {2, 3}},  {74, {2, 3}},
    {91, {2, 3}}, {44, {2, 4}}, {54, {2, 4}}, {64, {2, 4}}, {94, {2, 4}}, {111, {3, 4}}, {115, {3, 8}}};

class UnvReader
{
public:
  UnvReader(MeshText &text, const unsigned int dim) : text(text), collector(text, dim) {}

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
                     "order");
      read_integers(3); // property, material, colour
      text.check(text.integer("the number of nodes", 0, INT32_MAX) == type->second.n_nodes,
                 "the element " + std::to_string(element.number) + " should have " +
                     std::to_string(type->second.n_nodes) + " nodes");
      if (type->second.dim == 1)
        read_integers(3); // of beams
      element.dim = type->second.dim;
      for (unsigned int i = 0; i < type->second.n_nodes; ++i)
        element.nodes.push_back(collector.node(text.integer("the number of a node", 1, largest_mesh_number)));
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
      const std::string name(text.peek());
      const auto id = text.to_integer(text.word(), "the name of a group, which must be a whole number", 0,
                                      largest_mesh_id);
      for (std::size_t i = 0; i < n_entities; ++i) {
        const auto type = text.integer("the type of an entity of a group", 0, INT32_MAX);
        const auto number = text.integer("the number of an entity of a group", 0, largest_mesh_number);
        read_integers(2);
        if (type != 8) // elements
          continue;
        const auto found = index.find(number);
        text.check(found != index.end(), "the group " + name + " has the element " + std::to_string(number) +
                                             ", which does not exist");
        elements[found->second].id = id;
      }
    }
  }

  void add_elements()
  {
    for (const Element &element : elements)
      collector.add_element(element.number, element.dim, element.id, element.nodes);
  }

  struct Element
  {
    std::int64_t number = 0;
    unsigned int dim = 0, id = 0;
    std::vector<unsigned int> nodes;
  };

  MeshText &text;
  MeshCollector collector;
  std::vector<Element> elements;
  std::unordered_map<std::int64_t, std::size_t> index;
};

} // namespace

MeshFile read_unv(MeshText &text, const unsigned int dim)
{
  return UnvReader(text, dim).read();
}

} // namespace dovetail
