// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The tangent of everything together, neo-Hookean bodies that conduct heat and expand, with convection,
// loads, Nitsche's tie (theta = 1 and -0.5) and a pointwise tie, condensed by all constraints: K v against
// central differences of the residual in random directions v that satisfy the constraints (relative error at
// most 1e-7). Unknowns that some rank does not own must not differ from those of their owner.
//
// ranks: 1, 2, 3

#include "scene_model.h"

using namespace test;

template <int dim>
std::string scene(const std::string &theta)
{
  const std::string zero = dim == 2 ? "0; 0" : "0; 0; 0", fields = set("Field", "displacement"),
                    from = dim == 2 ? "0" : "0, 0", to = dim == 2 ? "1" : "1, 1";
  const auto law = [](const std::string &conductivity, const std::string &alpha) {
    return subsection("Solid", set("Type", "neo-Hookean") + set("Young modulus", "2") +
                                   set("Poisson ratio", "0.3") + set("Expansion coefficient", alpha) +
                                   set("Reference temperature", "2")) +
           subsection("Heat", set("Type", "Fourier") + set("Conductivity", conductivity));
  };
  return set("Materials", "first, second") + set("Domains", "left, right, far") +
         set("Interfaces", "seam, glue") + subsection("Material first", law("1 + 0.1*T", "0.02")) +
         subsection("Material second", law("3", "0.05")) +
         subsection("Domain left", set("Material", "first") + set("Boundary conditions", "clamp, air") +
                                       subsection("Boundary condition clamp", set("Type", "value") + fields +
                                                                                  set("Boundary ids", "0") +
                                                                                  set("Expression", zero)) +
                                       subsection("Boundary condition air",
                                                  set("Type", "convection") + set("Field", "temperature") +
                                                      set("Boundary ids", "0, 2") +
                                                      set("Coefficient", "1 + x") + set("Ambient", "4")) +
                                       box(dim == 2 ? "2, 2 : 0, 0 : 1, 1" : "1, 2, 1 : 0, 0, 0 : 1, 1, 1")) +
         subsection("Domain right",
                    set("Material", "second") + (dim == 2 ? set("Degree", "2") : "") +
                        set("Boundary conditions", "pull") +
                        subsection("Boundary condition pull",
                                   set("Type", "flux") + fields + set("Boundary ids", "3") +
                                       set("Expression", dim == 2 ? "0.1; 0.2" : "0.1; 0.2; 0.1")) +
                        box((dim == 2 ? "2, 3 : 1.01, " : "1, 1, 2 : 1.01, ") + from + " : 2, " + to)) +
         subsection("Domain far", set("Material", "first") + box((dim == 2 ? "1, 2 : 2, " : "1, 2, 2 : 2, ") +
                                                                 from + " : 3, " + to)) +
         subsection("Interface seam", set("Type", "Nitsche") + set("Source", "left : 1") +
                                          set("Destination", "right : 0") + set("Theta", theta) +
                                          set("Integrate on", "both")) +
         subsection("Interface glue",
                    set("Type", "pointwise") + set("Source", "far : 0") + set("Destination", "right : 1"));
}

template <int dim>
void check(const std::string &theta)
{
  SceneModel<dim> scene_model(scene<dim>(theta));
  Model<dim> &model = scene_model.model;
  BlockSystem<dim> system(model);
  system.set_up(1.);
  const dealii::IndexSet &owned = model.numbering->owned;

  // any x, moved onto the constraints
  Vector x = system.owned_vector(), dx = system.owned_vector();
  interpolate<dim>(
      model,
      [](const unsigned int d, const unsigned int c, const dealii::Point<dim> &X) {
        const double wave = std::sin(5 * X[0] + 3 * X[1] + c + d);
        return c == dim ? 3 + wave : 0.04 * wave;
      },
      x);
  system.begin_step(1., x);
  bool is_defined = system.assemble(x, false);
  system.distribute(dx);
  x += dx;
  is_defined = system.assemble(x, true) && is_defined;
  report("x satisfies the constraints", !system.moves_constraints());

  double error = 0, symmetry = 0;
  Vector of_tangent = system.owned_vector(), previous = system.owned_vector(),
         of_previous = system.owned_vector();
  for (unsigned int direction = 0; direction < 6; ++direction) {
    Vector v = system.owned_vector(), free = system.owned_vector(), y = system.owned_vector();
    for (const auto dof : owned)
      v(dof) = noise(dof + 1000 * direction);
    v.compress(dealii::VectorOperation::insert);
    free = v;
    system.assemble(x, false);
    system.distribute(v);
    // what distribute() has changed is constrained
    for (const auto dof : owned)
      if (v(dof) != free(dof))
        free(dof) = 0;
    free.compress(dealii::VectorOperation::insert);
    system.tangent().vmult(of_tangent, free);

    const double h = 1e-5;
    y = x;
    y.add(h, v);
    is_defined = system.assemble(y, false) && is_defined;
    Vector difference = system.negative_residual();
    y.add(-2 * h, v);
    is_defined = system.assemble(y, false) && is_defined;
    difference -= system.negative_residual();
    difference *= -1 / (2 * h);
    difference -= of_tangent;
    error = std::max(error, difference.l2_norm() / of_tangent.l2_norm());
    if (direction > 0)
      symmetry = std::max(symmetry, std::abs(previous * of_tangent - free * of_previous));
    previous = free;
    of_previous = of_tangent;
  }
  report("every state is defined", is_defined);
  report(std::to_string(dim) + "D, theta " + theta + ": tangent", error, 1e-7);
  report("with heat it is not symmetric", symmetry > 1e-3);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check<2>("1");
  check<2>("-0.5");
  check<3>("1");
}
