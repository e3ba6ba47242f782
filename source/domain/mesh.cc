// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/mesh.h>
#include <dovetail/domain/simplices.h>

#include <deal.II/base/mpi.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_in.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/grid/manifold.h>

#include <fstream>
#include <iostream>
#include <limits>

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
  if (converts || coarse_mesh.all_reference_cells_are_simplex()) {
    make_simplices(n_refinements, coarse_mesh);
    return distribute(coarse_mesh, communicator);
  }
  mesh->copy_triangulation(coarse_mesh);
  if (is_straight(mesh->origin))
    mesh->origin.clear();
  mesh->refine_global(n_refinements);
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
