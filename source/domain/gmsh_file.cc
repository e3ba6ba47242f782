// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Gmsh's .msh, versions 2 and 4.1 (Gmsh reference manual, "MSH file format"). The id of an element is its
// first tag (version 2) or the physical group of its entity (version 4.1), 0 without one.

#include <dovetail/domain/mesh_text.h>

#include <array>
#include <map>

namespace dovetail {

namespace {

struct GmshType
{
  unsigned int dim, n_vertices, n_nodes;
};

/// Gmsh's types of elements up to second order.
const std::map<int, GmshType> gmsh_types = {
    {1, {1, 2, 2}},   {2, {2, 3, 3}},   {3, {2, 4, 4}},   {4, {3, 4, 4}},   {5, {3, 8, 8}},
    {6, {3, 6, 6}},   {7, {3, 5, 5}},   {8, {1, 2, 3}},   {9, {2, 3, 6}},   {10, {2, 4, 9}},
    {11, {3, 4, 10}}, {12, {3, 8, 27}}, {13, {3, 6, 18}}, {14, {3, 5, 14}}, {15, {0, 1, 1}},
    {16, {2, 4, 8}},  {17, {3, 8, 20}}, {18, {3, 6, 15}}, {19, {3, 5, 13}}};

class GmshReader
{
public:
  GmshReader(MeshText &text, const unsigned int dim) : text(text), collector(text, dim), dim(dim) {}

  MeshFile read()
  {
    read_format();
    while (!text.peek().empty())
      read_section(std::string(text.word()));
    text.check(has_nodes && has_elements,
               "the file ends without $" + std::string(has_nodes ? "Elements" : "Nodes"));
    return collector.finish();
  }

private:
  void read_format()
  {
    while (text.peek() == "$Comments")
      skip(std::string(text.word()));
    text.expect("$MeshFormat");
    const double version = text.number("the version of the format");
    is_version_4 = version > 4.05 && version < 4.15;
    text.check(is_version_4 || (version >= 2 && version < 3),
               "the version of the format is not known. In Gmsh, save the mesh as 'Version 4.1 ASCII' or "
               "'Version 2 ASCII'");
    text.check(text.integer("0 or 1, the type of the file", 0, 1) == 0,
               "the file is binary. In Gmsh, save the mesh as 'Version 4.1 ASCII'");
    text.integer("the size of a number", 4, 16);
    text.expect("$EndMeshFormat");
  }

  void read_section(const std::string &name)
  {
    text.check(name.size() > 1 && name[0] == '$' && name.substr(0, 4) != "$End",
               "expected the begin of a section, '$…', found '" + name.substr(0, 40) + "'");
    text.check(name != "$PartitionedEntities",
               "the mesh is partitioned. Save it without partitions: the ranks divide it themselves");
    if (name == "$Entities" && is_version_4)
      read_entities();
    else if (name == "$Nodes")
      read_nodes();
    else if (name == "$Elements")
      read_elements();
    else {
      skip(name);
      return;
    }
    text.expect("$End" + name.substr(1));
  }

  void skip(const std::string &name)
  {
    const std::string end = "$End" + name.substr(1);
    for (auto word = text.word(); word != end; word = text.word())
      text.check(!word.empty(), "the section " + name.substr(0, 40) + " does not end");
  }

  void read_entities()
  {
    std::array<std::size_t, 4> n;
    for (auto &count : n)
      count = text.count("a number of entities");
    for (unsigned int d = 0; d < 4; ++d)
      for (std::size_t i = 0; i < n[d]; ++i) {
        const auto tag = text.integer("the tag of an entity", INT32_MIN, INT32_MAX);
        for (unsigned int c = 0; c < (d == 0 ? 3 : 6); ++c)
          text.number("a coordinate of an entity");
        auto &groups = physical_groups[{d, tag}];
        for (auto k = text.count("the number of physical groups"); k > 0; --k)
          groups.push_back(std::abs(text.integer("a physical group", -largest_mesh_id, largest_mesh_id)));
        if (d > 0)
          for (auto k = text.count("the number of bounding entities"); k > 0; --k)
            text.integer("a bounding entity", INT32_MIN, INT32_MAX);
      }
  }

  void read_node(const std::int64_t number, const unsigned int n_parameters)
  {
    dealii::Point<3> position;
    for (unsigned int d = 0; d < 3; ++d)
      position[d] = text.number("a coordinate of the node " + std::to_string(number));
    for (unsigned int p = 0; p < n_parameters; ++p)
      text.number("a parameter of the node " + std::to_string(number));
    collector.add_node(number, position);
  }

  std::int64_t read_node_number() { return text.integer("the number of a node", 1, largest_mesh_number); }

  /// At the top of a section of nodes or elements: the numbers of blocks (version 2: one) and of these
  /// things.
  std::pair<std::size_t, std::size_t> read_sizes(const std::string &thing)
  {
    const std::size_t n_blocks = is_version_4 ? text.count("the number of blocks of " + thing + "s") : 1;
    const std::size_t n = text.count("the number of " + thing + "s");
    for (unsigned int i = 0; is_version_4 && i < 2; ++i)
      text.integer("the smallest and largest number of " +
                       (thing == "element" ? "an " + thing : "a " + thing),
                   0, largest_mesh_number);
    return {n_blocks, n};
  }

  void read_nodes()
  {
    text.check(!has_nodes, "the section $Nodes is there twice");
    has_nodes = true;
    const auto [n_blocks, n_nodes] = read_sizes("node");
    if (!is_version_4)
      for (std::size_t i = 0; i < n_nodes; ++i)
        read_node(read_node_number(), 0);
    for (std::size_t block = 0; is_version_4 && block < n_blocks; ++block) {
      const auto entity_dim = text.integer("the dimension of an entity", 0, 3);
      text.integer("the tag of an entity", INT32_MIN, INT32_MAX);
      const bool is_parametric = text.integer("0 or 1, whether nodes have parameters", 0, 1) == 1;
      std::vector<std::int64_t> numbers(text.count("the number of nodes of a block"));
      for (auto &number : numbers)
        number = read_node_number();
      for (const auto number : numbers)
        read_node(number, is_parametric ? entity_dim : 0);
    }
    text.check(collector.file.nodes.size() == n_nodes, "the section $Nodes announces " +
                                                           std::to_string(n_nodes) + " nodes and has " +
                                                           std::to_string(collector.file.nodes.size()));
  }

  void read_elements()
  {
    text.check(has_nodes && !has_elements, "the section $Elements comes before $Nodes, or twice");
    has_elements = true;
    const auto [n_blocks, n_elements] = read_sizes("element");
    if (!is_version_4)
      for (std::size_t i = 0; i < n_elements; ++i)
        read_element_of_version_2();
    std::size_t n = is_version_4 ? 0 : n_elements;
    for (std::size_t block = 0; is_version_4 && block < n_blocks; ++block)
      n += read_block_of_elements();
    text.check(n == n_elements, "the section $Elements announces " + std::to_string(n_elements) +
                                    " elements and has " + std::to_string(n));
  }

  void read_element_of_version_2()
  {
    const auto number = text.integer("the number of an element", 0, largest_mesh_number);
    const GmshType &type = read_type();
    std::int64_t id = 0;
    const auto n_tags = text.integer("the number of tags of an element", 0, 1000);
    for (std::int64_t t = 0; t < n_tags; ++t) {
      const auto tag = text.integer("a tag of the element " + std::to_string(number), INT32_MIN, INT32_MAX);
      if (t == 0)
        id = std::abs(tag);
    }
    read_element(number, type, id);
  }

  std::size_t read_block_of_elements()
  {
    const auto entity_dim = text.integer("the dimension of an entity", 0, 3);
    const auto tag = text.integer("the tag of an entity", INT32_MIN, INT32_MAX);
    const GmshType &type = read_type();
    text.check(type.dim == entity_dim, "an entity of dimension " + std::to_string(entity_dim) +
                                           " has elements of dimension " + std::to_string(type.dim));
    const std::size_t n = text.count("the number of elements of a block");
    const auto id = n > 0 && type.dim + 1 >= dim ? id_of_entity(entity_dim, tag) : 0;
    for (std::size_t i = 0; i < n; ++i)
      read_element(text.integer("the number of an element", 0, largest_mesh_number), type, id);
    return n;
  }

  std::int64_t id_of_entity(const unsigned int entity_dim, const std::int64_t tag) const
  {
    const auto found = physical_groups.find({entity_dim, tag});
    if (found == physical_groups.end() || found->second.empty())
      return 0;
    text.check(found->second.size() == 1,
               "the entity " + std::to_string(tag) + " of dimension " + std::to_string(entity_dim) +
                   " is in " + std::to_string(found->second.size()) +
                   " physical groups, but a cell or face has one id. Leave it in one group");
    return found->second[0];
  }

  const GmshType &read_type()
  {
    const auto number = text.integer("the type of an element", 1, INT32_MAX);
    const auto found = gmsh_types.find(number);
    text.check(found != gmsh_types.end(),
               "elements of Gmsh's type " + std::to_string(number) +
                   " are not read. Make a mesh of first order (or, of triangles or "
                   "tetrahedra, of second order)");
    return found->second;
  }

  void read_element(const std::int64_t number, const GmshType &type, const std::int64_t id)
  {
    std::vector<unsigned int> nodes(type.n_nodes);
    for (auto &node : nodes)
      node = collector.node(read_node_number());
    const bool is_cell_or_face = type.dim + 1 >= dim;
    text.check(!is_cell_or_face || type.n_vertices == type.dim + 1 || type.n_vertices == (1u << type.dim),
               "the element " + std::to_string(number) +
                   " is a wedge or a pyramid. All cells must be tetrahedra, or all hexahedra");
    collector.add_element(number, type.dim, id, nodes);
  }

  MeshText &text;
  MeshCollector collector;
  const unsigned int dim;
  bool is_version_4 = false, has_nodes = false, has_elements = false;
  std::map<std::pair<unsigned int, std::int64_t>, std::vector<std::int64_t>> physical_groups;
};

} // namespace

MeshFile read_gmsh(MeshText &text, const unsigned int dim)
{
  return GmshReader(text, dim).read();
}

} // namespace dovetail
