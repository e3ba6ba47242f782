// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A material: a list of terms, seen by everybody else as one function from State to Response.

#pragma once

#include <dovetail/material/phase_choice.h>
#include <dovetail/material/term.h>
#include <dovetail/scene/section.h>

#include <memory>
#include <string>
#include <vector>

namespace dovetail {

template <int dim>
class SolidTerm;

/// The terms of one material. Its parts (material_part.h) bring the fields, ordered displacement,
/// temperature, species; a part that the scene does not name gives no field. Where a toggle is off another
/// material may take its place (phase_choice.h): then the terms of both are here, and those of one hold at a
/// point. What is stored does not change.
template <int dim>
class Material
{
public:
  Material(const std::string &name, const Section &section);

  const std::string name;
  /// While documenting one of every kind.
  const std::vector<Field> &fields() const { return all_fields; }
  const Field *find_field(const std::string &field_name) const; ///< nullptr if it has no such field
  unsigned int n_components() const;
  const Field *solid_field() const; ///< the displacement; nullptr without a solid law
  double solid_density() const;     ///< mass per undeformed volume, 0: not given. @pre It has a displacement.

  /// @return false if a law is not defined at this state. A term that needs a component whose value is
  /// NaN gives NaN and remembers what it has: an interface does not know the fields that it does not tie.
  /// Derivatives that vanish identically are not touched; coupling() tells them.
  bool evaluate(const State<dim> &state, const bool with_derivatives, Response<dim> &response) const
  {
    return evaluate(state, asks_for_all(with_derivatives), response);
  }
  /// Likewise, but of each field what @p asked says: fluxes and sources of which nothing is asked mean
  /// nothing, and terms that remember something are evaluated in any case.
  bool evaluate(const State<dim> &state, const std::vector<Asked> &asked, Response<dim> &response) const;
  /// The same of all fields.
  const std::vector<Asked> &asks_for_all(const bool with_derivatives) const
  {
    return with_derivatives ? all_derivatives : all_responses;
  }
  /// Likewise, but of the sources only what is stored, with derivatives: that of the terms that ask for
  /// rates. The fluxes are not touched. @pre The rates are known.
  bool evaluate_storage(const State<dim> &state, Response<dim> &response) const;

  /// Second derivatives of sum_c w_c . A_c by all of S = (B_0, grad B_0, B_1, grad B_1, …): a symmetric
  /// matrix of size n (1 + dim), component d at rows d (1 + dim) …; zero blocks are zero. Only the terms of
  /// fields in which w is not zero are evaluated.
  void curvature(const State<dim> &state, const std::vector<dealii::Tensor<1, dim>> &w,
                 dealii::FullMatrix<double> &result) const;

  /// The force per deformed area, three-dimensional also in plane strain (SolidTerm::cauchy_stress). @pre The
  /// material has a displacement.
  dealii::Tensor<2, 3> cauchy_stress(const State<dim> &state) const;
  double energy_density(const State<dim> &state) const; ///< that of all terms, Term::energy_density()
  /// H = F - I = grad u, also across the plane of a scene in 2D. NaN where the solid law is not defined.
  /// @pre likewise.
  dealii::Tensor<2, 3> displacement_gradient(const State<dim> &state) const;

  /// What is stored of the field of a component, Term::content() and Term::liquid_fraction(); NaN if nothing.
  double content(const State<dim> &state, unsigned int component) const;
  double liquid_fraction(const State<dim> &state, unsigned int component) const;

  /// How component c depends on component d.
  const Coupling &coupling(const unsigned int c, const unsigned int d) const
  {
    return couplings[c * n_components() + d];
  }
  bool depends(unsigned int field, unsigned int on_field) const; ///< A or S of one field on another
  bool flux_depends(unsigned int field, unsigned int on_field) const;
  bool has_source(unsigned int field) const;
  bool has_load(unsigned int field) const; ///< a source that stores nothing
  bool has_load_by_state() const;          ///< such a source depends on the fields
  /// The highest order of the rates that the terms of a component's field ask for; 0 in static scenes.
  unsigned int order_in_time(const unsigned int component) const { return orders_in_time[component]; }
  unsigned int order_in_time() const { return largest_order_in_time; } ///< of all fields
  bool sees_past() const { return has_past; }                          ///< a term asks for State::past
  bool stores_by_position() const;                                     ///< what is stored depends on X itself
  bool is_linear(unsigned int field) const;       ///< affine in all fields, so constant derivatives
  bool has_linear_flux(unsigned int field) const; ///< the same of the flux alone
  /// Whether all that evaluate() gives for a field without rates is Term::is_uniform().
  bool is_uniform(unsigned int field) const;
  bool has_uniform_stiffness(unsigned int field) const; ///< all fluxes have Term::has_uniform_stiffness()
  /// Count @p n_points more points of the fields of which something is asked: evaluate() would have said
  /// there what it has said before.
  void count_uniform(const std::vector<Asked> &asked, unsigned int n_points) const;
  bool has_large_strain() const; ///< a law knows the deformed body; its derivatives State::linearised_at
  bool is_symmetric(unsigned int field) const; ///< own block of the tangent is symmetric, and not negative
  bool depends_on_time() const;
  /// Whether all nonlinear fluxes of a field have second derivatives.
  bool has_curvature(unsigned int field) const;

  /// What its terms remember at a point, and how that begins, number by number.
  std::vector<InternalVariable> internal_variables() const;
  const std::vector<double> &initial_memory() const { return memory_at_start; }
  bool has_memory() const { return !memory_at_start.empty(); }

  bool has_phases() const { return choice.is_given(); } ///< another material may take its place
  /// Whether its toggles look at a component, whatever the terms depend on.
  bool chooses_by(const unsigned int component) const { return choice.sees(component); }
  /// Of the materials that may hold at a point the number of the one that does; 0 is the one of this name.
  unsigned int phase(const State<dim> &state) const { return choice.at(state); }
  /// Whether it remembers something that goes on in time, so that it has to see where that begins.
  bool has_to_look_at_start() const { return has_memory() && depends_on_time(); }
  /// Of the state before the first step: write the trial of what it remembers, as if all terms had let it
  /// pass; and which material holds there.
  void look_at_start(const State<dim> &state) const;

  /// "Fourier, linear"
  std::string description(unsigned int field) const;

  /// How often the terms with a flux of fields with this Field::law have been asked at points of this rank.
  unsigned long evaluations(const std::string &law) const;

private:
  void add_phase(const Section &other);
  void set_up_terms();
  const SolidTerm<dim> &solid_term(unsigned int phase = 0) const;
  /// Whether term i belongs to the material of this number.
  bool holds(const unsigned int i, const unsigned int phase) const
  {
    return !has_phases() || terms[i]->order_in_time() > 0 || phases[i] == phase;
  }
  template <typename Predicate>
  bool all_terms(unsigned int field, const Predicate &does) const;
  Coupling coupling_of_fields(unsigned int field, unsigned int on_field) const;

  std::vector<Field> all_fields;
  std::vector<std::unique_ptr<Term<dim>>> terms;
  PhaseChoice<dim> choice;
  std::vector<unsigned int> phases;                   ///< by term, the number of its material
  std::vector<std::vector<unsigned int>> needed_by;   ///< components, by term
  std::vector<Coupling> couplings;                    ///< of components (c, d) at c * n + d
  std::vector<unsigned int> flux_pairs, source_pairs; ///< those that have derivatives
  std::vector<double> memory_at_start;
  std::vector<unsigned int> orders_in_time; ///< by component
  unsigned int largest_order_in_time = 0;
  bool has_past = false;
  std::vector<unsigned int> field_of_term;           ///< among all fields
  std::vector<bool> remembers;                       ///< by term
  std::vector<Asked> all_responses, all_derivatives; ///< by field

  const Term<dim> *storing_term(unsigned int component) const; ///< nullptr if nothing is stored
};

} // namespace dovetail
