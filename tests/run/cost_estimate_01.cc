// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The entries of the matrices that the estimate of a run's cost counts at some cells against those of the
// matrices themselves: within a tenth, for squares, cubes, triangles and tetrahedra of several degrees, one
// field and two that follow each other, with a weakly prescribed value. Four instead of two times the output
// for three steps in place of one: the time grows, the memory does not.
//
// ranks: 1, 2

#include "../system/scene_model.h"

#include <dovetail/run/cost_estimate.h>
#include <dovetail/system/solve_groups.h>

using namespace test;

namespace {

template <int dim>
void check(const std::string &name, const std::string &material, const std::string &mesh)
{
  SceneModel<dim> scene(set("Materials", "one") + set("Domains", "body") +
                        subsection("Material one", material) +
                        subsection("Domain body", set("Material", "one") + mesh));
  BlockSystem<dim> system(scene.model);
  system.set_up(1.);
  double n_entries = 0;
  const auto groups =
      make_solve_groups<dim>(scene.model, [&]() -> const BlockSystem<dim> & { return system; });
  for (const SolveGroup &group : groups) {
    const unsigned int part = system.tangent().part_of(group.blocks[0]);
    n_entries += system.tangent().part(part, part).n_nonzero_elements();
  }
  const auto estimate = [&](const std::string &n_steps) {
    const LinearSolver solver(SceneText::root(SceneText::from_prm(set("Type", "multigrid"))), groups);
    return estimate_cost(scene.model, solver,
                         Steps(SceneText::root(SceneText::from_prm(set("Number of steps", n_steps)))));
  };
  const CostEstimate one = estimate("1"), three = estimate("3");
  report(name + ", entries", std::abs(one.n_entries / n_entries - 1), 0.1);
  report(name + ", output", std::abs(three.output / one.output - 2), 1e-12);
  report(name + ", memory", one.memory > 0 && std::abs(three.memory - one.memory) < 0.2 * one.memory);
  report(name + ", seconds", one.setup > 0 && one.assembly > 0 && one.solve > 0 && one.knows_solver);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string heat = subsection("Heat", set("Type", "Fourier") + set("Conductivity", "2")),
                    solid = subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "1") +
                                                    set("Poisson ratio", "0.3"));
  const auto held = [](const std::string &type, const std::string &entries) {
    return subsection("Boundary condition " + type,
                      set("Type", type) + set("Boundary ids", "0") + set("Coefficient", "1") + entries);
  };
  const std::string spring = held("spring", ""),
                    air = held("convection", set("Field", "temperature") + set("Ambient", "0"));
  const std::string with_spring = set("Boundary conditions", "spring") + spring,
                    with_air = set("Boundary conditions", "convection") + air,
                    with_weak_value = set("Boundary conditions", "wall") +
                                      subsection("Boundary condition wall",
                                                 set("Type", "value") + set("Field", "temperature") +
                                                     set("Boundary ids", "0") + set("Expression", "1") +
                                                     set("Method", "Nitsche")),
                    simplices = set("Cells", "simplices");
  check<2>("squares", solid, set("Degree", "2") + with_spring + box("20, 15 : 0, 0 : 1, 1"));
  check<2>("triangles", heat, set("Degree", "2") + with_weak_value + box("14, 14 : 0, 0 : 1, 1", simplices));
  check<3>("cubes", solid, set("Degree", "1") + with_spring + box("8, 9, 10 : 0, 0, 0 : 1, 1, 1"));
  check<3>("cubes of degree 3", heat, set("Degree", "3") + with_air + box("4, 5, 6 : 0, 0, 0 : 1, 1, 1"));
  check<3>("tetrahedra", heat + solid,
           set("Degree", "1") + set("Boundary conditions", "spring, convection") + spring + air +
               box("5, 5, 6 : 0, 0, 0 : 1, 1, 1", simplices));
}
