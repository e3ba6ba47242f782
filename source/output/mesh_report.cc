// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/curved_cube.h>
#include <dovetail/domain/curved_simplex.h>
#include <dovetail/domain/mesh_examination.h>
#include <dovetail/domain/mesh_file.h>
#include <dovetail/domain/symmetric_eigenvalues.h>
#include <dovetail/output/mesh_report.h>
#include <dovetail/output/new_file.h>
#include <dovetail/scene/input_file.h>
#include <dovetail/scene/user_error.h>

#include <deal.II/base/geometry_info.h>
#include <deal.II/base/numbers.h>
#include <deal.II/base/quadrature_lib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <sstream>

namespace dovetail {

namespace {

using dealii::Point;
using dealii::Tensor;

std::string digits(const double value)
{
  std::ostringstream text;
  text.precision(7);
  text << (std::abs(value) < 1e-14 ? 0. : value);
  return text.str();
}

/// Sizes and shapes of the cells of one volume.
template <int dim>
class Measures
{
public:
  explicit Measures(const MeshFile &mesh) : mesh(mesh), n_vertices(mesh.cells.n_nodes(0))
  {
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
      const unsigned int *nodes = mesh.cells.nodes_of(c);
      for (unsigned int v = 0; v < n_vertices; ++v)
        for (unsigned int d = 0; d < dim; ++d) {
          lowest[d] = std::min(lowest[d], mesh.nodes[nodes[v]][d]);
          highest[d] = std::max(highest[d], mesh.nodes[nodes[v]][d]);
        }
      add_cell(nodes);
      volume += n_vertices == dim + 1 ? CurvedSimplex(mesh, c, {nodes, nodes + n_vertices}).measure()
                : mesh.further_nodes.empty()
                    ? volume_of_hypercube(nodes)
                    : CurvedCube<dim>(mesh, c, {nodes, nodes + n_vertices}).measure();
    }
  }

  double volume = 0, smallest_angle = dealii::numbers::PI, largest_aspect = 1;
  std::array<double, dim> lowest = filled(1), highest = filled(-1);

private:
  static std::array<double, dim> filled(const int sign)
  {
    std::array<double, dim> values;
    values.fill(sign * std::numeric_limits<double>::max());
    return values;
  }

  Tensor<1, dim> edge(const unsigned int from, const unsigned int to) const
  {
    Tensor<1, dim> result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] = mesh.nodes[to][d] - mesh.nodes[from][d];
    return result;
  }

  void add_cell(const unsigned int *nodes)
  {
    const bool is_simplex = n_vertices == dim + 1;
    for (unsigned int v = 0; v < n_vertices; ++v) {
      Tensor<2, dim> J; // its columns are the edges at this corner
      for (unsigned int d = 0; d < dim; ++d) {
        const unsigned int other = is_simplex ? (v + 1 + d) % n_vertices : v ^ (1u << d);
        const auto column = edge(nodes[v], nodes[other]);
        for (unsigned int i = 0; i < dim; ++i)
          J[i][d] = column[i];
        for (unsigned int e = 0; e < d; ++e) {
          Tensor<1, dim> before;
          for (unsigned int i = 0; i < dim; ++i)
            before[i] = J[i][e];
          const double cosine = before * column / (before.norm() * column.norm());
          smallest_angle = std::min(smallest_angle, std::acos(std::max(-1., std::min(1., cosine))));
        }
      }
      largest_aspect = std::max(largest_aspect, aspect_of(is_simplex ? J * from_regular_simplex() : J));
    }
  }

  double volume_of_hypercube(const unsigned int *nodes) const
  {
    static const dealii::QGauss<dim> gauss(2);
    double volume = 0;
    for (unsigned int q = 0; q < gauss.size(); ++q) {
      Tensor<2, dim> J;
      for (unsigned int v = 0; v < n_vertices; ++v) {
        const auto gradient = dealii::GeometryInfo<dim>::d_linear_shape_function_gradient(gauss.point(q), v);
        const auto X = edge(nodes[0], nodes[v]);
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            J[i][j] += X[i] * gradient[j];
      }
      volume += gauss.weight(q) * dealii::determinant(J);
    }
    return volume;
  }

  /// Maps the edges of a regular simplex to unit vectors.
  static Tensor<2, dim> from_regular_simplex()
  {
    Tensor<2, dim> edges;
    edges[0][0] = 1;
    edges[0][1] = 0.5;
    edges[1][1] = std::sqrt(3.) / 2;
    if constexpr (dim == 3) {
      edges[0][2] = 0.5;
      edges[1][2] = std::sqrt(3.) / 6;
      edges[2][2] = std::sqrt(2. / 3.);
    }
    return dealii::invert(edges);
  }

  static double aspect_of(const Tensor<2, dim> &J)
  {
    const auto squares = symmetric_eigenvalues(dealii::symmetrize(dealii::transpose(J) * J));
    return squares[dim - 1] > 0 ? std::sqrt(squares[0] / squares[dim - 1])
                                : std::numeric_limits<double>::infinity();
  }

  const MeshFile &mesh;
  const unsigned int n_vertices;
};

/// A face of a cell, its vertices in circular order.
struct FaceOfCell
{
  std::vector<unsigned int> vertices;
  std::size_t cell;
  unsigned int id = 0;
};

template <int dim>
double area_of(const MeshFile &mesh, const FaceOfCell &face)
{
  const bool is_of_simplex = mesh.cells.n_nodes(face.cell) == dim + 1;
  if (is_of_simplex || (dim == 2 && mesh.further_nodes.empty()))
    return CurvedSimplex(mesh, face.cell, face.vertices).measure();
  if (!mesh.further_nodes.empty()) {
    auto vertices = face.vertices;
    if (dim == 3)
      std::swap(vertices[2], vertices[3]);
    return CurvedCube<dim - 1>(mesh, face.cell, vertices).measure();
  }
  const auto X = [&](const unsigned int v) { return mesh.nodes[face.vertices[v]]; };
  return dealii::cross_product_3d(X(2) - X(0), X(3) - X(1)).norm() / 2;
}

/// By id: number of faces and their area. Faces that the file does not mark have the id 0.
template <int dim>
std::map<unsigned int, std::pair<std::size_t, double>> boundaries_of(const MeshFile &mesh)
{
  std::map<std::vector<unsigned int>, FaceOfCell> faces; // by their vertices in ascending order
  const unsigned int n = mesh.cells.n_nodes(0);
  const auto sorted = [](std::vector<unsigned int> vertices) {
    std::sort(vertices.begin(), vertices.end());
    return vertices;
  };
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    for (unsigned int f = 0; f < (n == dim + 1 ? dim + 1 : 2 * dim); ++f) {
      std::vector<unsigned int> vertices;
      if (n == dim + 1) {
        for (unsigned int v = 0; v < n; ++v)
          if (v != f)
            vertices.push_back(mesh.cells.nodes_of(c)[v]);
      } else
        for (unsigned int v = 0; v < (1u << (dim - 1)); ++v)
          vertices.push_back(mesh.cells.nodes_of(c)[dealii::GeometryInfo<dim>::face_to_cell_vertices(f, v)]);
      if (vertices.size() == 4)
        std::swap(vertices[2], vertices[3]);
      if (const auto [place, is_new] = faces.emplace(sorted(vertices), FaceOfCell{vertices, c}); !is_new)
        faces.erase(place);
    }
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    if (const auto found =
            faces.find(sorted({mesh.faces.nodes_of(f), mesh.faces.nodes_of(f) + mesh.faces.n_nodes(f)}));
        found != faces.end())
      found->second.id = mesh.faces.ids[f];
  std::map<unsigned int, std::pair<std::size_t, double>> result;
  for (const auto &[key, face] : faces) {
    auto &[n_faces, area] = result[face.id];
    ++n_faces;
    area += area_of<dim>(mesh, face);
  }
  return result;
}

template <int dim>
void print_boundaries(const MeshFile &mesh, std::ostream &out)
{
  for (const auto &[id, measures] : boundaries_of<dim>(mesh)) {
    std::vector<std::string> names, groups; // a face in several groups of the file has an id of its own
    for (const auto &[name, ids] : mesh.boundary_names)
      if (std::find(ids.begin(), ids.end(), id) != ids.end())
        (name.find_first_not_of("0123456789") == std::string::npos ? groups : names).push_back(name);
    out << "  boundary id " << id << (groups.empty() ? "" : ", of the ids " + comma_separated(groups))
        << (names.empty() ? "" : " (" + comma_separated(names) + ")") << ": " << measures.first
        << (measures.first == 1 ? " face" : " faces") << (dim == 2 ? ", length " : ", area ")
        << digits(measures.second) << '\n';
  }
}

/// One volume. Returns whether it can be used.
template <int dim>
bool print_volume(const std::string &title, MeshFile mesh, std::ostream &out)
{
  out << title << ": " << mesh.cells.size() << ' ';
  const unsigned int n_nodes = mesh.cells.n_nodes(0);
  try {
    examine<dim>(mesh);
  } catch (const MeshError &fault) {
    out << "cells, which cannot be used: " << fault.what() << '\n';
    return false;
  }
  const unsigned int n_vertices = mesh.cells.n_nodes(0);
  const Measures<dim> measures(mesh);
  out << (n_vertices == 3   ? "triangles"
          : n_vertices == 8 ? "hexahedra"
          : dim == 2        ? "quadrilaterals"
                            : "tetrahedra")
      << (n_nodes == n_vertices        ? " of first order"
          : mesh.further_nodes.empty() ? " of second order, straight"
                                       : " of second order, curved")
      << (dim == 2 ? ", area " : ", volume ") << digits(measures.volume) << "\n ";
  for (unsigned int d = 0; d < dim; ++d)
    out << (d == 0 ? " " : ", ") << "xyz"[d] << " from " << digits(measures.lowest[d]) << " to "
        << digits(measures.highest[d]);
  out << "\n  smallest angle " << digits(180 / dealii::numbers::PI * measures.smallest_angle)
      << " degrees, largest aspect ratio " << digits(measures.largest_aspect) << '\n';
  print_boundaries<dim>(mesh, out);
  if (!mesh.note.empty())
    out << "  note: " << mesh.note << '\n';
  return true;
}

/// Cells that are in no volume become volumes by their material ids, unless others have these, or are called
/// so, too.
void complete_volumes(MeshFile &mesh)
{
  std::vector<char> is_in_volume(mesh.cells.size(), 0);
  std::set<unsigned int> ids;
  for (const auto &[name, cells] : mesh.volumes)
    for (const std::size_t cell : cells) {
      is_in_volume[cell] = 1;
      ids.insert(mesh.cells.ids[cell]);
    }
  std::string without_name = "of no name";
  while (mesh.volumes.count(without_name) > 0)
    without_name += " at all";
  std::map<std::string, std::vector<std::size_t>> others;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    if (const unsigned int id = mesh.cells.ids[c]; is_in_volume[c] == 0) {
      const bool is_taken = ids.count(id) > 0 || mesh.volumes.count(std::to_string(id)) > 0;
      others[is_taken ? without_name : std::to_string(id)].push_back(c);
    }
  if (!mesh.volumes.empty() || others.size() > 1)
    mesh.volumes.merge(others);
}

/// Volumes with the same cells have one title. @return the titles in their order, each with one of its names
std::map<std::string, std::string> titles_of_volumes(const MeshFile &mesh)
{
  std::map<std::vector<std::size_t>, std::vector<std::string>> names_of;
  for (const auto &[name, cells] : mesh.volumes)
    names_of[cells].push_back(name);
  std::map<std::string, std::string> titles;
  for (const auto &[cells, names] : names_of)
    titles["volume " + comma_separated(names)] = names[0];
  return titles;
}

template <int dim>
bool print_volumes(MeshFile mesh, std::ostream &out)
{
  complete_volumes(mesh);
  const auto titles = titles_of_volumes(mesh);
  if (titles.size() < 2)
    return print_volume<dim>(titles.empty() ? "all cells" : titles.begin()->first, mesh, out);
  bool is_usable = false;
  for (const auto &[title, name] : titles) {
    MeshFile part = mesh;
    select_volumes({name}, part);
    is_usable = print_volume<dim>(title, part, out) || is_usable;
  }
  return is_usable;
}

std::string data_array(const std::string &attributes, const std::string &numbers)
{
  return "<DataArray " + attributes + " format=\"ascii\">\n" + numbers + "</DataArray>\n";
}

/// Of first or second order.
bool is_wedge_or_pyramid(const unsigned int n_nodes)
{
  return n_nodes == 5 || n_nodes == 6 || (n_nodes > 10 && n_nodes != 20 && n_nodes != 27);
}

/// Cells and marked faces by their vertices, with their ids, but wedges and pyramids; VTK's order is that of
/// the file.
void write_preview(const MeshFile &mesh, const unsigned int dim, const std::string &name)
{
  const std::string beginning = "<?xml version=\"1.0\"?>\n<!-- A mesh file as Dovetail reads it -->\n";
  std::ostringstream points, connectivity, offsets, types, materials, boundaries;
  points.precision(16);
  for (const auto &X : mesh.nodes)
    points << X[0] << ' ' << X[1] << ' ' << X[2] << '\n';
  std::size_t offset = 0, n_cells = 0;
  const auto add = [&](const MeshElements &elements, const unsigned int element_dim) {
    for (std::size_t e = 0; e < elements.size(); ++e) {
      const unsigned int n = elements.n_nodes(e);
      if (element_dim == 3 && is_wedge_or_pyramid(n))
        continue;
      ++n_cells;
      const bool is_triangular = n == 3 || n == 6 || n == 10 || (element_dim == 3 && n == 4);
      const unsigned int n_vertices = is_triangular ? element_dim + 1 : 1u << element_dim;
      for (unsigned int v = 0; v < (element_dim == 1 ? 2 : n_vertices); ++v)
        connectivity << elements.nodes_of(e)[v] << ' ';
      connectivity << '\n';
      offset += element_dim == 1 ? 2 : n_vertices;
      offsets << offset << '\n';
      types << (element_dim == 1   ? 3
                : element_dim == 2 ? (is_triangular ? 5 : 9)
                                   : (is_triangular ? 10 : 12))
            << '\n';
      materials << (element_dim == dim ? std::to_string(elements.ids[e]) : "-1") << '\n';
      boundaries << (element_dim == dim ? "-1" : std::to_string(elements.ids[e])) << '\n';
    }
  };
  add(mesh.cells, dim);
  add(mesh.faces, dim - 1);
  const std::string text =
      beginning +
      "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
      std::to_string(mesh.nodes.size()) + "\" NumberOfCells=\"" + std::to_string(n_cells) +
      "\">\n<Points>\n" + data_array("type=\"Float64\" NumberOfComponents=\"3\"", points.str()) +
      "</Points>\n<Cells>\n" + data_array("type=\"Int64\" Name=\"connectivity\"", connectivity.str()) +
      data_array("type=\"Int64\" Name=\"offsets\"", offsets.str()) +
      data_array("type=\"UInt8\" Name=\"types\"", types.str()) + "</Cells>\n<CellData>\n" +
      data_array("type=\"Int64\" Name=\"material_id\"", materials.str()) +
      data_array("type=\"Int64\" Name=\"boundary_id\"", boundaries.str()) +
      "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  if (const Obstacle obstacle = write_file(name, beginning, text))
    obstacle.raise("Start the program in a directory where you may write.");
}

/// Why its cells must be the surfaces of bodies; empty if they may be a plane mesh.
std::string obstacle_to_a_plane(const MeshFile &mesh)
{
  unsigned int low = mesh.cells.nodes[0], high = low;
  double size = 0;
  for (const unsigned int node : mesh.cells.nodes) {
    if (mesh.nodes[node][2] < mesh.nodes[low][2])
      low = node;
    if (mesh.nodes[node][2] > mesh.nodes[high][2])
      high = node;
    size = std::max(size, mesh.nodes[node].distance(mesh.nodes[mesh.cells.nodes[0]]));
  }
  if (mesh.nodes[high][2] - mesh.nodes[low][2] <= 1e-6 * size)
    return "";
  return " Dimension = 2 needs equal z: node " + std::to_string(mesh.node_numbers[high]) +
         " has another z than node " + std::to_string(mesh.node_numbers[low]) + ".";
}

/// Three dimensions if there is a cell of three, else two.
std::pair<MeshFile, unsigned int> read_in_its_dimension(const std::string &file_name)
{
  try {
    return {read_mesh_file(file_name, 3), 3};
  } catch (const MeshError &in_three) {
    MeshFile plane;
    try {
      plane = read_mesh_file(file_name, 2);
    } catch (const MeshError &in_two) {
      const std::string reason = in_two.what();
      throw MeshError(reason.find("three dimensions") == std::string::npos ? reason : in_three.what());
    }
    if (const std::string obstacle = obstacle_to_a_plane(plane); !obstacle.empty())
      throw MeshError(in_three.what() + obstacle);
    return {std::move(plane), 2};
  }
}

} // namespace

void report_on_mesh(const std::string &file_name, std::ostream &out)
{
  if (const std::string obstacle = obstacle_to_reading(file_name); !obstacle.empty())
    throw UserError("The mesh file '" + file_name + "' " + obstacle);
  if (!is_known_mesh_format(file_name))
    throw UserError(
        "The format of the mesh file '" + file_name +
        "' is not known. Use .msh (Gmsh 2.2 or 4.1), .inp (Abaqus or AVS UCD), .vtk or .unv, or one "
        "that meshio converts (.vtu, .exo, .med, .bdf, .xdmf, .mesh, .cgns).");
  try {
    const auto [mesh, dim] = read_in_its_dimension(file_name);
    out << file_name << " (" << mesh.format << "): " << dim << "D, " << mesh.nodes.size() << " nodes\n";
    const bool is_usable = dim == 2 ? print_volumes<2>(mesh, out) : print_volumes<3>(mesh, out);
    const std::string preview = std::filesystem::path(file_name).stem().string() + "_mesh.vtu";
    write_preview(mesh, dim, preview);
    out << "preview: " << preview << std::endl;
    if (!is_usable)
      throw UserError("The mesh file '" + file_name + "' has no volume that can be used; see above.");
  } catch (const MeshError &fault) {
    throw UserError("The mesh file '" + file_name + "' cannot be used: " + fault.what());
  }
}

} // namespace dovetail
