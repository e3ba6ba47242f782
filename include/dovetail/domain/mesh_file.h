// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a file says about a mesh, before anything is made of it: nodes, cells and marked faces with the
// numbers that the file gives them, so that a message can name them.

#pragma once

#include <deal.II/base/point.h>

#include <boost/serialization/map.hpp>

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace dovetail {

/// Something is wrong with a mesh: a sentence without the scene's entry, which whoever catches it adds.
class MeshError : public std::runtime_error
{
public:
  using std::runtime_error::runtime_error;
};

/// Elements of one dimension. The vertices of each stand first: lines; triangles and quadrilaterals in
/// circular order; tetrahedra; hexahedra as one quadrilateral after its opposite one, vertex facing vertex.
struct MeshElements
{
  std::vector<std::size_t> begin = {0}; ///< of the nodes of each element; one more than elements
  std::vector<unsigned int> nodes;      ///< indices
  std::vector<std::int64_t> numbers;    ///< as in the file
  std::vector<unsigned int> ids;        ///< material or boundary ids

  std::size_t size() const { return numbers.size(); }
  unsigned int n_nodes(const std::size_t element) const { return begin[element + 1] - begin[element]; }
  const unsigned int *nodes_of(const std::size_t element) const { return nodes.data() + begin[element]; }
  unsigned int *nodes_of(const std::size_t element) { return nodes.data() + begin[element]; }
  void add(std::int64_t number, unsigned int id, const std::vector<unsigned int> &its_nodes)
  {
    nodes.insert(nodes.end(), its_nodes.begin(), its_nodes.end());
    begin.push_back(nodes.size());
    numbers.push_back(number);
    ids.push_back(id);
  }

  template <class Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &begin &nodes &numbers &ids;
  }
};

/// The content of a mesh file.
struct MeshFile
{
  std::vector<dealii::Point<3>> nodes;
  std::vector<std::int64_t> node_numbers; ///< as in the file
  MeshElements cells, faces;              ///< of the dimension of the scene and of one less

  /// The nodes of curved cells beside their vertices, cell by cell. Of triangles and tetrahedra: on the edges
  /// 01, 02, 12 or 01, 02, 03, 12, 13, 23 of the vertices; of quadrilaterals and hexahedra: those of FE_Q(2)
  /// on the lines, on the faces in 3D, and in the middle. Empty where all cells are straight. Found by
  /// examine().
  std::vector<dealii::Point<3>> further_nodes;

  std::map<std::string, std::vector<unsigned int>> boundary_names; ///< ids of the faces that have the name
  /// Cells by the names of volumes, which may be numbers: of the whole file, on the rank that reads it.
  std::map<std::string, std::vector<std::size_t>> volumes;
  bool is_part = false; ///< of the file: it has faces of other cells, too

  std::string format; ///< "Gmsh 4.1, binary", for messages
  std::string note;   ///< sentences about what is remarkable, by who reads and by examine()

  template <class Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &nodes &node_numbers &cells &faces &further_nodes &boundary_names &note;
  }
};

/// Read .msh (Gmsh 2.2 or 4.1), .inp (Abaqus or AVS UCD), .vtk or .unv, and believe nothing in it: counts,
/// numbers, types and ranges are checked. Files of some other formats are converted by the Python module
/// meshio, if it is installed; the note says so.
/// @throw MeshError, which names the line.
MeshFile read_mesh_file(const std::string &file_name, unsigned int dim);

/// Whether the ending of a name is that of a format which read_mesh_file() knows or gives to meshio.
bool is_known_mesh_format(const std::string &file_name);

/// Keep the cells of these volumes, each the name of a volume or a material id, and all faces.
/// @throw MeshError with the names that there are
void select_volumes(const std::vector<std::string> &names, MeshFile &mesh);

/// Convert a file into one of Gmsh's format at @p result. @throw MeshError
void convert_by_meshio(const std::string &file_name, const std::string &result);

class MeshText;

/// The formats, one file each.
MeshFile read_gmsh(MeshText &text, unsigned int dim);
MeshFile read_vtk(MeshText &text, unsigned int dim);
MeshFile read_abaqus(MeshText &text, unsigned int dim);
MeshFile read_ucd(MeshText &text, unsigned int dim);
MeshFile read_unv(MeshText &text, unsigned int dim);

} // namespace dovetail
