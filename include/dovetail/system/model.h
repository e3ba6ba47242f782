// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Everything a scene is made of, before anything is solved.

#pragma once

#include <dovetail/domain/numbering.h>
#include <dovetail/interface/interface.h>
#include <dovetail/system/vector.h>

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace dovetail {

/// All domains and interfaces of a scene, and the numbering of their unknowns.
template <int dim>
class Model
{
public:
  /// Reads `Toggles`, `Materials`, `Domains` and `Interfaces`; makes the meshes. Collective.
  Model(const Section &scene, const MPI_Comm &communicator);
  /// The same bodies on the same meshes, with elements that are @p more_degrees higher, tied such that the
  /// errors of @p other show (Tie::type_for_errors). It has no materials of its own and lives no longer than
  /// @p other keeps its meshes. Collective.
  Model(const Model &other, unsigned int more_degrees);

  /// Find the partners of all interfaces. Collective; nothing happens without interfaces.
  void pair();

  /// Refine every domain that can be refined (Domain::refine; marks by domain) and number and pair anew.
  /// Collective. @return @p ghosted on the new meshes, owned entries.
  Vector refine(const std::vector<std::vector<bool>> &marked, const Vector &ghosted);

  /// An error if two interfaces that are active at time @p t tie the same field on the same boundaries.
  void check_ties(double t) const;

  MPI_Comm communicator;
  Toggles toggles;
  std::vector<std::unique_ptr<Material<dim>>> materials;
  std::vector<std::unique_ptr<Domain<dim>>> domains;
  std::vector<std::unique_ptr<Interface<dim>>> interfaces;
  std::unique_ptr<Numbering> numbering;

  /// Names of all fields that some domain has, in the order in which they can be solved one after another: a
  /// field comes after those its fluxes depend on. Fields that depend on each other stand in one group.
  std::vector<std::vector<std::string>> field_groups() const;

  /// Of each group its number in the order in which Newton's method solves them: a group that is affine, and
  /// that is driven by others, is solved when those have converged. Others iterate together: one after the
  /// other they would take more assemblies. A linear scene has one stage, because the linear solver takes the
  /// groups one after the other anyway.
  std::vector<unsigned int> stages() const;
  std::map<std::string, unsigned int> stages_of_fields() const; ///< likewise, by name
  /// Whether no block of one stage by another is needed: residuals tell what drives a stage. Accelerations at
  /// the beginning of a motion are those of all fields at once.
  bool solves_stages_apart() const { return order_in_time() < 2; }

  unsigned int order_in_time() const; ///< of the rates that materials ask for
  bool sees_past() const;             ///< some material asks for the values of the steps before
  bool has_large_strain() const;      ///< of some solid
  bool is_linear() const;             ///< one Newton iteration is exact
  bool
  is_linear(const std::vector<std::string> &fields) const; ///< likewise, for these fields of field_groups()
  std::vector<bool> active_toggles(double t) const;        ///< of all conditions and interfaces, in order
  bool has_conditions_by_fields() const; ///< their toggles look at fields at the last good state
  bool depends(const std::string &field, const std::string &on_field) const; ///< in some material
  bool has_constant_tangent() const; ///< likewise, and it changes with toggles only
  /// The field's own block of the tangent, what this rank knows of it: a tie may lose its symmetry in a step.
  bool is_symmetric(const std::string &field) const;
  bool allows_jumps(const std::string &field) const; ///< some interface lets its sides come apart
  unsigned int degree() const;                       ///< the largest of the domains

  /// Near-null space of the block of a field of a domain at some of this rank's unknowns, by default all: the
  /// constant for scalars; for vectors translations and rotations scaled to order one, about the centre of
  /// the domain or, if @p about_one_point, about one point for all of them. A body that has turned at large
  /// strain resists rotations of the place where it was, so these are of the one with @p displacements: all
  /// unknowns, ghosted.
  std::vector<std::vector<double>> near_null_space(const Block &block, bool about_one_point,
                                                   const std::vector<unsigned int> *unknowns = nullptr,
                                                   const Vector *displacements = nullptr) const;

  double pairing_seconds = 0; ///< search and shape functions, this rank
  double search_seconds = 0;  ///< the search alone, this rank

private:
  template <typename IsAsked>
  bool is_linear_in(const IsAsked &is_asked) const;
  void find_interfaces(const Section &scene) const;
  void tell_other_interfaces();
  void number();
  void make_covers();
  void check_acts_somewhere(const Domain<dim> &domain, const Condition<dim> &condition) const;
  /// At a time, or with everything active.
  void check_constants(std::optional<double> t = {}) const;
  std::set<const Domain<dim> *> held_domains(const std::string &field, unsigned int component,
                                             std::optional<double> t, bool with_reactions = true) const;
  bool is_held_by_source(const Domain<dim> &domain, unsigned int c, std::optional<double> t) const;
};

/// "left, right".
template <int dim>
std::string names_of(const std::vector<const Domain<dim> *> &bodies);

} // namespace dovetail
