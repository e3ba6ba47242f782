// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// AVS UCD: counts, nodes (number, x, y, z), elements (number, id, type, nodes). Lines that begin with '#'
// come first.

#include <dovetail/domain/mesh_text.h>

#include <map>
#include <string>

namespace dovetail {

namespace {

struct UcdType
{
  unsigned int dim, n_nodes;
};

const std::map<std::string, UcdType, std::less<>> ucd_types = {
    {"pt", {0, 1}}, {"line", {1, 2}}, {"tri", {2, 3}}, {"quad", {2, 4}}, {"tet", {3, 4}}, {"hex", {3, 8}}};

} // namespace

MeshFile read_ucd(MeshText &text, const unsigned int dim)
{
  MeshCollector collector(text, dim);
  while (!text.peek().empty() && text.peek()[0] == '#') {
    text.word();
    text.rest_of_line();
  }
  const std::size_t n_nodes = text.count("the number of nodes");
  const std::size_t n_elements = text.count("the number of elements");
  for (unsigned int i = 0; i < 3; ++i)
    text.integer("a number of data", 0, largest_mesh_number);

  for (std::size_t i = 0; i < n_nodes; ++i) {
    const auto number = text.integer("the number of a node", 0, largest_mesh_number);
    dealii::Point<3> position;
    for (unsigned int d = 0; d < 3; ++d)
      position[d] = text.number("a coordinate of the node " + std::to_string(number));
    collector.add_node(number, position);
  }
  for (std::size_t i = 0; i < n_elements; ++i) {
    const auto number = text.integer("the number of an element", 0, largest_mesh_number);
    const auto id = text.integer("the id of the element " + std::to_string(number), 0, largest_mesh_id);
    const auto type = ucd_types.find(text.word());
    text.check(type != ucd_types.end(), "the type of the element " + std::to_string(number) +
                                            " is not read. Use line, tri, quad, tet and hex");
    std::vector<unsigned int> nodes(type->second.n_nodes);
    for (auto &node : nodes)
      node = collector.node(text.integer("the number of a node", 0, largest_mesh_number));
    collector.add_element(number, type->second.dim, id, nodes);
  }
  return collector.finish();
}

} // namespace dovetail
