// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The scenes beside this file in plain deal.II: step-40 with a smooth solution, without its adaptive cycles.
// Conjugate gradients with ML, to the relative residual that Dovetail asks for.
//
//     plain_heat DIMENSION DEGREE N [error]    N cells in each direction, N = coarse cells times a power of
//     two
//
// Prints one line: unknowns, relative L2 error (-1 if it is not asked for), CG iterations, seconds by phase
// and in all, the sum of the ranks' largest memory.

#include <deal.II/base/conditional_ostream.h>
#include <deal.II/base/function.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/base/timer.h>
#include <deal.II/base/utilities.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
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

#include <iostream>

using namespace dealii;

/// T = prod_d sin(2 x_d + (d + 1) / 2), so that -Laplace T = 4 dim T
template <int dim>
class ExactTemperature : public Function<dim>
{
public:
  double value(const Point<dim> &x, const unsigned int = 0) const override
  {
    double product = 1;
    for (unsigned int d = 0; d < dim; ++d)
      product *= std::sin(2 * x[d] + 0.5 * (d + 1));
    return product;
  }
};

template <int dim>
class Heat
{
public:
  Heat(unsigned int degree, unsigned int n_cells);
  void run(bool with_error);

private:
  void make_mesh();
  void set_up();
  void assemble();
  unsigned int solve();
  double relative_error() const;
  void print(unsigned int n_iterations, double error, double seconds) const;

  const MPI_Comm communicator = MPI_COMM_WORLD;
  const unsigned int degree, n_cells;
  parallel::distributed::Triangulation<dim> triangulation;
  const FE_Q<dim> fe;
  DoFHandler<dim> dof_handler;
  IndexSet owned, relevant;
  AffineConstraints<double> constraints;
  TrilinosWrappers::SparseMatrix matrix;
  TrilinosWrappers::MPI::Vector right_hand_side, solution;
  TimerOutput timer;
};

template <int dim>
Heat<dim>::Heat(const unsigned int degree, const unsigned int n_cells)
    : degree(degree), n_cells(n_cells), triangulation(communicator), fe(degree), dof_handler(triangulation),
      timer(communicator, std::cout, TimerOutput::never, TimerOutput::wall_times)
{
}

template <int dim>
void Heat<dim>::make_mesh()
{
  TimerOutput::Scope scope(timer, "mesh");
  unsigned int coarse = n_cells, n_refinements = 0;
  for (; coarse % 2 == 0; coarse /= 2)
    ++n_refinements;
  GridGenerator::subdivided_hyper_cube(triangulation, coarse);
  triangulation.refine_global(n_refinements);
  dof_handler.distribute_dofs(fe);
}

template <int dim>
void Heat<dim>::set_up()
{
  TimerOutput::Scope scope(timer, "setup");
  owned = dof_handler.locally_owned_dofs();
  relevant = DoFTools::extract_locally_relevant_dofs(dof_handler);
  constraints.reinit(relevant);
  VectorTools::interpolate_boundary_values(dof_handler, 0, ExactTemperature<dim>(), constraints);
  constraints.close();

  DynamicSparsityPattern pattern(relevant);
  DoFTools::make_sparsity_pattern(dof_handler, pattern, constraints, false);
  SparsityTools::distribute_sparsity_pattern(pattern, owned, communicator, relevant);
  matrix.reinit(owned, owned, pattern, communicator);
  right_hand_side.reinit(owned, communicator);
  solution.reinit(owned, relevant, communicator);
}

template <int dim>
void Heat<dim>::assemble()
{
  TimerOutput::Scope scope(timer, "assembly");
  const QGauss<dim> quadrature(degree + 1);
  FEValues<dim> fe_values(fe, quadrature,
                          update_values | update_gradients | update_quadrature_points | update_JxW_values);
  const unsigned int n = fe.n_dofs_per_cell();
  FullMatrix<double> cell_matrix(n, n);
  Vector<double> cell_rhs(n);
  std::vector<types::global_dof_index> dofs(n);
  const ExactTemperature<dim> exact;
  for (const auto &cell : dof_handler.active_cell_iterators())
    if (cell->is_locally_owned()) {
      fe_values.reinit(cell);
      cell_matrix = 0;
      cell_rhs = 0;
      for (const unsigned int q : fe_values.quadrature_point_indices()) {
        const double source = 4 * dim * exact.value(fe_values.quadrature_point(q));
        for (unsigned int i = 0; i < n; ++i) {
          for (unsigned int j = 0; j < n; ++j)
            cell_matrix(i, j) += fe_values.shape_grad(i, q) * fe_values.shape_grad(j, q) * fe_values.JxW(q);
          cell_rhs(i) += source * fe_values.shape_value(i, q) * fe_values.JxW(q);
        }
      }
      cell->get_dof_indices(dofs);
      constraints.distribute_local_to_global(cell_matrix, cell_rhs, dofs, matrix, right_hand_side);
    }
  matrix.compress(VectorOperation::add);
  right_hand_side.compress(VectorOperation::add);
}

template <int dim>
unsigned int Heat<dim>::solve()
{
  TimerOutput::Scope scope(timer, "solve");
  TrilinosWrappers::PreconditionAMG::AdditionalData data;
  data.elliptic = true;
  data.higher_order_elements = degree > 1;
  data.smoother_sweeps = 2;
  TrilinosWrappers::PreconditionAMG multigrid;
  multigrid.initialize(matrix, data);

  TrilinosWrappers::MPI::Vector owned_solution(owned, communicator);
  SolverControl control(1000, 1e-10 * right_hand_side.l2_norm());
  SolverCG<TrilinosWrappers::MPI::Vector>(control).solve(matrix, owned_solution, right_hand_side, multigrid);
  constraints.distribute(owned_solution);
  solution = owned_solution;
  return control.last_step();
}

template <int dim>
double Heat<dim>::relative_error() const
{
  const QGauss<dim> quadrature(degree + 3);
  FEValues<dim> fe_values(fe, quadrature, update_values | update_quadrature_points | update_JxW_values);
  const ExactTemperature<dim> exact;
  std::vector<double> values(quadrature.size());
  double error = 0, norm = 0;
  for (const auto &cell : dof_handler.active_cell_iterators())
    if (cell->is_locally_owned()) {
      fe_values.reinit(cell);
      fe_values.get_function_values(solution, values);
      for (const unsigned int q : fe_values.quadrature_point_indices()) {
        const double T = exact.value(fe_values.quadrature_point(q));
        error += Utilities::fixed_power<2>(values[q] - T) * fe_values.JxW(q);
        norm += T * T * fe_values.JxW(q);
      }
    }
  return std::sqrt(Utilities::MPI::sum(error, communicator) / Utilities::MPI::sum(norm, communicator));
}

template <int dim>
void Heat<dim>::print(const unsigned int n_iterations, const double error, const double seconds) const
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

template <int dim>
void Heat<dim>::run(const bool with_error)
{
  Timer all;
  make_mesh();
  set_up();
  assemble();
  const unsigned int n_iterations = solve();
  double error = -1;
  if (with_error) {
    TimerOutput::Scope scope(timer, "measure");
    error = relative_error();
  }
  print(n_iterations, error, all.wall_time());
}

int main(int argc, char **argv)
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const bool with_error = argc == 5 && std::string(argv[4]) == "error";
  if (argc != 4 && !with_error) {
    std::cerr << "plain_heat DIMENSION DEGREE N [error]" << std::endl;
    return 1;
  }
  const unsigned int degree = Utilities::string_to_int(argv[2]), n_cells = Utilities::string_to_int(argv[3]);
  if (argv[1][0] == '2')
    Heat<2>(degree, n_cells).run(with_error);
  else
    Heat<3>(degree, n_cells).run(with_error);
}
