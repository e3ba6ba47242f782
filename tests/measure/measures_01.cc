// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Errors, norms and numbers of an interface by hand. Two squares [0,1] x [0,1] and [1,2] x [0,1], one
// temperature field each, interpolated from `Exact` on 4 x 4 and 3 x 3 bilinear cells:
//
// left, k = 2:  T = x^2; the interpolant errs by h^2 / sqrt(30) in L2 and h / sqrt(3) in H1 (h = 1/4),
//               in energy sqrt(2) times that of H1;
//               norms 1/sqrt(5) and 2/sqrt(3); extremes 1 and 0
// right, k = 1: T = x, no error; norms sqrt(7/3) and 1; extremes 2 and 1
// at x = 1:     jump 1 - 1 = 0; A_src.N_src = 2 (2 - h) = 3.5 of the interpolant, A_dst.N_dst = -1,
//               flux jump 2.5;
//               equal mean 2.25, exact 4: flux error 1.75; resultants +-2.25, the integral of that mean
//
// ranks: 1 2 3

#include "given_solution.h"

#include <dovetail/measure/measures.h>
#include <dovetail/measure/probes.h>

using namespace test;

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const GivenSolution<2> given(R"(
set Materials = good, poor
set Domains = left, right
set Interfaces = seam
set Probes = corner, middle, shared corner
subsection Material good
  subsection Heat
    set Type = Fourier
    set Conductivity = 2
  end
end
subsection Material poor
  subsection Heat
    set Type = Fourier
    set Conductivity = 1
  end
end
subsection Domain left
  set Material = good
  set Boundary conditions = cold
  subsection Mesh
    set Generator = subdivided_hyper_rectangle
    set Arguments = 4, 4 : 0, 0 : 1, 1 : true
  end
  subsection Exact
    set temperature = x^2
  end
  subsection Source
    set temperature = -4
  end
  subsection Boundary condition cold
    set Type = value
    set Field = temperature
    set Boundary ids = 0
    set Expression = 0
  end
end
subsection Domain right
  set Material = poor
  subsection Mesh
    set Generator = subdivided_hyper_rectangle
    set Arguments = 3, 3 : 1, 0 : 2, 1 : true
  end
  subsection Exact
    set temperature = x
  end
end
subsection Interface seam
  set Type = Nitsche
  set Source = left : 1
  set Destination = right : 0
  set Weights = equal
  set Penalty = volume
end
subsection Probe corner
  set Domain = right
  set Point = 2; 1
  set Field = temperature
end
subsection Probe middle
  set Domain = left
  set Point = 0.375; 0.7
  set Field = temperature
end
subsection Probe shared corner
  set Domain = left
  set Point = 0.5; 0.5
  set Field = temperature
end
)");
  const auto domains = measure_domains(given.model, given.solution, 1.);
  const auto &left = domains["left"], &right = domains["right"];
  const double h = 0.25;
  print("cells, dofs", {left["cells"], left["dofs"], right["cells"], right["dofs"]});
  print("errors / by hand", {left["errors"]["temperature"]["L2"].get<double>() / (h * h / std::sqrt(30.)),
                             left["errors"]["temperature"]["H1"].get<double>() / (h / std::sqrt(3.))});
  print("norms / by hand", {left["norms"]["temperature"]["L2"].get<double>() * std::sqrt(5.),
                            left["norms"]["temperature"]["H1"].get<double>() * std::sqrt(3.) / 2});
  print("energy / by hand", {left["errors"]["temperature"]["energy"].get<double>() / (h * std::sqrt(2. / 3.)),
                             left["norms"]["temperature"]["energy"].get<double>() / std::sqrt(8. / 3.)});
  print("errors of the right", {right["errors"]["temperature"]["L2"], right["errors"]["temperature"]["H1"]});
  print("norms / by hand", {right["norms"]["temperature"]["L2"].get<double>() / std::sqrt(7. / 3.),
                            right["norms"]["temperature"]["H1"]});
  print("extremes", {left["maximum"]["temperature"], left["minimum"]["temperature"],
                     right["maximum"]["temperature"], right["minimum"]["temperature"]});

  const auto seam = measure_interfaces(given.model, given.solution, *given.reactions)["seam"];
  print("areas",
        {seam["area source"], seam["area destination"], seam["covered source"], seam["covered destination"]});
  print("uncovered, gap", {seam["uncovered points"], seam["largest gap"]});
  print("jump", {seam["jump L2"]["temperature"]});
  print("flux jump / 2.5", {seam["flux jump L2"]["temperature"].get<double>() / 2.5});
  print("flux error / 1.75", {seam["flux error L2"]["temperature"].get<double>() / 1.75});
  print("largest flux error / 1.75", {seam["flux error max"]["temperature"].get<double>() / 1.75});
  print("flux norm, largest flux, oscillation",
        {seam["flux norm L2"]["temperature"], seam["flux max"]["temperature"],
         seam["flux oscillation"]["temperature"]});
  print("has penalty", {double(seam.contains("penalty"))});
  print("resultants",
        {seam["resultant source"]["temperature"][0], seam["resultant destination"]["temperature"][0]});

  const Probes<2> probes(given.scene, given.model);
  const auto values = probes.evaluate(given.solution, *given.reactions).numbers;
  print("probes", {values["corner"], values["middle"], values["shared corner"]}); // 2, (h^2 + (2h)^2)/2, 1/4
}
