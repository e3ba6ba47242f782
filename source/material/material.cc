// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/material.h>
#include <dovetail/material/material_part.h>
#include <dovetail/material/solid_term.h>
#include <dovetail/scene/undefined.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

using dealii::Tensor;

template <int dim>
Material<dim>::Material(const std::string &name, const Section &section) : name(name), choice(section)
{
  const auto parts = MaterialParts<dim>::create(section);
  for (const auto &part : parts)
    for (Field field : part->fields()) {
      field.first_component = n_components();
      all_fields.push_back(field);
    }
  for (const auto &part : parts)
    part->add_terms(all_fields, terms);
  section.check(!all_fields.empty(), "",
                "has no law: set Type in its subsection Solid or Heat, or name Species.");
  phases.assign(terms.size(), 0);
  choice.set_fields(all_fields);
  for (unsigned int m = 1; m < choice.materials().size(); ++m)
    add_phase(choice.materials()[m]);
  set_up_terms();
}

/// The terms of a material that may take the place of this one, but for those that store.
template <int dim>
void Material<dim>::add_phase(const Section &other)
{
  const Section &own = choice.materials()[0];
  const auto parts = MaterialParts<dim>::create(other);
  std::vector<std::string> names, own_names;
  for (const auto &part : parts)
    for (const Field &field : part->fields())
      names.push_back(field.name);
  for (const Field &field : all_fields)
    own_names.push_back(field.name);
  own.check(names == own_names, "Otherwise",
            "leads to " + other.path() + ", which has the fields " + comma_separated(names) +
                ", but this material has " + comma_separated(own_names) +
                ". Give all phases of a material the same fields.");
  for (const auto &part : parts)
    for (const auto &[subsection, entry] : part->entries_of_storage()) {
      const std::string value = own.peek(subsection, entry), other_value = other.peek(subsection, entry);
      own.check(value == other_value, "Otherwise",
                "leads to " + other.path() + ", where " + entry + " is '" + other_value + "', not '" + value +
                    "': what is stored must be the same in all phases, else a change of phase would not "
                    "conserve it. Write " +
                    entry + " once for all of them, as a formula.");
    }
  std::vector<std::unique_ptr<Term<dim>>> all;
  for (const auto &part : parts)
    part->add_terms(all_fields, all);
  const auto phase = static_cast<unsigned int>(phases.back() + 1);
  for (auto &term : all)
    if (term->order_in_time() == 0) {
      terms.push_back(std::move(term));
      phases.push_back(phase);
    }
}

template <int dim>
void Material<dim>::set_up_terms()
{
  const unsigned int n = n_components();
  couplings.resize(n * n);
  orders_in_time.assign(n, 0);
  all_responses.assign(all_fields.size(), Asked::response);
  all_derivatives.assign(all_fields.size(), Asked::derivatives);
  for (const auto &term : terms) {
    const unsigned int first = term->field.first_component, end = first + term->field.n_components;
    needed_by.emplace_back();
    field_of_term.push_back(std::find_if(all_fields.begin(), all_fields.end(),
                                         [&](const Field &field) { return field.has_component(first); }) -
                            all_fields.begin());
    remembers.push_back(!term->internal_variables().empty());
    largest_order_in_time = std::max(largest_order_in_time, term->order_in_time());
    has_past = has_past || term->sees_past();
    for (unsigned int c = first; c < end; ++c)
      orders_in_time[c] = std::max(orders_in_time[c], term->order_in_time());
    for (unsigned int d = 0; d < n; ++d) {
      bool is_needed = d >= first && d < end;
      for (unsigned int c = first; c < end; ++c) {
        const Coupling coupling = term->coupling(c, d);
        couplings[c * n + d] |= coupling;
        is_needed = is_needed || coupling.any();
      }
      if (is_needed)
        needed_by.back().push_back(d);
    }
  }
  for (const InternalVariable &variable : choice.internal_variables())
    memory_at_start.insert(memory_at_start.end(), variable.n_components, variable.initial);
  for (const auto &term : terms) {
    term->first_internal_variable = memory_at_start.size();
    for (const InternalVariable &variable : term->internal_variables())
      memory_at_start.insert(memory_at_start.end(), variable.n_components, variable.initial);
  }
  for (unsigned int pair = 0; pair < n * n; ++pair) {
    if (couplings[pair].in_flux())
      flux_pairs.push_back(pair);
    if (couplings[pair].in_source())
      source_pairs.push_back(pair);
  }
}

template <int dim>
const Field *Material<dim>::find_field(const std::string &field_name) const
{
  for (const Field &field : all_fields)
    if (field.name == field_name)
      return &field;
  return nullptr;
}

template <int dim>
unsigned int Material<dim>::n_components() const
{
  return all_fields.empty() ? 0 : all_fields.back().first_component + all_fields.back().n_components;
}

template <int dim>
bool Material<dim>::evaluate(const State<dim> &state, const std::vector<Asked> &asked,
                             Response<dim> &response) const
{
  const bool with_derivatives = std::find(asked.begin(), asked.end(), Asked::derivatives) != asked.end();
  AssertDimension(asked.size(), all_fields.size());
  AssertDimension(state.gradient.size(), n_components());
  AssertDimension(response.flux.size(), n_components());
  AssertDimension(state.memory.accepted.size(), memory_at_start.size());
  AssertDimension(state.memory.trial.size(), memory_at_start.size());
  std::copy(state.memory.accepted.begin(), state.memory.accepted.end(), state.memory.trial.begin());
  std::fill(response.flux.begin(), response.flux.end(), Tensor<1, dim>());
  std::fill(response.source.begin(), response.source.end(), 0.);
  if (with_derivatives) {
    if (!flux_pairs.empty()) { // one range is faster than many small ones
      std::fill_n(&response.by_gradient[0][0][0], response.by_gradient.size() * dim * dim, 0.);
      std::fill_n(&response.by_value[0][0], response.by_value.size() * dim, 0.);
    }
    for (const unsigned int pair : source_pairs) {
      response.source_by_gradient[pair] = 0;
      response.source_by_value[pair] = 0;
    }
  }
  if (has_phases())
    choice.remember(state);
  const unsigned int phase = has_phases() ? choice.at(state) : 0;
  if (phase == PhaseChoice<dim>::not_known)
    return undefined("the Toggle of the material " + name + " is not a number at " + in_words(state.X) +
                         " and t = " + in_words(state.t),
                     true);
  for (unsigned int i = 0; i < terms.size(); ++i) {
    const auto &term = terms[i];
    const unsigned int first = term->field.first_component;
    const Asked of_term = asked[field_of_term[i]];
    if (of_term == Asked::nothing && !remembers[i])
      continue;
    if (!holds(i, phase)) {
      term->pass(state);
      continue;
    }
    if (term->order_in_time() > 0 && state.rate.empty())
      continue;
    if (std::any_of(needed_by[i].begin(), needed_by[i].end(),
                    [&](const unsigned int c) { return std::isnan(state.value[c]); })) {
      const double not_known = std::numeric_limits<double>::quiet_NaN();
      for (unsigned int c = first; c < first + term->field.n_components; ++c) {
        if (term->has_source())
          response.source[c] = not_known;
        for (unsigned int d = 0; term->has_flux() && d < dim; ++d)
          response.flux[c][d] = not_known;
      }
      continue;
    }
    term->n_evaluations.fetch_add(1, std::memory_order_relaxed);
    if (!term->add(state, of_term == Asked::derivatives, response))
      return false;
  }
  return true;
}

template <int dim>
void Material<dim>::look_at_start(const State<dim> &state) const
{
  std::copy(state.memory.accepted.begin(), state.memory.accepted.end(), state.memory.trial.begin());
  choice.remember(state);
  for (const auto &term : terms)
    term->pass(state);
}

template <int dim>
bool Material<dim>::evaluate_storage(const State<dim> &state, Response<dim> &response) const
{
  std::copy(state.memory.accepted.begin(), state.memory.accepted.end(), state.memory.trial.begin());
  std::fill(response.source.begin(), response.source.end(), 0.);
  for (const unsigned int pair : source_pairs)
    response.source_by_value[pair] = 0;
  return std::all_of(terms.begin(), terms.end(), [&](const auto &term) {
    return term->order_in_time() == 0 || term->add(state, true, response);
  });
}

template <int dim>
void Material<dim>::curvature(const State<dim> &state, const std::vector<Tensor<1, dim>> &w,
                              dealii::FullMatrix<double> &result) const
{
  AssertDimension(w.size(), n_components());
  result.reinit(n_components() * (1 + dim), n_components() * (1 + dim));
  const unsigned int phase = has_phases() ? choice.at(state) : 0;
  for (unsigned int i = 0; i < terms.size(); ++i) {
    const auto &term = terms[i];
    const auto first = w.begin() + term->field.first_component;
    if (holds(i, phase) && !term->is_linear() &&
        std::any_of(first, first + term->field.n_components,
                    [](const auto &w_c) { return w_c.norm_square() > 0; }))
      term->add_curvature(state, w, result);
  }
}

template <int dim>
const SolidTerm<dim> &Material<dim>::solid_term(const unsigned int phase) const
{
  for (unsigned int i = 0; i < terms.size(); ++i)
    if (const auto *solid = dynamic_cast<const SolidTerm<dim> *>(terms[i].get());
        solid != nullptr && holds(i, phase))
      return *solid;
  AssertThrow(false, dealii::ExcMessage("A material without a solid law has no stress and does not deform."));
}

template <int dim>
const Field *Material<dim>::solid_field() const
{
  return find_field("displacement");
}

template <int dim>
double Material<dim>::solid_density() const
{
  return solid_term().density;
}

template <int dim>
Tensor<2, 3> Material<dim>::cauchy_stress(const State<dim> &state) const
{
  Tensor<2, 3> sigma; // in a mixed formulation a sum
  const unsigned int phase = has_phases() ? choice.at(state) : 0;
  for (unsigned int i = 0; i < terms.size(); ++i)
    if (const auto *solid = dynamic_cast<const SolidTerm<dim> *>(terms[i].get());
        solid != nullptr && holds(i, phase))
      sigma += solid->cauchy_stress(state);
  return sigma;
}

template <int dim>
double Material<dim>::energy_density(const State<dim> &state) const
{
  const unsigned int phase = has_phases() ? choice.at(state) : 0;
  double sum = 0;
  for (unsigned int i = 0; i < terms.size(); ++i)
    sum += holds(i, phase) ? terms[i]->energy_density(state) : 0;
  return sum;
}

template <int dim>
Tensor<2, 3> Material<dim>::displacement_gradient(const State<dim> &state) const
{
  return solid_term(choice.at(state)).full_displacement_gradient(state);
}

template <int dim>
Coupling Material<dim>::coupling_of_fields(const unsigned int field, const unsigned int on_field) const
{
  AssertIndexRange(field, all_fields.size());
  AssertIndexRange(on_field, all_fields.size());
  const Field &of = all_fields[field], &on = all_fields[on_field];
  Coupling result;
  for (unsigned int c = of.first_component; c < of.first_component + of.n_components; ++c)
    for (unsigned int d = on.first_component; d < on.first_component + on.n_components; ++d)
      result |= coupling(c, d);
  return result;
}

template <int dim>
bool Material<dim>::depends(const unsigned int field, const unsigned int on_field) const
{
  return field == on_field || coupling_of_fields(field, on_field).any();
}

template <int dim>
bool Material<dim>::flux_depends(const unsigned int field, const unsigned int on_field) const
{
  return field == on_field || coupling_of_fields(field, on_field).in_flux();
}

template <int dim>
template <typename Predicate>
bool Material<dim>::all_terms(const unsigned int field, const Predicate &does) const
{
  AssertIndexRange(field, all_fields.size());
  return std::all_of(terms.begin(), terms.end(), [&](const auto &term) {
    return term->field.first_component != all_fields[field].first_component || does(*term);
  });
}

template <int dim>
bool Material<dim>::has_source(const unsigned int field) const
{
  return !all_terms(field, [](const Term<dim> &term) { return !term.has_source(); });
}

template <int dim>
bool Material<dim>::has_load(const unsigned int field) const
{
  return !all_terms(field,
                    [](const Term<dim> &term) { return !term.has_source() || term.order_in_time() > 0; });
}

template <int dim>
bool Material<dim>::has_load_by_state() const
{
  return std::any_of(terms.begin(), terms.end(), [this](const auto &term) {
    bool depends = false;
    for (unsigned int c = 0; c < term->field.n_components; ++c)
      for (unsigned int d = 0; d < n_components(); ++d)
        depends = depends || term->coupling(term->field.first_component + c, d).in_source();
    return depends && term->order_in_time() == 0;
  });
}

template <int dim>
bool Material<dim>::has_large_strain() const
{
  return std::any_of(terms.begin(), terms.end(), [](const auto &term) { return term->has_large_strain(); });
}

template <int dim>
bool Material<dim>::is_linear(const unsigned int field) const
{
  return all_terms(field, [](const Term<dim> &term) { return term.is_linear(); });
}

template <int dim>
bool Material<dim>::has_linear_flux(const unsigned int field) const
{
  return all_terms(field, [](const Term<dim> &term) { return !term.has_flux() || term.is_linear(); });
}

/// What stores is left out where the rates are not known.
template <int dim>
bool Material<dim>::is_uniform(const unsigned int field) const
{
  return !has_phases() && !has_memory() && all_terms(field, [](const Term<dim> &term) {
    return term.is_uniform() || term.order_in_time() > 0;
  });
}

template <int dim>
bool Material<dim>::has_uniform_stiffness(const unsigned int field) const
{
  return all_terms(field,
                   [](const Term<dim> &term) { return !term.has_flux() || term.has_uniform_stiffness(); });
}

template <int dim>
void Material<dim>::count_uniform(const std::vector<Asked> &asked, const unsigned int n_points) const
{
  for (unsigned int i = 0; i < terms.size(); ++i)
    if (asked[field_of_term[i]] != Asked::nothing && terms[i]->is_uniform())
      terms[i]->n_evaluations.fetch_add(n_points, std::memory_order_relaxed);
}

template <int dim>
bool Material<dim>::is_symmetric(const unsigned int field) const
{
  return all_terms(field, [](const Term<dim> &term) { return term.is_symmetric(); });
}

template <int dim>
bool Material<dim>::depends_on_time() const
{
  return has_phases() ||
         std::any_of(terms.begin(), terms.end(), [](const auto &term) { return term->depends_on_time(); });
}

template <int dim>
bool Material<dim>::stores_by_position() const
{
  return std::any_of(terms.begin(), terms.end(), [](const auto &term) { return term->stores_by_position(); });
}

template <int dim>
const Term<dim> *Material<dim>::storing_term(const unsigned int component) const
{
  for (const auto &term : terms)
    if (term->field.has_component(component) && term->order_in_time() > 0)
      return term.get();
  return nullptr;
}

template <int dim>
double Material<dim>::content(const State<dim> &state, const unsigned int component) const
{
  const Term<dim> *term = storing_term(component);
  return term != nullptr ? term->content(state) : std::numeric_limits<double>::quiet_NaN();
}

template <int dim>
double Material<dim>::liquid_fraction(const State<dim> &state, const unsigned int component) const
{
  const Term<dim> *term = storing_term(component);
  return term != nullptr ? term->liquid_fraction(state) : std::numeric_limits<double>::quiet_NaN();
}

template <int dim>
bool Material<dim>::has_curvature(const unsigned int field) const
{
  return all_terms(field, [](const Term<dim> &term) {
    return !term.has_flux() || term.is_linear() || term.has_curvature();
  });
}

template <int dim>
std::vector<InternalVariable> Material<dim>::internal_variables() const
{
  std::vector<InternalVariable> all = choice.internal_variables();
  for (unsigned int i = 0; i < terms.size(); ++i)
    for (InternalVariable variable : terms[i]->internal_variables()) {
      if (phases[i] > 0)
        variable.name += " of phase " + std::to_string(phases[i]);
      all.push_back(variable);
    }
  return all;
}

template <int dim>
std::string Material<dim>::description(const unsigned int field) const
{
  std::string words;
  unsigned int phase = 0;
  for (unsigned int i = 0; i < terms.size(); ++i)
    if (terms[i]->field.name == all_fields[field].name) {
      words += (words.empty() ? "" : phases[i] > phase ? " or " : " with ") + terms[i]->description();
      phase = phases[i];
    }
  words += is_linear(field) ? ", linear" : ", nonlinear";
  for (unsigned int other = 0; other < all_fields.size(); ++other)
    if (other != field && depends(field, other))
      words += ", depends on the " + all_fields[other].name;
  return words;
}

template <int dim>
unsigned long Material<dim>::evaluations(const std::string &law) const
{
  unsigned long n = 0;
  for (const auto &term : terms)
    if (term->field.law == law && term->has_flux())
      n += term->n_evaluations;
  return n;
}

template class Material<2>;
template class Material<3>;

} // namespace dovetail
