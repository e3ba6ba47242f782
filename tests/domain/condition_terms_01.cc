// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Conditions and body forces on a cell: the tangent at random states against central differences of the
// residual (relative error at most 1e-7), with a pressure that follows the deformed boundary, a spring, a
// centrifugal force at the deformed position, radiation and convection whose coefficients depend on the
// temperature, and values by Nitsche's method, for which the second
// derivatives of the laws count. Without the pressure a small-strain body has a symmetric tangent of the
// displacement, and the penalty alone makes it positive on every cell: its smallest eigenvalue is zero or
// positive, also for flat cells and nu = 0.49.
//
// ranks: 1, 2

#include "../system/scene_model.h"

#include <dovetail/domain/weak_penalties.h>

#include <deal.II/lac/lapack_full_matrix.h>

using namespace test;

template <int dim>
std::string scene(const std::string &solid, const unsigned int degree, const bool with_pressure)
{
  const std::string affine = dim == 2 ? "0.1*x; 0.05*y - 0.02*x" : "0.1*x; 0.05*y - 0.02*x; 0.03*z";
  const auto condition = [](const std::string &name, const std::string &entries) {
    return subsection("Boundary condition " + name, entries);
  };
  const auto weak = [](const std::string &field, const std::string &ids, const std::string &expression) {
    return set("Type", "value") + set("Field", field) + set("Boundary ids", ids) + set("Method", "Nitsche") +
           set("Expression", expression);
  };
  return set("Materials", "steel") + set("Domains", "body") +
         subsection("Material steel",
                    subsection("Solid", solid) +
                        subsection("Heat", set("Type", "Fourier") + set("Conductivity", "1 + 0.1*T^2"))) +
         subsection("Domain body",
                    set("Material", "steel") + set("Degree", std::to_string(degree)) +
                        set("Acceleration", dim == 2 ? "1; 2" : "1; 2; 3") + set("Angular velocity", "1.5") +
                        set("Boundary conditions",
                            std::string("clamp, warm, soil, glow, air") + (with_pressure ? ", gas" : "")) +
                        box(dim == 2 ? "3, 1 : 0, 0 : 3, 0.1" : "3, 1, 1 : 0, 0, 0 : 3, 0.2, 1") +
                        condition("clamp", weak("displacement", dim == 2 ? "0, 2" : "0, 2, 4", affine)) +
                        condition("warm", weak("temperature", "1, 2", "3 + x")) +
                        condition("soil", set("Type", "spring") + set("Boundary ids", "1") +
                                              set("Coefficient", dim == 2 ? "2; 1 + x" : "2; 1; 1 + x")) +
                        (with_pressure ? condition("gas", set("Type", "pressure") + set("Boundary ids", "3") +
                                                              set("Expression", "0.3 + x"))
                                       : "") +
                        condition("glow", set("Type", "radiation") + set("Field", "temperature") +
                                              set("Boundary ids", "0") + set("Coefficient", "0.2*T") +
                                              set("Ambient", "1") + set("Offset", "0.5")) +
                        condition("air", set("Type", "convection") + set("Field", "temperature") +
                                             set("Boundary ids", "3") + set("Coefficient", "1 + T^2") +
                                             set("Ambient", "x")));
}

/// The relative skew part of the displacement's block and its smallest eigenvalue over the largest.
template <int dim>
std::array<double, 2> symmetry_of(const dealii::FullMatrix<double> &tangent, const unsigned int n)
{
  dealii::FullMatrix<double> block(n, n), skew(n, n);
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int j = 0; j < n; ++j) {
      block(i, j) = (tangent(i, j) + tangent(j, i)) / 2;
      skew(i, j) = tangent(i, j) - block(i, j);
    }
  dealii::LAPACKFullMatrix<double> copy(n, n);
  copy = block;
  copy.compute_eigenvalues();
  double smallest = std::numeric_limits<double>::max(), largest = 0;
  for (unsigned int i = 0; i < n; ++i) {
    smallest = std::min(smallest, copy.eigenvalue(i).real());
    largest = std::max(largest, copy.eigenvalue(i).real());
  }
  return {{skew.frobenius_norm() / block.frobenius_norm(), smallest / largest}};
}

template <int dim>
void check(const std::string &name, const std::string &solid, const unsigned int degree,
           const bool with_pressure)
{
  SceneModel<dim> scene_model(scene<dim>(solid + set("Density", "0.7"), degree, with_pressure));
  Domain<dim> &domain = *scene_model.model.domains[0];
  freeze_weak_penalties<dim>(domain, 1.,
                             [](const auto &dofs, auto &values) { values.assign(dofs.size(), 0.); });
  const unsigned int n = domain.dofs_per_cell(), n_nodes = domain.layout().n_nodes(0);
  CellTerms<dim> terms(domain);
  std::vector<double> unknowns(n), residual(n), plus(n), minus(n);
  dealii::FullMatrix<double> tangent(n, n), difference(n, n);
  double error = 0, skew = 0, smallest = std::numeric_limits<double>::max();
  bool is_defined = true;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      for (unsigned int i = 0; i < n; ++i)
        unknowns[i] = i / n_nodes == dim ? 3 + noise(i) : 0.02 * noise(i);
      is_defined = terms.assemble(cell, 1., unknowns, residual, &tangent) && is_defined;
      const double h = 2e-6;
      for (unsigned int j = 0; j < n; ++j) {
        const double center = unknowns[j];
        unknowns[j] = center + h;
        is_defined = terms.assemble(cell, 1., unknowns, plus, nullptr) && is_defined;
        unknowns[j] = center - h;
        is_defined = terms.assemble(cell, 1., unknowns, minus, nullptr) && is_defined;
        unknowns[j] = center;
        for (unsigned int i = 0; i < n; ++i)
          difference(i, j) = (plus[i] - minus[i]) / (2 * h);
      }
      difference.add(-1, tangent);
      error = std::max(error, difference.frobenius_norm() / tangent.frobenius_norm());
      const auto of_cell = symmetry_of<dim>(tangent, dim * n_nodes);
      skew = std::max(skew, of_cell[0]);
      smallest = std::min(smallest, of_cell[1]);
    }
  print(std::to_string(dim) + "D, degree " + std::to_string(degree) + ", " + name, std::vector<double>());
  report("defined", is_defined);
  report("tangent", error, 1e-7);
  if (with_pressure)
    return;
  report("symmetric", skew, 1e-12);
  report("positive", std::max(0., -smallest), 1e-12);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string moduli = set("Young modulus", "2") + set("Poisson ratio", "0.3"),
                    nearly_incompressible = set("Young modulus", "2") + set("Poisson ratio", "0.49"),
                    expansion = set("Expansion coefficient", "0.03") + set("Reference temperature", "3");
  for (const unsigned int degree : {1, 2}) {
    check<2>("neo-Hookean, expanding", set("Type", "neo-Hookean") + moduli + expansion, degree, true);
    check<2>("linear elastic", set("Type", "linear elastic") + nearly_incompressible, degree, false);
    check<3>("linear elastic", set("Type", "linear elastic") + nearly_incompressible, degree, false);
  }
  check<3>("neo-Hookean", set("Type", "neo-Hookean") + moduli, 1, true);
}
