// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Multigrid on chains of twenty elastic cubes (14 040 unknowns) that Nitsche's method ties: Young's modulus 1
// and 1e6 in turn, and growing by the same factor from cube to cube up to 1e8, and falling as much. Within 45
// iterations the true residual is what rounding leaves of it, without help by MUMPS, which would be a note.
// With aggregates of both sides of a tie, modes by the contrast of the whole chain, and another pass from the
// residual of rounding, the first two took 68 and 79. The free end moves as MUMPS says (relative difference
// at most 1e-2: rounding disturbs a chain of this contrast so much). A hundred and seventy-five cubes of one
// cell have more rows on the level of their rigid motions than are factorised elsewhere, and no level below.
//
// ranks: 1, 3

#include "assembled_scene.h"

#include <array>
#include <cmath>
#include <functional>

using namespace test;

namespace {

std::string number(const std::string &name, const unsigned int i)
{
  return name + " " + std::to_string(i);
}

/// @param n cells along its edges
std::string body(const unsigned int i, const std::string &n, const double modulus)
{
  const std::string begin = std::to_string(i), end = std::to_string(i + 1);
  std::string text = set("Material", number("m", i)) +
                     subsection("Source", set("displacement", "0; 1e-3; 2e-3")) +
                     box(n + ", " + n + ", " + n + " : " + begin + ", 0, 0 : " + end + ", 1, 1");
  if (i == 0)
    text +=
        set("Boundary conditions", "clamp") +
        subsection("Boundary condition clamp", set("Type", "value") + set("Field", "displacement") +
                                                   set("Boundary ids", "0") + set("Expression", "0; 0; 0"));
  std::ostringstream young;
  young << modulus;
  return subsection("Material " + number("m", i),
                    subsection("Solid", set("Type", "linear elastic") + set("Young modulus", young.str()) +
                                            set("Poisson ratio", "0.3"))) +
         subsection("Domain " + number("b", i), text);
}

using ByNumber = std::function<double(unsigned int)>;

std::string chain(const unsigned int n_bodies, const std::array<std::string, 2> &cells,
                  const ByNumber &modulus)
{
  std::string materials, domains, interfaces, text;
  for (unsigned int i = 0; i < n_bodies; ++i) {
    const std::string comma = i == 0 ? "" : ", ";
    materials += comma + number("m", i);
    domains += comma + number("b", i);
    text += body(i, cells[i % 2], modulus(i));
    if (i > 0) {
      interfaces += (i == 1 ? "" : ", ") + number("s", i);
      text += subsection("Interface " + number("s", i), set("Type", "Nitsche") +
                                                            set("Source", number("b", i - 1) + " : 1") +
                                                            set("Destination", number("b", i) + " : 0"));
    }
  }
  return set("Materials", materials) + set("Domains", domains) + set("Interfaces", interfaces) + text;
}

void check(const std::string &name, const unsigned int n_bodies, const std::array<std::string, 2> &cells,
           const ByNumber &modulus)
{
  const AssembledScene<3> assembled(chain(n_bodies, cells, modulus));
  const auto solve = [&](const std::string &type, Vector &solution) {
    LinearSolver solver(SceneText::root(SceneText::from_prm(set("Type", type))), assembled.groups());
    const unsigned int n = assembled.solve(solver, solution).value_or(1000);
    return solver.notes().empty() ? n : 1000;
  };
  Vector reference, solution;
  solve("direct", reference);
  report(name + ", iterations", solve("multigrid", solution), 45);
  const unsigned int last = n_bodies - 1;
  solution.block(last) -= reference.block(last);
  report(name + ", last body", solution.block(last).l2_norm() / reference.block(last).l2_norm(), 1e-2);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::array<std::string, 2> cells = {{"4", "6"}};
  check("in turn", 20, cells, [](const unsigned int i) { return i % 2 == 0 ? 1 : 1e6; });
  check("growing", 20, cells, [](const unsigned int i) { return std::pow(1e8, i / 19.); });
  check("falling", 20, cells, [](const unsigned int i) { return std::pow(1e-8, i / 19.); });
  check("many", 175, {{"1", "1"}}, [](const unsigned int i) { return i % 2 == 0 ? 1 : 1e4; });
}
