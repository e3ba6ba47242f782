// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Solves block systems, each group of blocks by a plugin; knows matrices and vectors, no finite elements.

#pragma once

#include <dovetail/scene/note.h>
#include <dovetail/scene/section.h>
#include <dovetail/solve/block_matrix.h>
#include <dovetail/solve/group_solver.h>

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dovetail {

/// A group of blocks that is solved at once.
struct SolveGroup : GroupTraits
{
  std::vector<unsigned int> blocks;            ///< of the bodies
  std::vector<unsigned int> multiplier_blocks; ///< of interfaces, and of constraints within bodies
  /// BodyShape of the present mesh. Collective. If missing, it is not known.
  std::function<BodyShape()> present_shape;
  /// n_followed of the present constraints. Collective. If missing, there are none.
  std::function<double()> present_followed;
  bool allows_jumps = false; ///< some bodies may come apart: each needs its own near-null space
  /// Near-null space of a block at some of this rank's unknowns, [mode][unknown], as part of that of all
  /// blocks together or by itself; asked for only if a solver does.
  std::function<std::vector<std::vector<double>>(unsigned int block, bool about_one_point,
                                                 const Selection *unknowns)>
      near_null_space;
  /// Of each of this rank's unknowns of a block: the unknowns of the whole system, and the weights, that it
  /// is the sum of in a function of degree one: those at the vertices of its cell, or those that it follows
  /// by a constraint; none if it is prescribed, itself if it is a vertex. @p by_products: the smoother sees
  /// products, and may solve in cells. Asked for only if a solver does; may be missing, which costs time
  /// only.
  std::function<RowSums(unsigned int block, bool by_products)> linear_part;
  /// Likewise which of these vertices coarser meshes do not have, as GroupFacts::mesh_levels. May be missing.
  std::function<MeshLevels(unsigned int block, bool with_parents)> mesh_levels;
  /// Where the nodes of some of this rank's unknowns of a block are. Asked for only if a solver does; may be
  /// missing.
  std::function<std::vector<std::array<double, 3>>(unsigned int block, const Selection *unknowns)> positions;
  /// If is_symmetric: whether the matrix still is, as far as this rank knows. If missing, it is.
  std::function<bool()> is_still_symmetric;
  /// The name of the field of a block of the bodies. If missing, all have the same.
  std::function<std::string(unsigned int block)> field;
  /// Whether the multipliers of a block are a pressure, which takes from the bodies all of their resistance
  /// to a change of volume. If missing, none are.
  std::function<bool(unsigned int block)> is_of_body;
  /// Of each of this rank's multipliers of a block: whether it was dropped, so that it is alone in its
  /// equation. If missing, none was.
  std::function<std::vector<bool>(unsigned int block)> dropped;
  /// Likewise the unknown of the whole system, one of this rank, that this multiplier belongs to, and no
  /// other one that acts. If missing, multipliers stay unknowns.
  std::function<std::vector<dealii::types::global_dof_index>(unsigned int block)> follower;
};

/// Solves K dx = b for a matrix that is lower block triangular over the groups (a field does not depend on
/// those after it), group after group, each as one matrix by a GroupSolver: the one that the scene names, or
/// by size. What that one does not solve the direct one does.
class LinearSolver
{
public:
  using Matrix = BlockMatrix;
  using Vector = dealii::TrilinosWrappers::MPI::BlockVector;

  /// The scene's; or that by size where the scene's does without entries, for a matrix that has them.
  enum class Choice { of_scene, by_entries };
  /// @throw UserError if the solver that the scene names does not fit a group.
  LinearSolver(const Section &section, std::vector<SolveGroup> groups, Choice choice = Choice::of_scene);
  ~LinearSolver();

  /// The sides of interfaces have been paired. Collective.
  void consider_shapes();
  /// There are other constraints, and no matrix yet. Collective.
  void consider_constraints();
  /// Of each group: whether its matrix must have all entries. If not, the tangent of cells may be products.
  std::vector<bool> needs_entries() const;
  /// Whether a group that has failed waits for them, or for products in their place.
  bool lacks_operator() const;

  /// The matrix has new entries.
  void set_matrix(const Matrix &matrix);
  /// Before the matrix is destroyed or gets another sparsity: what was built from it refers to it.
  void forget_matrix();

  /// @return the number of linear iterations (1 per direct solve), or nothing if even the direct solver
  /// failed. A group whose iteration fails, or ends above the tolerance though rounding would let it go on,
  /// is solved directly, now and from then on. What one rank alone meets (an exception of a library, no
  /// memory) all ranks agree on before another way is tried.
  std::optional<unsigned int> solve(Vector &dx, const Vector &right_hand_side);
  /// Of some groups that follow each other; dx = 0 for others. A residual of @p enough times the right-hand
  /// side will do, even if that is more than the tolerance of the scene.
  /// @p excess asks for less than that: by which factor the residual of a dx is too large in some of the
  /// blocks. CG goes on until that is one, as long as rounding lets it and the goal is near. Collective. May
  /// be missing. With @p ends_at_rounding CG ends where rounding hides all rows, if stiffnesses differ much.
  /// Where Newton's method measures dx by the laws, which lose less than K dx, there is more to solve then,
  /// and it had better begin anew.
  struct Demand
  {
    unsigned int first_group, end_group;
    double enough = 0;
    std::function<double(const Vector &dx, const std::vector<unsigned int> &blocks)> excess = {};
    bool ends_at_rounding = false;
  };
  std::optional<unsigned int> solve(Vector &dx, const Vector &right_hand_side, const Demand &demand);

  /// The first one of these groups in which stiffnesses of bodies differ by more than a thousand, and
  /// @p end_group if there is none: the rounding of K x may move stiff bodies, which soft ones hold.
  /// Collective. @pre set_matrix()
  unsigned int first_with_stiff_and_soft(unsigned int first_group, unsigned int end_group) const;

  bool is_symmetric(unsigned int group) const;

  /// Of the matrix of a group that was solved last; nothing if the solver does not know.
  std::optional<unsigned long> n_negative_eigenvalues(unsigned int group) const;
  /// Whether some are, as far as is known: by pivots, the sign of the determinant, or directions of CG.
  bool has_met_negative(unsigned int group) const;

  /// Whether some group is solved by iteration, as far as is known.
  bool iterates() const;
  /// From now on everything is solved directly. A note gives the @p reason, if there is one, for each group
  /// that was iterated.
  void prefer_direct(const std::string &reason = {});

  /// What a user should know about how it went, the same on all ranks.
  const NoteList &notes() const { return all_notes; }

  /// For tests: called where memory is taken or a library is entered, with the name of the place; it may
  /// throw.
  void set_fault(std::function<void(const std::string &place)> fault);

  /// What each group is solved with, or will be, for the plan: "displacement: CG with multigrid".
  std::vector<std::string> description() const;

  /// Of the solver that a group will have, as far as is known.
  std::optional<ExpectedCost> expected_cost(unsigned int group, const GroupSize &size) const;

  struct Counts
  {
    unsigned long solves = 0;                                      ///< of groups
    std::map<std::string, GroupSolver::Preparations> preparations; ///< by the name of the solver
  };
  Counts counts() const;

private:
  struct Group;

  const Section section;
  const Matrix *matrix = nullptr;
  std::vector<std::unique_ptr<Group>> groups;
  std::vector<std::string> types; ///< "automatic" and the names of all solvers
  std::string type;
  double relative_tolerance;
  double present_tolerance = 0; ///< of the present solve
  Agreement ranks;
  unsigned long n_solves = 0;
  NoteList all_notes;
};

} // namespace dovetail
