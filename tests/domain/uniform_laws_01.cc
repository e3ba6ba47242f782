// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Cells whose laws are uniform are not integrated point by point, and cells that are moved to each other
// share their shape functions. The same numbers come from the general way, which a law takes whose
// coefficient is a formula of x that is constant: residual, tangent and sizes of the terms agree to rounding
// (relative 1e-13) for tensors, orthotropic elasticity, sources and body forces, on boxes, distorted and
// curved cells, around an axis, at rest and at any other state, in any order of cells, with and without
// tangent. What the laws are asked is counted alike. Cells that differ by a relative 1e-10 are not equal: the
// areas of 64 of them in a row, whose lengths grow by 1e-10 of each other, are exact to 1e-14.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

#include <dovetail/domain/cell_terms.h>

#include <deal.II/grid/grid_tools.h>

#include <algorithm>
#include <limits>
#include <numeric>

using namespace test;

template <int dim>
std::string scene(const std::string &mesh, const unsigned int degree, const std::string &geometry,
                  const std::string &solid, const std::string &heat)
{
  const std::string force = dim == 2 ? "x*y; t + x^2" : "x*y; t + x^2; z";
  return set("Geometry", geometry) + set("Materials", "steel") + set("Domains", "body") +
         subsection("Material steel",
                    subsection("Solid", solid) +
                        subsection("Heat", set("Type", "Fourier") + set("Conductivity", heat))) +
         subsection(
             "Domain body",
             set("Material", "steel") + set("Degree", std::to_string(degree)) +
                 set("Boundary conditions", "clamp, air") + mesh +
                 subsection("Source", set("temperature", "2 + sin(x)*y") + set("displacement", force)) +
                 subsection("Boundary condition clamp",
                            set("Type", "value") + set("Field", "displacement") + set("Boundary ids", "0") +
                                set("Expression", dim == 2 ? "0; 0" : "0; 0; 0")) +
                 subsection("Boundary condition air",
                            set("Type", "convection") + set("Field", "temperature") +
                                set("Boundary ids", "0") + set("Coefficient", "3") + set("Ambient", "7")));
}

double relative_difference(const std::vector<double> &a, const std::vector<double> &b)
{
  double difference = 0, size = 0;
  for (unsigned int i = 0; i < a.size(); ++i) {
    difference = std::max(difference, std::abs(a[i] - b[i]));
    size = std::max(size, std::abs(b[i]));
  }
  return size == 0 ? difference : difference / size;
}

/// What one way gives for a cell.
struct Result
{
  bool is_defined;
  std::vector<double> residual, forces;
  dealii::FullMatrix<double> tangent;
};

template <int dim>
void assemble(CellTerms<dim> &terms, const typename Domain<dim>::cell_iterator &cell, const bool with_tangent,
              const std::vector<double> &unknowns, Result &result)
{
  result.residual.resize(unknowns.size());
  result.tangent.reinit(unknowns.size(), unknowns.size());
  result.is_defined =
      terms.assemble(cell, 0.5, unknowns, result.residual, with_tangent ? &result.tangent : nullptr);
  result.forces = terms.forces();
}

template <int dim>
std::vector<typename Domain<dim>::cell_iterator> cells_of(const Domain<dim> &domain)
{
  std::vector<typename Domain<dim>::cell_iterator> cells;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned())
      cells.push_back(cell);
  return cells;
}

/// The uniform way against the general one.
template <int dim>
void check(const std::string &name, const std::string &mesh, const unsigned int degree,
           const std::string &uniform_solid, const std::string &general_solid,
           const std::string &uniform_heat, const std::string &general_heat,
           const std::string &geometry = "plane strain")
{
  SceneModel<dim> uniform(scene<dim>(mesh, degree, geometry, uniform_solid, uniform_heat)),
      general(scene<dim>(mesh, degree, geometry, general_solid, general_heat));
  const Domain<dim> &domain = *uniform.model.domains[0], &other = *general.model.domains[0];
  const bool is_around_axis = geometry == "axisymmetric";
  report(std::to_string(dim) + "D, degree " + std::to_string(degree) + ", " + name + ": uniform",
         domain.material.is_uniform(0) == !is_around_axis && domain.material.is_uniform(1) &&
             !other.material.is_uniform(0) && !other.material.is_uniform(1));
  CellTerms<dim> terms(domain), other_terms(other);
  if (is_around_axis) // of which the displacement is never uniform
    for (CellTerms<dim> *cells : {&terms, &other_terms})
      cells->ask_for({Asked::nothing, Asked::derivatives});
  const auto cells = cells_of(domain), other_cells = cells_of(other);
  std::vector<double> unknowns(domain.dofs_per_cell());
  Result a, b;
  double error = 0, error_of_sizes = 0, error_of_tangent = 0;
  bool is_defined = true;
  for (unsigned int k = 0; k < 3 * cells.size(); ++k) {
    const unsigned int i = k < 2 * cells.size() ? k / 2 * (k % 2) : 3 * cells.size() - 1 - k; // and backwards
    const bool with_tangent = k % 5 != 3, is_at_rest = k % 3 == 1;
    for (unsigned int j = 0; j < unknowns.size(); ++j)
      unknowns[j] = is_at_rest ? 0 : noise(1000 * k + j);
    assemble(terms, cells[i], with_tangent, unknowns, a);
    assemble(other_terms, other_cells[i], with_tangent, unknowns, b);
    is_defined = is_defined && a.is_defined && b.is_defined;
    error = std::max(error, relative_difference(a.residual, b.residual));
    error_of_sizes = std::max(error_of_sizes, relative_difference(a.forces, b.forces));
    if (with_tangent) {
      const double size = b.tangent.frobenius_norm();
      b.tangent.add(-1, a.tangent);
      error_of_tangent = std::max(error_of_tangent, b.tangent.frobenius_norm() / size);
    }
  }
  report("defined", is_defined);
  report("residual", error, 1e-13);
  report("sizes of its terms", error_of_sizes, 1e-13);
  report("tangent", error_of_tangent, 1e-13);
  for (const std::string law : {"solid", "heat"})
    report("evaluations of " + law, domain.material.evaluations(law) == other.material.evaluations(law));
  // a state that is no number is not defined in both ways, and spoils nothing
  if (!cells.empty()) {
    unknowns.assign(unknowns.size(), std::numeric_limits<double>::infinity());
    assemble(terms, cells[0], true, unknowns, a);
    is_defined = a.is_defined;
    unknowns.assign(unknowns.size(), 1.5);
    assemble(terms, cells.back(), true, unknowns, a);
    assemble(other_terms, other_cells.back(), true, unknowns, b);
    is_defined = is_defined || !a.is_defined || relative_difference(a.residual, b.residual) > 1e-13;
  }
  report("no number", cells.empty() || !is_defined);
}

/// Of a row of cells with a source of 1: their areas.
void check_nearly_equal_cells()
{
  SceneModel<2> scene_model(
      set("Materials", "steel") + set("Domains", "body") +
      subsection("Material steel", subsection("Heat", set("Type", "Fourier") + set("Conductivity", "1"))) +
      subsection("Domain body",
                 set("Material", "steel") + box("64, 1 : 0, 0 : 64, 1") + set("Boundary conditions", "air") +
                     subsection("Source", set("temperature", "1")) +
                     subsection("Boundary condition air", set("Type", "value") + set("Field", "temperature") +
                                                              set("Boundary ids", "0") +
                                                              set("Expression", "0"))));
  Domain<2> &domain = *scene_model.model.domains[0];
  const double growth = 1e-10;
  dealii::GridTools::transform(
      [growth](const dealii::Point<2> &X) {
        return dealii::Point<2>(X[0] + 0.5 * growth * X[0] * X[0], X[1]);
      },
      const_cast<Mesh<2> &>(domain.mesh()));
  CellTerms<2> terms(domain);
  std::vector<double> unknowns(domain.dofs_per_cell(), 0.), residual(domain.dofs_per_cell());
  double error = 0;
  for (const auto &cell : cells_of(domain)) {
    terms.assemble(cell, 0., unknowns, residual, nullptr);
    const double area = cell->vertex(1)[0] - cell->vertex(0)[0];
    error = std::max(error, std::abs(std::accumulate(residual.begin(), residual.end(), 0.) / -area - 1));
  }
  report("areas of nearly equal cells", error, 1e-14);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string isotropic = set("Type", "linear elastic") + set("Poisson ratio", "0.3"),
                    young = isotropic + set("Young modulus", "2"),
                    young_of_x = isotropic + set("Young modulus", "2 + 0*x");
  const std::string orthotropic = set("Type", "orthotropic elastic") + set("Young moduli", "3, 2, 1") +
                                  set("Poisson ratios", "0.2, 0.1, 0.3") +
                                  set("Shear moduli", "0.5, 0.6, 0.7");
  const auto axes = [](const std::string &first, const std::string &second) {
    return set("First axis", first) + (second.empty() ? "" : set("Second axis", second));
  };
  const std::string squares = box("3, 2 : 0, 0 : 3, 1", set("Refinements", "1")),
                    cubes = box("2, 2, 1 : 0, 0, 0 : 3, 1, 2", set("Refinements", "1"));
  const auto other_mesh = [](const std::string &generator, const std::string &arguments) {
    return subsection("Mesh",
                      set("Generator", generator) + set("Arguments", arguments) + set("Refinements", "1"));
  };
  check<2>("boxes", squares, 1, young, young_of_x, "2", "2 + 0*x");
  check<2>("boxes, plane stress", squares, 2, young, young_of_x, "2; 1", "2 + 0*x; 1", "plane stress");
  check<2>("boxes, axes", squares, 1, orthotropic + axes("2; 1", ""), orthotropic + axes("2 + 0*x; 1", ""),
           "2; 0.5; -0.5; 3", "2 + 0*x; 0.5; -0.5; 3");
  check<2>("around an axis", squares, 1, young, young_of_x, "2", "2 + 0*x", "axisymmetric");
  check<2>("distorted", other_mesh("hyper_ball", "0, 0 : 1 : false"), 1, young, young_of_x, "2", "2 + 0*x");
  check<2>("curved", other_mesh("hyper_ball", "0, 0 : 1 : false"), 2, young, young_of_x, "2", "2 + 0*x");
  check<2>("cells of three sizes",
           box("3, 2 : 0, 0 : 3, 1", set("Refine at boundary ids", "0") + set("Local refinements", "2")), 1,
           young, young_of_x, "2", "2 + 0*x");
  check<3>("boxes", cubes, 1, young, young_of_x, "2", "2 + 0*x");
  check<3>("boxes, axes", cubes, 1, orthotropic + axes("2; 1; 0", "0; 0; 1"),
           orthotropic + axes("2; 1 + 0*x; 0", "0; 0; 1"), "2; 1; 3", "2; 1; 3 + 0*x");
  check<3>("curved", other_mesh("hyper_shell", "0, 0, 0 : 1 : 2 : 6 : true"), 2, young, young_of_x, "2",
           "2 + 0*x");
  check_nearly_equal_cells();
}
