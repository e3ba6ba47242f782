// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Solves block systems; knows matrices and vectors, no finite elements.

#pragma once

#include <dovetail/scene/section.h>
#include <dovetail/solve/block_matrix.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dovetail {

/// A group of blocks that is solved at once.
struct SolveGroup
{
  std::string name; ///< for messages
  std::vector<unsigned int> blocks;
  /// Of multipliers: they have no block of their own on the diagonal, [A B^T; B 0] with A regular.
  std::vector<unsigned int> multiplier_blocks;
  bool is_symmetric = true;  ///< and, but for multipliers, positive definite
  bool allows_jumps = false; ///< some bodies may come apart: each needs its own near-null space
  unsigned int dim = 3;
  unsigned int degree = 1;
  unsigned long n_unknowns = 0; ///< of all ranks; for the plan
  /// Near-null space of a block at this rank's unknowns, [mode][local unknown], as part of that of all blocks
  /// together or by itself; asked for only if multigrid is used.
  std::function<std::vector<std::vector<double>>(unsigned int block, bool of_all_blocks)> near_null_space;
  /// Of each of this rank's unknowns of a block: the unknowns of the whole system, and the weights, that it
  /// is the sum of in a function of degree one: those at the vertices of its cell, or those that it follows
  /// by a constraint; none if it is prescribed, itself if it is a vertex. Asked for only if multigrid is used
  /// for a degree above one; may be missing, which costs time only.
  using Sum = std::vector<std::pair<dealii::types::global_dof_index, double>>;
  std::function<std::vector<Sum>(unsigned int block)> linear_part;
};

/// Solves K dx = b for a matrix that is lower block triangular over the groups (a field does not depend on
/// those after it), group after group, each merged into one matrix: by MUMPS, or by CG (symmetric) or GMRES
/// with ML's smoothed aggregation and the near-null space of the blocks; for a degree above one and a
/// symmetric group after a first coarsening to the functions of degree one. With multipliers GMRES has the
/// block triangular preconditioner [A 0; B -S], A by multigrid and the Schur complement S by the diagonal of
/// B diag(A)^-1 B^T.
class LinearSolver
{
public:
  using Matrix = BlockMatrix;
  using Vector = dealii::TrilinosWrappers::MPI::BlockVector;

  LinearSolver(const Section &section, std::vector<SolveGroup> groups);
  ~LinearSolver();

  /// The matrix has new entries.
  void set_matrix(const Matrix &matrix);
  /// Before the matrix is destroyed or gets another sparsity: what was built from it refers to it.
  void forget_matrix();

  /// @return the number of linear iterations (1 per direct solve), or nothing if even the direct solver
  /// failed. A group whose iteration fails, or ends above the tolerance though rounding would let it go on,
  /// is solved directly, now and from then on. What one rank alone meets (an exception of a library, no
  /// memory) all ranks agree on before another way is tried.
  std::optional<unsigned int> solve(Vector &dx, const Vector &right_hand_side);

  /// From now on everything is solved directly. @return false if it is already.
  bool prefer_direct();

  /// What a user should know about how it went, the same on all ranks.
  const std::vector<std::string> &notes() const { return all_notes; }

  /// For tests: called where memory is taken or a library is entered, with the name of the place; it may
  /// throw.
  void set_fault(std::function<void(const std::string &place)> fault);

  /// What each group is solved with, or will be, for the plan: "displacement: CG with multigrid".
  std::vector<std::string> description() const;

  struct Counts
  {
    unsigned long solves = 0, factorisations = 0, multigrids = 0;
  };
  Counts counts() const; ///< of all groups

private:
  struct Group;
  const Matrix *matrix = nullptr;
  std::vector<std::unique_ptr<Group>> groups;
  unsigned int type; ///< 0 automatic, 1 direct, 2 multigrid
  double relative_tolerance;
  std::vector<std::string> all_notes;
};

} // namespace dovetail
