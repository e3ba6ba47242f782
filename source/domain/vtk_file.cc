// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// VTK's legacy format, an unstructured grid in ASCII with CELLS as before version 5 (number of points,
// points) or since then (OFFSETS, CONNECTIVITY); VTK file formats, vtk.org. The ids are the cell data
// "MaterialID", or "CellEntityIds" as Gmsh calls them and "gmsh:physical" as meshio does, of cells and of
// faces alike, 0 without them. Nodes and elements are counted from 0, as VTK does.

#include <dovetail/domain/mesh_text.h>

#include <map>

namespace dovetail {

namespace {

struct CellType
{
  unsigned int dim, n_nodes;
};

/// Of first order, and of second; 13, 14, 26, 27 and 32 are wedges and pyramids.
const std::map<std::int64_t, CellType> vtk_types = {
    {1, {0, 1}},   {3, {1, 2}},   {5, {2, 3}},   {9, {2, 4}},  {10, {3, 4}},  {12, {3, 8}},
    {13, {3, 6}},  {14, {3, 5}},  {21, {1, 3}},  {22, {2, 6}}, {23, {2, 8}},  {24, {3, 10}},
    {25, {3, 20}}, {26, {3, 15}}, {27, {3, 13}}, {28, {2, 9}}, {29, {3, 27}}, {32, {3, 18}}};

class VtkReader
{
public:
  VtkReader(MeshText &text, const unsigned int dim) : text(text), collector(text, dim) {}

  MeshFile read()
  {
    text.check(text.rest_of_line().substr(0, 5) == "# vtk", "expected '# vtk DataFile Version …'");
    text.rest_of_line(); // a title
    for (const char *word : {"ASCII", "DATASET", "UNSTRUCTURED_GRID"})
      text.expect(word);
    while (!text.peek().empty())
      read_section(std::string(text.word()));
    text.check(!node_lists.empty() && node_lists.size() == cell_types.size(),
               "the file has " + std::to_string(node_lists.size()) + " CELLS and " +
                   std::to_string(cell_types.size()) + " CELL_TYPES");
    add_elements();
    return collector.finish();
  }

private:
  void read_section(const std::string &name)
  {
    if (name == "POINTS")
      read_points();
    else if (name == "CELLS")
      read_cells();
    else if (name == "CELL_TYPES") {
      cell_types.resize(text.count("the number of types of cells"));
      for (auto &type : cell_types)
        type = text.integer("a type of a cell", 0, 1000);
    } else if (name == "CELL_DATA" || name == "POINT_DATA")
      is_cell_data = name == "CELL_DATA";
    else if (name == "SCALARS" && is_cell_data && is_name_of_ids(text.peek()))
      read_scalar_ids();
    else if (is_name_of_ids(name) && is_cell_data)
      read_ids_of_field();
    // all else is data that nobody asks for
  }

  /// Without a MaterialID the entities count.
  bool is_name_of_ids(const std::string_view name) const
  {
    return name == "MaterialID" || ((name == "CellEntityIds" || name == "gmsh:physical") && ids.empty());
  }

  void read_points()
  {
    text.check(collector.file.nodes.empty(), "the section POINTS is there twice");
    const std::size_t n = text.count("the number of points");
    text.word(); // the type of the numbers
    for (std::size_t i = 0; i < n; ++i) {
      dealii::Point<3> position;
      for (unsigned int d = 0; d < 3; ++d)
        position[d] = text.number("a coordinate of the point " + std::to_string(i));
      collector.add_node(i, position);
    }
  }

  unsigned int read_point_number()
  {
    return collector.node(text.integer("the number of a point", 0, largest_mesh_number));
  }

  void read_cells()
  {
    text.check(node_lists.empty(), "the section CELLS is there twice");
    const std::size_t n = text.count("the number of cells"), n_numbers = text.count("the size of CELLS");
    if (text.peek() == "OFFSETS") {
      read_offsets_and_connectivity(n, n_numbers);
      return;
    }
    node_lists.resize(n);
    std::size_t n_read = n;
    for (auto &nodes : node_lists) {
      nodes.resize(text.count("the number of points of a cell"));
      n_read += nodes.size();
      for (auto &node : nodes)
        node = read_point_number();
    }
    text.check(n_read == n_numbers,
               "CELLS announces " + std::to_string(n_numbers) + " numbers and has " + std::to_string(n_read));
  }

  /// Since version 5 "CELLS a b" counts the offsets, one more than the cells, and the points of all cells.
  void read_offsets_and_connectivity(const std::size_t n_offsets, const std::size_t n_numbers)
  {
    text.expect("OFFSETS");
    text.word();
    std::vector<std::size_t> offsets(n_offsets);
    for (std::size_t i = 0; i < n_offsets; ++i)
      offsets[i] = text.integer("an offset", i == 0 ? 0 : offsets[i - 1], i == 0 ? 0 : n_numbers);
    text.check(n_offsets > 0 && offsets.back() == n_numbers, "the last of the OFFSETS is not the number of "
                                                             "points of all cells");
    text.expect("CONNECTIVITY");
    text.word();
    for (std::size_t i = 0; i + 1 < n_offsets; ++i) {
      node_lists.emplace_back(offsets[i + 1] - offsets[i]);
      for (auto &node : node_lists.back())
        node = read_point_number();
    }
  }

  /// SCALARS MaterialID int [1], LOOKUP_TABLE name, values
  void read_scalar_ids()
  {
    text.word();
    text.rest_of_line();
    text.expect("LOOKUP_TABLE");
    text.word();
    read_ids();
  }

  /// In a FIELD: MaterialID 1 n int, values
  void read_ids_of_field()
  {
    text.integer("1, the number of components of MaterialID", 1, 1);
    text.check(text.count("the number of ids") == node_lists.size(),
               "MaterialID has not as many ids as there are cells");
    text.word();
    read_ids();
  }

  void read_ids()
  {
    text.check(!node_lists.empty() && ids.empty(), "MaterialID comes before CELLS, or twice");
    for (std::size_t i = 0; i < node_lists.size(); ++i)
      ids.push_back(text.integer("the MaterialID of the cell " + std::to_string(i), 0, largest_mesh_id));
  }

  void add_elements()
  {
    for (std::size_t i = 0; i < node_lists.size(); ++i) {
      const auto type = vtk_types.find(cell_types[i]);
      const std::string cell = "the cell " + std::to_string(i) + " has VTK's type ";
      if (type == vtk_types.end())
        throw MeshError(cell + std::to_string(cell_types[i]) +
                        ", which is not read. Use lines (3), triangles (5), quadrilaterals (9), tetrahedra "
                        "(10) and hexahedra (12), or those of second order (21 to 25, 28, 29).");
      if (type->second.n_nodes != node_lists[i].size())
        throw MeshError(cell + std::to_string(cell_types[i]) + " but " +
                        std::to_string(node_lists[i].size()) + " points.");
      if (type->second.dim == 3)
        order_as_in_gmsh(node_lists[i]);
      collector.add_element(i, type->second.dim, ids.empty() ? 0 : ids[i], node_lists[i]);
    }
  }

  MeshText &text;
  MeshCollector collector;
  std::vector<std::vector<unsigned int>> node_lists;
  std::vector<std::int64_t> cell_types;
  std::vector<unsigned int> ids;
  bool is_cell_data = false;
};

} // namespace

MeshFile read_vtk(MeshText &text, const unsigned int dim)
{
  return VtkReader(text, dim).read();
}

} // namespace dovetail
