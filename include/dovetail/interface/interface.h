// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A pair of boundaries that is tied: two sides, the fields, the pairing and the tie.

#pragma once

#include <dovetail/interface/interface_memory.h>
#include <dovetail/interface/tie.h>
#include <dovetail/scene/note.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// One `subsection Interface NAME`.
template <int dim>
class Interface
{
public:
  /// Reads the section and checks it against the domains; the pairing is made later, by pair(). Collective.
  Interface(const std::string &name, const Section &section,
            const std::vector<std::unique_ptr<Domain<dim>>> &domains, const Toggles &toggles);

  const std::string name;
  const Section section; ///< for error messages
  std::array<InterfaceSide<dim>, 2> sides;
  std::vector<TiedField> fields;

  /// Components of each side's domain that are tied or that the flux of a tied field depends on.
  std::array<std::vector<unsigned int>, 2> components;

  /// Find the partners; obeys `Uncovered`. Collective.
  void pair(const MPI_Comm &communicator);
  const Pairing<dim> &pairing() const { return *geometry; }
  bool is_paired() const { return geometry != nullptr; }
  /// What the laws of both sides remember at the points.
  InterfaceMemory<dim> memory;
  /// What it has cost so far; whoever works for it adds to that.
  InterfaceWork &work() const { return all_work; }
  /// Finds points on the faces of a side as pair() does.
  FaceLocator<dim> make_locator(unsigned int side, const MPI_Comm &communicator) const;
  /// For the next one on meshes that have been refined: what the one before has tied stays tied, what is
  /// remembered at its points goes over to the nearest ones, and its work counts. Collective.
  void follow(const Interface &other);
  GapExtension gap_extension() const { return options.gap_extension; }

  Tie<dim> &tie() const { return *method; }
  /// What a user should know of the geometry and of the tie.
  NoteList notes() const;
  bool has_toggle() const { return !toggle.empty(); }
  /// The tie, where its points lie, and what joins them: "Nitsche, Theta = 1, …, segments on the source".
  std::string description() const;
  /// An error if this and another interface, both active @p when, tie one field on the same pair of
  /// boundaries (by their ids; with the same shift).
  void check_against(const Interface &other, const std::string &when) const;
  /// Whether the domain of a side has conditions on its tied boundary ids and fields.
  bool has_conditions(unsigned int side) const;
  bool is_active(const double t) const { return toggles->is_active(toggle, t); }

  /// Number of local unknowns of one side of a group: those of components[side].
  unsigned int n_local(const unsigned int side) const { return n_unknowns[side]; }
  /// The first unknown of a component of a side among those of a group.
  unsigned int first_unknown(unsigned int side, unsigned int component) const;
  /// Global unknowns of a group: source then destination, each in the order component, node.
  void group_dofs(const typename Pairing<dim>::Group &group,
                  std::vector<dealii::types::global_dof_index> &dofs) const;
  /// The jump of a field at a point less the prescribed one, [B] - c, all components.
  void jump(const TiedField &field, unsigned int q, double t, const std::vector<double> &unknowns,
            std::vector<double> &result) const;
  /// The entry Jump, c: what [B] is to be where it is tied; at a point @p X of the source. NaN, with the
  /// reason left, where it is not a finite number.
  bool has_prescribed_jump() const { return has_jump; }
  double prescribed_jump(const dealii::Point<dim> &X, double t, unsigned int component) const;
  /// Whether constraints or equations of multipliers change with t because it does.
  bool has_moving_constraints() const { return has_moving_jump() && method->parts().elimination != nullptr; }
  /// Whether the prescribed jump changes with t.
  bool has_moving_jump() const { return has_jump && given_jump.depends_on_time(); }
  /// Which of the unknowns of a group the jump of a tied field or its variation depends on, at any point of
  /// it.
  std::vector<bool> unknowns_in_jump(const typename Pairing<dim>::Group &group) const;
  /// Shape functions at a point that are smaller than this are rounding: their node is not on the interface.
  static constexpr double least_in_jump = 1e-14;
  /// Of a group whose terms depend on traces and gradients at its points.
  const LeadingUnknowns &leading_unknowns(const typename Pairing<dim>::Group &group) const
  {
    return *leading[&group - geometry->groups.data()];
  }
  /// Of one whose terms depend on more than that.
  const LeadingUnknowns &all_unknowns() const { return every_unknown; }
  /// Position of a component of the domain among components[side].
  unsigned int position(unsigned int side, unsigned int component) const;
  /// Whether the unknown of component index r (row, counted over both sides' components) couples with that of
  /// s.
  bool couples(unsigned int row, unsigned int column) const;
  /// Whether the fluxes of the tied fields are affine in the unknowns.
  bool is_linear() const;
  /// Whether the derivatives of these fluxes are the same in all steps.
  bool has_constant_fluxes() const;
  bool has_constant_flux(const TiedField &field) const; ///< likewise of one field
  bool is_symmetric() const                             ///< the terms of the tie, if the laws are
  {
    return method->is_symmetric() && options.gap_extension != GapExtension::trial;
  }

private:
  void check_toggle() const;
  void check_not_to_itself() const;
  void read_fields();
  void check_co_fields(const std::array<std::string, 2> &names) const;
  void add_field(const std::array<std::string, 2> &names);
  void read_jump();
  void read_partition();
  void find_components();
  double distance_of_sides(const MPI_Comm &communicator) const;
  void check_coverage(const MPI_Comm &communicator);
  void find_leading();

  typename Pairing<dim>::Options options;
  std::string uncovered; ///< error, warn or allow
  NoteList geometry_notes;
  std::array<unsigned int, 2> n_unknowns = {{0, 0}}; ///< of a group, by side
  bool has_jump = false;
  Expression given_jump;
  const Toggles *toggles;
  std::string toggle;
  std::unique_ptr<Tie<dim>> method;
  std::unique_ptr<Pairing<dim>> geometry;
  LeadingUnknowns every_unknown;
  std::map<std::array<unsigned int, 2>, LeadingUnknowns> leading_by_faces; ///< by face of each side's cell
  std::vector<const LeadingUnknowns *> leading;                            ///< of each group
  mutable InterfaceWork all_work; ///< counted by collective calls, so never by two threads at once
};

} // namespace dovetail
