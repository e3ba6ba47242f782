// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The cube of cube.prm as one conforming mesh, in plain deal.II: what one would write after step-8 and
// step-40. CG with ML, rigid-body modes as the near-null space, to the relative residual that Dovetail asks
// for.
//
//     plain_cube DEGREE N          N cells in each direction, N = coarse cells times a power of two
//
// Prints one line: unknowns, relative L2 error, CG iterations, seconds by phase and in all, largest memory of
// a rank.

#include <deal.II/base/conditional_ostream.h>
#include <deal.II/base/function.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/base/timer.h>
#include <deal.II/base/utilities.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/solver_cg.h>
#include <deal.II/lac/sparsity_tools.h>
#include <deal.II/lac/trilinos_precondition.h>
#include <deal.II/lac/trilinos_sparse_matrix.h>
#include <deal.II/lac/trilinos_vector.h>
#include <deal.II/numerics/vector_tools.h>

#include <Epetra_MultiVector.h>
#include <Teuchos_ParameterList.hpp>

#include <iostream>

using namespace dealii;

constexpr unsigned int dim = 3;
constexpr double nu = 0.3, lambda = nu / ((1 + nu) * (1 - 2 * nu)), mu = 1 / (2 * (1 + nu));
constexpr double phase[dim][dim] = {{0.5, 1.3, 0.9}, {1.1, 0.4, 0.7}, {0.8, 1.2, 0.3}};

/// u_i = prod_d sin(pi x_d + phase_id)
class ExactDisplacement : public Function<dim>
{
public:
  ExactDisplacement() : Function<dim>(dim) {}

  double value(const Point<dim> &x, const unsigned int i) const override
  {
    double product = 1;
    for (unsigned int d = 0; d < dim; ++d)
      product *= std::sin(numbers::PI * x[d] + phase[i][d]);
    return product;
  }
};

/// b = -mu Laplace u - (lambda + mu) grad div u
Tensor<1, dim> body_force(const Point<dim> &x)
{
  double s[dim][dim], c[dim][dim];
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int d = 0; d < dim; ++d) {
      s[i][d] = std::sin(numbers::PI * x[d] + phase[i][d]);
      c[i][d] = std::cos(numbers::PI * x[d] + phase[i][d]);
    }
  Tensor<1, dim> b;
  for (unsigned int i = 0; i < dim; ++i) {
    double of_divergence = -s[i][0] * s[i][1] * s[i][2]; // d_i d_j u_j over pi^2
    for (unsigned int j = 0; j < dim; ++j)
      if (j != i)
        of_divergence += c[j][i] * c[j][j] * s[j][dim - i - j];
    b[i] =
        numbers::PI * numbers::PI * (dim * mu * s[i][0] * s[i][1] * s[i][2] - (lambda + mu) * of_divergence);
  }
  return b;
}

class Elasticity
{
public:
  Elasticity(unsigned int degree, unsigned int n_cells);
  void run();

private:
  void make_mesh();
  void set_up();
  void assemble();
  unsigned int solve();
  double relative_error() const;
  Epetra_MultiVector rigid_body_modes() const;
  void print(unsigned int n_iterations, double error, double seconds) const;

  const MPI_Comm communicator = MPI_COMM_WORLD;
  const unsigned int degree, n_cells;
  parallel::distributed::Triangulation<dim> triangulation;
  const FESystem<dim> fe;
  DoFHandler<dim> dof_handler;
  IndexSet owned, relevant;
  AffineConstraints<double> constraints;
  TrilinosWrappers::SparseMatrix matrix;
  TrilinosWrappers::MPI::Vector right_hand_side, solution;
  TimerOutput timer;
};

Elasticity::Elasticity(const unsigned int degree, const unsigned int n_cells)
    : degree(degree), n_cells(n_cells), triangulation(communicator), fe(FE_Q<dim>(degree), dim),
      dof_handler(triangulation), timer(communicator, std::cout, TimerOutput::never, TimerOutput::wall_times)
{
}

void Elasticity::make_mesh()
{
  TimerOutput::Scope scope(timer, "mesh");
  unsigned int coarse = n_cells, n_refinements = 0;
  for (; coarse % 2 == 0; coarse /= 2)
    ++n_refinements;
  GridGenerator::subdivided_hyper_cube(triangulation, coarse);
  triangulation.refine_global(n_refinements);
  dof_handler.distribute_dofs(fe);
}

void Elasticity::set_up()
{
  TimerOutput::Scope scope(timer, "setup");
  owned = dof_handler.locally_owned_dofs();
  relevant = DoFTools::extract_locally_relevant_dofs(dof_handler);
  constraints.reinit(relevant);
  VectorTools::interpolate_boundary_values(dof_handler, 0, ExactDisplacement(), constraints);
  constraints.close();

  DynamicSparsityPattern pattern(relevant);
  DoFTools::make_sparsity_pattern(dof_handler, pattern, constraints, false);
  SparsityTools::distribute_sparsity_pattern(pattern, owned, communicator, relevant);
  matrix.reinit(owned, owned, pattern, communicator);
  right_hand_side.reinit(owned, communicator);
  solution.reinit(owned, relevant, communicator);
}

void Elasticity::assemble()
{
  TimerOutput::Scope scope(timer, "assembly");
  const QGauss<dim> quadrature(degree + 1);
  FEValues<dim> fe_values(fe, quadrature,
                          update_values | update_gradients | update_quadrature_points | update_JxW_values);
  const unsigned int n = fe.n_dofs_per_cell();
  FullMatrix<double> cell_matrix(n, n);
  Vector<double> cell_rhs(n);
  std::vector<types::global_dof_index> dofs(n);
  std::vector<unsigned int> component(n);
  for (unsigned int i = 0; i < n; ++i)
    component[i] = fe.system_to_component_index(i).first;
  std::vector<Tensor<1, dim>> gradient(n);

  for (const auto &cell : dof_handler.active_cell_iterators())
    if (cell->is_locally_owned()) {
      fe_values.reinit(cell);
      cell_matrix = 0;
      cell_rhs = 0;
      for (const unsigned int q : fe_values.quadrature_point_indices()) {
        const double JxW = fe_values.JxW(q);
        const Tensor<1, dim> b = body_force(fe_values.quadrature_point(q));
        for (unsigned int i = 0; i < n; ++i) {
          gradient[i] = fe_values.shape_grad(i, q);
          cell_rhs(i) += b[component[i]] * fe_values.shape_value(i, q) * JxW;
        }
        // (lambda div v div u + 2 mu eps(v):eps(u)), the lower half
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int j = 0; j <= i; ++j) {
            const unsigned int c_i = component[i], c_j = component[j];
            double value =
                lambda * gradient[i][c_i] * gradient[j][c_j] + mu * gradient[i][c_j] * gradient[j][c_i];
            if (c_i == c_j)
              value += mu * (gradient[i] * gradient[j]);
            cell_matrix(i, j) += value * JxW;
          }
      }
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int j = i + 1; j < n; ++j)
          cell_matrix(i, j) = cell_matrix(j, i);
      cell->get_dof_indices(dofs);
      constraints.distribute_local_to_global(cell_matrix, cell_rhs, dofs, matrix, right_hand_side);
    }
  matrix.compress(VectorOperation::add);
  right_hand_side.compress(VectorOperation::add);
}

/// Three translations, three rotations about the centre.
Epetra_MultiVector Elasticity::rigid_body_modes() const
{
  Epetra_MultiVector modes(matrix.trilinos_matrix().OperatorDomainMap(), 6);
  const Quadrature<dim> nodes(fe.get_unit_support_points());
  FEValues<dim> fe_values(fe, nodes, update_quadrature_points);
  std::vector<types::global_dof_index> dofs(fe.n_dofs_per_cell());
  for (const auto &cell : dof_handler.active_cell_iterators())
    if (cell->is_locally_owned()) {
      fe_values.reinit(cell);
      cell->get_dof_indices(dofs);
      for (unsigned int i = 0; i < dofs.size(); ++i)
        if (owned.is_element(dofs[i])) {
          const unsigned int row = owned.index_within_set(dofs[i]);
          const unsigned int c = fe.system_to_component_index(i).first;
          const Point<dim> x = fe_values.quadrature_point(i);
          modes[c][row] = 1;
          modes[3 + (c + 1) % 3][row] = x[(c + 2) % 3] - 0.5;
          modes[3 + (c + 2) % 3][row] = -(x[(c + 1) % 3] - 0.5);
        }
    }
  return modes;
}

unsigned int Elasticity::solve()
{
  TimerOutput::Scope scope(timer, "solve");
  const Epetra_MultiVector modes = rigid_body_modes();
  TrilinosWrappers::PreconditionAMG::AdditionalData data;
  data.elliptic = true;
  data.higher_order_elements = degree > 1;
  data.smoother_sweeps = 2;
  Teuchos::ParameterList parameters;
  std::unique_ptr<Epetra_MultiVector> unused;
  data.set_parameters(parameters, unused, matrix);
  parameters.set("null space: type", "pre-computed");
  parameters.set("null space: dimension", modes.NumVectors());
  parameters.set("null space: vectors", modes.Values());
  TrilinosWrappers::PreconditionAMG multigrid;
  multigrid.initialize(matrix, parameters);

  TrilinosWrappers::MPI::Vector owned_solution(owned, communicator);
  SolverControl control(1000, 1e-10 * right_hand_side.l2_norm());
  SolverCG<TrilinosWrappers::MPI::Vector>(control).solve(matrix, owned_solution, right_hand_side, multigrid);
  constraints.distribute(owned_solution);
  solution = owned_solution;
  return control.last_step();
}

double Elasticity::relative_error() const
{
  const QGauss<dim> quadrature(degree + 3);
  FEValues<dim> fe_values(fe, quadrature, update_values | update_quadrature_points | update_JxW_values);
  const FEValuesExtractors::Vector displacement(0);
  const ExactDisplacement exact;
  std::vector<Tensor<1, dim>> values(quadrature.size());
  double error = 0, norm = 0;
  for (const auto &cell : dof_handler.active_cell_iterators())
    if (cell->is_locally_owned()) {
      fe_values.reinit(cell);
      fe_values[displacement].get_function_values(solution, values);
      for (const unsigned int q : fe_values.quadrature_point_indices())
        for (unsigned int c = 0; c < dim; ++c) {
          const double u = exact.value(fe_values.quadrature_point(q), c);
          error += Utilities::fixed_power<2>(values[q][c] - u) * fe_values.JxW(q);
          norm += u * u * fe_values.JxW(q);
        }
    }
  return std::sqrt(Utilities::MPI::sum(error, communicator) / Utilities::MPI::sum(norm, communicator));
}

void Elasticity::print(const unsigned int n_iterations, const double error, const double seconds) const
{
  Utilities::System::MemoryStats memory;
  Utilities::System::get_memory_stats(memory);
  const double MiB = Utilities::MPI::sum(memory.VmHWM / 1024., communicator);
  ConditionalOStream out(std::cout, Utilities::MPI::this_mpi_process(communicator) == 0);
  out << "unknowns " << dof_handler.n_dofs() << "  error " << error << "  iterations " << n_iterations;
  for (const auto &[name, time] : timer.get_summary_data(TimerOutput::total_wall_time))
    out << "  " << name << ' ' << time;
  out << "  total " << seconds << "  MiB " << MiB << std::endl;
}

void Elasticity::run()
{
  Timer all;
  make_mesh();
  set_up();
  assemble();
  const unsigned int n_iterations = solve();
  double error = 0;
  {
    TimerOutput::Scope scope(timer, "measure");
    error = relative_error();
  }
  print(n_iterations, error, all.wall_time());
}

int main(int argc, char **argv)
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  if (argc != 3) {
    std::cerr << "plain_cube DEGREE N" << std::endl;
    return 1;
  }
  Elasticity(Utilities::string_to_int(argv[1]), Utilities::string_to_int(argv[2])).run();
}
