// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What is left when the cells have been added up, of bodies with heat sources, gravity, convection, loads,
// hanging nodes and several fields:
//
// * The matrix of the first assembly, whose positions are looked up, of the second, which keeps them, and
// that
//   of the transposed system, which goes the general way of deal.II: w.K v in random directions (1e-13
//   relative), and the residuals.
// * What the given sources put into the cells: with the cells at the conditions it is the sum of all of them,
//   one by one, positive and negative parts for themselves (1e-13). After the time has changed it is not
//   known.
//
// ranks: 1, 2, 3

#include "scene_model.h"

#include <dovetail/domain/cell_terms.h>

#include <numeric>

using namespace test;

namespace {

std::string domain(const std::string &material, const std::string &mesh, const std::string &conditions)
{
  return set("Material", material) + mesh + conditions +
         subsection("Source", set("temperature", "(1 + t)*sin(7*x) + y")) +
         set("Acceleration", "x - 0.4; -1 + t*y");
}

std::string scene(const unsigned int degree)
{
  const std::string law = subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "10") +
                                                  set("Poisson ratio", "0.3") + set("Density", "3") +
                                                  set("Expansion coefficient", "0.01")) +
                          subsection("Heat", set("Type", "Fourier") + set("Conductivity", "2"));
  const std::string conditions =
      set("Boundary conditions", "clamp, air, load") +
      subsection("Boundary condition clamp", set("Type", "value") + set("Field", "displacement") +
                                                 set("Boundary ids", "0") + set("Expression", "0.1*y; 0")) +
      subsection("Boundary condition air", set("Type", "convection") + set("Field", "temperature") +
                                               set("Boundary ids", "0, 2") + set("Coefficient", "1 + x") +
                                               set("Ambient", "4 - 8*x")) +
      subsection("Boundary condition load", set("Type", "flux") + set("Field", "displacement") +
                                                set("Boundary ids", "3") + set("Expression", "0.5 - x; 1"));
  return set("Materials", "steel") + set("Domains", "left, right") + set("Interfaces", "seam") +
         subsection("Material steel", law) +
         subsection("Domain left", domain("steel",
                                          set("Degree", std::to_string(degree)) +
                                              box("3, 4 : 0, 0 : 1, 1", set("Refinements", "1")),
                                          conditions)) +
         subsection("Domain right", domain("steel", box("2, 5 : 1, 0 : 2, 1"), "")) +
         subsection("Interface seam",
                    set("Type", "Nitsche") + set("Source", "left : 1") + set("Destination", "right : 0"));
}

double product(const BlockSystem<2> &system, const Vector &w, const Vector &v)
{
  Vector Kv = system.owned_vector();
  system.tangent().vmult(Kv, v);
  return w * Kv;
}

/// The flows of all cells by assemble_loads(), and given_flows() with those of the cells that it leaves out.
void compare_flows(const Model<2> &model, const NodalForces<2> &forces, const Vector &x, const double t)
{
  double error = 0, size = 0;
  for (unsigned int d = 0; d < model.domains.size(); ++d) {
    const Domain<2> &body = *model.domains[d];
    CellTerms<2> terms(body);
    Flows all(body.n_components()), by_parts = *forces.given_flows(d);
    std::vector<dealii::types::global_dof_index> dofs;
    std::vector<double> unknowns(body.dofs_per_cell()), residual(unknowns.size());
    for (const auto &cell : body.dof_handler().active_cell_iterators())
      if (cell->is_locally_owned()) {
        body.cell_dofs(cell, dofs);
        x.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
        terms.assemble_loads(cell, t, unknowns, residual);
        for (unsigned int c = 0; c < body.n_components(); ++c) {
          const double influx =
              -std::accumulate(residual.begin() + body.layout().first(c),
                               residual.begin() + body.layout().first(c) + body.layout().n_nodes(c), 0.);
          all.add(c, influx);
          if (!body.conditions().empty() && cell->at_boundary())
            by_parts.add(c, influx);
        }
      }
    for (unsigned int c = 0; c < body.n_components(); ++c) {
      error = std::max({error, std::abs(all.in[c] - by_parts.in[c]), std::abs(all.out[c] - by_parts.out[c])});
      size = std::max({size, all.in[c], all.out[c]});
    }
  }
  report("given sources", error, 1e-13);
  report("they are not nothing", dealii::Utilities::MPI::max(size, MPI_COMM_WORLD) > 0.1);
}

void check(const unsigned int degree)
{
  SceneModel<2> scene_model(scene(degree));
  Model<2> &model = scene_model.model;
  BlockSystem<2> system(model), transposed(model, Form::transposed);
  Vector x, v, w, first_residual;
  double first = 0;
  for (const double t : {1., 2.}) {
    if (t == 1)
      for (BlockSystem<2> *one : {&system, &transposed})
        one->set_up(t);
    if (t == 1) {
      x = system.owned_vector();
      v = w = first_residual = x;
      for (const auto dof : model.numbering->owned) {
        x(dof) = noise(dof);
        v(dof) = noise(3 * dof + 1);
        w(dof) = noise(7 * dof + 2);
      }
      for (Vector *one : {&x, &v, &w})
        one->compress(dealii::VectorOperation::insert);
    }
    for (BlockSystem<2> *one : {&system, &transposed}) {
      one->begin_step(t, x);
      one->constrain(x); // prescribed values do not move: then deal.II's way is that of few cells
      report("assembled", one->assemble(x, true));
    }
    const double direct = product(system, w, v), other = product(transposed, v, w);
    report("transposed", std::abs(direct - other) / std::abs(direct), 1e-13);
    first = t == 1 ? direct : first;
    report("kept positions", std::abs(direct - first) / std::abs(direct), 1e-13);
    Vector difference = system.negative_residual();
    difference -= transposed.negative_residual();
    report("residual", difference.linfty_norm() / system.negative_residual().linfty_norm(), 1e-13);
    compare_flows(model, system.nodal_forces(x), system.ghosted(x), t);
  }
  system.set_time(3.);
  report("not known at another time", system.nodal_forces(x).given_flows(0) == nullptr);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const unsigned int degree : {1, 2})
    check(degree);
}
