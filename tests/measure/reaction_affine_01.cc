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
// there; everywhere else T is prescribed, and u on x-, too. So y- reacts with 6 * 1 * 3 = 18 (2D: 6) and
// -0.2 * 3 = -0.6 (2D: -0.16), although its edges belong to prescribed neighbours as well: each face has
// exactly its share. Over all boundaries the sum is zero.
//
// ranks: 1 2 3

#include "given_solution.h"

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
  set Boundary conditions = heated, walls, fixed, heat in, pull
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
  subsection Boundary condition walls
    set Type = value
    set Field = temperature
    set Boundary ids = )" +
                          (dim == 2 ? "2, 3" : "2, 3, 4, 5") +
                          R"(
    set Expression = 5 + x - 2*y
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
    set Boundary ids = )" +
                          (dim == 2 ? "0, 2, 3" : "0, 2, 3, 4, 5") +
                          R"(
    set Expression = )" + (dim == 2 ? "x/10; y/10" : "x/10; y/10; z/10") +
                          R"(
  end
end
)";
  const GivenSolution<dim> given(prm);
  const Domain<dim> &box = *given.model.domains[0];
  const Field &u = *box.material.find_field("displacement"), &T = *box.material.find_field("temperature");

  print("temperature, all", given.reactions->resultant(box, box.boundary_ids(), T));
  print("displacement, all", given.reactions->resultant(box, box.boundary_ids(), u));
  for (const unsigned int id : {0, 1, 2}) {
    print("temperature, " + std::to_string(id), given.reactions->resultant(box, {id}, T));
    print("displacement, " + std::to_string(id), given.reactions->resultant(box, {id}, u));
  }
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check<2>();
  check<3>();
}
