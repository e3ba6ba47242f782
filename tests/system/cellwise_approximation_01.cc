// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Solves in cells as an approximation of the tangent. In a box of equal cells that conducts heat, r is zero
// but inside of one cell. There, M^-1 r without its weights solves the rows of the closure of the cell
// exactly, in the middle and beside faces that are insulated or convect heat (1e-12), which the products of
// the tangent tell. With other laws, ties and hanging nodes, M^-1 is symmetric (1e-13) and the same on any
// number of ranks: y . M^-1 y is printed for two y. In single precision, M^-1 y is the same within 1e-5.
// Cells that are not stretched have no such approximation. The smoother's lambda is above the largest
// eigenvalue of M^-1 A, which a power iteration finds, also in a soft body that is tied to a stiff one.
//
// ranks: 1, 2, 3

#include "../../source/solve/chebyshev_smoother.h"
#include "scene_model.h"

#include <dovetail/solve/approximation.h>
#include <dovetail/solve/part_operator.h>
#include <dovetail/solve/row_numbering.h>

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_q.h>

#include <Epetra_Vector.h>

#include <iomanip>
#include <memory>
#include <sstream>

using namespace test;

namespace {

/// The tangent as products, and M^-1 of its first part.
template <int dim>
struct System : public LevelProducts
{
  explicit System(const std::string &prm) : scene(prm), system(scene.model)
  {
    system.choose_entries(std::vector<bool>(scene.model.field_groups().size(), false));
    system.set_up(1.);
    Vector x = system.owned_vector();
    interpolate<dim>(
        scene.model,
        [](unsigned int, const unsigned int c, const dealii::Point<dim> &X) {
          return 1e-3 * std::sin(3 * X[0] + (c + 1) * X[1]);
        },
        x);
    system.begin_step(1., x);
    system.assemble(x, true);
    const BlockMatrix &K = system.tangent();
    std::vector<unsigned int> blocks;
    for (unsigned int b = 0; b < K.n_block_rows(); ++b)
      if (K.part_of(b) == K.part_of(0))
        blocks.push_back(b);
    numbering = RowNumbering(K.owned_unknowns(), blocks, MPI_COMM_WORLD);
    cells = K.part_operator(K.part_of(0));
    entries = &K.part(K.part_of(0), K.part_of(0)).trilinos_matrix();
    M = solves_in_cells(false);
  }

  const Epetra_Map &rows() const override { return entries->OperatorDomainMap(); }
  void vmult(Epetra_Vector &y, const Epetra_Vector &x) const override
  {
    entries->Multiply(false, x, y);
    cells->add_product(1., x, y, true);
  }
  void diagonal(Epetra_Vector &values) const override
  {
    entries->ExtractDiagonalCopy(values);
    cells->add_diagonal(values);
  }
  std::unique_ptr<Approximation> solves_in_cells(const bool in_single_precision) const
  {
    Epetra_Vector values(rows());
    diagonal(values);
    return cells->cellwise_approximation(values, in_single_precision);
  }

  Vector approximate_inverse(const Vector &r, const Approximation &inverse) const
  {
    std::vector<double> values(numbering.n_local());
    numbering.gather(r, values.data());
    inverse.vmult(values.data(), values.data());
    Vector z = system.owned_vector();
    numbering.scatter(values.data(), z);
    return z;
  }
  Vector approximate_inverse(const Vector &r) const { return approximate_inverse(r, *M); }

  SceneModel<dim> scene;
  BlockSystem<dim> system;
  RowNumbering numbering;
  const PartOperator *cells = nullptr;
  const Epetra_CrsMatrix *entries = nullptr;
  std::unique_ptr<Approximation> M;
};

/// The first entry of the stiffness of a line of length one. Supports are rounded to quarters of an octave of
/// it.
double stiffness_of_end(const unsigned int degree)
{
  const dealii::QGauss<1> points(degree + 1);
  const dealii::FE_Q<1> element(degree);
  double sum = 0;
  for (unsigned int q = 0; q < points.size(); ++q)
    sum += points.weight(q) * std::pow(element.shape_grad(0, points.point(q))[0], 2);
  return sum;
}

/// @p support: by the conductivity and the length of a cell along x
template <int dim>
void check_one_cell(const std::string &name, const unsigned int degree, const std::string &cells,
                    const dealii::Point<dim> &centre, const double support = 0)
{
  std::ostringstream coefficient;
  coefficient << std::setprecision(17) << support;
  System<dim> of(
      set("Materials", "one") + set("Domains", "body") +
      subsection("Material one", subsection("Heat", set("Type", "Fourier") + set("Conductivity", "3"))) +
      subsection(
          "Domain body",
          set("Material", "one") + set("Degree", std::to_string(degree)) + box(cells) +
              set("Boundary conditions", "bath, air") +
              subsection("Boundary condition bath", set("Type", "value") + set("Field", "temperature") +
                                                        set("Boundary ids", "0") + set("Expression", "0")) +
              subsection("Boundary condition air", set("Type", "convection") + set("Field", "temperature") +
                                                       set("Boundary ids", "1") + set("Ambient", "0") +
                                                       set("Coefficient", coefficient.str()))));
  const Domain<dim> &domain = *of.scene.model.domains[0];
  Vector r = of.system.owned_vector(), n_cells = r, is_in_cell = r, product = r;
  std::vector<dealii::types::global_dof_index> dofs;
  dealii::Vector<double> ones(domain.dofs_per_cell());
  ones = 1;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      for (const auto dof : dofs)
        n_cells.add(std::vector<dealii::types::global_dof_index>{dof}, std::vector<double>{1.});
      if (cell->center().distance(centre) < 1e-6)
        for (const auto dof : dofs)
          is_in_cell.add(std::vector<dealii::types::global_dof_index>{dof}, std::vector<double>{1.});
    }
  n_cells.compress(dealii::VectorOperation::add);
  is_in_cell.compress(dealii::VectorOperation::add);
  for (const auto i : of.scene.model.numbering->owned)
    r(i) = is_in_cell(i) > 0.5 && n_cells(i) < 1.5 && !of.system.is_constrained(i) ? noise(i) : 0.;
  r.compress(dealii::VectorOperation::insert);
  Vector u = of.approximate_inverse(r);
  for (const auto i : of.scene.model.numbering->owned)
    u(i) = u(i) * std::sqrt(double(n_cells(i)));
  u.compress(dealii::VectorOperation::insert);
  of.system.tangent().vmult(product, u);
  double error = 0, outside = 0;
  for (const auto i : of.scene.model.numbering->owned)
    if (is_in_cell(i) < 0.5)
      outside = std::max(outside, std::abs(double(u(i))));
    else if (!of.system.is_constrained(i))
      error = std::max(error, std::abs(product(i) - r(i)));
  report(name + ", degree " + std::to_string(degree) + ", rows of the cell", error, 1e-12);
  report(name + ", degree " + std::to_string(degree) + ", zero elsewhere", outside, 0.);
}

template <int dim>
void check_properties(const std::string &name, const std::string &prm)
{
  const System<dim> of(prm);
  const auto function = [&](const double a) {
    Vector x = of.system.owned_vector();
    interpolate<dim>(
        of.scene.model,
        [a](const unsigned int d, const unsigned int c, const dealii::Point<dim> &X) {
          return std::sin(a * (X[0] + 2 * X[1] + d) + c) + (dim == 3 ? std::cos(7 * X[dim - 1]) : 0.);
        },
        x);
    for (const auto i : of.scene.model.numbering->owned)
      if (of.system.is_constrained(i))
        x(i) = 0;
    x.compress(dealii::VectorOperation::insert);
    return x;
  };
  const Vector a = function(17), b = function(11), Ma = of.approximate_inverse(a),
               Mb = of.approximate_inverse(b);
  report(name + ", symmetric", std::abs(Ma * b - Mb * a) / std::sqrt((Ma * a) * (Mb * b)), 1e-13);
  Vector difference = of.approximate_inverse(a, *of.solves_in_cells(true));
  difference -= Ma;
  report(name + ", single precision", difference.l2_norm() / Ma.l2_norm(), 1e-5);
  print(name, {Ma * a, Mb * b});
}

/// By as many power iterations as it takes, in the energy norm.
double largest_eigenvalue(const LevelProducts &A, const Approximation &M)
{
  Epetra_Vector x(A.rows()), Ax(A.rows()), MAx(A.rows());
  for (int i = 0; i < x.MyLength(); ++i)
    x[i] = std::sin(1e3 * (1 + A.rows().GID(i)));
  double result = 0, norm = 0;
  for (unsigned int k = 0; k < 300; ++k) {
    A.vmult(Ax, x);
    M.vmult(MAx.Values(), Ax.Values());
    double energy = 0;
    Ax.Dot(x, &energy);
    Ax.Dot(MAx, &result);
    result /= energy;
    MAx.Norm2(&norm);
    x.Update(1 / norm, MAx, 0.);
  }
  return result;
}

/// CG steps begin from below, and lambda has a margin of 1.2.
template <int dim>
void check_eigenvalue(const std::string &name, const std::string &prm)
{
  const System<dim> of(prm);
  const auto smoother = ChebyshevSmoother::with_approximation(of, of.solves_in_cells(false), {3, 15.});
  const double ratio = smoother->eigenvalue() / largest_eigenvalue(of, *of.M);
  report(name + ", lambda", ratio > 1 && ratio < 1.21);
}

std::string two_bodies(const unsigned int degree, const std::string &material, const std::string &tie,
                       const std::string &clamp, const std::string &of_mesh = "",
                       const std::string &modulus_on_the_left = "1")
{
  const auto solid = [&](const std::string &name, const std::string &modulus) {
    return subsection("Material " + name, subsection("Solid", set("Young modulus", modulus) +
                                                                  set("Poisson ratio", "0.3") + material));
  };
  const std::string common = set("Degree", std::to_string(degree)),
                    left = subsection("Boundary condition clamp",
                                      set("Type", "value") + set("Field", "displacement") +
                                          set("Boundary ids", "0") + set("Expression", clamp));
  const bool is_flat = clamp.size() < 5;
  return set("Materials", "one, two") + set("Domains", "left, right") + set("Interfaces", "seam") +
         solid("one", modulus_on_the_left) + solid("two", "1") +
         subsection("Domain left",
                    set("Material", "one") + common + set("Boundary conditions", "clamp") + left +
                        box(is_flat ? "6, 2 : 0, 0 : 9, 1" : "3, 2, 1 : 0, 0, 0 : 5, 1, 1", of_mesh)) +
         subsection("Domain right",
                    set("Material", "two") + common +
                        box(is_flat ? "3, 3 : 9, 0 : 12, 1" : "3, 1, 2 : 5, 0, 0 : 9, 1, 1")) +
         subsection("Interface seam", tie + set("Source", "left : 1") + set("Destination", "right : 0"));
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const unsigned int degree : {2, 3, 4}) {
    check_one_cell<2>("middle", degree, "4, 3 : 0, 0 : 12, 3", {4.5, 1.5});
    check_one_cell<2>("beside free faces", degree, "4, 3 : 0, 0 : 12, 3", {10.5, 0.5});
    check_one_cell<3>("beside free faces in 3D", degree, "2, 3, 1 : 0, 0, 0 : 6, 3, 1", {4.5, 1.5, 0.5});
    check_one_cell<3>("beside a convecting face in 3D", degree, "2, 3, 1 : 0, 0, 0 : 6, 3, 1",
                      {4.5, 1.5, 0.5}, 8 * stiffness_of_end(degree));
  }
  const std::string linear = set("Type", "linear elastic"), rubber = set("Type", "neo-Hookean"),
                    nitsche = set("Type", "Nitsche"),
                    dual = set("Type", "mortar") + set("Multiplier space", "dual"),
                    pointwise = set("Type", "pointwise");
  check_properties<2>("elastic", two_bodies(2, linear, nitsche, "0; 0"));
  check_properties<3>("rubber", two_bodies(3, rubber, nitsche, "0; 0; 0"));
  check_properties<2>("dual mortar", two_bodies(3, linear, dual, "0; 0"));
  check_properties<2>("pointwise", two_bodies(2, rubber, pointwise, "0; 0"));
  check_properties<2>("hanging nodes",
                      two_bodies(2, linear, nitsche, "0; 0", set("Refine boxes", "3; 0 : 6; 0.4")));
  for (const std::string modulus : {"1", "1e7"}) {
    check_eigenvalue<2>("contrast " + modulus, two_bodies(2, linear, nitsche, "0; 0", "", modulus));
    check_eigenvalue<3>("contrast " + modulus + " in 3D",
                        two_bodies(3, linear, nitsche, "0; 0; 0", "", modulus));
  }
  const System<2> squares(
      set("Materials", "one") + set("Domains", "body") +
      subsection("Material one",
                 subsection("Solid", linear + set("Young modulus", "1") + set("Poisson ratio", "0.3"))) +
      subsection("Domain body", set("Material", "one") + set("Degree", "2") + box("3, 2 : 0, 0 : 3, 2") +
                                    set("Boundary conditions", "clamp") +
                                    subsection("Boundary condition clamp",
                                               set("Type", "value") + set("Field", "displacement") +
                                                   set("Boundary ids", "0") + set("Expression", "0; 0"))));
  report("squares have none", squares.M == nullptr);
}
