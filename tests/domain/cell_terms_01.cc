// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The weak form on a cell at random states: the tangent against central differences of the residual (relative
// error at most 1e-7), with all flux conditions and sources; where a field does not depend on another, the
// tangent vanishes. By hand: for constant test functions only loads are left, so the residual of T = 5 with a
// source of 2 and a convection of 3 (7 - T) on one side is, summed over the domain, -2 |Omega| - 6 |Gamma|,
// and a dead load of (1, 2) gives -(1, 2) |Gamma|; around an axis |Omega| = 9 pi and |Gamma| = 6 pi.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

using namespace test;

template <int dim>
std::string scene(const std::string &solid, const std::string &heat, const unsigned int degree,
                  const bool is_curved, const std::string &geometry)
{
  const std::string zero = dim == 2 ? "0; 0" : "0; 0; 0";
  const std::string mesh =
      is_curved ? subsection("Mesh", set("Generator", "hyper_shell") +
                                         set("Arguments", dim == 2 ? "0, 0 : 1 : 2 : 5 : true"
                                                                   : "0, 0, 0 : 1 : 2 : 6 : true"))
                : box(dim == 2 ? "3, 1 : 0, 0 : 3, 1" : "3, 1, 1 : 0, 0, 0 : 3, 1, 1");
  return set("Geometry", geometry) + set("Materials", "steel") + set("Domains", "body") +
         subsection("Material steel",
                    subsection("Solid", solid) +
                        subsection("Heat", set("Type", "Fourier") + set("Conductivity", heat))) +
         subsection(
             "Domain body",
             set("Material", "steel") + set("Degree", std::to_string(degree)) +
                 set("Boundary conditions", "clamp, air, pull") + mesh +
                 subsection("Source", set("temperature", "2")) +
                 subsection("Boundary condition clamp", set("Type", "value") + set("Field", "displacement") +
                                                            set("Boundary ids", "0") +
                                                            set("Expression", zero)) +
                 subsection("Boundary condition air",
                            set("Type", "convection") + set("Field", "temperature") +
                                set("Boundary ids", "1") + set("Coefficient", "3") + set("Ambient", "7")) +
                 subsection("Boundary condition pull", set("Type", "flux") + set("Field", "displacement") +
                                                           set("Boundary ids", "1") +
                                                           set("Expression", dim == 2 ? "1; 2" : "1; 2; 0")));
}

template <int dim>
void check(const std::string &name, const std::string &solid, const std::string &heat,
           const unsigned int degree, const bool is_curved, const std::string &geometry = "plane strain")
{
  SceneModel<dim> scene_model(scene<dim>(solid, heat, degree, is_curved, geometry));
  const Domain<dim> &domain = *scene_model.model.domains[0];
  const unsigned int n = domain.dofs_per_cell(), n_nodes = domain.layout().n_nodes(0);
  CellTerms<dim> terms(domain);
  std::vector<double> unknowns(n), residual(n), plus(n), minus(n), sum(dim + 1, 0.);
  dealii::FullMatrix<double> tangent(n, n), difference(n, n);
  double error = 0, coupling = 0;
  bool is_defined = true;
  unsigned int n_cells = 0;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      for (unsigned int i = 0; i < n; ++i)
        unknowns[i] = i / n_nodes == dim ? 5 : 0;
      is_defined = terms.assemble(cell, 1., unknowns, residual, nullptr) && is_defined;
      for (unsigned int i = 0; i < n; ++i)
        sum[i / n_nodes] += residual[i];
      if (++n_cells > 2)
        continue;

      for (unsigned int i = 0; i < n; ++i)
        unknowns[i] = i / n_nodes == dim ? 3 + noise(i) : 0.05 * noise(i);
      is_defined = terms.assemble(cell, 1., unknowns, residual, &tangent) && is_defined;
      const double h = 1e-5;
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
      // heat does not depend on the displacement
      for (unsigned int i = dim * n_nodes; i < n; ++i)
        for (unsigned int j = 0; j < dim * n_nodes; ++j)
          coupling = std::max(coupling, std::abs(tangent(i, j)));
    }
  const std::string of_dim = std::to_string(dim) + "D, degree " + std::to_string(degree) + ", " + name;
  report(of_dim + ": defined", is_defined);
  report("tangent", error, 1e-7);
  report("no coupling", coupling, 0.);
  dealii::Utilities::MPI::sum(sum, MPI_COMM_WORLD, sum);
  print("sums of the residual", sum);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string moduli = set("Young modulus", "2") + set("Poisson ratio", "0.3"),
                    expansion = set("Expansion coefficient", "0.03") + set("Reference temperature", "5");
  check<2>("linear elastic", set("Type", "linear elastic") + moduli, "2", 1, false);
  check<2>("neo-Hookean, expanding", set("Type", "neo-Hookean") + moduli + expansion, "1 + 0.1*T^2", 1,
           false);
  check<2>("neo-Hookean, curved", set("Type", "neo-Hookean") + moduli + expansion, "1; 0.1*T; 0; 2", 2, true);
  check<2>("Saint Venant-Kirchhoff", set("Type", "Saint Venant-Kirchhoff") + moduli + expansion, "1 + x", 2,
           false);
  check<2>("neo-Hookean, axisymmetric", set("Type", "neo-Hookean") + moduli + expansion, "1 + 0.1*T^2", 1,
           false, "axisymmetric");
  check<2>("linear elastic, axisymmetric", set("Type", "linear elastic") + moduli + expansion, "2", 2, false,
           "axisymmetric");
  check<3>("neo-Hookean, expanding", set("Type", "neo-Hookean") + moduli + expansion, "1 + 0.1*T", 1, false);
  check<3>("linear elastic, curved", set("Type", "linear elastic") + moduli + expansion, "1 + 0.1*T", 1,
           true);
}
