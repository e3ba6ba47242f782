// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Stiff and soft bodies in turn, squares or cubes of edge 1 with 2 and 3 cells along their edges, tied by
// Nitsche's method, held at x = 0, under their weight.
//
// A cantilever of a hundred squares, of which each other one is 1e8 times softer: each stiff square is held
// by soft ones, and moves with the sum of what rounding leaves of K u in it, so that a solution of K u = f
// loses 5e-3 (MUMPS) or 7e-3 (multigrid) of the forces. The laws refine it: each square is in balance to 1e-5
// of what goes through it, and the free end moves as with a contrast of 1e6, but for the share of the stiff
// squares, which is below 1e-5.
//
// Sixteen cubes of degree 2 like a chess board with a contrast of 1e4: with aggregates of stiff and soft
// bodies products are slow, and MUMPS takes over; with those within bodies, which a look at the rate asks
// for, they take 36 iterations with those before.
//
// ranks: 1, 2

#include "../system/scene_model.h"

#include <dovetail/run/simulation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

using namespace test;

namespace {

using Place = std::array<unsigned int, 3>;
using Bodies = std::array<unsigned int, 3>; ///< number along each direction

struct Case
{
  Bodies bodies;
  std::string degree, stiff, solver;
};

std::string name(const std::string &letter, const Place &place)
{
  std::string result = letter;
  for (const unsigned int number : place)
    result += " " + std::to_string(number);
  return result;
}

template <int dim>
std::string body(const Place &place, const Case &of)
{
  const bool is_stiff = (place[0] + place[1] + place[2]) % 2 == 0;
  std::string cells, begin, end;
  for (unsigned int d = 0; d < dim; ++d) {
    const std::string comma = d > 0 ? ", " : "";
    cells += comma + (is_stiff ? "2" : "3");
    begin += comma + std::to_string(place[d]);
    end += comma + std::to_string(place[d] + 1);
  }
  const std::string weight = dim == 2 ? "0; 1e-3" : "0; 1e-3; 2e-3", zero = dim == 2 ? "0; 0" : "0; 0; 0";
  std::string text =
      set("Material", is_stiff ? "stiff" : "soft") + set("Degree", of.degree) +
      subsection("Source", set("displacement", weight)) +
      subsection("Mesh", set("Generator", "subdivided_hyper_rectangle") +
                             set("Arguments", cells + " : " + begin + " : " + end + " : true"));
  if (place[0] == 0)
    text += set("Boundary conditions", "clamp") +
            subsection("Boundary condition clamp", set("Type", "value") + set("Field", "displacement") +
                                                       set("Boundary ids", "0") + set("Expression", zero));
  return subsection("Domain " + name("d", place), text);
}

std::string material(const std::string &name, const std::string &modulus)
{
  return subsection("Material " + name,
                    subsection("Solid", set("Type", "linear elastic") + set("Young modulus", modulus) +
                                            set("Poisson ratio", "0.3")));
}

template <int dim>
std::string scene(const Case &of)
{
  std::string domains, interfaces, text = material("stiff", of.stiff) + material("soft", "1"), last;
  for (unsigned int x = 0; x < of.bodies[0]; ++x)
    for (unsigned int y = 0; y < of.bodies[1]; ++y)
      for (unsigned int z = 0; z < of.bodies[2]; ++z) {
        const Place place = {{x, y, z}};
        last = name("d", place);
        domains += (domains.empty() ? "" : ", ") + last;
        text += body<dim>(place, of);
        for (unsigned int d = 0; d < dim; ++d) {
          Place next = place;
          if (++next[d] == of.bodies[d])
            continue;
          const std::string seam = name("s" + std::to_string(d), place);
          interfaces += (interfaces.empty() ? "" : ", ") + seam;
          text +=
              subsection("Interface " + seam,
                         set("Type", "Nitsche") + set("Source", last + " : " + std::to_string(2 * d + 1)) +
                             set("Destination", name("d", next) + " : " + std::to_string(2 * d)));
        }
      }
  const std::string end = std::to_string(of.bodies[0]) + (dim == 2 ? "; 0.5" : "; 1.5; 1.5");
  return set("Dimension", std::to_string(dim)) + set("Materials", "stiff, soft") + set("Domains", domains) +
         set("Interfaces", interfaces) + text + subsection("Linear solver", set("Type", of.solver)) +
         set("Probes", "end") +
         subsection("Probe end", set("Domain", last) + set("Field", "displacement") + set("Point", end)) +
         subsection("Output", set("Directory", "out") + set("Paraview", "false"));
}

struct Result
{
  double end = 0;     ///< how far it moves along y
  double missing = 0; ///< largest imbalance of a body by the largest force on it
  unsigned int n_iterations = 0;
};

template <int dim>
Result solve(const Case &of)
{
  std::ostringstream silence;
  auto *const terminal = std::cout.rdbuf(silence.rdbuf());
  {
    Simulation<dim> simulation(SceneText::from_prm(scene<dim>(of)), MPI_COMM_WORLD);
    simulation.run();
  }
  std::cout.rdbuf(terminal);
  nlohmann::json report;
  std::ifstream("out/report.json") >> report;
  MPI_Barrier(MPI_COMM_WORLD);
  Result result;
  result.end = report["probes"]["end"][1];
  for (const nlohmann::json &n_of_solve : report["steps"].back()["linear iterations"])
    result.n_iterations += n_of_solve.get<unsigned int>();
  for (const auto &domain : report["balance"].items()) {
    const nlohmann::json &balance = domain.value()["displacement"];
    double force = 0;
    for (const std::string way : {"in", "out"})
      for (const double component : balance[way])
        force = std::max(force, std::abs(component));
    for (const double component : balance["imbalance"])
      result.missing = std::max(result.missing, std::abs(component) / force);
  }
  return result;
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const bool speaks = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;
  const Bodies chain = {{100, 1, 1}};
  const Result usual = solve<2>({chain, "1", "1e6", "direct"});
  for (const std::string solver : {"multigrid", "direct"}) {
    const Result extreme = solve<2>({chain, "1", "1e8", solver});
    if (speaks)
      std::cout << "chain, " << solver << ": in balance " << (extreme.missing < 1e-5)
                << ", moves as with 1e6 " << (std::abs(extreme.end / usual.end - 1) < 1e-5)
                << ", iterations at most 150 " << (extreme.n_iterations <= 150) << std::endl;
  }
  const Result lattice = solve<3>({{{4, 2, 2}}, "2", "1e4", "matrix-free"});
  if (speaks)
    std::cout << "lattice: in balance " << (lattice.missing < 1e-6) << ", iterations from 20 to 70 "
              << (lattice.n_iterations > 20 && lattice.n_iterations < 70) << std::endl;
}
