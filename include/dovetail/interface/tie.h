// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The methods that tie two bodies.

#pragma once

#include <dovetail/domain/constraint_lines.h>
#include <dovetail/interface/leading_unknowns.h>
#include <dovetail/interface/transmission.h>
#include <dovetail/material/term.h>
#include <dovetail/pairing/pairing.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/note.h>

#include <deal.II/lac/full_matrix.h>

#include <array>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace dovetail {

template <int dim>
class Interface;

/// A field of each side that are tied: B_src = K B_dst, with K = 1 but for a species with a partition
/// coefficient.
struct TiedField
{
  std::string name, symbol;         ///< those of Field, of the source
  std::array<std::string, 2> names; ///< of each side; they differ for Co-fields only
  double partition = 1;             ///< K
  unsigned int index;               ///< among Interface::fields
  unsigned int n_components;
  std::array<unsigned int, 2> field;           ///< index among the fields of each side's domain
  std::array<unsigned int, 2> first_component; ///< among the components of each side's domain
  std::array<unsigned int, 2> n_nodes;         ///< of a component, in a cell of each side
  std::array<unsigned int, 2> first_shape;     ///< of its shape functions among all at a point (CellLayout)
  bool has_curvature = true; ///< the laws of both sides know the second derivatives of its flux
  /// Multipliers of this rank, if the tie has any, and the global index of the first; set by the numbering.
  unsigned int n_multipliers = 0;
  dealii::types::global_dof_index first_multiplier = dealii::numbers::invalid_dof_index;

  std::string label() const { return names[0] == names[1] ? name : names[0] + " : " + names[1]; }
  bool has_partition() const { return partition != 1; }
  bool ties(const std::string &field) const { return names[0] == field || names[1] == field; }
  /// [B] = B_src - K B_dst: what the trace of a side counts in it, without the sign.
  double in_jump(const unsigned int side) const { return side == 0 ? 1 : partition; }

  /// Whether a test function of component @p d of a side varies the flux by its value, too (nitsche.cc).
  bool varies_by_value(const unsigned int side, const unsigned int d) const
  {
    return n_components > 1 && d >= first_component[side] && d < first_component[side] + n_components;
  }
};

/// What is known of single unknowns that this rank owns, while the ties of a scene add to it one after the
/// other.
struct TieConstraints
{
  ConstraintLines lines;                                ///< hanging nodes, prescribed values, ties
  std::set<dealii::types::global_dof_index> multiplied; ///< have an equation of a multiplier
  int tie = -1; ///< the position in the scene of the interface whose tie adds now
  double t = 0; ///< the time, for prescribed jumps
  void add(const dealii::types::global_dof_index dof, ConstraintLine line)
  {
    line.tie = tie;
    lines[dof] = std::move(line);
  }
  bool has(const dealii::types::global_dof_index dof) const
  {
    return lines.count(dof) > 0 || multiplied.count(dof) > 0;
  }
};

/// For the report; infinity or zero where there is nothing to say.
struct PenaltyRange
{
  double smallest = std::numeric_limits<double>::infinity();
  double largest = 0;
  /// gamma over its lower bound, minus 1: coercive if positive.
  double coercivity_margin = std::numeric_limits<double>::infinity();
};

/// How often first and second variations of a flux have been evaluated at points of this rank.
struct FluxVariations
{
  unsigned long first = 0, second = 0;
};

/// Gives the values of unknowns of cells that this rank owns or of groups of its points.
using ValuesOf = std::function<void(const std::vector<dealii::types::global_dof_index> &dofs,
                                    std::vector<double> &values)>;
/// A value at an unknown that this rank owns, by global index.
using ValueAt = std::function<double(dealii::types::global_dof_index dof)>;

/// The part of a tie that adds terms at the points of the pairing. It may assume that a group's unknowns are
/// those of Interface::group_dofs, in that order.
template <int dim>
class PointTerms
{
public:
  virtual ~PointTerms() = default;

  /// Residual and, if @p tangent is not nullptr, its exact derivative over the points of a group; both come
  /// in as zero. @return false if a law is not defined at the state of a point.
  virtual bool assemble(const Interface<dim> &interface, const typename Pairing<dim>::Group &group, double t,
                        const std::vector<double> &unknowns, std::vector<double> &residual,
                        dealii::FullMatrix<double> *tangent) = 0;

  /// Of a group, if the tie can tell: the unknowns from whose terms those of the others follow. Then
  /// assemble_leading() does for these what assemble() does for all; @p unknowns are all there.
  virtual const LeadingUnknowns *leading_unknowns(const Interface<dim> & /*interface*/,
                                                  const typename Pairing<dim>::Group & /*group*/) const
  {
    return nullptr;
  }
  virtual bool assemble_leading(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                                double t, const std::vector<double> &unknowns, std::vector<double> &residual,
                                dealii::FullMatrix<double> *tangent)
  {
    return assemble(interface, group, t, unknowns, residual, tangent);
  }

  /// Whether two unknowns that are both zero in the jump, of different sides, have an entry in the tangent.
  virtual bool couples_fluxes() const { return true; }
  /// Whether two such unknowns of one side have one.
  virtual bool couples_insides(const Interface<dim> & /*interface*/) const { return true; }
  /// Whether both sides get the same flux at every point; else each gets that of the points on its own faces.
  virtual bool is_balanced() const { return true; }

  /// After each full update of Newton's method that does not end the iteration: change the equations where
  /// the way to the solution asks for it. Collective. @return whether they have changed, on all ranks alike.
  virtual bool adapt(const Interface<dim> & /*interface*/, double /*t*/, const ValuesOf & /*unknowns*/,
                     const MPI_Comm & /*communicator*/)
  {
    return false;
  }
  /// The state of the last assembly becomes the solution so far: of a trial that is rejected nothing may
  /// stay.
  virtual void accept_state() {}

  virtual PenaltyRange penalty() const { return {}; } ///< of this rank's points
  virtual FluxVariations flux_variations() const { return {}; }

  /// From now on assemble() may leave out the rows of tied fields of which nothing is asked, and of the
  /// tangent those of fields whose derivatives are not.
  virtual void ask_for(const std::vector<Asked> & /*of_fields*/) {}
};

/// The part of a tie by which destination unknowns follow from those of the source.
template <int dim>
class Elimination
{
public:
  virtual ~Elimination() = default;

  /// Lines for destination unknowns that this rank owns. Collective. Keep what is already there: hanging
  /// nodes and prescribed values win, and ties that come first in the scene.
  virtual void add_constraints(const Interface<dim> &interface, TieConstraints &constraints,
                               const MPI_Comm &communicator) = 0;
  /// After add_constraints: unknowns of this rank that miss in them because they are prescribed.
  virtual const std::vector<HeldUnknown> &held() const
  {
    static const std::vector<HeldUnknown> none;
    return none;
  }
};

/// The part of a tie whose multipliers are unknowns of their own.
template <int dim>
class Multipliers
{
public:
  virtual ~Multipliers() = default;

  /// The unknowns of the destination that this rank owns and that have a multiplier for a field each; these
  /// are numbered in the same order, from TiedField::first_multiplier on.
  virtual std::vector<dealii::types::global_dof_index>
  unknowns_with_multiplier(const Interface<dim> &interface, const TiedField &field) const = 0;
  /// Terms with multipliers, this rank's, known after add_constraints; the last unknown of each is the
  /// multiplier. Residual and tangent come in as zero.
  virtual unsigned int n_terms() const = 0;
  virtual const std::vector<dealii::types::global_dof_index> &term_dofs(unsigned int term) const = 0;
  virtual void assemble_term(unsigned int term, const std::vector<double> &unknowns,
                             std::vector<double> &residual, dealii::FullMatrix<double> *tangent) const = 0;
  /// The size of what cancels in the equation of the multiplier.
  virtual double magnitude_of_term(unsigned int term, const std::vector<double> &unknowns) const = 0;
};

/// The part of a tie that finds for output what it transmits by constraints and multipliers.
template <int dim>
class FluxRecovery
{
public:
  virtual ~FluxRecovery() = default;

  /// At a solution: multipliers that are no unknowns follow from the forces that constraints transmit.
  /// @p force: the residual at an unknown without the line that this tie gave it. Collective.
  virtual void find_multipliers(const Interface<dim> &interface, const ValueAt &solution,
                                const ValueAt &force, const MPI_Comm &communicator) = 0;
  /// After find_multipliers: what it gives the sides, this rank's.
  virtual std::vector<Transmission> transmissions() const = 0;
};

/// The parts that a tie has; nullptr for the others.
template <int dim>
struct TieParts
{
  PointTerms<dim> *point_terms = nullptr;
  Elimination<dim> *elimination = nullptr; ///< it takes destination unknowns for itself
  Multipliers<dim> *multipliers = nullptr;
  FluxRecovery<dim> *flux_recovery = nullptr;
};

/// How an interface is tied: a few facts, and parts that do the work. Copy nitsche.cc or pointwise.cc.
template <int dim>
class Tie
{
public:
  virtual ~Tie() = default;

  virtual TieParts<dim> parts() = 0;

  /// Once the fields are known: check the entries that depend on them.
  virtual void set_fields(const Section & /*section*/, const std::vector<TiedField> & /*fields*/) {}

  /// The sides on whose faces the points of the pairing lie.
  virtual std::array<bool, 2> integrates_on() const = 0;
  /// Whether the jump extends the fields over a gap, according to Gap extension.
  virtual bool bridges_gaps() const { return true; }
  /// Whether it does so by Pairing::bridge() where gaps are small.
  virtual bool asks_bridges() const { return false; }
  /// The type of tie whose equations show the error of this one, with elements of a higher degree; empty: its
  /// own. One that errs by itself needs another one.
  virtual std::string type_for_errors() const { return ""; }
  /// Whether it heeds TiedField::partition.
  virtual bool allows_partition() const { return false; }

  /// Before the first iteration of a step: freeze penalty and weights at the last good state. Collective.
  virtual void begin_step(const Interface<dim> & /*interface*/, double /*t*/, const ValuesOf & /*unknowns*/,
                          const MPI_Comm & /*communicator*/)
  {
  }
  /// After a step has converged at time @p t: if what begin_step() has frozen fits the solution no more,
  /// freeze it anew. Collective. @return whether it did, on all ranks alike: then the step must be solved on.
  virtual bool update_penalties(const Interface<dim> & /*interface*/, double /*t*/,
                                const ValuesOf & /*unknowns*/, const MPI_Comm & /*communicator*/)
  {
    return false;
  }
  /// What the steps to come depend on beside the solution, such as penalties of the last step: as many
  /// numbers at each point of this rank. A checkpoint holds them, so that unpack_points() gets them back
  /// after begin_step().
  virtual std::vector<double> pack_points(const Interface<dim> & /*interface*/) const { return {}; }
  virtual void unpack_points(const Interface<dim> & /*interface*/, const std::vector<double> & /*numbers*/) {}
  /// What it remembers itself at each point, beside the laws of both sides.
  virtual std::vector<InternalVariable> internal_variables() const { return {}; }
  /// What the laws of both sides remember of a state: the trial of the interface's memory. @return false if
  /// one is not defined there, on this rank.
  virtual bool evaluate_memory(Interface<dim> &interface, double t, const ValuesOf &unknowns);

  /// What a user should know about this tie, if anything; after add_constraints, the same on all ranks.
  virtual NoteList notes() const { return {}; }
  /// For the plan: what distinguishes it from others of its Type, "Theta = 1, …", and "what: why" it can do
  /// without at this interface.
  virtual std::string description() const { return {}; }
  virtual std::vector<std::string> left_out(const Interface<dim> & /*interface*/) const { return {}; }

  /// Whether the derivatives of all terms are the same in all steps; if so, a linear scene assembles them
  /// once.
  virtual bool has_constant_tangent(const Interface<dim> & /*interface*/) const { return false; }
  virtual bool is_symmetric() const { return true; } ///< if the laws are; on this rank, in this step
  virtual bool is_linear() const { return true; }    ///< the terms are affine in the unknowns if the laws are

  /// Whether it asks for this field of its sides although it does not tie it.
  virtual bool looks_at(const Field & /*field*/) const { return false; }
  /// Whether a toggle that looks at fields switches its points between steps; and whether it has done so at
  /// the beginning of this step, on any rank: then the fluxes are on another curve.
  virtual bool follows_fields() const { return false; }
  virtual bool has_switched() const { return false; }

  /// Whether a constant of the field that one side has and the other not costs anything: then what keeps one
  /// side from drifting keeps the other, too.
  virtual bool holds(const TiedField & /*field*/) const { return true; }
  /// Whether the sides may come apart, for which the linear solver must know the modes of each body.
  virtual bool allows_jump(const TiedField & /*field*/) const { return false; }
  /// Whether at time @p t it surely resists every motion of one side against the other, rotations too.
  virtual bool surely_holds(const TiedField &field, double /*t*/) const { return !allows_jump(field); }

  /// The influx into the source at a point as the tie sees it, from the states of both sides, their influxes
  /// A.N (each through its own normal) and the jump; without a better one the mean of the influxes.
  virtual void numerical_flux(const Interface<dim> & /*interface*/, const TiedField & /*field*/,
                              unsigned int /*q*/, const std::array<State<dim>, 2> & /*state*/,
                              const std::array<std::vector<double>, 2> &flux, const std::vector<double> &jump,
                              std::vector<double> &result) const
  {
    for (unsigned int c = 0; c < jump.size(); ++c)
      result[c] = (flux[source][c] - flux[destination][c]) / 2;
  }

  /// Per area at a point, by the numerical flux and the jump, if its forces follow from an energy; a tie
  /// without terms, whose jump does no work, has none.
  virtual std::optional<double> energy(const Interface<dim> & /*interface*/, const TiedField & /*field*/,
                                       unsigned int /*q*/, const std::vector<double> & /*numerical_flux*/,
                                       const std::vector<double> & /*jump*/) const
  {
    return 0.;
  }
};

template <int dim>
using TieCatalogue = Catalogue<Tie<dim>>;

/// Register a class template over dim in both dimensions.
template <template <int> class Derived>
bool add_tie(const std::string &name, const std::string &help)
{
  return TieCatalogue<2>::template add<Derived<2>>(name, help) &&
         TieCatalogue<3>::template add<Derived<3>>(name, help);
}

} // namespace dovetail
