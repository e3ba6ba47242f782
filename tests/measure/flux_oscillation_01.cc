// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The oscillation of given errors on an interface of unit length or area, by hand. Coarse source, n faces of
// size h = 1/n along each direction on the destination, so the destination counts. The errors of one face:
//
// +1, -1 like a checkerboard   every neighbour differs by 2: o = 1
// a constant                   o = 0
// y                            inside the mean of the neighbours is the face itself; in 2D the two at the
// ends differ
//                              by h from their only neighbour: o^2 = 2 h h^2 / 4; in 3D a face at an end has
//                              three neighbours (at a corner two) of which one differs: 2 h ((1 - 2h) (h/3)^2
//                              + 2h (h/2)^2) / 4
//
// ranks: 1 2 3

#include "../system/scene_model.h"

#include <dovetail/measure/flux_oscillation.h>

using namespace test;

template <int dim>
void check(const unsigned int n)
{
  const std::string many = std::to_string(n), side = dim == 2 ? "" : ", 0", end = dim == 2 ? "" : ", 1";
  const auto cells = [&](const std::string &of_seam) {
    return "1, " + of_seam + (dim == 2 ? "" : ", " + of_seam);
  };
  const SceneModel<dim> scene(
      set("Materials", "heat") + set("Domains", "left, right") + set("Interfaces", "seam") +
      subsection("Material heat", subsection("Heat", set("Type", "Fourier") + set("Conductivity", "1"))) +
      subsection("Domain left", set("Material", "heat") +
                                    box(cells("2") + " : 0, 0" + side + " : 1, 1" + end) +
                                    set("Boundary conditions", "cold") +
                                    subsection("Boundary condition cold",
                                               set("Type", "value") + set("Field", "temperature") +
                                                   set("Boundary ids", "0") + set("Expression", "0"))) +
      subsection("Domain right",
                 set("Material", "heat") + box(cells(many) + " : 1, 0" + side + " : 2, 1" + end)) +
      subsection("Interface seam",
                 set("Type", "Nitsche") + set("Source", "left : 1") + set("Destination", "right : 0")));
  const Interface<dim> &interface = *scene.model.interfaces[0];
  const auto oscillation = [&](const std::function<double(const dealii::Point<dim> &centre)> &error) {
    FluxOscillation<dim> result(interface);
    for (unsigned int q = 0; q < interface.pairing().n_points(); ++q) {
      dealii::Point<dim> centre = interface.pairing().X(destination, q);
      for (unsigned int d = 1; d < dim; ++d)
        centre[d] = (std::floor(centre[d] * n) + 0.5) / n;
      result.add(0, q, {error(centre)});
    }
    return result.evaluate(MPI_COMM_WORLD)[0];
  };
  const double h = 1. / n;
  print(std::to_string(dim) + "D checkerboard", {oscillation([&](const auto &X) {
          double sum = 0;
          for (unsigned int d = 1; d < dim; ++d)
            sum += std::floor(X[d] * n);
          return std::fmod(sum, 2) == 0 ? 1 : -1;
        })});
  print("constant", {oscillation([](const auto &) { return 3; })});
  print("affine / by hand",
        {oscillation([](const auto &X) { return X[1]; }) /
         std::sqrt(dim == 2 ? h * h * h / 2 : h / 2 * ((1 - 2 * h) * h * h / 9 + 2 * h * h * h / 4))});
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check<2>(8);
  check<3>(5);
}
