// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What pictures of a body and of its boundary hold, on cells of all shapes of degree 2 in the unit square or
// cube: how many patches over all ranks, and from where to where each array goes. T = x with k = 3, so q =
// (-3, 0), and 1 <= J = 1 + x/2 <= 3/2. What holds T at x = 0 is -3 in total: by Simpson's rule -1/2, -2 and
// -1/2 at the nodes of the one face in 2D.
//
// ranks: 1 2 3

#include "../measure/given_solution.h"

#include <dovetail/output/domain_picture.h>

using namespace test;

namespace {

template <class Picture>
struct Shown : Picture
{
  using Picture::get_dataset_names;
  using Picture::get_patches;
  using Picture::Picture;
};

template <class Picture>
void print_picture(const std::string &title, const Shown<Picture> &picture)
{
  const std::vector<std::string> names = picture.get_dataset_names();
  std::vector<double> largest(2 * names.size(), -1e300);
  for (const auto &patch : picture.get_patches())
    for (unsigned int i = 0; i < names.size(); ++i)
      for (unsigned int q = 0; q < patch.data.n_cols(); ++q) {
        largest[2 * i] = std::max(largest[2 * i], -double(patch.data(i, q)));
        largest[2 * i + 1] = std::max(largest[2 * i + 1], double(patch.data(i, q)));
      }
  dealii::Utilities::MPI::max(largest, MPI_COMM_WORLD, largest);
  const unsigned int n_patches =
      dealii::Utilities::MPI::sum(static_cast<unsigned int>(picture.get_patches().size()), MPI_COMM_WORLD);
  print(title + ", patches", {double(n_patches)});
  for (unsigned int i = 0; i < names.size(); ++i)
    if (names[i] != "reaction displacement") // not in equilibrium
      print("  " + names[i], {-largest[2 * i], largest[2 * i + 1]});
}

template <int dim>
void show(const std::string &title, const std::string &mesh)
{
  const std::string displacement = dim == 2 ? "x^2/4; 0" : "x^2/4; 0; 0";
  const GivenSolution<dim> given(
      set("Materials", "soft") + set("Domains", "block") +
      subsection("Material soft", subsection("Solid", set("Type", "neo-Hookean") + set("Shear modulus", "2") +
                                                          set("Bulk modulus", "5")) +
                                      subsection("Heat", set("Type", "Fourier") + set("Conductivity", "3"))) +
      subsection(
          "Domain block",
          set("Material", "soft") + set("Degree", "2") + set("Boundary conditions", "held, cold") + mesh +
              subsection("Boundary condition held", set("Type", "value") + set("Field", "displacement") +
                                                        set("Boundary ids", "0") +
                                                        set("Expression", displacement)) +
              subsection("Boundary condition cold", set("Type", "value") + set("Field", "temperature") +
                                                        set("Boundary ids", "0") + set("Expression", "x")) +
              subsection("Exact", set("displacement", displacement) + set("temperature", "x"))));
  const Domain<dim> &domain = *given.model.domains[0];
  const auto make = [&](const std::string &name) {
    auto quantity = QuantityCatalogue<dim>::find(name, given.scene, "").create(name, domain);
    if (quantity->is_of_nodes())
      quantity->set_reactions(*given.reactions);
    return quantity;
  };
  const auto solution = make("solution"), heat_flux = make("heat flux"), J = make("J"),
             id = make("boundary id"), reactions = make("reactions");
  const QuantityList<dim> of_body = {solution.get(), heat_flux.get(), J.get(), reactions.get()},
                          of_boundary = {id.get(), J.get()};
  print_picture(title, Shown<DomainPicture<dim>>(domain, of_body, given.solution, 1.));
  print_picture(title + ", boundary", Shown<BoundaryPicture<dim>>(domain, of_boundary, given.solution, 1.));
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string simplices = set("Cells", "simplices");
  show<2>("quadrilaterals", box("2, 1 : 0, 0 : 1, 1"));
  show<2>("triangles", box("2, 1 : 0, 0 : 1, 1", simplices));
  show<3>("hexahedra", box("2, 1, 1 : 0, 0, 0 : 1, 1, 1"));
  show<3>("tetrahedra", box("1, 1, 1 : 0, 0, 0 : 1, 1, 1", simplices));
}
