// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Residual and tangent of a deformed neo-Hookean cube by Dovetail and by a loop in plain deal.II, in turn in
// one process. The loop is what one would write after step-44: with the Kirchhoff stress tau and its spatial
// tensor Jc,
//
//     K_ij = int eps(phi_i):Jc:eps(phi_j) + grad phi_i . tau grad phi_j dV,   gradients in space,
//
// of the lower half of a cell's matrix. Dovetail assembles it with entries and without (matrix-free), and two
// metals in small displacements, elastic and plastic, of which the second does not yield.
//
//     plain_tangents DEGREE N          N cells in each direction
//
// Prints one line: unknowns, the relative difference of the norms of both matrices, and the processor seconds
// of one assembly, and of reading the matrix once in a product with a vector, each the median of five.

#include <dovetail/scene/scene_text.h>
#include <dovetail/system/block_system.h>

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/base/symmetric_tensor.h>
#include <deal.II/base/utilities.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/sparse_matrix.h>
#include <deal.II/physics/elasticity/standard_tensors.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <iostream>

namespace {

using namespace dealii;
using std::to_string;

constexpr unsigned int dim = 3;
constexpr double shear = 0.4, bulk = 2;

/// Of component i of the displacement at X, which is held at x = 0.
double displacement(const unsigned int i, const Point<dim> &X)
{
  return 0.05 * std::sin(2 * X[i] + X[(i + 1) % dim] + 0.3 * i) * X[0];
}

/// The loop in plain deal.II.
class Plain
{
public:
  Plain(const Triangulation<dim> &mesh, unsigned int degree);
  void assemble();

  SparseMatrix<double> matrix;
  Vector<double> right_hand_side;

private:
  using Symmetric = SymmetricTensor<2, dim>;
  struct AtPoint
  {
    Symmetric tau;
    SymmetricTensor<4, dim> Jc;
  };
  static AtPoint respond(const Tensor<2, dim> &F);
  void add_point(unsigned int q, const Tensor<2, dim> &F);

  const FESystem<dim> fe;
  DoFHandler<dim> dof_handler;
  AffineConstraints<double> constraints;
  SparsityPattern pattern;
  Vector<double> solution;
  FEValues<dim> fe_values;
  FullMatrix<double> cell_matrix;
  Vector<double> cell_rhs;
  std::vector<Tensor<2, dim>> grad;
  std::vector<Symmetric> symmetric_grad;
};

Plain::Plain(const Triangulation<dim> &mesh, const unsigned int degree)
    : fe(FE_Q<dim>(degree), dim), dof_handler(mesh),
      fe_values(fe, QGauss<dim>(degree + 1), update_gradients | update_JxW_values),
      cell_matrix(fe.n_dofs_per_cell(), fe.n_dofs_per_cell()), cell_rhs(fe.n_dofs_per_cell()),
      grad(fe.n_dofs_per_cell()), symmetric_grad(fe.n_dofs_per_cell())
{
  dof_handler.distribute_dofs(fe);
  DoFTools::make_zero_boundary_constraints(dof_handler, 0, constraints);
  constraints.close();
  DynamicSparsityPattern dynamic(dof_handler.n_dofs());
  DoFTools::make_sparsity_pattern(dof_handler, dynamic, constraints, false);
  pattern.copy_from(dynamic);
  matrix.reinit(pattern);
  right_hand_side.reinit(dof_handler.n_dofs());
  solution.reinit(dof_handler.n_dofs());
  FEValues<dim> nodes(fe, Quadrature<dim>(fe.get_unit_support_points()), update_quadrature_points);
  std::vector<types::global_dof_index> dofs(fe.n_dofs_per_cell());
  for (const auto &cell : dof_handler.active_cell_iterators()) {
    nodes.reinit(cell);
    cell->get_dof_indices(dofs);
    for (unsigned int i = 0; i < dofs.size(); ++i)
      solution[dofs[i]] = displacement(fe.system_to_component_index(i).first, nodes.quadrature_point(i));
  }
}

/// tau = mu dev b_bar + kappa/2 (J² - 1) I
Plain::AtPoint Plain::respond(const Tensor<2, dim> &F)
{
  using Tensors = Physics::Elasticity::StandardTensors<dim>;
  const double J = determinant(F), pressure = bulk / 2 * (J * J - 1);
  const Symmetric tau_bar = shear * std::pow(J, -2. / dim) * symmetrize(F * transpose(F));
  const Symmetric tau_iso = Tensors::dev_P * tau_bar;
  return {tau_iso + pressure * Tensors::I,
          2. / dim *
                  (trace(tau_bar) * Tensors::dev_P - outer_product(tau_iso, Tensors::I) -
                   outer_product(Tensors::I, tau_iso)) +
              bulk * J * J * Tensors::IxI - 2 * pressure * Tensors::S};
}

void Plain::add_point(const unsigned int q, const Tensor<2, dim> &F)
{
  const auto [tau, Jc] = respond(F);
  const Tensor<2, dim> inverse = invert(F), stress = tau;
  const double JxW = fe_values.JxW(q);
  for (unsigned int i = 0; i < fe.n_dofs_per_cell(); ++i) {
    grad[i] = fe_values[FEValuesExtractors::Vector(0)].gradient(i, q) * inverse;
    symmetric_grad[i] = symmetrize(grad[i]);
  }
  for (unsigned int i = 0; i < fe.n_dofs_per_cell(); ++i) {
    const unsigned int c = fe.system_to_component_index(i).first;
    const Symmetric flux = symmetric_grad[i] * Jc;
    const Tensor<1, dim> traction = grad[i][c] * stress;
    cell_rhs(i) -= symmetric_grad[i] * tau * JxW;
    for (unsigned int j = 0; j <= i; ++j) {
      cell_matrix(i, j) += flux * symmetric_grad[j] * JxW;
      if (fe.system_to_component_index(j).first == c)
        cell_matrix(i, j) += traction * grad[j][c] * JxW;
    }
  }
}

void Plain::assemble()
{
  matrix = 0;
  right_hand_side = 0;
  std::vector<Tensor<2, dim>> gradients(fe_values.n_quadrature_points);
  std::vector<types::global_dof_index> dofs(fe.n_dofs_per_cell());
  for (const auto &cell : dof_handler.active_cell_iterators()) {
    fe_values.reinit(cell);
    fe_values[FEValuesExtractors::Vector(0)].get_function_gradients(solution, gradients);
    cell_matrix = 0;
    cell_rhs = 0;
    for (const unsigned int q : fe_values.quadrature_point_indices())
      add_point(q, gradients[q] + Physics::Elasticity::StandardTensors<dim>::I);
    for (unsigned int i = 0; i < fe.n_dofs_per_cell(); ++i)
      for (unsigned int j = i + 1; j < fe.n_dofs_per_cell(); ++j)
        cell_matrix(i, j) = cell_matrix(j, i);
    cell->get_dof_indices(dofs);
    constraints.distribute_local_to_global(cell_matrix, cell_rhs, dofs, matrix, right_hand_side);
  }
}

std::string scene_text(const std::string &law, const unsigned int degree, const unsigned int n)
{
  const std::string cells = to_string(n);
  return R"(set Dimension = 3
set Materials = stuff
set Domains   = cube
subsection Material stuff
  subsection Solid
    set Shear modulus = 0.4      # Pa
    set Bulk modulus  = 2
)" + law +
         R"(
  end
end
subsection Domain cube
  set Material            = stuff
  set Boundary conditions = clamp
  set Degree              = )" +
         to_string(degree) + R"(
  subsection Mesh
    set Generator = subdivided_hyper_rectangle
    set Arguments = )" +
         cells + ", " + cells + ", " + cells + R"( : 0, 0, 0 : 1, 1, 1 : true
  end
  subsection Boundary condition clamp
    set Type         = value
    set Field        = displacement
    set Boundary ids = 0
    set Expression   = 0; 0; 0
  end
end
)";
}

/// A scene's system at the displacement, times @p size.
class Dovetail
{
public:
  Dovetail(const std::string &law, unsigned int degree, unsigned int n, bool has_entries, double size);
  void assemble() { AssertThrow(system.assemble(x, true), ExcMessage("A law is not defined.")); }
  double norm() const { return system.tangent().part(0, 0).frobenius_norm(); }
  const Triangulation<dim> &mesh() const { return model.domains[0]->mesh(); }

private:
  std::shared_ptr<dovetail::SceneText> text;
  dovetail::Section scene;
  dovetail::Model<dim> model;
  dovetail::BlockSystem<dim> system;
  dovetail::Vector x;
};

Dovetail::Dovetail(const std::string &law, const unsigned int degree, const unsigned int n,
                   const bool has_entries, const double size)
    : text(dovetail::SceneText::from_prm(scene_text(law, degree, n))), scene(dovetail::SceneText::root(text)),
      model(scene, MPI_COMM_WORLD), system(model)
{
  model.pair();
  system.choose_entries({has_entries});
  system.set_up(0);
  x = system.owned_vector();
  const dovetail::Domain<dim> &domain = *model.domains[0];
  const auto &element = domain.layout().element(0);
  FEValues<dim> nodes(domain.mapping(), element, Quadrature<dim>(element.get_unit_support_points()),
                      update_quadrature_points);
  std::vector<types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators()) {
    nodes.reinit(typename Triangulation<dim>::active_cell_iterator(cell));
    domain.cell_dofs(cell, dofs);
    for (unsigned int c = 0; c < dim; ++c)
      for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
        x(dofs[domain.layout().index(c, a)]) = size * displacement(c, nodes.quadrature_point(a));
  }
  x.compress(VectorOperation::insert);
  system.begin_step(0, x);
}

/// Reads the matrix once, as a product with a vector does.
struct Stream
{
  explicit Stream(const Plain &plain) : plain(plain), product(plain.right_hand_side) {}
  void assemble() { plain.matrix.vmult(product, plain.right_hand_side); }

  const Plain &plain;
  Vector<double> product;
};

template <typename Assembly>
double seconds(Assembly &assembly)
{
  const std::clock_t start = std::clock();
  assembly.assemble();
  return double(std::clock() - start) / CLOCKS_PER_SEC;
}

double median(std::vector<double> values)
{
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

void run(const unsigned int degree, const unsigned int n)
{
  const std::string rubber = "set Type = neo-Hookean", steel = "set Type = linear elastic",
                    yielding = "set Type = J2 plasticity\nset Yield stress = 1e6";
  Dovetail entries(rubber, degree, n, true, 1), products(rubber, degree, n, false, 1),
      elastic(steel, degree, n, true, 1e-3), plastic(yielding, degree, n, true, 1e-3);
  Plain plain(entries.mesh(), degree);
  Stream stream(plain);
  std::vector<double> times[6];
  for (unsigned int i = 0; i < 5; ++i) {
    times[0].push_back(seconds(plain));
    times[1].push_back(seconds(entries));
    times[2].push_back(seconds(products));
    times[3].push_back(seconds(elastic));
    times[4].push_back(seconds(plastic));
    times[5].push_back(seconds(stream));
  }
  std::cout << "unknowns " << plain.right_hand_side.size() << " difference "
            << std::abs(entries.norm() / plain.matrix.frobenius_norm() - 1) << " plain " << median(times[0])
            << " entries " << median(times[1]) << " products " << median(times[2]) << " elastic "
            << median(times[3]) << " plastic " << median(times[4]) << " stream " << median(times[5])
            << std::endl;
}

} // namespace

int main(int argc, char **argv)
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  if (argc != 3) {
    std::cerr << "plain_tangents DEGREE N" << std::endl;
    return 1;
  }
  run(Utilities::string_to_int(argv[1]), Utilities::string_to_int(argv[2]));
}
