// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Reactions of affine fields on a box with edges 1, 2, 3, by hand:
//
//     T = 5 + x - 2 y, k = 3:        A = (3, -6, 0);  x+: 3 * 2 * 3 = 18 (2D: 6),  y-: 6 * 3 = 18 (2D: 6)
//     u = (x, y, z)/10, E = 1, nu = 0.25 (lambda = mu = 0.4): 3D  P = 0.2 I on x+: 0.2 * 6 = 1.2
//                                                              2D  P = (2 lambda + 2 mu)/10 = 0.16 on x+:
//                                                              0.32
//
// On x- a convection puts in h (Ambient - T) = -3, and on x+ fluxes put in 3 and P, which is what A.N is
// there: they count where they are an other boundary and not on the boundary itself, so y- reacts with 6 * 1
// * 3 = 18 (2D: 6). The displacement is prescribed on x-, so only the edge that x- has in common with y-
// counts for y-: half a cell (1/2) of P on x- is included, -0.2 * 0.5 * 3 = -0.3 (2D: -0.08). Over all
// boundaries w = 1: the sum is zero.
//
// ranks: 1 2 3

#include "given_solution.h"

#include <dovetail/output/reaction.h>

using namespace test;

template <int dim>
void check()
{
  const std::string prm = std::string(R"(set Materials = stuff
set Domains = box
subsection Material stuff
  subsection Heat
    set Type = Fourier
    set Conductivity = 3
  end
  subsection Solid
    set Type = linear elastic
    set Young modulus = 1
    set Poisson ratio = 0.25
  end
end
subsection Domain box
  set Material = stuff
  set Boundary conditions = heated, fixed, heat in, pull
  subsection Mesh
    set Generator = subdivided_hyper_rectangle
    set Arguments = )") + (dim == 2 ? "3, 2 : 0, 0 : 1, 2 : true" : "3, 2, 2 : 0, 0, 0 : 1, 2, 3 : true") +
                          R"(
  end
  subsection Exact
    set temperature = 5 + x - 2*y
    set displacement = )" +
                          (dim == 2 ? "x/10; y/10" : "x/10; y/10; z/10") + R"(
  end
  subsection Boundary condition heated
    set Type = convection
    set Field = temperature
    set Boundary ids = 0
    set Coefficient = 1
    set Ambient = 2 - 2*y
  end
  subsection Boundary condition heat in
    set Type = flux
    set Field = temperature
    set Boundary ids = 1
    set Expression = 3
  end
  subsection Boundary condition pull
    set Type = flux
    set Field = displacement
    set Boundary ids = 1
    set Expression = )" + (dim == 2 ? "0.16; 0" : "0.2; 0; 0") +
                          R"(
  end
  subsection Boundary condition fixed
    set Type = value
    set Field = displacement
    set Boundary ids = 0
    set Expression = )" + (dim == 2 ? "0; 0" : "0; 0; 0") +
                          R"(
  end
end
)";
  const GivenSolution<dim> given(prm);
  const Domain<dim> &box = *given.model.domains[0];
  const Field &u = *box.material.find_field("displacement"), &T = *box.material.find_field("temperature");

  const auto all = [](const auto &, dealii::types::boundary_id) { return true; };
  print("temperature, all", reaction(given.model, box, all, T, given.solution, 1.));
  print("displacement, all", reaction(given.model, box, all, u, given.solution, 1.));

  for (const unsigned int id : {0, 1, 2}) {
    const auto one = [id](const auto &, const dealii::types::boundary_id other) { return other == id; };
    print("temperature, " + std::to_string(id), reaction(given.model, box, one, T, given.solution, 1.));
    print("displacement, " + std::to_string(id), reaction(given.model, box, one, u, given.solution, 1.));
  }
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check<2>();
  check<3>();
}
