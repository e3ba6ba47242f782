// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A cantilever of a hundred squares, stiff and soft ones in turn, the soft ones 1e8 times softer: each stiff
// square is held by soft ones, and moves with the sum of what rounding leaves of K u in it, so that a
// solution of K u = f loses 5e-3 (MUMPS) or 7e-3 (multigrid) of the forces. The laws refine it: each square
// is in balance to 1e-5 of what goes through it, and the free end moves as with a contrast of 1e6, but for
// the share of the stiff squares, which is below 1e-5.
//
// ranks: 1, 2

#include "../system/scene_model.h"

#include <dovetail/run/simulation.h>

#include <algorithm>
#include <cmath>
#include <fstream>

using namespace test;

namespace {

const unsigned int n = 100;

std::string name(const std::string &letter, const unsigned int i)
{
  return letter + std::to_string(i);
}

std::string square(const unsigned int i, const std::string &modulus)
{
  const std::string cells = i % 2 == 0 ? "2" : "3", begin = std::to_string(i), end = std::to_string(i + 1);
  std::string text = set("Material", name("m", i)) + subsection("Source", set("displacement", "0; 1e-3")) +
                     subsection("Mesh", set("Generator", "subdivided_hyper_rectangle") +
                                            set("Arguments", cells + ", " + cells + " : " + begin +
                                                                 ", 0 : " + end + ", 1 : true"));
  if (i == 0)
    text += set("Boundary conditions", "clamp") +
            subsection("Boundary condition clamp", set("Type", "value") + set("Field", "displacement") +
                                                       set("Boundary ids", "0") + set("Expression", "0; 0"));
  return subsection("Material " + name("m", i),
                    subsection("Solid", set("Type", "linear elastic") + set("Young modulus", modulus) +
                                            set("Poisson ratio", "0.3"))) +
         subsection("Domain " + name("d", i), text);
}

std::string scene(const std::string &first, const std::string &second, const std::string &solver)
{
  std::string materials, domains, interfaces, text;
  for (unsigned int i = 0; i < n; ++i) {
    const std::string comma = i > 0 ? ", " : "";
    materials += comma + name("m", i);
    domains += comma + name("d", i);
    text += square(i, i % 2 == 0 ? first : second);
    if (i == 0)
      continue;
    interfaces += (i > 1 ? ", " : "") + name("s", i);
    text += subsection("Interface " + name("s", i), set("Type", "Nitsche") +
                                                        set("Source", name("d", i - 1) + " : 1") +
                                                        set("Destination", name("d", i) + " : 0"));
  }
  return set("Dimension", "2") + set("Materials", materials) + set("Domains", domains) +
         set("Interfaces", interfaces) + text + subsection("Linear solver", set("Type", solver)) +
         set("Probes", "end") +
         subsection("Probe end", set("Domain", name("d", n - 1)) + set("Field", "displacement") +
                                     set("Point", std::to_string(n) + "; 0.5")) +
         subsection("Output", set("Directory", "out") + set("Paraview", "false"));
}

struct Chain
{
  double end = 0;     ///< deflection
  double missing = 0; ///< largest imbalance of a square by the largest force on it
  unsigned int n_iterations = 0;
};

Chain solve(const std::string &first, const std::string &second, const std::string &solver)
{
  std::ostringstream silence;
  auto *const terminal = std::cout.rdbuf(silence.rdbuf());
  {
    Simulation<2> simulation(SceneText::from_prm(scene(first, second, solver)), MPI_COMM_WORLD);
    simulation.run();
  }
  std::cout.rdbuf(terminal);
  nlohmann::json report;
  std::ifstream("out/report.json") >> report;
  MPI_Barrier(MPI_COMM_WORLD);
  Chain result;
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
  const Chain usual = solve("1e6", "1", "direct");
  for (const std::string solver : {"multigrid", "direct"}) {
    const Chain extreme = solve("1e8", "1", solver);
    if (speaks)
      std::cout << solver << ": in balance " << (extreme.missing < 1e-5) << ", moves as with 1e6 "
                << (std::abs(extreme.end / usual.end - 1) < 1e-5) << ", iterations at most 150 "
                << (extreme.n_iterations <= 150) << std::endl;
  }
}
