// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The lines of the pointwise tie reproduce affine fields exactly, also over a gap and on curved sides, for
// every pair of degrees; what is prescribed on the destination stays prescribed; and the closed constraints
// of the whole system give the affine field back, where prescribed unknowns of the source are behind the
// lines, too. The number of lines is the number of the destination's nodes times components, without the
// prescribed ones.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

using namespace test;

/// Coefficients of the affine field c, and its text.
template <int dim>
double affine(const unsigned int c, const dealii::Point<dim> &X)
{
  double value = 1 + c;
  for (unsigned int d = 0; d < dim; ++d)
    value += (1 + d + 2 * c) * X[d] / 4;
  return value;
}

template <int dim>
std::string text(const unsigned int c)
{
  const std::string letters = "xyz";
  std::string words = std::to_string(1 + c);
  for (unsigned int d = 0; d < dim; ++d)
    words += " + " + std::to_string(1 + d + 2 * c) + "*" + letters[d] + "/4";
  return words;
}

/// A body with both fields prescribed on two of its boundary ids.
template <int dim>
std::string body(const std::string &u_ids, const std::string &T_ids, const unsigned int degree,
                 const std::string &mesh)
{
  std::string u = text<dim>(0);
  for (unsigned int c = 1; c < dim; ++c)
    u += "; " + text<dim>(c);
  return set("Material", "steel") + set("Degree", std::to_string(degree)) +
         set("Boundary conditions", "u, T") +
         subsection("Boundary condition u", set("Type", "value") + set("Field", "displacement") +
                                                set("Boundary ids", u_ids) + set("Expression", u)) +
         subsection("Boundary condition T", set("Type", "value") + set("Field", "temperature") +
                                                set("Boundary ids", T_ids) +
                                                set("Expression", text<dim>(dim))) +
         mesh;
}

template <int dim>
void check(const std::string &name, const std::string &left, const std::string &right)
{
  SceneModel<dim> scene_model(
      set("Materials", "steel") + set("Domains", "left, right") + set("Interfaces", "seam") +
      subsection("Material steel",
                 subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "1") +
                                         set("Poisson ratio", "0.3")) +
                     subsection("Heat", set("Type", "Fourier") + set("Conductivity", "1"))) +
      subsection("Domain left", left) + subsection("Domain right", right) +
      subsection("Interface seam",
                 set("Type", "pointwise") + set("Source", "left : 1") + set("Destination", "right : 0")));
  Model<dim> &model = scene_model.model;
  BlockSystem<dim> system(model);
  Vector exact = system.owned_vector();
  interpolate<dim>(
      model, [](unsigned int, const unsigned int c, const dealii::Point<dim> &X) { return affine(c, X); },
      exact);
  const std::vector<double> all = gather(model, exact);

  ConstraintLines given;
  for (const auto &domain : model.domains)
    domain->add_constraints(1., given);
  TieConstraints all_constraints;
  all_constraints.lines = given;
  model.interfaces[0]->tie().parts().elimination->add_constraints(*model.interfaces[0], all_constraints,
                                                                  MPI_COMM_WORLD);
  const ConstraintLines &lines = all_constraints.lines;
  double error = 0, n_given = 0;
  bool keeps_given = true;
  for (const auto &[dof, line] : lines) {
    double value = line.inhomogeneity;
    for (const auto &[master, weight] : line.entries)
      value += weight * all[master];
    error = std::max(error, std::abs(value - all[dof]));
    if (const auto old = given.find(dof); old != given.end()) {
      ++n_given;
      keeps_given = keeps_given && line.entries.empty() && line.inhomogeneity == old->second.inhomogeneity;
    } else
      keeps_given = keeps_given && line.inhomogeneity == 0 && !line.entries.empty() &&
                    dof >= model.domains[1]->first_dof() && model.numbering->owned.is_element(dof) &&
                    line.entries[0].first < model.domains[1]->first_dof();
  }
  keeps_given = keeps_given && n_given == given.size();
  if (is_rank_0())
    std::cout << name << std::endl;
  print("  prescribed, tied", {dealii::Utilities::MPI::sum(n_given, MPI_COMM_WORLD),
                               dealii::Utilities::MPI::sum(lines.size() - n_given, MPI_COMM_WORLD)});
  report("  affine fields", error, 1e-12);
  report("  what is prescribed stays, what is tied follows the source", keeps_given);

  // constrained unknowns from the others
  system.set_up(1.);
  system.begin_step(1., exact);
  Vector x = exact, dx = system.owned_vector();
  for (const auto &[dof, line] : lines)
    x(dof) = noise(dof);
  x.compress(dealii::VectorOperation::insert);
  report("  defined", system.assemble(x, false));
  system.distribute(dx);
  x += dx;
  x -= exact;
  report("  closed constraints", x.linfty_norm(), 1e-12);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const unsigned int left : {1, 2})
    for (const unsigned int right : {1, 2})
      check<2>("2D, degrees " + std::to_string(left) + " and " + std::to_string(right),
               body<2>("0, 3", "0", left, box("2, 3 : 0, 0 : 1, 1")),
               body<2>("2", "1", right, box("3, 4 : 1.02, 0 : 2, 1")));
  check<3>("3D, degrees 1 and 2", body<3>("0, 2", "0", 1, box("1, 2, 3 : 0, 0, 0 : 1, 1, 1")),
           body<3>("4", "1", 2, box("1, 3, 2 : 1.02, 0, 0 : 2, 1, 1")));
  const auto ring = [](const std::string &arguments) {
    return subsection("Mesh",
                      set("Generator", "hyper_shell") + set("Arguments", "0, 0 : " + arguments + " : true"));
  };
  check<2>("rings", body<2>("0", "0", 2, ring("0.5 : 1 : 10")), body<2>("1", "1", 2, ring("1 : 1.5 : 15")));
}
