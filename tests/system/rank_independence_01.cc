// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Nothing depends on the number of ranks: residual norms at a given state, the solution of a linear scene and
// the integrals over its interfaces, whose faces lie on several ranks. A ring of 20 faces turns in one of 12
// (Nitsche), and a block of one cell, fewer than ranks, hangs at the outside (pointwise).
//
// What the tie of the rings transmits is in balance with the loads: (0, -0.4) of force, the integral of -1 +
// y over the loaded side, and the heat that the block takes from the fluid, 3 (9 - T) there.
//
// ranks: 1, 2, 3

#include "scene_model.h"

#include <dovetail/interface/side_points.h>
#include <dovetail/solve/linear_solver.h>

#include <array>

#include <algorithm>

using namespace test;

std::string scene()
{
  const std::string law =
      subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "10") +
                              set("Poisson ratio", "0.3") + set("Expansion coefficient", "0.01")) +
      subsection("Heat", set("Type", "Fourier") + set("Conductivity", "2"));
  const auto ring = [](const std::string &arguments, const std::string &more) {
    return subsection("Mesh", set("Generator", "hyper_shell") + set("Arguments", arguments) + more);
  };
  return set("Materials", "steel") + set("Domains", "inside, outside, block") +
         set("Interfaces", "fit, weld") + subsection("Material steel", law) +
         subsection("Domain inside",
                    set("Material", "steel") + set("Degree", "2") + set("Boundary conditions", "hub, cold") +
                        subsection("Boundary condition hub",
                                   set("Type", "value") + set("Field", "displacement") +
                                       set("Boundary ids", "0") + set("Expression", "0.01*x; 0.01*y")) +
                        subsection("Boundary condition cold",
                                   set("Type", "value") + set("Field", "temperature") +
                                       set("Boundary ids", "0") + set("Expression", "1 + x")) +
                        ring("0, 0 : 0.5 : 1 : 5 : true", set("Refinements", "2"))) +
         subsection("Domain outside",
                    set("Material", "steel") + ring("0, 0 : 1 : 1.5 : 6 : true", set("Refinements", "1"))) +
         subsection(
             "Domain block",
             set("Material", "steel") + set("Boundary conditions", "load, hot") +
                 subsection("Boundary condition load", set("Type", "flux") + set("Field", "displacement") +
                                                           set("Boundary ids", "1") +
                                                           set("Expression", "0; -1 + y")) +
                 subsection("Boundary condition hot",
                            set("Type", "convection") + set("Field", "temperature") +
                                set("Boundary ids", "1") + set("Coefficient", "3") + set("Ambient", "9")) +
                 box("1, 1 : 1.5, -0.2 : 2, 0.2")) +
         subsection("Interface fit", set("Type", "Nitsche") + set("Source", "inside : 1") +
                                         set("Destination", "outside : 0") + set("Integrate on", "both") +
                                         set("Search radius", "0.5")) +
         subsection("Interface weld", set("Type", "pointwise") + set("Source", "outside : 1") +
                                          set("Destination", "block : 0") + set("Uncovered", "allow") +
                                          set("Search radius", "0.5"));
}

/// Integrals over an interface: 1, the squared jumps, and the fluxes into the source as the tie sees them.
void print_interface(const Interface<2> &interface, const std::vector<double> &all)
{
  std::array<std::vector<double>, 2> flux;
  std::vector<double> area(1, 0.), squares, resultants(3, 0.), jump, transmitted;
  squares.resize(interface.fields.size());
  SidePoints<2> points(interface, 0);
  for (const auto &group : interface.pairing().groups) {
    const std::vector<double> unknowns = of_group(interface, group, all);
    for (unsigned int q = group.begin; q < group.end; ++q) {
      const double w = interface.pairing().weight(q);
      area[0] += w;
      unsigned int position = 0;
      for (unsigned int f = 0; f < interface.fields.size(); ++f) {
        const TiedField &field = interface.fields[f];
        interface.jump(field, q, 0, unknowns, jump);
        for (const double component : jump)
          squares[f] += 1e6 * w * component * component;
        for (const unsigned int side : {source, destination}) {
          points.reinit(side, q, unknowns);
          points.evaluate(side, false);
          flux[side].clear();
          for (unsigned int c = 0; c < field.n_components; ++c)
            flux[side].push_back(points.response[side].flux[field.first_component[side] + c] *
                                 interface.pairing().N(side, q));
        }
        transmitted.resize(field.n_components);
        interface.tie().numerical_flux(interface, field, q, points.state, flux, jump, transmitted);
        for (const double component : transmitted)
          resultants[position++] += w * component;
      }
    }
  }
  for (std::vector<double> *integrals : {&area, &squares, &resultants})
    dealii::Utilities::MPI::sum(*integrals, MPI_COMM_WORLD, *integrals);
  print("interface " + interface.name + ": area", area);
  print("1e6 times the squared jumps", squares);
  print("transmitted", resultants);
  const Coverage &coverage = interface.pairing().coverage();
  print("areas, covered", {coverage.area[0], coverage.area[1], coverage.covered[0], coverage.covered[1]});
  print("points, uncovered, gap",
        {double(coverage.n_points), double(coverage.n_uncovered), coverage.largest_gap});
}

/// The heat that the block takes from the fluid: 3 (9 - T) over x = 2, T linear there.
double heat_of_fluid(const Model<2> &model, const std::vector<double> &all)
{
  double heat = 0;
  const Domain<2> &block = *model.domains[2];
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : block.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      block.cell_dofs(cell, dofs);
      for (const unsigned int node : {1, 3})
        heat += 0.2 * 3 * (9 - all[dofs[2 * 4 + node]]);
    }
  return dealii::Utilities::MPI::sum(heat, MPI_COMM_WORLD);
}

std::vector<double> norms(const Vector &vector)
{
  std::vector<double> result;
  for (unsigned int b = 0; b < vector.n_blocks(); ++b)
    result.push_back(vector.block(b).l2_norm());
  return result;
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  SceneModel<2> scene_model(scene());
  Model<2> &model = scene_model.model;
  BlockSystem<2> system(model);
  system.set_up(1.);
  Vector x = system.owned_vector(), dx = system.owned_vector();
  interpolate<2>(
      model,
      [](unsigned int d, unsigned int c, const dealii::Point<2> &X) {
        return std::sin(X[0] + 2 * X[1] + c + d);
      },
      x);
  system.begin_step(1., x);
  system.assemble(x, true);
  print("residual at a given state, by block", norms(system.negative_residual()));
  double moved = 0;
  system.distribute(dx);
  for (const double norm : norms(dx))
    moved += norm;
  print("moved by constraints", {moved});
  system.tangent().vmult(dx, x);
  print("K x, by block", norms(dx));

  x = 0;
  system.begin_step(1., x);
  system.assemble(x, true);
  SolveGroup all_blocks;
  all_blocks.name = "all";
  for (unsigned int b = 0; b < model.numbering->blocks().size(); ++b)
    all_blocks.blocks.push_back(b);
  std::stable_sort(all_blocks.blocks.begin(), all_blocks.blocks.end(), [&](const auto a, const auto b) {
    return system.tangent().part_of(a) < system.tangent().part_of(b);
  });
  all_blocks.is_symmetric = false;
  LinearSolver solver(SceneText::root(SceneText::from_prm(set("Type", "direct"))), {all_blocks});
  solver.set_matrix(system.tangent());
  report("solved", solver.solve(x, system.negative_residual()).has_value());
  system.distribute(x);
  print("solution, norms by block", norms(x));
  print("its sum over the unknowns", {x.mean_value() * x.size()});

  system.begin_step(1., x);
  system.assemble(x, false);
  report("residual of the solution", system.negative_residual().l2_norm(), 1e-11);
  const std::vector<double> all = gather(model, x);
  for (const auto &interface : model.interfaces)
    print_interface(*interface, all);
  print("heat of the fluid", {heat_of_fluid(model, all)});
}
