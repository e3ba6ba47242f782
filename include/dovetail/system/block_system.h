// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Residual and tangent of all domains and interfaces in Trilinos block matrices.

#pragma once

#include <dovetail/domain/cell_terms.h>
#include <dovetail/system/free_motion.h>
#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/trilinos_block_sparse_matrix.h>

#include <memory>
#include <vector>

namespace dovetail {

/// The nonlinear system R(x) = 0 on the constraints of hanging nodes, prescribed values and ties. Newton's
/// update dx solves K dx = -R with the constraints that make x + dx satisfy those of the current time, so
/// prescribed values enter through the tangent and not by a jump at the boundary nodes. In a linear scene
/// constrain() moves x first and dx is what is left; the two are the same there, but the second needs no
/// local matrices, so a tangent that does not change is kept.
template <int dim>
class BlockSystem
{
public:
  explicit BlockSystem(Model<dim> &model);

  /// Constraints, sparsity and matrix for what is active at time @p t. Collective.
  void set_up(double t);
  /// Whether set_up must be called again because toggles have changed.
  bool is_outdated(double t) const;

  /// Prescribed values of time @p t; weights and penalties of the ties frozen at @p x.
  void begin_step(double t, const Vector &x);
  /// After a step has converged at @p x: freeze those weights and penalties anew that do not fit it any more.
  /// Collective. @return whether there were any; then the step must be solved on.
  bool refreeze(double t, const Vector &x);

  /// R(x), and the tangent. @return false, on all ranks alike, if a law is not defined at x.
  bool assemble(const Vector &x, bool with_tangent);

  /// Whether the tangent of the last assembly is that of every state and time until set_up is called again.
  bool keeps_tangent() const { return has_tangent && model.has_constant_tangent(); }
  /// Make @p x satisfy the constraints of the current time, by moving the constrained unknowns alone.
  void constrain(Vector &x) const;

  /// How often assemble() has been called with and without the tangent.
  struct Assemblies
  {
    unsigned long of_tangent = 0, of_residual = 0;
  };
  const Assemblies &assemblies() const { return n_assemblies; }

  const dealii::TrilinosWrappers::BlockSparseMatrix &tangent() const { return matrix; }
  const Vector &negative_residual() const { return right_hand_side; }
  /// Prescribed values, hanging nodes and ties of the unknowns relevant to this rank, resolved.
  const dealii::AffineConstraints<double> &all_constraints() const { return constraints; }

  /// Largest over the fields of ||R_f|| relative to its largest value among the states that have been
  /// accepted in this step; a field whose residual is rounding noise of |K||x| or not above @p
  /// absolute_tolerance counts as zero. That largest value counts at most as a hundred times what the cells'
  /// residuals and |K||x| are now: after an update that went astray (an exponential law) it would make
  /// anything look small. A residual that is larger, but not by more than the factor largest_growth, gives 1:
  /// bending goes through such states.
  double residual_norm(double absolute_tolerance = 0);
  /// The state of the last residual_norm() is accepted; the first one of a step always is.
  void accept_residual();
  /// Forget the largest values: a new step begins.
  void reset_norms();
  /// The norm that the residual would have after dx, for linear systems: of K dx + R.
  double linear_residual_norm(const Vector &dx);

  /// Whether the last assembled right-hand side moves prescribed values.
  bool moves_constraints() const { return constraints_move; }
  double largest_move() const { return move; } ///< of a prescribed value, likewise
  /// A motion that the last tangent does not resist, if the scene leaves one possible. Collective; costs
  /// nothing where all bodies are surely held, unless @p in_any_case.
  std::optional<FreeMotion<dim>> find_free_motion(bool in_any_case = false) const;
  /// Whether an unknown that this rank owns follows from others, so that its row is trivial.
  bool is_constrained(dealii::types::global_dof_index dof) const
  {
    return update_constraints.is_constrained(dof);
  }
  /// Complete @p dx by the constrained unknowns.
  void distribute(Vector &dx) const;

  /// Before output: the multipliers of the ties at a solution. Collective.
  void find_multipliers(const Vector &x);
  /// What the ties did that a user should know; after set_up, the same on all ranks.
  std::vector<std::string> notes() const;

  Vector owned_vector() const;
  Vector ghosted_vector() const;

  double seconds_of_ties() const
  {
    return tie_seconds;
  } ///< set-up of constraints and terms of interfaces, this rank

private:
  typename Tie<dim>::Unknowns ghosted_values() const;
  using SparseMatrix = dealii::TrilinosWrappers::BlockSparseMatrix;

  void make_relevant_set(double t);
  ConstraintLines lines_at(double t) const;
  bool are_prescribed(const ConstraintLines &lines) const;
  void make_constraints(const ConstraintLines &lines);
  void make_sparsity(double t);
  void move_constraints_from(const Vector &ghosted);
  bool assemble_domain(unsigned int d, const Vector &ghosted, bool with_tangent);
  bool assemble_interface(Interface<dim> &interface, const Vector &ghosted, bool with_tangent);
  void assemble_multipliers(const Interface<dim> &interface, const Vector &ghosted, bool with_tangent);
  template <typename Visit>
  void for_each_multiplier(const Interface<dim> &interface, const Visit &visit) const;
  bool has_multipliers() const;
  void apply(const dealii::AffineConstraints<double> &lines, Vector &x) const;
  Vector forces(const Vector &x);
  void scatter(const std::vector<double> &residual, const std::vector<dealii::types::global_dof_index> &dofs,
               bool with_tangent);
  const dealii::AffineConstraints<double> *scatters_on; ///< the constraints that scatter obeys
  std::vector<bool> active_toggles(double t) const;

  Model<dim> &model;
  double time = 0;
  std::vector<std::string> fields; ///< of the norms; multipliers have one of their own for each interface
  std::vector<unsigned int> field_of_block;
  std::vector<bool> is_of_multipliers; ///< by field
  dealii::IndexSet relevant;           ///< relevant unknowns of the domains and those behind interface points
  ConstraintLines tie_lines;           ///< of owned unknowns
  ConstraintLines hanging_lines;       ///< likewise, if there are interfaces
  std::set<dealii::types::global_dof_index> freed;      ///< of tie_lines, where they would have no solution
  dealii::AffineConstraints<double> constraints;        ///< of x at the current time
  dealii::AffineConstraints<double> update_constraints; ///< of dx
  bool constraints_move = false;
  double move = 0;
  std::vector<bool> toggles_of_set_up;
  SparseMatrix matrix;
  bool has_tangent = false; ///< since set_up
  Assemblies n_assemblies;
  Vector right_hand_side;
  mutable Vector ghosted_scratch;
  std::vector<std::unique_ptr<CellTerms<dim>>> cell_terms;
  dealii::FullMatrix<double> local_matrix;
  dealii::Vector<double> local_rhs;
  std::vector<double>
      local_scale; ///< per field: sums of squares over the cells, of R_i, then of sum_j |K_ij x_j|
  std::vector<double> scale, magnitude, largest; ///< per field; magnitude: of the last tangent
  std::vector<double> norms, at_start;           ///< likewise: of the last residual, of the first of the step
  static constexpr double largest_growth = 1e6, largest_of_reference = 100;
  std::vector<double> noise_at_start;          ///< per field, of this step
  static constexpr double largest_noise = 100; ///< over the largest accepted residual of the step
  double tie_seconds = 0;
};

} // namespace dovetail
