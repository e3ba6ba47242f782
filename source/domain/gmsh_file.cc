// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Gmsh's .msh, versions 2 and 4.1, text and binary (Gmsh reference manual, "MSH file format"). The id of an
// element is its first tag (version 2) or the physical group of its entity (version 4.1), 0 without one.
// Physical groups name volumes and boundaries; groups of one name are one. Without any of them the entities'
// numbers are names of volumes.

#include <dovetail/domain/mesh_text.h>

#include <array>
#include <cmath>
#include <map>
#include <set>

namespace dovetail {

namespace {

struct GmshType
{
  unsigned int dim, n_nodes;
};

/// Gmsh's types of elements up to second order.
const std::map<int, GmshType> gmsh_types = {
    {1, {1, 2}},  {2, {2, 3}},  {3, {2, 4}},   {4, {3, 4}},   {5, {3, 8}},   {6, {3, 6}},   {7, {3, 5}},
    {8, {1, 3}},  {9, {2, 6}},  {10, {2, 9}},  {11, {3, 10}}, {12, {3, 27}}, {13, {3, 18}}, {14, {3, 14}},
    {15, {0, 1}}, {16, {2, 8}}, {17, {3, 20}}, {18, {3, 15}}, {19, {3, 13}}};

class GmshReader
{
public:
  GmshReader(MeshText &text, const unsigned int dim) : text(text), collector(text, dim), dim(dim) {}

  MeshFile read()
  {
    read_format();
    while (!text.peek().empty())
      read_section(std::string(text.word()));
    name_groups();
    text.check(has_nodes && has_elements,
               "the file ends without $" + std::string(has_nodes ? "Elements" : "Nodes"));
    return collector.finish();
  }

private:
  void read_format()
  {
    while (text.peek() == "$Comments")
      skip(std::string(text.word()));
    text.check(text.peek().substr(0, 1) != "(",
               "it is a mesh of ANSYS Fluent, which meshio, too, calls .msh. In meshio, write it with "
               "file_format = \"gmsh\"");
    text.check(text.peek() == "$MeshFormat",
               "it does not begin with $MeshFormat, as meshes of Gmsh do since version 2. In Gmsh, save the "
               "mesh as 'Version 4.1 ASCII'");
    text.expect("$MeshFormat");
    const double version = text.number("the version of the format");
    is_version_4 = version > 4.05 && version < 4.15;
    text.check(is_version_4 || (version >= 2 && version < 3),
               "the version of the format is not known. In Gmsh, save the mesh as 'Version 4.1 ASCII' or "
               "'Version 2 ASCII'");
    is_binary = text.integer("0 or 1, the type of the file", 0, 1) == 1;
    const auto size = text.integer("the size of a number", 4, 16);
    if (is_binary) {
      text.rest_of_line();
      text.begin_bytes();
      text.check(size == 8 && text.bytes<std::int32_t>("the number 1") == 1,
                 "the file was written on another kind of computer, its bytes have another order or size. In "
                 "Gmsh, save the mesh as 'Version 4.1 ASCII'");
    }
    text.expect("$EndMeshFormat");
    collector.file.format =
        "Gmsh " + std::string(is_version_4 ? "4.1" : "2.2") + (is_binary ? ", binary" : ", text");
  }

  // ---- numbers, of which a binary file of version 2 has only small ones

  std::int64_t checked(const std::int64_t number, const std::string_view what, const std::int64_t smallest,
                       const std::int64_t largest) const
  {
    if (number < smallest || number > largest)
      text.fail_at(std::to_string(number), what);
    return number;
  }

  std::int64_t small(const std::string_view what, const std::int64_t smallest, const std::int64_t largest)
  {
    return is_binary ? checked(text.bytes<std::int32_t>(what), what, smallest, largest)
                     : text.integer(what, smallest, largest);
  }

  std::int64_t large(const std::string_view what, const std::int64_t smallest, const std::int64_t largest)
  {
    return is_binary && is_version_4 ? checked(text.bytes<std::int64_t>(what), what, smallest, largest)
                                     : small(what, smallest, largest);
  }

  std::size_t count(const std::string_view what)
  {
    return is_binary ? text.to_count(large(what, 0, largest_mesh_number), what) : text.count(what);
  }

  double number(const std::string_view what)
  {
    if (!is_binary)
      return text.number(what);
    const double value = text.bytes<double>(what);
    if (!std::isfinite(value))
      text.fail("expected " + std::string(what) + ", found a number that is not finite");
    return value;
  }

  void read_section(const std::string &name)
  {
    text.check(name.size() > 1 && name[0] == '$' && name.substr(0, 4) != "$End",
               "expected the begin of a section, '$…', found '" + name.substr(0, 40) + "'");
    text.check(name != "$PartitionedEntities",
               "the mesh is partitioned. Save it without partitions: the ranks divide it themselves");
    if (is_binary)
      text.rest_of_line();
    if (name == "$Entities" && is_version_4)
      read_entities();
    else if (name == "$Nodes")
      read_nodes();
    else if (name == "$Elements")
      read_elements();
    else if (name == "$PhysicalNames")
      read_names();
    else {
      skip(name);
      return;
    }
    text.expect("$End" + name.substr(1));
  }

  /// dimension, number, "name"; text also in a binary file
  void read_names()
  {
    for (auto n = text.count("the number of names"); n > 0; --n) {
      const auto group_dim = text.integer("the dimension of a physical group", 0, 3);
      const auto tag = std::abs(text.integer("a physical group", -largest_mesh_id, largest_mesh_id));
      const std::string rest(text.rest_of_line());
      const auto begin = rest.find('"'), end = rest.rfind('"');
      text.check(begin != end, "expected the name of a physical group in quotation marks");
      names[{group_dim, tag}].insert(rest.substr(begin + 1, end - begin - 1));
    }
  }

  void name_groups()
  {
    auto &file = collector.file;
    for (const auto &[group, its_names] : names)
      for (const std::string &name : its_names)
        if (const auto cells = cells_of_group.find(group.second); group.first == dim - 1)
          file.boundary_names[name].push_back(group.second);
        else if (group.first == dim && cells != cells_of_group.end()) {
          auto &volume = file.volumes[name];
          volume.insert(volume.end(), cells->second.begin(), cells->second.end());
        }
    auto &volumes = cells_of_group.empty() ? cells_of_entity : cells_of_group;
    for (auto &[tag, cells] : volumes)
      file.volumes.emplace(std::to_string(tag), std::move(cells));
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
    for (auto &n_of_dim : n)
      n_of_dim = count("a number of entities");
    for (unsigned int d = 0; d < 4; ++d)
      for (std::size_t i = 0; i < n[d]; ++i) {
        const auto tag = small("the tag of an entity", INT32_MIN, INT32_MAX);
        for (unsigned int c = 0; c < (d == 0 ? 3 : 6); ++c)
          number("a coordinate of an entity");
        auto &groups = physical_groups[{d, tag}];
        for (auto k = count("the number of physical groups"); k > 0; --k)
          groups.push_back(std::abs(small("a physical group", -largest_mesh_id, largest_mesh_id)));
        if (d > 0)
          for (auto k = count("the number of bounding entities"); k > 0; --k)
            small("a bounding entity", INT32_MIN, INT32_MAX);
      }
  }

  void read_node(const std::int64_t node, const unsigned int n_parameters)
  {
    dealii::Point<3> position;
    const std::string what = "a coordinate of the node " + std::to_string(node);
    for (unsigned int d = 0; d < 3; ++d)
      position[d] = number(what);
    for (unsigned int p = 0; p < n_parameters; ++p)
      number("a parameter of the node " + std::to_string(node));
    collector.add_node(node, position);
  }

  std::int64_t read_node_number() { return large("the number of a node", 1, largest_mesh_number); }

  /// At the top of a section of nodes or elements: the numbers of blocks (version 2: one) and of these
  /// things.
  std::pair<std::size_t, std::size_t> read_sizes(const std::string &thing)
  {
    const std::size_t n_blocks = is_version_4 ? count("the number of blocks of " + thing + "s") : 1;
    const std::size_t n =
        is_version_4 ? count("the number of " + thing + "s") : text.count("the number of " + thing + "s");
    if (is_binary && !is_version_4)
      text.rest_of_line(); // the bytes begin in the next one
    for (unsigned int i = 0; is_version_4 && i < 2; ++i)
      large("the smallest and largest number of " + (thing == "element" ? "an " + thing : "a " + thing), 0,
            largest_mesh_number);
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
      const auto entity_dim = small("the dimension of an entity", 0, 3);
      small("the tag of an entity", INT32_MIN, INT32_MAX);
      const bool is_parametric = small("0 or 1, whether nodes have parameters", 0, 1) == 1;
      std::vector<std::int64_t> numbers(count("the number of nodes of a block"));
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
      for (std::size_t i = 0; i < n_elements;)
        i += is_binary ? read_block_of_version_2(n_elements - i) : read_element_of_version_2();
    std::size_t n = is_version_4 ? 0 : n_elements;
    for (std::size_t block = 0; is_version_4 && block < n_blocks; ++block)
      n += read_block_of_elements();
    text.check(n == n_elements, "the section $Elements announces " + std::to_string(n_elements) +
                                    " elements and has " + std::to_string(n));
  }

  std::size_t read_element_of_version_2()
  {
    const auto number = text.integer("the number of an element", 0, largest_mesh_number);
    const GmshType &type = read_type();
    read_tagged_element(number, type, text.integer("the number of tags of an element", 0, 1000));
    return 1;
  }

  /// Type, number of elements and of tags, then the elements.
  std::size_t read_block_of_version_2(const std::size_t n_left)
  {
    const GmshType &type = read_type();
    const auto n = small("the number of elements of a block", 1, n_left);
    const auto n_tags = small("the number of tags of an element", 0, 1000);
    for (std::int64_t i = 0; i < n; ++i)
      read_tagged_element(small("the number of an element", 0, INT32_MAX), type, n_tags);
    return n;
  }

  void read_tagged_element(const std::int64_t number, const GmshType &type, const std::int64_t n_tags)
  {
    std::int64_t id = 0, entity = 0;
    const std::string what = "a tag of the element " + std::to_string(number);
    for (std::int64_t t = 0; t < n_tags; ++t) {
      const auto tag = small(what, INT32_MIN, INT32_MAX);
      (t == 0 ? id : entity) = t < 2 ? std::abs(tag) : entity;
    }
    read_element(number, type, id == 0 ? std::vector<std::int64_t>() : std::vector<std::int64_t>{id}, entity);
  }

  std::size_t read_block_of_elements()
  {
    const auto entity_dim = small("the dimension of an entity", 0, 3);
    const auto tag = small("the tag of an entity", INT32_MIN, INT32_MAX);
    const GmshType &type = read_type();
    text.check(type.dim == entity_dim, "an entity of dimension " + std::to_string(entity_dim) +
                                           " has elements of dimension " + std::to_string(type.dim));
    const std::size_t n = count("the number of elements of a block");
    const auto found = physical_groups.find({entity_dim, tag});
    for (std::size_t i = 0; i < n; ++i)
      read_element(large("the number of an element", 0, largest_mesh_number), type,
                   found == physical_groups.end() ? std::vector<std::int64_t>() : found->second,
                   std::abs(tag));
    return n;
  }

  const GmshType &read_type()
  {
    const auto number = small("the type of an element", 1, INT32_MAX);
    const auto found = gmsh_types.find(number);
    if (found == gmsh_types.end())
      text.fail("elements of Gmsh's type " + std::to_string(number) +
                " are not read. Make a mesh of first or second order");
    return found->second;
  }

  /// A face in several groups is there once for each; a cell has the id of the first.
  void read_element(const std::int64_t number, const GmshType &type, const std::vector<std::int64_t> &groups,
                    const std::int64_t entity)
  {
    std::vector<unsigned int> nodes(type.n_nodes);
    for (auto &node : nodes)
      node = collector.node(read_node_number());
    if (type.dim == dim) {
      for (const auto group : groups)
        cells_of_group[group].push_back(collector.file.cells.size());
      cells_of_entity[entity].push_back(collector.file.cells.size());
    }
    collector.add_element(number, type.dim, groups.empty() ? 0 : groups[0], nodes);
    for (std::size_t g = 1; g < groups.size() && type.dim + 1 == dim; ++g)
      collector.add_element(number, type.dim, groups[g], nodes);
  }

  MeshText &text;
  MeshCollector collector;
  const unsigned int dim;
  bool is_version_4 = false, is_binary = false, has_nodes = false, has_elements = false;
  std::map<std::pair<unsigned int, std::int64_t>, std::vector<std::int64_t>> physical_groups; ///< of entities
  std::map<std::pair<unsigned int, std::int64_t>, std::set<std::string>> names;               ///< of groups
  std::map<std::int64_t, std::vector<std::size_t>> cells_of_group, cells_of_entity;
};

} // namespace

MeshFile read_gmsh(MeshText &text, const unsigned int dim)
{
  return GmshReader(text, dim).read();
}

} // namespace dovetail
