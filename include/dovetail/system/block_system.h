// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Residual and tangent of all domains and interfaces in Trilinos block matrices.

#pragma once

#include <dovetail/domain/cell_terms.h>
#include <dovetail/scene/undefined.h>
#include <dovetail/solve/block_matrix.h>
#include <dovetail/solve/ghost_exchange.h>
#include <dovetail/system/cellwise_tangent.h>
#include <dovetail/system/force_sizes.h>
#include <dovetail/system/free_pressures.h>
#include <dovetail/system/local_to_global.h>
#include <dovetail/system/model.h>
#include <dovetail/system/nodal_forces.h>
#include <dovetail/system/stages.h>
#include <dovetail/system/tangent_entries.h>
#include <dovetail/system/unrestrained_mode.h>
#include <dovetail/system/update_constraints.h>
#include <dovetail/system/vector.h>
#include <dovetail/time/rates.h>

#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

namespace dovetail {

template <int dim>
class AffineResidual;

/// The nonlinear system R(x) = 0 on the constraints of hanging nodes, prescribed values and ties. Newton's
/// update dx solves K dx = -R with the constraints that make x + dx satisfy those of the current time, so
/// prescribed values enter through the tangent and not by a jump at the boundary nodes. In a linear scene
/// constrain() moves x first and dx is what is left; the two are the same there, but the second needs no
/// local matrices, so a tangent that does not change is kept.
template <int dim>
class BlockSystem
{
public:
  explicit BlockSystem(Model<dim> &model, Form form = Form::direct);
  ~BlockSystem();

  /// From the next set_up() on: of each group of fields (Model::field_groups), whether its matrix has all
  /// entries. If not, the tangent of the cells is products; that of ties and conditions has entries.
  void choose_entries(const std::vector<bool> &of_groups) { entries.choose(of_groups); }

  /// From the next set_up() or make_matrix() on: the blocks of one stage by another (Model::stages) are left
  /// out of the tangent.
  void leave_out_couplings(const bool are_left_out) { has_couplings = !are_left_out; }
  bool leaves_out_couplings() const { return !has_couplings; }

  /// Constraints, sparsity and matrix for what is active at time @p t. @p entries_for_constraints: asked when
  /// the constraints are there, for what choose_entries() has not been told. May be missing. Collective.
  void set_up(double t, const std::function<std::vector<bool>()> &entries_for_constraints = {});
  /// Those entries that choose_entries() has asked for, and nothing else anew. Collective.
  void make_matrix() { make_sparsity(time); }
  /// Whether set_up must be called again because toggles have changed, or prescribed jumps of strong ties.
  bool is_outdated(double t) const;

  /// Those of the unknowns in the present step, from a time scheme; without any what is stored is left out.
  void set_rates(const Rates &rates);
  bool has_rates() const { return step_rates.has_first(); }

  /// Prescribed values of time @p t; weights and penalties of the ties frozen at @p x.
  void begin_step(double t, const Vector &x);
  /// Loads and prescribed values of time @p t; ties stay as they have been begun. @pre not is_outdated(t)
  void set_time(double t);
  /// After a step has converged at @p x: freeze those weights and penalties anew that do not fit it any more.
  /// Collective. @return whether there were any; then the step must be solved on.
  bool update_penalties(double t, const Vector &x);
  /// Within a step: let the ties change their equations at @p x. @return whether one did. Collective.
  bool adapt_ties(double t, const Vector &x);

  /// R(x), and the tangent. Rows of the tangent of other blocks than @p of_blocks may stay as they are, and
  /// those of R of other blocks than @p residual_of, which has these, may be zero: of other stages
  /// (Model::stages) they are, and their laws are not evaluated. Empty: all are asked for. @return false, on
  /// all ranks alike, if a law is not defined at x. @throw UserError if what is not defined is not so at any
  /// x.
  bool assemble(const Vector &x, bool with_tangent, const std::vector<bool> &of_blocks = {},
                const std::vector<bool> &residual_of = {});
  /// The state of the last assembly becomes the solution so far.
  void accept_state();
  /// Of a solution @p x of time @p t: let all laws remember it. Nothing is remembered, and false returned on
  /// all ranks alike, if one is not defined there. Collective; costs nothing where no law remembers anything.
  bool remember(double t, const Vector &x);
  /// Of the state @p x before the first step: materials remember it, and choose their phases of that step.
  /// Collective; costs nothing where none has to.
  void look_at_start(const Vector &x);
  /// Of a step to time @p t: conditions whose toggles look at fields see its first state @p x in it.
  /// begin_step() does so, unless it is that step again.
  void keep_last_good(double t, const Vector &x);
  /// Of the last assembly since begin_step() that was not defined: which law at which state, in which domain
  /// and cell; the same on all ranks.
  const Undefined &why_undefined() const { return problem; }

  /// Newton's homotopy from @p x, for loads that cannot be divided in time: from now on x solves the system
  /// with share 0, and share 1 is the system itself. What is held back is 1 - share of the residual at x and
  /// of what the constraints have to move there. Until begin_step.
  void hold_back_from(const Vector &x);
  void set_share(double value) { share = value; }

  /// Whether the tangent of the last assembly is that of every state and time until set_up is called again or
  /// the derivatives of the rates change.
  bool keeps_tangent() const
  {
    return has_tangent && model.has_constant_tangent() && step_rates.by_value == rates_of_tangent[0] &&
           step_rates.second_by_value == rates_of_tangent[1];
  }
  /// Make @p x satisfy the constraints of the current time, by moving the constrained unknowns alone.
  void constrain(Vector &x);

  /// From now on tangents have the stress that the tangent at @p x predicts, where a law knows it
  /// (SolidTerm); nullptr: that of the state itself.
  void linearise_at(const Vector *x);

  /// How often assemble() has been called with and without the tangent.
  struct Assemblies
  {
    unsigned long tangents = 0, residuals_alone = 0;
    unsigned long tangents_by_sums = 0, residuals_by_products = 0; ///< in place of these (affine_residual.h)
  };
  const Assemblies &assemblies() const { return n_assemblies; }

  /// What rounding of K may change of the energy x . K x of a field, relative to that, before integrals take
  /// the place of products.
  static constexpr double largest_rounding_of_energy = 1e-7;
  /// Whether residuals alone are products, as far as is known.
  bool takes_products() const;
  void give_up_products(); ///< for integrals, until set_up() is called again

  const BlockMatrix &tangent() const { return matrix; }
  /// Until the next assembly of a tangent. @p other: one of this system since set_up().
  void add_to_tangent(const double factor, const BlockMatrix &other) { matrix.add(factor, other); }
  const Vector &negative_residual() const { return right_hand_side; }
  /// Prescribed values, hanging nodes and ties of the unknowns relevant to this rank, resolved.
  /// Their constants are those of the update.
  const dealii::AffineConstraints<double> &all_constraints() const { return constraints.of_update(); }

  /// What is at work in the equations of each block of unknowns at the state of the last assembly, as
  /// Euclidean norms: the residual; the forces, of every cell and tie for itself, be they internal, given,
  /// transmitted or reactions (of multipliers: the traces that cancel); what rounding can leave of them, a
  /// bound of the standard deviation, doc/theory/convergence.md.
  std::vector<double> residuals() const;
  std::vector<double> forces() const { return sizes.forces(); }
  std::vector<double> rounding() const { return sizes.rounding(); }
  /// The last one that was integrated, unless something else was made ghosted since; nullptr: none. It is
  /// meant for preconditioners, which bear that.
  const Vector *last_state() const { return ghosted_scratch.size() > 0 ? &ghosted_scratch : nullptr; }
  /// By block: the number of its field; multipliers have one of their own for each interface.
  const std::vector<unsigned int> &fields_of_blocks() const { return field_of_block; }
  /// For linear systems, by block ||K dx + R|| relative to the forces there. @p rest becomes -R - K dx.
  std::vector<double> linear_residuals(const Vector &dx, Vector &rest);

  /// Whether the last assembly has found that the constraints move unknowns, of a block or of any.
  bool moves_constraints(const unsigned int block) const { return constraints.moves(block); }
  bool moves_constraints() const { return constraints.moves(); }
  double largest_move() const { return constraints.largest_move(); } ///< of a prescribed value, likewise
  /// Fields that is_surely_held() are not looked at.
  enum class Unless {
    held,         ///< by conditions, ties and rates
    held_at_rest, ///< by conditions and ties
    never
  };
  /// A motion that the last tangent does not resist. Collective; costs nothing where nothing is looked at.
  std::optional<UnrestrainedMode<dim>> find_unrestrained_mode(Unless unless = Unless::held) const;
  /// Pressures that the last tangent does not see. Collective; costs nothing where no body is incompressible.
  std::vector<FreePressure<dim>> find_free_pressures() const
  {
    return dovetail::find_free_pressures(model, time, matrix, constraints.of_update());
  }
  /// Whether an unknown that this rank owns follows from others, so that its row is trivial.
  bool is_constrained(dealii::types::global_dof_index dof) const
  {
    return constraints.of_update().is_constrained(dof);
  }
  /// Whether a multiplier that this rank owns has no equation of its own and is zero: its tie is switched
  /// off, or has dropped it.
  bool is_dropped(dealii::types::global_dof_index multiplier) const { return dropped.count(multiplier) > 0; }
  /// Complete @p dx by the constrained unknowns.
  void distribute(Vector &dx);
  /// Likewise a rate: what is prescribed has none. @p what_is_prescribed: else these unknowns stay as they
  /// are.
  void distribute_rate(Vector &rate, bool what_is_prescribed);
  /// Make those unknowns of @p x that follow others do so; what is prescribed stays as it is.
  void follow(Vector &x);

  /// What holds the constrained unknowns at a solution of the current time. Collective; refers to
  /// constraints of this system.
  NodalForces<dim> nodal_forces(const Vector &x);
  /// At another time of the step that has begun, with other rates. Collective.
  NodalForces<dim> nodal_forces(const Vector &x, double t, const Rates &rates);
  bool has_multipliers() const; ///< some tie that is active now
  /// Before output: the multipliers of the ties at a solution and what they transmit. Collective.
  void find_multipliers(const Vector &x, const NodalForces<dim> &forces);
  /// What the ties did that a user should know; after set_up, the same on all ranks.
  NoteList notes() const;

  Vector owned_vector() const;
  Vector ghosted_vector() const;
  Vector ghosted(const Vector &owned) const; ///< a copy with ghosts

  /// Set-up of constraints and terms of interfaces, this rank.
  double seconds_of_ties() const { return tie_seconds + constraints.seconds_of_ties(); }

private:
  ValuesOf ghosted_values() const;

  void make_sparsity(double t);
  std::vector<unsigned int> parts_of_blocks() const;
  void ask_for(const std::vector<bool> &of_blocks, const std::vector<bool> &residual_of);
  void begin_tangent();
  void make_cell_terms();
  void make_cell_operators(double t);
  std::vector<TieOperator<dim> *> products_of(const Interface<dim> &interface) const;
  bool assemble_products(PointTerms<dim> &terms, const Interface<dim> &interface, unsigned int g,
                         const std::vector<TieOperator<dim> *> &products,
                         const std::vector<dealii::types::global_dof_index> &dofs,
                         const std::vector<double> &unknowns, std::vector<double> &residual,
                         dealii::FullMatrix<double> *rest);
  void find_dropped(double t);
  AffineResidual<dim> *affine_residual();
  bool evaluate_products(const Vector &x);
  bool assemble_by_products(const Vector &x);
  void combine_tangent();
  void find_summands();
  bool is_as_integrated(const Vector &x);
  bool assemble_all(bool with_tangent);
  bool assemble_domain(unsigned int d, const Vector &ghosted, bool with_tangent);
  bool assemble_interface(Interface<dim> &interface, const Vector &ghosted, bool with_tangent);
  bool assemble_point_terms(Interface<dim> &interface, bool with_tangent);
  void assemble_multipliers(const Interface<dim> &interface, const Vector &ghosted, bool with_tangent);
  void add_merged(const std::vector<unsigned int> &position,
                  const std::vector<dealii::types::global_dof_index> &dofs,
                  const std::vector<double> &residual, const dealii::FullMatrix<double> *tangent);
  void note_undefined(const std::string &where);

  Model<dim> &model;
  double time = 0;
  std::vector<std::string> fields; ///< of the norms; multipliers have one of their own for each interface
  std::vector<unsigned int> field_of_block;
  std::vector<bool> is_of_multipliers; ///< by field
  bool has_couplings = true;           ///< of stages
  Stages<dim> stages;
  TangentEntries<dim> entries;
  UpdateConstraints<dim> constraints;
  std::set<dealii::types::global_dof_index> dropped; ///< multipliers
  std::vector<bool> toggles_of_set_up;
  double time_of_set_up = 0;
  BlockMatrix matrix;
  Vector right_hand_side;
  ForceSizes sizes;
  SharedSums negative_sums; ///< of the right-hand side, in an assembly
  LocalToGlobal<dim> sums;
  std::map<unsigned int, std::shared_ptr<CellwiseTangent<dim>>> cellwise; ///< by part of the matrix
  bool has_tangent = false;                                               ///< since set_up
  unsigned int n_tangents = 0;                                            ///< assembled, likewise
  /// Of the tangent, by order of the rates by whose derivative they are multiplied; 0: the rest.
  std::map<unsigned int, BlockMatrix> summands;
  Vector linearised;                           ///< ghosted, of linearise_at()
  Rates step_rates;                            ///< ghosted
  Rates owned_rates;                           ///< the same, without the past
  std::unique_ptr<AffineResidual<dim>> affine; ///< since set_up, once it is asked for
  bool are_products_rounded = false;           ///< of affine, since set_up
  std::array<double, 2> rates_of_tangent{};    ///< derivatives of the rates in the last tangent
  Undefined problem, problem_here;             ///< over all ranks; on this one, in the present assembly
  Assemblies n_assemblies;
  std::shared_ptr<const GhostExchange> ghosts; ///< since set_up
  Vector ghosted_scratch;
  std::vector<std::unique_ptr<CellTerms<dim>>> cell_terms;
  std::optional<double> time_of_given;                 ///< that of their given_flows(), if these are complete
  dealii::FullMatrix<double> local_matrix, of_leading; // scratch
  std::vector<double> residual_of_leading;
  double share = 1; ///< of what is held back
  Vector held_back; ///< the negative residual
  double tie_seconds = 0;
};

} // namespace dovetail
