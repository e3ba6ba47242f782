// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// [A B^T; B -C] by GMRES with multigrid and Schur complement: A a chain of 400 springs, B ties each tenth to
// its neighbour, by numbers over six decades, C a compliance (a pressure has one). Every fourth multiplier
// was dropped: it is alone, with a number on the diagonal, and marked. The iterations are few with C, too:
// what a diagonal is for is known from the mark. The solution is that of MUMPS.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

#include <dovetail/solve/linear_solver.h>

using namespace test;

namespace {

using Index = BlockMatrix::size_type;

const Index n_springs = 400, n_multipliers = 40;
const double stiffness = 1e6;

/// The entries of a row of B, up to the sign.
double tie(const Index multiplier)
{
  return std::pow(10., 6. * multiplier / n_multipliers - 3);
}

bool was_dropped(const Index multiplier)
{
  return multiplier % 4 == 3;
}

/// An equal share of each rank.
std::vector<dealii::IndexSet> owned_sets()
{
  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD),
                     n_ranks = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
  std::vector<dealii::IndexSet> owned;
  for (const Index n : {n_springs, n_multipliers}) {
    owned.emplace_back(n);
    owned.back().add_range(n * rank / n_ranks, n * (rank + 1) / n_ranks);
  }
  return owned;
}

/// Calls @p add(row, column, value) for the rows that this rank owns.
template <typename Add>
void for_each_entry(const std::vector<dealii::IndexSet> &owned, const double compliance, const Add &add)
{
  for (const Index i : owned[0]) {
    add(i, i, 2 * stiffness);
    if (i > 0)
      add(i, i - 1, -stiffness);
    if (i + 1 < n_springs)
      add(i, i + 1, -stiffness);
    if (i % 10 < 2 && !was_dropped(i / 10))
      add(i, n_springs + i / 10, i % 10 == 0 ? tie(i / 10) : -tie(i / 10));
  }
  for (const Index i : owned[1]) {
    add(n_springs + i, n_springs + i, was_dropped(i) ? 1. : -compliance * tie(i) * tie(i));
    if (!was_dropped(i)) {
      add(n_springs + i, 10 * i, tie(i));
      add(n_springs + i, 10 * i + 1, -tie(i));
    }
  }
}

void check(const double compliance)
{
  const auto owned = owned_sets();
  dealii::IndexSet rows(n_springs + n_multipliers);
  rows.add_indices(owned[0]);
  rows.add_indices(owned[1], n_springs);
  dealii::DynamicSparsityPattern pattern(n_springs + n_multipliers, n_springs + n_multipliers, rows);
  for_each_entry(owned, compliance,
                 [&](const Index row, const Index column, double) { pattern.add(row, column); });
  BlockMatrix matrix;
  matrix.reinit(owned, {0, 1}, pattern, MPI_COMM_WORLD);
  for_each_entry(owned, compliance, [&](const Index row, const Index column, const double value) {
    matrix.add(row, column, value);
  });
  matrix.compress(dealii::VectorOperation::add);

  SolveGroup group;
  group.name = "chain";
  group.blocks = {0};
  group.multiplier_blocks = {1};
  group.near_null_space = [&](unsigned int, bool, const Selection *) {
    return std::vector<std::vector<double>>(1, std::vector<double>(owned[0].n_elements(), 1.));
  };
  group.dropped = [&](unsigned int) {
    std::vector<bool> of_own;
    for (const Index i : owned[1])
      of_own.push_back(was_dropped(i));
    return of_own;
  };
  BlockMatrix::Vector b(owned, MPI_COMM_WORLD);
  for (unsigned int block = 0; block < 2; ++block) {
    for (const Index i : owned[block])
      b.block(block)(i) = noise(i);
    b.block(block).compress(dealii::VectorOperation::insert);
  }
  std::vector<BlockMatrix::Vector> x(2, b);
  const std::vector<std::string> types = {"direct", "multigrid"};
  for (unsigned int i = 0; i < 2; ++i) {
    LinearSolver solver(
        SceneText::root(SceneText::from_prm(set("Type", types[i]) + set("Relative tolerance", "1e-13"))),
        {group});
    solver.set_matrix(matrix);
    const auto n_iterations = solver.solve(x[i], b);
    if (is_rank_0())
      std::cout << solver.description()[0] << std::endl;
    report("at most 10 iterations", n_iterations ? *n_iterations : 1e3, 10);
    report("no notes", solver.notes().empty());
  }
  for (unsigned int block = 0; block < 2; ++block) {
    const double size = x[0].block(block).l2_norm();
    x[1].block(block) -= x[0].block(block);
    report("block " + std::to_string(block), x[1].block(block).l2_norm() / size, 1e-8);
  }
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check(0.);
  check(1e-6);
}
