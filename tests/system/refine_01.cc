// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Two solids with heat, tied pointwise or by Nitsche's method, refined several times where a changing rule
// says so: a polynomial of the degree of the elements is transferred exactly, an affine function satisfies
// all constraints (hanging nodes, prescribed values and ties, in chains over the ranks), its estimated error
// vanishes; that of a wave with a jump at the interface does not depend on the ranks.
//
// ranks: 1 2 3

#include "scene_model.h"

#include <dovetail/measure/error_estimate.h>

using namespace test;

template <int dim>
std::string domain(const std::string &name, const std::string &boundary_ids, const std::string &mesh,
                   const std::string &degree)
{
  const std::string zeros = dim == 2 ? "; x - y" : "; x - y; y + 2*z";
  return subsection(
      "Domain " + name,
      set("Material", "both") + set("Degree", degree) + set("Boundary conditions", "T, u") +
          subsection("Boundary condition T", set("Type", "value") + set("Field", "temperature") +
                                                 set("Boundary ids", boundary_ids) +
                                                 set("Expression", "1 + x + 0.5*y")) +
          subsection("Boundary condition u", set("Type", "value") + set("Field", "displacement") +
                                                 set("Boundary ids", boundary_ids) +
                                                 set("Expression", "x + y" + zeros)) +
          box(mesh));
}

template <int dim>
double affine(const unsigned int c, const dealii::Point<dim> &X)
{
  if (c == dim)
    return 1 + X[0] + 0.5 * X[1];
  return c == 0 ? X[0] + X[1] : c == 1 ? X[0] - X[1] : X[1] + 2 * X[dim - 1];
}

template <int dim>
Vector ghosted_of(const BlockSystem<dim> &system, const Vector &owned)
{
  Vector ghosted = system.ghosted_vector();
  ghosted = owned;
  return ghosted;
}

template <int dim>
void run(const std::string &type, const unsigned int degree)
{
  const std::string p = std::to_string(degree), z = dim == 2 ? "" : ", 2", o = dim == 2 ? "" : ", 0",
                    e = dim == 2 ? "" : ", 1", sides = dim == 2 ? ", 2, 3" : ", 2, 3, 4";
  SceneModel<dim> scene_model(
      set("Materials", "both") + set("Domains", "left, right") + set("Interfaces", "seam") +
      set("Adaptive cycles", "1") +
      subsection("Material both",
                 subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "1") +
                                         set("Poisson ratio", "0.3")) +
                     subsection("Heat", set("Type", "Fourier") + set("Conductivity", "2"))) +
      domain<dim>("left", "0" + sides, "2, 2" + z + " : 0, 0" + o + " : 1, 1" + e, p) +
      domain<dim>("right", "1" + sides, "2, 2" + z + " : 1, 0" + o + " : 2, 1" + e, p) +
      subsection("Interface seam",
                 set("Type", type) + set("Source", "left : 1") + set("Destination", "right : 0")));
  Model<dim> &model = scene_model.model;

  const NodeFunction<dim> line = [](unsigned int, const unsigned int c, const dealii::Point<dim> &X) {
    return affine<dim>(c, X);
  };
  const NodeFunction<dim> polynomial = [&](unsigned int, const unsigned int c, const dealii::Point<dim> &X) {
    return affine<dim>(c, X) + std::pow(X[0] + 0.3 * X[1], degree) * (c + 1.);
  };
  const NodeFunction<dim> wave = [](const unsigned int d, const unsigned int c, const dealii::Point<dim> &X) {
    return std::sin(3 * X[0] + 2 * X[1] + c) + 0.01 * d;
  };
  double error_of_transfer = 0, move = 0, estimate_of_line = 0;
  std::vector<double> estimates, unknowns;
  auto system = std::make_unique<BlockSystem<dim>>(model);
  system->set_up(1);
  Vector x = system->owned_vector();
  interpolate(model, polynomial, x);
  const unsigned int n_cycles = dim == 3 ? 3 - degree : degree == 1 ? 3 : 2;
  for (unsigned int cycle = 0; cycle < n_cycles; ++cycle) {
    std::vector<std::vector<bool>> marked;
    for (const auto &domain : model.domains) {
      marked.emplace_back(domain->mesh().n_active_cells(), false);
      for (const auto &cell : domain->mesh().active_cell_iterators())
        if (cell->is_locally_owned())
          marked.back()[cell->active_cell_index()] =
              std::abs(cell->center()[0] - 1) < 0.5 && cell->center()[1] < 0.4 + 0.3 * cycle;
    }
    x = model.refine(marked, ghosted_of(*system, x));
    system = std::make_unique<BlockSystem<dim>>(model);
    system->set_up(1);
    unknowns.push_back(model.numbering->n_dofs());
    Vector difference = system->owned_vector();
    interpolate(model, polynomial, difference);
    difference -= x;
    error_of_transfer = std::max(error_of_transfer, difference.linfty_norm());

    Vector of_wave = system->owned_vector();
    interpolate(model, wave, of_wave);
    system->begin_step(1, of_wave);
    estimates.push_back(estimate_error(model, ghosted_of(*system, of_wave), 1.).relative);

    Vector of_line = system->owned_vector();
    interpolate(model, line, of_line);
    system->begin_step(1, of_line);
    system->assemble(of_line, false);
    move = std::max(move, system->moves_constraints() ? 1. : 0.);
    estimate_of_line =
        std::max(estimate_of_line, estimate_error(model, ghosted_of(*system, of_line), 1.).relative);
  }
  const std::string name = type + " " + std::to_string(dim) + "D degree " + p;
  print(name, unknowns);
  report("  transfer", error_of_transfer, 1e-12);
  report("  affine functions satisfy all constraints", move, 0.5);
  report("  estimated error of affine functions", estimate_of_line, 1e-6);
  print("  estimated error", estimates);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const std::string type : {"Nitsche", "pointwise"}) {
    run<2>(type, 1);
    run<2>(type, 2);
    run<2>(type, 3);
    run<3>(type, 1);
    run<3>(type, 2);
  }
}
