// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The scene beside this file in plain deal.II, in one body: step-26 with backward Euler on one mesh. The
// matrices are assembled once, the preconditioner is made once, and each step is solved by conjugate
// gradients with ML from the last solution, to the residual that Dovetail asks for.
//
//     plain_transient N STEPS    N cells in each direction, on one rank
//
// Prints one line: unknowns, the temperature at (0.75, 0.5, 0.5) at the end, CG iterations of all steps,
// seconds by phase and in all, the sum of the ranks' largest memory.

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

#include <cmath>
#include <iostream>

using namespace dealii;

class TransientHeat
{
public:
  explicit TransientHeat(unsigned int n_cells);
  void run(unsigned int n_steps);

private:
  void make_mesh(unsigned int n_cells);
  void set_up();
  void assemble();
  unsigned int solve(unsigned int n_steps);
  void print(unsigned int n_iterations, double seconds) const;

  const MPI_Comm communicator = MPI_COMM_WORLD;
  const double end_time = 0.1;
  double step = 0;
  parallel::distributed::Triangulation<3> triangulation;
  const FE_Q<3> fe;
  DoFHandler<3> dof_handler;
  IndexSet owned, relevant;
  AffineConstraints<double> constraints;
  TrilinosWrappers::SparseMatrix matrix, mass; ///< M + step K, M
  TrilinosWrappers::MPI::Vector source, solution;
  TimerOutput timer;
};

TransientHeat::TransientHeat(const unsigned int n_cells)
    : triangulation(communicator), fe(1), dof_handler(triangulation),
      timer(communicator, std::cout, TimerOutput::never, TimerOutput::wall_times)
{
  make_mesh(n_cells);
}

void TransientHeat::make_mesh(const unsigned int n_cells)
{
  const TimerOutput::Scope scope(timer, "mesh");
  GridGenerator::subdivided_hyper_cube(triangulation, n_cells);
  dof_handler.distribute_dofs(fe);
}

void TransientHeat::set_up()
{
  const TimerOutput::Scope scope(timer, "setup");
  owned = dof_handler.locally_owned_dofs();
  relevant = DoFTools::extract_locally_relevant_dofs(dof_handler);
  constraints.reinit(relevant);
  VectorTools::interpolate_boundary_values(dof_handler, 0, Functions::ZeroFunction<3>(), constraints);
  constraints.close();

  DynamicSparsityPattern pattern(relevant);
  DoFTools::make_sparsity_pattern(dof_handler, pattern, constraints, false);
  SparsityTools::distribute_sparsity_pattern(pattern, owned, communicator, relevant);
  for (TrilinosWrappers::SparseMatrix *one : {&matrix, &mass})
    one->reinit(owned, owned, pattern, communicator);
  for (TrilinosWrappers::MPI::Vector *one : {&source, &solution})
    one->reinit(owned, communicator);
}

void TransientHeat::assemble()
{
  const TimerOutput::Scope scope(timer, "assembly");
  const QGauss<3> quadrature(2);
  FEValues<3> fe_values(fe, quadrature,
                        update_values | update_gradients | update_quadrature_points | update_JxW_values);
  const unsigned int n = fe.n_dofs_per_cell();
  FullMatrix<double> cell_matrix(n, n), cell_mass(n, n);
  Vector<double> cell_source(n);
  std::vector<types::global_dof_index> dofs(n);
  for (const auto &cell : dof_handler.active_cell_iterators())
    if (cell->is_locally_owned()) {
      fe_values.reinit(cell);
      cell_matrix = 0;
      cell_mass = 0;
      cell_source = 0;
      for (const unsigned int q : fe_values.quadrature_point_indices()) {
        const Point<3> &x = fe_values.quadrature_point(q);
        double heat = 30;
        for (unsigned int d = 0; d < 3; ++d)
          heat *= std::sin(numbers::PI * x[d]);
        for (unsigned int i = 0; i < n; ++i) {
          for (unsigned int j = 0; j < n; ++j) {
            const double stored =
                fe_values.shape_value(i, q) * fe_values.shape_value(j, q) * fe_values.JxW(q);
            cell_mass(i, j) += stored;
            cell_matrix(i, j) +=
                stored + step * fe_values.shape_grad(i, q) * fe_values.shape_grad(j, q) * fe_values.JxW(q);
          }
          cell_source(i) += step * heat * fe_values.shape_value(i, q) * fe_values.JxW(q);
        }
      }
      cell->get_dof_indices(dofs);
      constraints.distribute_local_to_global(cell_matrix, cell_source, dofs, matrix, source);
      constraints.distribute_local_to_global(cell_mass, dofs, mass);
    }
  for (TrilinosWrappers::SparseMatrix *one : {&matrix, &mass})
    one->compress(VectorOperation::add);
  source.compress(VectorOperation::add);
}

unsigned int TransientHeat::solve(const unsigned int n_steps)
{
  const TimerOutput::Scope scope(timer, "solve");
  TrilinosWrappers::PreconditionAMG::AdditionalData data;
  data.elliptic = true;
  data.smoother_sweeps = 2;
  TrilinosWrappers::PreconditionAMG multigrid;
  multigrid.initialize(matrix, data);

  TrilinosWrappers::MPI::Vector right_hand_side(owned, communicator);
  unsigned int n_iterations = 0;
  for (unsigned int n = 0; n < n_steps; ++n) {
    mass.vmult(right_hand_side, solution);
    right_hand_side += source;
    SolverControl control(1000, 1e-11 * right_hand_side.l2_norm());
    SolverCG<TrilinosWrappers::MPI::Vector>(control).solve(matrix, solution, right_hand_side, multigrid);
    constraints.distribute(solution);
    n_iterations += control.last_step();
  }
  return n_iterations;
}

void TransientHeat::print(const unsigned int n_iterations, const double seconds) const
{
  Utilities::System::MemoryStats memory;
  Utilities::System::get_memory_stats(memory);
  const double MiB = Utilities::MPI::sum(memory.VmHWM / 1024., communicator);
  const double inside = VectorTools::point_value(dof_handler, solution, Point<3>(0.75, 0.5, 0.5));
  ConditionalOStream out(std::cout, Utilities::MPI::this_mpi_process(communicator) == 0);
  out << "unknowns " << dof_handler.n_dofs() << "  error " << inside << "  iterations " << n_iterations;
  for (const auto &[name, time] : timer.get_summary_data(TimerOutput::total_wall_time))
    out << "  " << name << ' ' << time;
  out << "  total " << seconds << "  MiB " << MiB << std::endl;
}

void TransientHeat::run(const unsigned int n_steps)
{
  Timer all;
  step = end_time / n_steps;
  set_up();
  assemble();
  print(solve(n_steps), all.wall_time());
}

int main(int argc, char **argv)
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  if (argc != 3) {
    std::cerr << "plain_transient N STEPS" << std::endl;
    return 1;
  }
  TransientHeat(Utilities::string_to_int(argv[1])).run(Utilities::string_to_int(argv[2]));
}
