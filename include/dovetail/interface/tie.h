// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The methods that tie two bodies.

#pragma once

#include <dovetail/domain/constraint_lines.h>
#include <dovetail/interface/pairing.h>
#include <dovetail/scene/catalogue.h>

#include <deal.II/lac/full_matrix.h>

#include <array>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace dovetail {

template <int dim>
class Interface;

/// A field that both sides have and that is tied.
struct TiedField
{
  std::string name;
  unsigned int n_components;
  std::array<unsigned int, 2> field;           ///< index among the fields of each side's domain
  std::array<unsigned int, 2> first_component; ///< among the components of each side's domain
};

/// How an interface is tied. A plugin overrides only what it needs: constraints between the unknowns of the
/// two sides, or terms at the points of the pairing. It may assume that a group's unknowns are those of
/// Interface::group_dofs, in that order. Copy nitsche.cc or pointwise.cc.
template <int dim>
class Tie
{
public:
  virtual ~Tie() = default;

  /// Once the fields are known: check the entries that depend on them.
  virtual void set_fields(const Section & /*section*/, const std::vector<TiedField> & /*fields*/) {}

  /// The sides on whose faces the points of the pairing lie.
  virtual std::array<bool, 2> integrates_on() const = 0;

  /// Lines for destination unknowns that this rank owns. Collective. Keep what is already in @p lines:
  /// hanging nodes and prescribed values win.
  virtual void add_constraints(const Interface<dim> & /*interface*/, ConstraintLines & /*lines*/,
                               const MPI_Comm & /*communicator*/)
  {
  }

  virtual bool adds_terms() const { return false; }

  /// Gives the values of unknowns of cells that this rank owns or of groups of its points.
  using Unknowns = std::function<void(const std::vector<dealii::types::global_dof_index> &dofs,
                                      std::vector<double> &values)>;
  /// Before the first iteration of a step: freeze penalty and weights at the last good state. Collective.
  virtual void begin_step(const Interface<dim> & /*interface*/, double /*t*/, const Unknowns & /*unknowns*/,
                          const MPI_Comm & /*communicator*/)
  {
  }

  /// Residual and, if @p tangent is not nullptr, its exact derivative over the points of a group; both come
  /// in as zero. @return false if a law is not defined at the state of a point.
  virtual bool assemble(const Interface<dim> & /*interface*/, const typename Pairing<dim>::Group & /*group*/,
                        double /*t*/, const std::vector<double> & /*unknowns*/,
                        std::vector<double> & /*residual*/, dealii::FullMatrix<double> * /*tangent*/)
  {
    return true;
  }

  virtual bool is_symmetric() const { return true; } ///< if the laws are
  virtual bool is_linear() const { return true; }    ///< the terms are affine in the unknowns if the laws are
  /// Whether a constant of the field that one side has and the other not costs anything: then what keeps one
  /// side from drifting keeps the other, too.
  virtual bool holds(const TiedField & /*field*/) const { return true; }
  /// Whether the sides may come apart, for which the linear solver must know the modes of each body.
  virtual bool allows_jump(const TiedField & /*field*/) const { return false; }
  /// Whether both sides get the same flux at every point; else each gets that of the points on its own faces.
  virtual bool is_balanced() const { return true; }

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

  /// For the report; infinity or zero where there is nothing to say.
  struct Penalty
  {
    double smallest = std::numeric_limits<double>::infinity();
    double largest = 0;
    /// gamma over its lower bound, minus 1: coercive if positive.
    double coercivity_margin = std::numeric_limits<double>::infinity();
  };
  virtual Penalty penalty() const { return {}; } ///< of this rank's points

  /// How often first and second variations of a flux have been evaluated at points of this rank.
  struct FluxVariations
  {
    unsigned long first = 0, second = 0;
  };
  virtual FluxVariations flux_variations() const { return {}; }
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
