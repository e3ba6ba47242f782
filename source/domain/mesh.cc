// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/mesh.h>
#include <dovetail/domain/simplices.h>

#include <deal.II/base/bounding_box.h>
#include <deal.II/base/mpi.h>
#include <deal.II/base/utilities.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_in.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/grid/manifold.h>

#include <fstream>
#include <iostream>
#include <limits>
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

std::string suffix_of(const std::string &file_name)
{
  const auto dot = file_name.rfind('.');
  return dot == std::string::npos ? "" : file_name.substr(dot);
}

/// Both Abaqus and AVS UCD end in .inp; only Abaqus has keyword lines, which start with '*'.
bool is_abaqus(const std::string &file_name)
{
  std::ifstream file(file_name);
  for (std::string line; std::getline(file, line);) {
    const auto first = line.find_first_not_of(" \t\r");
    if (first != std::string::npos)
      return line[first] == '*';
  }
  return false;
}

/// What deal.II prints before it throws goes nowhere: the exception says enough, once.
class SilentErrors
{
public:
  SilentErrors() : of_terminal(std::cerr.rdbuf(nullptr)) {}
  ~SilentErrors()
  {
    std::cerr.rdbuf(of_terminal);
    std::cerr.clear();
  }

private:
  std::streambuf *of_terminal;
};

template <int dim>
void read_file(const Section &section, const std::string &file_name, dealii::Triangulation<dim> &mesh)
{
  std::ifstream file(file_name);
  section.check(file.good(), "File",
                "names '" + file_name +
                    "', which cannot be read. Relative paths start at the working directory.");
  const SilentErrors silent;
  dealii::GridIn<dim> reader(mesh);
  const std::string suffix = suffix_of(file_name);
  if (suffix == ".msh")
    reader.read_msh(file);
  else if (suffix == ".vtk")
    reader.read_vtk(file);
  else if (suffix == ".unv")
    reader.read_unv(file);
  else if (suffix == ".inp")
    is_abaqus(file_name) ? reader.read_abaqus(file) : reader.read_ucd(file);
  else
    section.fail("File", "names '" + file_name +
                             "', whose format is not known. Use .msh (Gmsh 2.2 or 4.1), .inp "
                             "(Abaqus or AVS UCD), .vtk or .unv.");
}

/// deal.II's reasons without its banner and stack.
std::string reason(const std::exception &error)
{
  if (const auto *exception = dynamic_cast<const dealii::ExceptionBase *>(&error)) {
    std::ostringstream text;
    exception->print_info(text);
    std::string words;
    for (const char letter : text.str())
      words += (letter == '\n') ? ' ' : letter;
    const auto first = words.find_first_not_of(' ');
    const auto last = words.find_last_not_of(' ');
    return first == std::string::npos ? exception->get_exc_name() : words.substr(first, last - first + 1);
  }
  return error.what();
}

/// deal.II's reason why a generator fails, in words of the scene. It shows the arguments it expects as a
/// pattern
/// "[Tuple of <4> elements <...".
[[noreturn]] void fail_generator(const Section &section, const std::string &generator,
                                 const std::string &arguments, const std::string &reason)
{
  const std::string help = " See the function of this name in deal.II's GridGenerator.";
  if (reason.find("not implemented") != std::string::npos) {
    const std::string guess = did_you_mean(generator, {"hyper_cube",
                                                       "subdivided_hyper_cube",
                                                       "hyper_rectangle",
                                                       "subdivided_hyper_rectangle",
                                                       "hyper_ball",
                                                       "hyper_ball_balanced",
                                                       "quarter_hyper_ball",
                                                       "half_hyper_ball",
                                                       "hyper_shell",
                                                       "quarter_hyper_shell",
                                                       "half_hyper_shell",
                                                       "cylinder",
                                                       "subdivided_cylinder",
                                                       "cylinder_shell",
                                                       "truncated_cone",
                                                       "hyper_L",
                                                       "hyper_cube_with_cylindrical_hole",
                                                       "plate_with_a_hole",
                                                       "channel_with_cylinder",
                                                       "parallelogram",
                                                       "cheese",
                                                       "simplex",
                                                       "torus",
                                                       "concentric_hyper_shells",
                                                       "general_cell",
                                                       "enclosed_hyper_cube",
                                                       "cross"});
    section.fail("Generator",
                 "names '" + generator + "', which deal.II does not have in this dimension" +
                     (guess.empty() ? ": see GridGenerator in its documentation." : ". " + guess));
  }
  const std::string begin = "[Tuple of <";
  if (const auto tuple = reason.find(begin); tuple != std::string::npos) {
    const auto first = tuple + begin.size();
    section.fail("Arguments", "are '" + arguments + "', which do not fit the generator " + generator +
                                  ": it takes " + reason.substr(first, reason.find('>', first) - first) +
                                  " arguments separated by ':', lists by ','." + help);
  }
  section.fail("Generator", "could not be used to make the mesh: " + reason + help);
}

template <int dim>
void make_coarse_mesh(const Section &section, dealii::Triangulation<dim> &mesh)
{
  const auto file_name = section.read<std::string>(
      "File", "", "The file of the mesh: .msh (Gmsh 2.2 or 4.1), .inp (Abaqus or AVS UCD), .vtk or .unv [-]");
  const auto generator = section.read<std::string>(
      "Generator", "", "Instead of a file: the name of one of deal.II's functions in GridGenerator [-]");
  const auto arguments = section.read<std::string>(
      "Arguments", "",
      "The generator's arguments, separated by ':', lists by ',', as in deal.II's documentation [-]");
  if (section.documenting())
    return;

  section.check(file_name.empty() || generator.empty(), "File",
                "and Generator exclude each other: give one.");
  section.check(!file_name.empty() || !generator.empty(), "",
                "a mesh needs either File or Generator (with Arguments).");
  const std::string source = file_name.empty() ? "Generator" : "File";
  try {
    if (file_name.empty())
      dealii::GridGenerator::generate_from_name_and_arguments(mesh, generator, arguments);
    else
      read_file(section, file_name, mesh);
  } catch (const UserError &) {
    throw;
  } catch (const std::exception &error) {
    if (file_name.empty())
      fail_generator(section, generator, arguments, reason(error));
    const std::string suffix = suffix_of(file_name);
    section.fail("File", "could not be used to make the mesh: " + reason(error) +
                             (suffix == ".inp" || suffix == ".unv"
                                  ? " In " + suffix +
                                        " files only quadrilaterals and hexahedra are understood; "
                                        "give triangles and tetrahedra as .msh or .vtk."
                                  : ""));
  }
  section.check(mesh.n_active_cells() > 0, source, "gives a mesh without cells.");
  const std::string shapes =
      dim == 2 ? "triangles or nothing but quadrilaterals" : "tetrahedra or nothing but hexahedra";
  section.check(mesh.all_reference_cells_are_hyper_cube() || mesh.all_reference_cells_are_simplex(), source,
                "gives a mesh of " +
                    std::string(dim == 2 ? "triangles and quadrilaterals"
                                         : "several cell shapes, or of wedges or pyramids") +
                    ". All cells must have one shape: mesh the body with nothing but " + shapes +
                    ", or make a domain of each part and tie them by an interface.");
}

/// A distributed mesh together with the coarse mesh it came from: some of deal.II's manifolds refer to it.
template <int dim>
class MeshWithOrigin : public dealii::parallel::distributed::Triangulation<dim>
{
public:
  using dealii::parallel::distributed::Triangulation<dim>::Triangulation;
  dealii::Triangulation<dim> origin;
};

template <int dim>
void transform(const double scale, const dealii::Tensor<1, dim> &shift, dealii::Triangulation<dim> &mesh)
{
  if (scale == 1. && shift.norm() == 0.)
    return;
  dealii::GridTools::transform(
      [&](const dealii::Point<dim> &X) { return dealii::Point<dim>(scale * X + shift); }, mesh);
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
             "Cells with their centre in one of these boxes, smallest : largest coordinates in the final "
             "position, are divided further; for instance 0; 0 : 1; 0.5, 2; 0 : 3; 0.5 [m]"))
      boxes.push_back(read_box(text));
    const auto ids = section.read<std::vector<unsigned int>>(
        "Refine at boundary ids", {}, "Cells with a face on these parts of the boundary, too [-]");
    boundary_ids.insert(ids.begin(), ids.end());
    n_refinements = section.read<unsigned int>(
        "Local refinements", 1, "How often the cells of these boxes and boundaries are divided [-]",
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
      for (const auto &cell : mesh.active_cell_iterators())
        if (cell->is_locally_owned()) {
          bool is_marked = is_at_boundary(cell);
          for (unsigned int b = 0; b < boxes.size(); ++b)
            if (boxes[b].point_inside(cell->center())) {
              ++n_in_box[b];
              is_marked = true;
            }
          if (is_marked)
            cell->set_refine_flag();
        }
      dealii::Utilities::MPI::sum(n_in_box, communicator, n_in_box);
      for (unsigned int b = 0; b < boxes.size(); ++b)
        section.check(
            n_in_box[b] > 0 || level > 0, "Refine boxes",
            "contains a box, number " + std::to_string(b + 1) +
                ", in which no cell has its centre. Boxes are in the final coordinates, after Scale "
                "and Shift.");
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

} // namespace

template <int dim>
std::unique_ptr<Mesh<dim>> make_mesh(const Section &section, const MPI_Comm &communicator)
{
  auto mesh = std::make_unique<MeshWithOrigin<dim>>(communicator);
  make_coarse_mesh(section, mesh->origin);
  const bool converts =
      section.choose(
          "Cells", {"as they are", "simplices"}, 0,
          "simplices: divide quadrilaterals into triangles, hexahedra into tetrahedra, after Refinements "
          "[-]") == 1;
  const auto n_refinements = section.read<unsigned int>(
      "Refinements", 0, "How often every cell is divided into 2^d [-]", Patterns::Integer(0, 20));
  const LocalRefinement<dim> local_refinement(section);
  const auto scale =
      section.read<double>("Scale", 1, "All lengths of the mesh are multiplied by this, before Shift [-]",
                           Patterns::Double(1e-300));
  const dealii::Point<3> shift =
      section.read_point("Shift", dealii::Point<3>(), "Added to all points of the mesh, after Scale [m]");

  if (section.documenting())
    return mesh;

  dealii::Tensor<1, dim> shift_in_dim;
  for (unsigned int d = 0; d < dim; ++d)
    shift_in_dim[d] = shift[d];
  dealii::Triangulation<dim> coarse_mesh;
  coarse_mesh.copy_triangulation(mesh->origin);
  transform(scale, shift_in_dim, coarse_mesh);
  if (local_refinement.is_asked_for())
    local_refinement.check(coarse_mesh, converts);
  if (converts || coarse_mesh.all_reference_cells_are_simplex()) {
    make_simplices(n_refinements, coarse_mesh);
    return distribute(coarse_mesh, communicator);
  }
  mesh->copy_triangulation(coarse_mesh);
  if (is_straight(mesh->origin))
    mesh->origin.clear();
  mesh->refine_global(n_refinements);
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
