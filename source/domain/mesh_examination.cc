// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/curved_cube.h>
#include <dovetail/domain/curved_simplex.h>
#include <dovetail/domain/mesh_examination.h>

#include <deal.II/base/geometry_info.h>
#include <deal.II/base/quadrature_lib.h>

#include <boost/container/small_vector.hpp>
#include <boost/pending/disjoint_sets.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <sstream>

namespace dovetail {

namespace {

/// Of an element of so many dimensions and nodes, of first or second order; 0 if there is none.
unsigned int n_vertices_of_element(const unsigned int dim, const unsigned int n_nodes)
{
  static const std::map<std::pair<unsigned int, unsigned int>, unsigned int> n_vertices = {
      {{1, 2}, 2}, {{1, 3}, 2}, {{2, 3}, 3},  {{2, 6}, 3}, {{2, 4}, 4},  {{2, 8}, 4},
      {{2, 9}, 4}, {{3, 4}, 4}, {{3, 10}, 4}, {{3, 8}, 8}, {{3, 20}, 8}, {{3, 27}, 8}};
  const auto found = n_vertices.find({dim, n_nodes});
  return found == n_vertices.end() ? 0 : found->second;
}

/// In deal.II's order of vertices, seen from outside against the clock (2D: the cell on the left).
const std::map<std::pair<unsigned int, unsigned int>, std::vector<std::vector<unsigned int>>> faces_of_cell =
    {{{2, 3}, {{0, 1}, {1, 2}, {2, 0}}},
     {{2, 4}, {{0, 1}, {1, 3}, {3, 2}, {2, 0}}},
     {{3, 4}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}},
     {{3, 8}, {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}}};

/// Between which vertices the further nodes of cells of second order stand, in Gmsh's order.
const std::map<std::pair<unsigned int, unsigned int>, std::vector<std::vector<unsigned int>>>
    middles_of_cell = {{{2, 3}, {{0, 1}, {1, 2}, {2, 0}}},
                       {{2, 4}, {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 1, 2, 3}}},
                       {{3, 4}, {{0, 1}, {1, 2}, {2, 0}, {3, 0}, {2, 3}, {1, 3}}},
                       {{3, 8},
                        {{0, 1},
                         {0, 3},
                         {0, 4},
                         {1, 2},
                         {1, 5},
                         {2, 3},
                         {2, 6},
                         {3, 7},
                         {4, 5},
                         {4, 7},
                         {5, 6},
                         {6, 7},
                         {0, 1, 2, 3},
                         {0, 1, 5, 4},
                         {0, 4, 7, 3},
                         {1, 2, 6, 5},
                         {2, 3, 7, 6},
                         {4, 5, 6, 7},
                         {0, 1, 2, 3, 4, 5, 6, 7}}}};

/// Of a cell or face; not on the heap.
using Nodes = boost::container::small_vector<unsigned int, 8>;

/// A face of a cell, known by its vertices in ascending order.
struct Face
{
  std::array<unsigned int, 4> sorted;
  std::size_t cell;
  unsigned int number;

  bool operator<(const Face &other) const
  {
    return std::tie(sorted, cell, number) < std::tie(other.sorted, other.cell, other.number);
  }
};

template <std::size_t n = 4>
std::array<unsigned int, n> sort_vertices(const Nodes &vertices)
{
  std::array<unsigned int, n> sorted;
  sorted.fill(std::numeric_limits<unsigned int>::max());
  std::copy(vertices.begin(), vertices.end(), sorted.begin());
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

template <int dim>
class Examination
{
public:
  explicit Examination(MeshFile &mesh) : mesh(mesh) {}

  void run()
  {
    check_shapes();
    if (dim == 2)
      check_plane();
    leave_vertices_only();
    order_as_in_dealii();
    check_different_nodes();
    turn_mirrored_cells();
    collect_further_nodes();
    look_for_turned_parts();
    check_doubled_cells();
    sort_faces();
    check_faces_between_cells();
    choose_faces_of_boundary();
    look_for_cracks();
    look_for_parts();
  }

private:
  // ---- words

  std::string numbers_of(const Nodes &nodes) const
  {
    std::string text;
    for (const unsigned int node : nodes)
      text += (text.empty() ? "" : ", ") + std::to_string(mesh.node_numbers[node]);
    return text;
  }

  std::string place_of(const Nodes &nodes) const
  {
    dealii::Point<3> centre;
    for (const unsigned int node : nodes)
      centre += mesh.nodes[node] / double(nodes.size());
    std::ostringstream text;
    text << "(" << centre[0] << "; " << centre[1];
    if (dim == 3)
      text << "; " << centre[2];
    text << ")";
    return text.str();
  }

  /// As the file names it.
  std::string name_of(const std::size_t cell) const { return std::to_string(mesh.cells.numbers[cell]); }

  /// "element 3 (nodes 1, 2, 6, 5) around (0; 1)", with the nodes as in the file
  std::string words_of(const std::size_t cell) const
  {
    Nodes nodes = vertices_of(cell);
    if (is_ordered && n_vertices > dim + 1)
      for (unsigned int v = 0; v < n_vertices; ++v)
        nodes[v] = mesh.cells.nodes_of(cell)[place[v]];
    return "element " + name_of(cell) + " (nodes " + numbers_of(nodes) + ") around " + place_of(nodes);
  }

  void add_note(const std::string &words) { mesh.note += (mesh.note.empty() ? "" : "; ") + words; }

  std::string words_of_face(const Nodes &vertices) const
  {
    return "the face with the nodes " + numbers_of(vertices) + " around " + place_of(vertices);
  }

  // ---- parts of the mesh

  Nodes vertices_of(const std::size_t cell) const
  {
    const unsigned int *nodes = mesh.cells.nodes_of(cell);
    return Nodes(nodes, nodes + n_vertices);
  }

  std::vector<unsigned int> list_of_vertices(const std::size_t cell) const
  {
    const unsigned int *nodes = mesh.cells.nodes_of(cell);
    return {nodes, nodes + n_vertices};
  }

  Nodes vertices_of_face(const std::size_t cell, const unsigned int number) const
  {
    Nodes vertices;
    for (const unsigned int v : (*faces)[number])
      vertices.push_back(mesh.cells.nodes_of(cell)[v]);
    return vertices;
  }

  // ---- steps

  void check_shapes()
  {
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
      if (n_vertices_of_element(dim, mesh.cells.n_nodes(c)) == 0)
        throw MeshError(
            "the element " + name_of(c) +
            " is a wedge or a pyramid. All cells of a domain must be tetrahedra, or all hexahedra: "
            "mesh the body so, or, if another volume is meant, choose it by Volume.");
    n_vertices = n_vertices_of_element(dim, mesh.cells.n_nodes(0));
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
      if (n_vertices_of_element(dim, mesh.cells.n_nodes(c)) != n_vertices)
        throw MeshError(
            std::string("it has ") +
            (dim == 2 ? "triangles and quadrilaterals" : "tetrahedra and hexahedra") + " (elements " +
            name_of(0) + " and " + name_of(c) +
            "). All cells must have one shape: mesh the body with nothing but " +
            (dim == 2 ? "triangles or nothing but quadrilaterals" : "tetrahedra or nothing but hexahedra") +
            ", or make a domain of each part and tie them by an interface.");
    faces = &faces_of_cell.at({dim, n_vertices});
  }

  /// All cells have the same z.
  void check_plane() const
  {
    const double z = mesh.nodes[mesh.cells.nodes[0]][2];
    double size = 0;
    for (const unsigned int node : mesh.cells.nodes)
      size = std::max(size, (mesh.nodes[node] - mesh.nodes[mesh.cells.nodes[0]]).norm());
    for (const unsigned int node : mesh.cells.nodes)
      if (std::abs(mesh.nodes[node][2] - z) > 1e-6 * size)
        throw MeshError("it does not lie in a plane of equal z, as Dimension = 2 needs: node " +
                        std::to_string(mesh.node_numbers[node]) + " has another z than node " +
                        std::to_string(mesh.node_numbers[mesh.cells.nodes[0]]) + ".");
  }

  /// The further nodes of cells of second order stand in the middle of vertices, or the cells are curved.
  void leave_vertices_only()
  {
    if (mesh.cells.nodes.size() == mesh.cells.size() * n_vertices)
      return;
    MeshElements vertices_only;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
      const unsigned int *nodes = mesh.cells.nodes_of(c);
      for (unsigned int i = n_vertices; i < mesh.cells.n_nodes(c); ++i)
        look_at_further_node(nodes, nodes[i], middles_of_cell.at({dim, n_vertices})[i - n_vertices]);
      vertices_only.add(mesh.cells.numbers[c], mesh.cells.ids[c], list_of_vertices(c));
    }
    mesh.cells = std::move(vertices_only);
  }

  void look_at_further_node(const unsigned int *nodes, const unsigned int node,
                            const std::vector<unsigned int> &around)
  {
    dealii::Point<3> middle;
    for (const unsigned int v : around)
      middle += mesh.nodes[nodes[v]] / double(around.size());
    const double length = mesh.nodes[nodes[around[0]]].distance(mesh.nodes[nodes[around[1]]]);
    is_curved = is_curved || middle.distance(mesh.nodes[node]) > 1e-6 * length;
    Nodes vertices;
    for (const unsigned int v : around)
      vertices.push_back(nodes[v]);
    const auto [known, is_new] = node_between.emplace(sort_vertices<8>(vertices), node);
    if (mesh.nodes[known->second].distance(mesh.nodes[node]) > 1e-6 * length)
      throw MeshError((vertices.size() == 2 ? "the edge between the nodes " : "the face with the nodes ") +
                      numbers_of(vertices) + " around " + place_of(vertices) +
                      " has two different nodes on it, " + numbers_of({known->second, node}) +
                      ", so the elements that share it do not fit together.");
  }

  /// As MeshFile wants them. Edges without a node of their own, as elements of first order have, are
  /// straight.
  void collect_further_nodes()
  {
    for (std::size_t c = 0; is_curved && c < mesh.cells.size(); ++c) {
      const auto nodes = n_vertices == dim + 1 ? nodes_of_curved_simplex(vertices_of(c))
                                               : nodes_of_curved_cube<dim>(vertices_of(c));
      mesh.further_nodes.insert(mesh.further_nodes.end(), nodes.begin(), nodes.end());
    }
  }

  /// The node between some vertices; nullptr if the file has none.
  const dealii::Point<3> *find_between(const Nodes &vertices) const
  {
    const auto found = node_between.find(sort_vertices<8>(vertices));
    return found != node_between.end() ? &mesh.nodes[found->second] : nullptr;
  }

  dealii::Point<3> on_edge(const unsigned int a, const unsigned int b) const
  {
    const dealii::Point<3> *const node = find_between({a, b});
    return node != nullptr ? *node : dealii::Point<3>((mesh.nodes[a] + mesh.nodes[b]) / 2);
  }

  std::vector<dealii::Point<3>> nodes_of_curved_simplex(const Nodes &vertices) const
  {
    std::vector<dealii::Point<3>> nodes;
    for (unsigned int i = 0; i < vertices.size(); ++i)
      for (unsigned int j = i + 1; j < vertices.size(); ++j)
        nodes.push_back(on_edge(vertices[i], vertices[j]));
    return nodes;
  }

  /// Without a node of the file in the middle of a face or of the cell: by transfinite interpolation of the
  /// lines and faces (Gordon and Hall, 1973), which is what elements with 8 and 20 nodes are.
  template <int structdim>
  std::vector<dealii::Point<3>> nodes_of_curved_cube(const Nodes &vertices) const
  {
    using Cube = dealii::GeometryInfo<structdim>;
    std::vector<dealii::Point<3>> nodes;
    dealii::Point<3> vertex_sum, line_sum, face_sum;
    for (const unsigned int v : vertices)
      vertex_sum += mesh.nodes[v];
    for (unsigned int l = 0; l < Cube::lines_per_cell; ++l) {
      nodes.push_back(
          on_edge(vertices[Cube::line_to_cell_vertices(l, 0)], vertices[Cube::line_to_cell_vertices(l, 1)]));
      line_sum += nodes.back();
    }
    if constexpr (structdim == 3)
      for (unsigned int f = 0; f < Cube::faces_per_cell; ++f) {
        Nodes face;
        for (unsigned int v = 0; v < Cube::vertices_per_face; ++v)
          face.push_back(vertices[Cube::face_to_cell_vertices(f, v)]);
        nodes.push_back(nodes_of_curved_cube<2>(face).back());
        face_sum += nodes.back();
      }
    const dealii::Point<3> *const middle = find_between(vertices);
    nodes.push_back(middle != nullptr ? *middle
                    : structdim == 2  ? dealii::Point<3>(line_sum / 2 - vertex_sum / 4)
                                      : dealii::Point<3>(face_sum / 2 - line_sum / 4 + vertex_sum / 8));
    return nodes;
  }

  void order_as_in_dealii()
  {
    is_ordered = true;
    if (n_vertices == dim + 1)
      return;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
      const auto in_file = vertices_of(c);
      for (unsigned int v = 0; v < n_vertices; ++v)
        mesh.cells.nodes_of(c)[place[v]] = in_file[v];
    }
  }

  void check_different_nodes() const
  {
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
      auto nodes = vertices_of(c);
      std::sort(nodes.begin(), nodes.end());
      const auto twice = std::adjacent_find(nodes.begin(), nodes.end());
      if (twice != nodes.end())
        throw MeshError(words_of(c) + " has the node " + std::to_string(mesh.node_numbers[*twice]) +
                        " twice. Cells that collapse to another shape are not understood.");
    }
  }

  /// Of the linear shape functions, point by point.
  std::vector<std::vector<dealii::Tensor<1, dim>>> gradients_at_gauss_points() const
  {
    std::vector<std::vector<dealii::Tensor<1, dim>>> gradients;
    if (n_vertices == dim + 1) {
      gradients.emplace_back(n_vertices); // they are constant
      for (unsigned int d = 0; d < dim; ++d) {
        gradients[0][0][d] = -1;
        gradients[0][d + 1][d] = 1;
      }
      return gradients;
    }
    const dealii::QGauss<dim> gauss(2);
    for (const auto &point : gauss.get_points()) {
      gradients.emplace_back();
      for (unsigned int v = 0; v < n_vertices; ++v)
        gradients.back().push_back(dealii::GeometryInfo<dim>::d_linear_shape_function_gradient(point, v));
    }
    return gradients;
  }

  void turn_mirrored_cells()
  {
    const auto gradients = gradients_at_gauss_points();
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
      bool is_positive = false, is_negative = false;
      const Corners corners = corners_of(c);
      for (const auto &gradient : gradients) {
        const double sign = sign_of_jacobian(corners, gradient);
        is_positive = is_positive || sign > 0;
        is_negative = is_negative || sign < 0;
      }
      if (is_positive && is_negative)
        throw MeshError(words_of(c) +
                        " is turned over in one part of it and not in the other: the Jacobian "
                        "changes its sign. Are two of its nodes swapped, or is one out of place?");
      if (!is_positive && !is_negative)
        throw MeshError(words_of(c) + std::string(" is flat, it has no ") + (dim == 2 ? "area." : "volume.") +
                        " Merge nodes that lie together, or make the mesh anew there.");
      if (is_negative)
        turn(mesh.cells.nodes_of(c));
    }
  }

  /// Of a cell.
  struct Corners
  {
    std::array<dealii::Tensor<1, dim>, 8> from_first;
    double largest = 0; ///< coordinate
    double size = 0;    ///< the largest distance from the first one
  };

  Corners corners_of(const std::size_t cell) const
  {
    const unsigned int *nodes = mesh.cells.nodes_of(cell);
    Corners corners;
    for (unsigned int v = 0; v < n_vertices; ++v) {
      for (unsigned int i = 0; i < dim; ++i) {
        corners.from_first[v][i] = mesh.nodes[nodes[v]][i] - mesh.nodes[nodes[0]][i];
        corners.largest = std::max(corners.largest, std::abs(mesh.nodes[nodes[v]][i]));
      }
      corners.size = std::max(corners.size, corners.from_first[v].norm_square());
    }
    corners.size = std::sqrt(corners.size);
    return corners;
  }

  /// Of det dX/dxi; 0 where that is no more than rounding of the coordinates.
  double sign_of_jacobian(const Corners &corners, const std::vector<dealii::Tensor<1, dim>> &gradients) const
  {
    std::array<dealii::Tensor<1, dim>, dim> column;
    for (unsigned int v = 0; v < n_vertices; ++v)
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int j = 0; j < dim; ++j)
          column[j][i] += corners.from_first[v][i] * gradients[v][j];
    double determinant;
    if constexpr (dim == 2)
      determinant = column[0][0] * column[1][1] - column[0][1] * column[1][0];
    else
      determinant = dealii::cross_product_3d(column[0], column[1]) * column[2];
    // the change of the determinant if the coordinates, and its terms, change by their last digit; at most
    // that of columns which are as long as they can be, since the gradients of all vertices sum up to 2
    constexpr double last_digit = 4 * std::numeric_limits<double>::epsilon();
    const double length = 2 * corners.size, area = dim == 2 ? length : length * length;
    if (std::abs(determinant) > last_digit * (area * length + corners.largest * dim * area))
      return determinant;
    double product = 1, cofactors = 0;
    for (unsigned int j = 0; j < dim; ++j) {
      product *= column[j].norm();
      if constexpr (dim == 2)
        cofactors += column[j].norm();
      else
        cofactors += dealii::cross_product_3d(column[j], column[(j + 1) % 3]).norm();
    }
    return std::abs(determinant) > last_digit * (product + corners.largest * cofactors) ? determinant : 0.;
  }

  /// Two vertices change places, or two opposite faces.
  void turn(unsigned int *nodes) const
  {
    if (n_vertices == dim + 1)
      std::swap(nodes[dim - 1], nodes[dim]);
    else if (dim == 2)
      std::swap(nodes[1], nodes[2]);
    else
      for (const unsigned int v : {0, 1, 4, 5})
        std::swap(nodes[v], nodes[v + 2]);
  }

  /// Of a straight quadrilateral or hexahedron. Between its vertices its edges span det dX/dxi.
  bool is_turned_over_at_a_vertex(const unsigned int *nodes) const
  {
    for (unsigned int v = 0; v < n_vertices; ++v) {
      dealii::Tensor<2, dim> edges;
      double product = 1;
      for (unsigned int d = 0; d < dim; ++d) {
        const auto edge = mesh.nodes[nodes[v | (1U << d)]] - mesh.nodes[nodes[v & ~(1U << d)]];
        for (unsigned int i = 0; i < dim; ++i)
          edges[d][i] = edge[i];
        product *= edge.norm();
      }
      if (!(dealii::determinant(edges) > 1e-10 * product))
        return true;
    }
    return false;
  }

  bool is_turned_over_in_a_part(const std::size_t c) const
  {
    const bool is_simplex = n_vertices == dim + 1;
    if (!is_curved)
      return !is_simplex && is_turned_over_at_a_vertex(mesh.cells.nodes_of(c));
    return is_simplex ? CurvedSimplex(mesh, c, list_of_vertices(c)).is_turned_over()
                      : CurvedCube<dim>(mesh, c, list_of_vertices(c)).is_turned_over();
  }

  /// No error: a quadrature rule may not see the part that is turned over.
  void look_for_turned_parts()
  {
    std::vector<std::size_t> turned;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
      if (is_turned_over_in_a_part(c))
        turned.push_back(c);
    if (!turned.empty())
      add_note(std::to_string(turned.size()) + (is_curved ? " curved" : "") +
               (turned.size() == 1 ? " cell is" : " cells are") +
               " turned over in a part (det dX/dxi is not positive there), first " + words_of(turned[0]) +
               ": values near it are doubtful. " +
               (is_curved
                    ? "Make the mesh finer where the boundary is curved, or let the mesh generator mend "
                      "its curved cells (Gmsh: Mesh.HighOrderOptimize = 2)"
                    : "Is one of its nodes out of place? Make the mesh anew there"));
  }

  void check_doubled_cells() const
  {
    std::vector<std::pair<std::array<unsigned int, 8>, std::size_t>> cells;
    cells.reserve(mesh.cells.size());
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
      cells.emplace_back(sort_vertices<8>(vertices_of(c)), c);
    std::sort(cells.begin(), cells.end());
    const auto twice = std::adjacent_find(cells.begin(), cells.end(),
                                          [](const auto &a, const auto &b) { return a.first == b.first; });
    if (twice != cells.end())
      throw MeshError(words_of(twice->second) + " is there twice, also as element " +
                      name_of((twice + 1)->second) +
                      ". Remove one. (Gmsh's version 2 saves an element once for each physical group that it "
                      "is in.)");
  }

  /// First by the smallest vertex, which few faces share.
  void sort_faces()
  {
    std::vector<Face> in_order_of_cells;
    in_order_of_cells.reserve(mesh.cells.size() * faces->size());
    std::vector<std::size_t> begin(mesh.nodes.size() + 1, 0);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
      for (unsigned int f = 0; f < faces->size(); ++f) {
        in_order_of_cells.push_back({sort_vertices(vertices_of_face(c, f)), c, f});
        ++begin[in_order_of_cells.back().sorted[0] + 1];
      }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    all_faces.resize(in_order_of_cells.size());
    auto end = begin;
    for (const Face &face : in_order_of_cells)
      all_faces[end[face.sorted[0]]++] = face;
    for (std::size_t v = 0; v < mesh.nodes.size(); ++v)
      std::sort(all_faces.begin() + begin[v], all_faces.begin() + end[v]);
  }

  void check_faces_between_cells() const
  {
    for (auto face = all_faces.begin(); face != all_faces.end();) {
      auto next = face;
      while (next != all_faces.end() && next->sorted == face->sorted)
        ++next;
      if (next - face > 2)
        throw MeshError(words_of_face(vertices_of_face(face->cell, face->number)) + " belongs to " +
                        std::to_string(next - face) + " elements, among them " + name_of(face[0].cell) +
                        ", " + name_of(face[1].cell) + " and " + name_of(face[2].cell) +
                        ". Two cells can share a face, no more.");
      if (next - face == 2)
        check_two_sides(face[0], face[1]);
      face = next;
    }
  }

  void check_two_sides(const Face &one, const Face &other) const
  {
    const auto a = vertices_of_face(one.cell, one.number);
    auto b = vertices_of_face(other.cell, other.number);
    std::rotate(b.begin(), std::find(b.begin(), b.end(), a[0]), b.end());
    const bool is_same_side = dim == 2 ? vertices_of_face(other.cell, other.number) == a : a == b;
    if (is_same_side)
      throw MeshError("the elements " + name_of(one.cell) + " and " + name_of(other.cell) +
                      " lie on the same side of " + words_of_face(a) +
                      ", so they overlap. A node of one of them is out of place.");
    std::reverse(b.begin() + 1, b.end());
    if (a != b && dim == 3)
      throw MeshError("the elements " + name_of(one.cell) + " and " + name_of(other.cell) +
                      " have the nodes of " + words_of_face(a) +
                      " in another order. Nodes of one of them are swapped.");
  }

  /// The faces of one cell only, with one id each.
  void choose_faces_of_boundary()
  {
    std::map<std::array<unsigned int, 4>, std::size_t> chosen;
    std::vector<std::set<unsigned int>> ids; // of the chosen ones
    MeshElements boundary;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const unsigned int n = n_vertices_of_element(dim - 1, mesh.faces.n_nodes(f));
      const Nodes vertices(mesh.faces.nodes_of(f), mesh.faces.nodes_of(f) + n);
      const Face face = {sort_vertices(vertices), 0, 0};
      const auto found = std::lower_bound(all_faces.begin(), all_faces.end(), face);
      const bool is_of_cell = found != all_faces.end() && found->sorted == face.sorted;
      if (!is_of_cell && !mesh.is_part)
        throw MeshError(
            words_of_face(vertices) + " (element " + std::to_string(mesh.faces.numbers[f]) +
            ") is no face of a cell. The mesh of the boundary does not fit that of the body. If it "
            "is a shell or an inner line, leave it out, or choose the body by Volume.");
      const bool is_inside = is_of_cell && found + 1 != all_faces.end() && (found + 1)->sorted == face.sorted;
      if (!is_of_cell || is_inside)
        continue;
      if (chosen.emplace(face.sorted, boundary.size()).second) {
        ids.emplace_back();
        boundary.add(mesh.faces.numbers[f], 0, {vertices.begin(), vertices.end()});
      }
      if (mesh.faces.ids[f] > 0)
        ids[chosen.at(face.sorted)].insert(mesh.faces.ids[f]);
    }
    mesh.faces = std::move(boundary);
    number_boundaries(ids);
  }

  /// A face with several ids gets a new one, for which all their names, and they themselves, stand as well.
  void number_boundaries(const std::vector<std::set<unsigned int>> &ids)
  {
    std::map<std::set<unsigned int>, unsigned int> together;
    std::map<unsigned int, std::set<unsigned int>> meant; // by an id of the file
    unsigned int largest = 0;
    for (const auto &of_face : ids) {
      if (of_face.size() > 1)
        together.emplace(of_face, 0);
      for (const unsigned int id : of_face)
        largest = std::max(largest, id);
    }
    for (auto &[several, id] : together) {
      if (largest >= std::numeric_limits<int>::max() - together.size())
        throw MeshError("it has faces with several boundary ids and the id " + std::to_string(largest) +
                        ", behind which there is no room for more. Take smaller ids.");
      id = ++largest;
    }
    for (std::size_t f = 0; f < ids.size(); ++f) {
      mesh.faces.ids[f] = ids[f].empty() ? 0 : ids[f].size() == 1 ? *ids[f].begin() : together.at(ids[f]);
      for (const unsigned int id : ids[f])
        meant[id].insert(mesh.faces.ids[f]);
    }
    auto names = std::move(mesh.boundary_names);
    mesh.boundary_names.clear();
    for (const auto &[id, all] : meant)
      if (all != std::set<unsigned int>{id})
        mesh.boundary_names[std::to_string(id)].assign(all.begin(), all.end());
    for (const auto &[name, its_ids] : names) {
      std::set<unsigned int> all;
      for (const unsigned int id : its_ids)
        if (const auto found = meant.find(id); found != meant.end())
          all.insert(found->second.begin(), found->second.end());
      if (!all.empty())
        mesh.boundary_names[name].assign(all.begin(), all.end());
    }
  }

  /// Nodes of the boundary at the same place, up to rounding. They do not belong to one face, so the body is
  /// open between them.
  void look_for_cracks()
  {
    std::vector<unsigned int> nodes;
    for (std::size_t f = 0; f < all_faces.size(); ++f)
      if ((f == 0 || all_faces[f - 1].sorted != all_faces[f].sorted) &&
          (f + 1 == all_faces.size() || all_faces[f + 1].sorted != all_faces[f].sorted))
        for (const unsigned int node : all_faces[f].sorted)
          if (node != std::numeric_limits<unsigned int>::max())
            nodes.push_back(node);
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    double size = 0;
    for (const unsigned int node : nodes)
      size = std::max(size, mesh.nodes[node].distance(mesh.nodes[nodes[0]]));
    std::vector<std::pair<std::array<double, 3>, unsigned int>> places;
    for (const unsigned int node : nodes) {
      places.push_back({{}, node});
      for (unsigned int d = 0; d < dim && size > 0; ++d)
        places.back().first[d] =
            std::nearbyint((mesh.nodes[node][d] - mesh.nodes[nodes[0]][d]) / (1e-9 * size));
    }
    std::sort(places.begin(), places.end());
    unsigned int n = 0, first = 0;
    for (unsigned int i = 1; i < places.size(); ++i)
      if (places[i].first == places[i - 1].first && n++ == 0)
        first = i;
    if (n > 0)
      add_note(std::to_string(n) + (n == 1 ? " node of the mesh stands" : " nodes of the mesh stand") +
               " where another one does, for instance the nodes " +
               numbers_of({places[first - 1].second, places[first].second}) + " at " +
               place_of({places[first].second}) +
               ": the body has a crack there, nothing passes through it. If that is not meant, merge such "
               "nodes (Gmsh: Coherence Mesh)");
  }

  /// Cells that hang together by faces. Where parts touch, nothing passes from one to the other.
  void look_for_parts()
  {
    boost::disjoint_sets_with_storage<> parts(mesh.cells.size());
    for (std::size_t f = 1; f < all_faces.size(); ++f)
      if (all_faces[f - 1].sorted == all_faces[f].sorted)
        parts.union_set(all_faces[f - 1].cell, all_faces[f].cell);
    std::map<std::size_t, std::size_t> first_cells; // of the parts
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
      first_cells.emplace(parts.find_set(c), c);
    if (first_cells.size() > 1)
      add_note("the body falls into " + std::to_string(first_cells.size()) +
               " parts that have no face in common, for instance at " +
               words_of(first_cells.begin()->second) + " and at " +
               words_of(std::next(first_cells.begin())->second) +
               ": nothing passes from one to the other, even where they touch or overlap. If they are to be "
               "one, mesh them together (Gmsh: BooleanFragments), or make a domain of each and tie them");
  }

  /// The vertex of deal.II at which the vertices of a quadrilateral or hexahedron of a file stand.
  static constexpr std::array<unsigned int, 8> place = {
      {0, 1, dim == 3 ? 5 : 3, dim == 3 ? 4 : 2, 2, 3, 7, 6}};

  MeshFile &mesh;
  unsigned int n_vertices = 0;
  bool is_ordered = false; ///< as in deal.II
  bool is_curved = false;
  std::map<std::array<unsigned int, 8>, unsigned int> node_between; ///< some vertices, of second order
  const std::vector<std::vector<unsigned int>> *faces = nullptr;
  std::vector<Face> all_faces;
};

} // namespace

template <int dim>
void examine(MeshFile &mesh)
{
  Examination<dim>(mesh).run();
}

template void examine<2>(MeshFile &);
template void examine<3>(MeshFile &);

} // namespace dovetail
