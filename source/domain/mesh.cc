// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_order.h>
#include <dovetail/domain/curved_cells.h>
#include <dovetail/domain/curved_cube.h>
#include <dovetail/domain/generator.h>
#include <dovetail/domain/mesh.h>
#include <dovetail/domain/mesh_examination.h>
#include <dovetail/domain/mesh_file.h>
#include <dovetail/domain/mesh_note.h>
#include <dovetail/domain/mesh_size.h>
#include <dovetail/domain/simplices.h>

#include "uniform_mesh.h"

#include <deal.II/base/bounding_box.h>
#include <deal.II/base/mpi.h>
#include <deal.II/base/utilities.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/grid/manifold.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

namespace dovetail {

namespace {

/// The image of a manifold under X -> scale X + shift.
template <int dim>
class TransformedManifold : public dealii::Manifold<dim>
{
public:
  TransformedManifold(const dealii::Manifold<dim> &base, const double scale,
                      const dealii::Tensor<1, dim> &shift)
      : base(base.clone()), scale(scale), shift(shift)
  {
  }

  std::unique_ptr<dealii::Manifold<dim>> clone() const override
  {
    return std::make_unique<TransformedManifold>(*base, scale, shift);
  }

  dealii::Point<dim> get_new_point(const dealii::ArrayView<const dealii::Point<dim>> &surrounding,
                                   const dealii::ArrayView<const double> &weights) const override
  {
    std::vector<dealii::Point<dim>> original(surrounding.begin(), surrounding.end());
    for (auto &point : original)
      point = dealii::Point<dim>((point - shift) / scale);
    const auto image = base->get_new_point(dealii::make_array_view(original), weights);
    return dealii::Point<dim>(scale * image + shift);
  }

private:
  std::unique_ptr<dealii::Manifold<dim>> base;
  double scale;
  dealii::Tensor<1, dim> shift;
};

/// The first rank reads the file and examines what it holds; all get it, or the same error.
template <int dim>
MeshFile read_on_one_rank(const Section &section, const std::string &file_name,
                          const std::vector<std::string> &volumes, const MPI_Comm &communicator)
{
  MeshFile content;
  std::string entry = "File", problem;
  if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0) {
    std::error_code error;
    if (!std::filesystem::exists(file_name, error))
      problem =
          "', which cannot be read. A relative path starts beside the scene or in the working directory.";
    else
      try {
        content = read_mesh_file(file_name, dim);
        entry = "Volume";
        if (!volumes.empty())
          select_volumes(volumes, content);
        entry = "File";
        examine<dim>(content);
        sort_scattered_cells<dim>(content);
      } catch (const MeshError &fault) {
        problem = entry == "File" ? std::string("', which cannot be used: ") + fault.what() : fault.what();
      } catch (const std::bad_alloc &) {
        problem = "', which does not fit into the memory.";
      }
  }
  entry = dealii::Utilities::MPI::broadcast(communicator, entry);
  problem = dealii::Utilities::MPI::broadcast(communicator, problem);
  section.check(problem.empty(), entry, (entry == "File" ? "names '" + file_name : "") + problem);
  return dealii::Utilities::MPI::n_mpi_processes(communicator) == 1
             ? content // else it would be packed and unpacked
             : dealii::Utilities::MPI::broadcast(communicator, content);
}

/// "1 : flank, 3 : bore" names boundary ids; a name may stand for several.
BoundaryNames read_names_of_boundaries(const Section &section)
{
  BoundaryNames names;
  for (const std::string &text :
       section.read<std::vector<std::string>>("Boundary names", {},
                                              "Names for boundary ids, for instance 1 : flank, 3 : bore; "
                                              "names of a file are known without it [-]")) {
    const auto parts = dealii::Utilities::split_string_list(text, ':');
    const bool is_good = parts.size() == 2 && Patterns::Integer(0).match(parts[0]) && !parts[1].empty();
    section.check(is_good, "Boundary names",
                  "has '" + text +
                      "', but must be a list of 'boundary id : name', for instance 1 : flank, 3 : "
                      "bore.");
    if (is_good)
      names[parts[1]].push_back(std::stoul(parts[0]));
  }
  return names;
}

template <int structdim>
std::vector<dealii::CellData<structdim>> cell_data(const MeshElements &elements)
{
  std::vector<dealii::CellData<structdim>> data;
  data.reserve(elements.size());
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const unsigned int n = elements.n_nodes(i);
    data.emplace_back(n);
    std::copy_n(elements.nodes_of(i), n, data.back().vertices.begin());
  }
  return data;
}

template <int dim>
dealii::Point<dim> in_dim(const dealii::Point<3> &X)
{
  dealii::Point<dim> result;
  for (unsigned int d = 0; d < dim; ++d)
    result[d] = X[d];
  return result;
}

/// @p cells: those of the file, quadrilaterals and hexahedra perhaps turned.
template <int dim>
FurtherNodes<dim> further_nodes_of_cells(const MeshFile &content,
                                         const std::vector<dealii::CellData<dim>> &cells)
{
  constexpr unsigned int n_edges = dim * (dim + 1) / 2; // of a simplex
  const auto begin = content.further_nodes.begin();
  FurtherNodes<dim> result(content.further_nodes.empty() ? 0 : cells.size());
  for (std::size_t c = 0; c < result.size(); ++c) {
    const auto nodes = cells[c].vertices.size() == dim + 1
                           ? std::vector<dealii::Point<3>>(begin + c * n_edges, begin + (c + 1) * n_edges)
                           : further_nodes_of<dim>(content, c, cells[c].vertices);
    for (const auto &node : nodes)
      result[c].push_back(in_dim<dim>(node));
  }
  return result;
}

/// Whether all cells run along the edges that they share in the same direction, as deal.II wants them.
template <int dim>
bool are_consistent(const std::vector<dealii::CellData<dim>> &cells)
{
  constexpr unsigned int n_edges = dealii::GeometryInfo<dim>::lines_per_cell;
  std::array<std::array<unsigned int, 2>, n_edges> ends;
  for (unsigned int e = 0; e < n_edges; ++e)
    for (const unsigned int i : {0, 1})
      ends[e][i] = dealii::GeometryInfo<dim>::line_to_cell_vertices(e, i);
  std::vector<std::uint64_t> edges; // lower vertex, upper vertex, direction
  edges.reserve(n_edges * cells.size());
  for (const auto &cell : cells)
    for (const auto &[from, to] : ends) {
      const std::uint64_t a = cell.vertices[from], b = cell.vertices[to];
      edges.push_back(std::min(a, b) << 32 | std::max(a, b) << 1 | (a < b ? 1 : 0));
    }
  std::sort(edges.begin(), edges.end());
  return std::adjacent_find(edges.begin(), edges.end(), [](const auto one, const auto next) {
           return one != next && one >> 1 == next >> 1;
         }) == edges.end();
}

template <int dim>
void read_file(const Section &section, const std::string &file_name, const std::vector<std::string> &volumes,
               const MPI_Comm &communicator, dealii::Triangulation<dim> &mesh,
               FurtherNodes<dim> &further_nodes, std::string &note)
{
  section.check(is_known_mesh_format(file_name), "File",
                "names '" + file_name +
                    "', whose format is not known. Use .msh (Gmsh 2.2 or 4.1), .inp "
                    "(Abaqus or AVS UCD), .vtk or .unv, or one that meshio converts (.vtu, .exo, .med, .bdf, "
                    ".xdmf, .mesh, .cgns).");
  const MeshFile content = read_on_one_rank<dim>(section, file_name, volumes, communicator);
  section.name_boundaries(content.boundary_names);
  note = content.note;
  std::vector<dealii::Point<dim>> vertices;
  vertices.reserve(content.nodes.size());
  for (const auto &node : content.nodes)
    vertices.push_back(in_dim<dim>(node));
  auto cells = cell_data<dim>(content.cells);
  for (std::size_t c = 0; c < cells.size(); ++c)
    cells[c].material_id = content.cells.ids[c];
  auto boundary = cell_data<dim - 1>(content.faces);
  for (std::size_t f = 0; f < boundary.size(); ++f) {
    boundary[f].boundary_id = content.faces.ids[f];
    if (boundary[f].vertices.size() == 4) // in circular order
      std::swap(boundary[f].vertices[2], boundary[f].vertices[3]);
  }
  dealii::SubCellData faces;
  if constexpr (dim == 2)
    faces.boundary_lines = std::move(boundary);
  else
    faces.boundary_quads = std::move(boundary);

  try {
    if (cells[0].vertices.size() == dealii::GeometryInfo<dim>::vertices_per_cell && !are_consistent(cells))
      dealii::GridTools::consistently_order_cells(cells);
    further_nodes = further_nodes_of_cells<dim>(content, cells);
    dealii::GridTools::delete_unused_vertices(vertices, cells, faces);
    mesh.create_triangulation(vertices, cells, faces);
  } catch (const dealii::ExceptionBase &) { // on all ranks alike
    section.fail("File", "names '" + file_name +
                             "', a mesh that deal.II does not take. Make it anew, with another algorithm.");
  }
}

/// A file or a generator; the latter's arguments tell how large its mesh will be.
template <int dim>
void make_coarse_mesh(const Section &section, const MPI_Comm &communicator, dealii::Triangulation<dim> &mesh,
                      FurtherNodes<dim> &further_nodes, std::string &note)
{
  const auto file_name = section.read_file_name(
      "File",
      "The file of the mesh: .msh (Gmsh 2.2 or 4.1), .inp (Abaqus or AVS UCD), .vtk or .unv; others are "
      "converted by the Python module meshio, if it is installed [-]");
  const auto volumes = section.read<std::vector<std::string>>(
      "Volume", {},
      "The cells of the file that make this body: names of volumes (Gmsh: physical groups; Abaqus: sets of "
      "elements, instances, parts, materials) or material ids; empty: all cells [-]");
  const auto generator = section.read<std::string>(
      "Generator", "", "Instead of a file: the name of a function in deal.II's GridGenerator [-]");
  const auto arguments =
      section.read<std::string>("Arguments", "",
                                "The generator's arguments in the order of deal.II's documentation, "
                                "separated by ':'; elements of a list are separated by ',' [-]");
  if (section.documenting())
    return;

  section.check(file_name.empty() || generator.empty(), "File",
                "and Generator exclude each other: give one.");
  section.check(!file_name.empty() || !generator.empty(), "",
                "a mesh needs either File or Generator (with Arguments).");
  section.check(volumes.empty() || !file_name.empty(), "Volume", "needs a File: a generator makes one body.");
  if (file_name.empty()) {
    const MeshGenerator<dim> mesh_generator(section, generator, arguments);
    const double n_ranks = dealii::Utilities::MPI::n_mpi_processes(communicator);
    check_cells<dim>(section, "Arguments", mesh_generator.n_cells(), n_ranks, communicator);
    mesh_generator.make(mesh);
    section.check(mesh.n_active_cells() > 0, "Generator", "gives a mesh without cells.");
  } else
    read_file(section, file_name, volumes, communicator, mesh, further_nodes, note);
}

/// A mesh together with the coarse mesh it came from: some of deal.II's manifolds refer to it.
template <int dim, typename Base>
class MeshWithOrigin : public Base, public WithCurvedCells<dim>, public WithNote
{
public:
  using Base::Base;
  std::unique_ptr<dealii::Triangulation<dim>> origin; ///< nullptr if the mesh is straight
};

template <int dim>
void transform(const double scale, const dealii::Tensor<1, dim> &shift, const bool is_flat,
               dealii::Triangulation<dim> &mesh)
{
  if (scale == 1. && shift.norm() == 0.)
    return;
  dealii::GridTools::transform(
      [&](const dealii::Point<dim> &X) { return dealii::Point<dim>(scale * X + shift); }, mesh);
  if (is_flat)
    return;
  for (const auto id : mesh.get_manifold_ids())
    if (id != dealii::numbers::flat_manifold_id) {
      const TransformedManifold<dim> image(mesh.get_manifold(id), scale, shift);
      mesh.set_manifold(id, image);
    }
}

/// Which cells are divided once more: those in boxes and those at parts of the boundary.
template <int dim>
class LocalRefinement
{
public:
  explicit LocalRefinement(const Section &section) : section(section)
  {
    for (const std::string &text : section.read<std::vector<std::string>>(
             "Refine boxes", {},
             "Cells with their centre in one of these boxes are refined further; a box has the form smallest "
             ": largest coordinates in the final position, for instance 0; 0 : 1; 0.5, 2; 0 : 3; 0.5 [m]"))
      boxes.push_back(read_box(text));
    const auto ids = section.read_boundary_ids(
        "Refine at boundary ids", "Cells with a face on these boundary ids are refined further, too [-]");
    boundary_ids.insert(ids.begin(), ids.end());
    n_refinements = section.read<unsigned int>(
        "Local refinements", 1, "Number of further refinements in these boxes and at these boundary ids [-]",
        Patterns::Integer(0, 20));
  }

  bool is_asked_for() const { return !boxes.empty() || !boundary_ids.empty(); }

  void check(const dealii::Triangulation<dim> &coarse_mesh, const bool becomes_simplices) const
  {
    section.check(!becomes_simplices && coarse_mesh.all_reference_cells_are_hyper_cube(),
                  boxes.empty() ? "Refine at boundary ids" : "Refine boxes",
                  "cannot be used: triangles and tetrahedra are not refined locally. Remove it, or make a "
                  "mesh that is finer there.");
    const auto known = coarse_mesh.get_boundary_ids();
    std::vector<std::string> names;
    for (const auto id : known)
      names.push_back(std::to_string(id));
    for (const auto id : boundary_ids)
      section.check(std::find(known.begin(), known.end(), id) != known.end(), "Refine at boundary ids",
                    "has " + std::to_string(id) + ", which the mesh does not have. It has " +
                        comma_separated(names) + ".");
  }

  void refine(Mesh<dim> &mesh, const MPI_Comm &communicator) const
  {
    for (unsigned int level = 0; level < n_refinements; ++level) {
      std::vector<unsigned int> n_in_box(boxes.size(), 0);
      double n_marked = 0;
      for (const auto &cell : mesh.active_cell_iterators())
        if (cell->is_locally_owned()) {
          bool is_marked = is_at_boundary(cell);
          for (unsigned int b = 0; b < boxes.size(); ++b)
            if (boxes[b].point_inside(cell->center())) {
              ++n_in_box[b];
              is_marked = true;
            }
          if (is_marked) {
            cell->set_refine_flag();
            ++n_marked;
          }
        }
      dealii::Utilities::MPI::sum(n_in_box, communicator, n_in_box);
      for (unsigned int b = 0; b < boxes.size(); ++b)
        section.check(
            n_in_box[b] > 0 || level > 0, "Refine boxes",
            "contains a box, number " + std::to_string(b + 1) +
                ", in which no cell has its centre. Boxes are in the final coordinates, after Scale "
                "and Shift.");
      n_marked = dealii::Utilities::MPI::sum(n_marked, communicator);
      check_cells<dim>(section, "Local refinements",
                       mesh.n_global_active_cells() + n_marked * (std::pow(2., dim) - 1), 1, communicator);
      mesh.execute_coarsening_and_refinement();
    }
  }

private:
  dealii::BoundingBox<dim> read_box(const std::string &text) const
  {
    const auto corners = dealii::Utilities::split_string_list(text, ':');
    section.check(corners.size() == 2, "Refine boxes",
                  "has the box '" + text + "', but a box is two corners: 'smallest : largest'.");
    std::array<dealii::Point<dim>, 2> points;
    for (unsigned int corner = 0; corner < 2; ++corner) {
      const auto coordinates = dealii::Utilities::split_string_list(corners[corner], ';');
      section.check(coordinates.size() == dim, "Refine boxes",
                    "has the corner '" + corners[corner] + "', but needs " + std::to_string(dim) +
                        " numbers separated by ';'.");
      for (unsigned int d = 0; d < dim; ++d) {
        section.check(Patterns::Double().match(coordinates[d]), "Refine boxes",
                      "has '" + coordinates[d] + "', which is not a number.");
        points[corner][d] = dealii::Utilities::string_to_double(coordinates[d]);
      }
    }
    for (unsigned int d = 0; d < dim; ++d)
      section.check(points[0][d] <= points[1][d], "Refine boxes",
                    "has the box '" + text + "', whose first corner is larger than its second one in " +
                        std::string(1, "xyz"[d]) + ". Write 'smallest : largest'.");
    return dealii::BoundingBox<dim>(std::make_pair(points[0], points[1]));
  }

  bool is_at_boundary(const typename dealii::Triangulation<dim>::active_cell_iterator &cell) const
  {
    for (const unsigned int face : cell->face_indices())
      if (cell->face(face)->at_boundary() && boundary_ids.count(cell->face(face)->boundary_id()) > 0)
        return true;
    return false;
  }

  const Section section;
  std::vector<dealii::BoundingBox<dim>> boxes;
  std::set<dealii::types::boundary_id> boundary_ids;
  unsigned int n_refinements;
};

/// Those of FE_Q(2), cell by cell.
template <int dim>
FurtherNodes<dim> all_nodes(const dealii::Triangulation<dim> &coarse_mesh,
                            const FurtherNodes<dim> &further_nodes)
{
  FurtherNodes<dim> nodes(further_nodes.size());
  for (const auto &cell : coarse_mesh.active_cell_iterators()) {
    auto &of_cell = nodes[cell->index()];
    for (const unsigned int v : cell->vertex_indices())
      of_cell.push_back(cell->vertex(v));
    const auto &further = further_nodes[cell->index()];
    of_cell.insert(of_cell.end(), further.begin(), further.end());
  }
  return nodes;
}

/// Whether a scene asks for meshes that follow the estimated error, as AdaptiveCycles and Probes read them.
bool has_adaptive_meshes(const Section &scene)
{
  const std::string cycles = scene.peek("Adaptive cycles");
  if (!cycles.empty() && cycles != "0")
    return true;
  const auto probes = dealii::Utilities::split_string_list(scene.peek("Probes"));
  return std::any_of(probes.begin(), probes.end(), [&](const std::string &probe) {
    return !scene.peek("Probe " + probe, "Tolerance").empty();
  });
}

/// @p coarse_mesh, in the final position, in a mesh that is refined as the scene asks.
template <int dim, typename Base>
std::unique_ptr<Mesh<dim>> refined(std::unique_ptr<dealii::Triangulation<dim>> origin,
                                   const dealii::Triangulation<dim> &coarse_mesh,
                                   const FurtherNodes<dim> &further_nodes, const std::string &note,
                                   const unsigned int n_refinements, const MPI_Comm &communicator)
{
  auto mesh = std::make_unique<MeshWithOrigin<dim, Base>>(communicator);
  mesh->note = note;
  mesh->copy_triangulation(coarse_mesh);
  if (!further_nodes.empty())
    mesh->curve(all_nodes(coarse_mesh, further_nodes), *mesh);
  mesh->origin = std::move(origin);
  mesh->refine_global(n_refinements);
  return mesh;
}

} // namespace

template <int dim>
std::unique_ptr<Mesh<dim>> make_mesh(const Section &section, const MPI_Comm &communicator)
{
  auto origin = std::make_unique<dealii::Triangulation<dim>>();
  FurtherNodes<dim> further_nodes;
  std::string note;
  make_coarse_mesh(section, communicator, *origin, further_nodes, note);
  section.name_boundaries(read_names_of_boundaries(section));
  const bool converts = section.choose("Cells", {"as they are", "simplices"}, 0,
                                       "simplices: divide quadrilaterals into triangles and hexahedra into "
                                       "tetrahedra, after Refinements [-]") == 1;
  const auto n_refinements = section.read<unsigned int>(
      "Refinements", 0, "Number of refinements; each refinement divides every cell into 2^d cells [-]",
      Patterns::Integer(0, 20));
  const LocalRefinement<dim> local_refinement(section);
  const auto scale = section.read<double>(
      "Scale", 1, "Factor for all lengths of the mesh, applied before Shift [-]", Patterns::Double(1e-300));
  const dealii::Point<3> shift = section.read_point(
      "Shift", dealii::Point<3>(), "Vector that is added to all points of the mesh, after Scale [m]");

  if (section.documenting())
    return std::make_unique<UniformMesh<dim>>(communicator);

  const dealii::Tensor<1, dim> shift_in_dim = in_dim<dim>(shift);
  dealii::Triangulation<dim> coarse_mesh;
  coarse_mesh.copy_triangulation(*origin);
  const bool is_flat = !section.peek("File").empty() || is_straight(*origin); // files name no manifolds
  transform(scale, shift_in_dim, is_flat, coarse_mesh);
  if (is_flat)
    origin.reset();
  for (auto &cell_nodes : further_nodes)
    for (dealii::Point<dim> &node : cell_nodes)
      node = dealii::Point<dim>(scale * node + shift_in_dim);
  if (local_refinement.is_asked_for())
    local_refinement.check(coarse_mesh, converts);
  section.check(!converts || further_nodes.empty() || coarse_mesh.all_reference_cells_are_simplex(), "Cells",
                std::string("is simplices, but the mesh has curved ") +
                    (dim == 2 ? "quadrilaterals" : "hexahedra") +
                    ", which are not divided. Remove it, or make a mesh of " +
                    (dim == 2 ? "triangles" : "tetrahedra") + " of second order.");
  const bool becomes_simplices = converts || coarse_mesh.all_reference_cells_are_simplex();
  const double n_ranks = dealii::Utilities::MPI::n_mpi_processes(communicator);
  const double n_parts = coarse_mesh.all_reference_cells_are_simplex() || !converts ? 1.
                         : dim == 2                                                 ? 8.
                                                                                    : 24.;
  check_cells<dim>(section, "Refinements",
                   coarse_mesh.n_active_cells() * std::pow(2., dim * n_refinements) * n_parts,
                   becomes_simplices ? n_ranks : 1., communicator);
  if (becomes_simplices) {
    const std::vector<bool> is_added = make_simplices(n_refinements, coarse_mesh, further_nodes);
    return distribute(coarse_mesh, further_nodes, is_added, note, communicator);
  }
  const bool divides_single_cells = local_refinement.is_asked_for() || has_adaptive_meshes(section.top());
  const auto refined_by = divides_single_cells
                              ? refined<dim, dealii::parallel::distributed::Triangulation<dim>>
                              : refined<dim, UniformMesh<dim>>;
  auto mesh = refined_by(std::move(origin), coarse_mesh, further_nodes, note, n_refinements, communicator);
  if (local_refinement.is_asked_for())
    local_refinement.refine(*mesh, communicator);
  return mesh;
}

template <int dim>
bool has_simplices(const Mesh<dim> &mesh)
{
  return !mesh.all_reference_cells_are_hyper_cube(); // a rank without cells may hold a dummy hypercube
}

template <int dim>
bool is_straight(const dealii::Triangulation<dim> &mesh)
{
  if (has_curved_cells(mesh))
    return false;
  for (const auto id : mesh.get_manifold_ids())
    if (id != dealii::numbers::flat_manifold_id)
      return false;
  return true;
}

template std::unique_ptr<Mesh<2>> make_mesh<2>(const Section &, const MPI_Comm &);
template std::unique_ptr<Mesh<3>> make_mesh<3>(const Section &, const MPI_Comm &);
template bool has_simplices<2>(const Mesh<2> &);
template bool has_simplices<3>(const Mesh<3> &);
template bool is_straight<2>(const dealii::Triangulation<2> &);
template bool is_straight<3>(const dealii::Triangulation<3> &);

} // namespace dovetail
