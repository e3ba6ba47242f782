// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/capacity_term.h>
#include <dovetail/scene/undefined.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

template <int dim>
CapacityTerm<dim>::CapacityTerm(const Field &field, const std::vector<Field> &all, const Section &section,
                                Contents parts, const double density, const double reference)
    : Term<dim>(field), scalars(all), own(scalars.number(field.first_component)), section(section),
      contents(std::move(parts)), density(density), reference(reference),
      is_affine(!any([](const Content &content) { return !content.is_linear(); }))
{
}

template <int dim>
template <typename Predicate>
bool CapacityTerm<dim>::any(const Predicate &is) const
{
  return std::any_of(contents.begin(), contents.end(), [&](const auto &content) { return is(*content); });
}

template <int dim>
bool CapacityTerm<dim>::depends_on_time() const
{
  return any([](const Content &content) { return content.depends_on_time(); });
}

template <int dim>
bool CapacityTerm<dim>::stores_by_position() const
{
  return any([](const Content &content) { return content.depends_on_position(); });
}

template <int dim>
Coupling CapacityTerm<dim>::coupling(const unsigned int /*c*/, const unsigned int d) const
{
  const unsigned int s = scalars.number(d);
  Coupling result;
  result.source_by_value = s == own || (s < scalars.size() && !is_affine && any([&](const Content &content) {
                                          return content.depends_on_scalar(s);
                                        }));
  return result;
}

/// Leave the reason why a content is not defined. @return false
template <int dim>
bool CapacityTerm<dim>::refuse(const Content &content, const State<dim> &state, const std::string &what,
                               const std::string &end) const
{
  return undefined(sentence_about(section, content.entry(),
                                  what + " at " + in_words(state.X) + " and t = " + in_words(state.t) + end),
                   content.is_linear());
}

/// Per mass and time.
template <int dim>
double CapacityTerm<dim>::change(const Content &content, const State<dim> &state,
                                 const ScalarState &here) const
{
  if (is_affine)
    return content.capacity(here) * state.rate[this->field.first_component];
  double sum = 0;
  for (unsigned int j = 0; j < state.past_weight.size(); ++j)
    sum -= state.past_weight[j] * content.change(here, past(state, j));
  return sum;
}

template <int dim>
bool CapacityTerm<dim>::add(const State<dim> &state, const bool with_derivatives,
                            Response<dim> &response) const
{
  if (state.rate_by_value == 0 && !is_affine) // nothing is stored here
    return true;
  const unsigned int c = this->field.first_component, n = state.value.size();
  const ScalarState here = scalars.state(state, own);
  for (const auto &content : contents) {
    const double capacity = content->capacity(here), source = change(*content, state, here);
    if (!(std::isfinite(capacity) && capacity >= 0))
      return refuse(*content, state, content->words_for_capacity() + in_words(capacity),
                    ", but must be positive.");
    if (!std::isfinite(source))
      return refuse(*content, state, "has an integral from the last state that is not a finite number");
    if (capacity == 0 && source == 0 && content->is_flat(here))
      return refuse(*content, state, "does not grow around " + in_words(here.value()),
                    ". Does its table begin above, or end below?");
    response.source[c] += density * source;
    if (!with_derivatives)
      continue;
    response.source_by_value[c * n + c] += density * capacity * state.rate_by_value;
    if (!add_slopes(*content, state, here, response))
      return false;
  }
  return true;
}

/// By other scalars.
template <int dim>
bool CapacityTerm<dim>::add_slopes(const Content &content, const State<dim> &state, const ScalarState &here,
                                   Response<dim> &response) const
{
  const unsigned int c = this->field.first_component, n = state.value.size();
  for (unsigned int s = 0; s < scalars.size() && !is_affine; ++s)
    if (s != own && content.depends_on_scalar(s)) {
      double slope = 0;
      for (unsigned int j = 0; j < state.past_weight.size(); ++j)
        slope -= density * state.past_weight[j] * content.slope_of_change(here, past(state, j), s);
      if (!std::isfinite(slope))
        return refuse(content, state, "has a derivative that is not a finite number");
      response.source_by_value[c * n + scalars.component(s)] += slope;
    }
  return true;
}

template <int dim>
double CapacityTerm<dim>::content(const State<dim> &state) const
{
  const ScalarState here = scalars.state(state, own);
  double sum = 0;
  for (const auto &content : contents)
    sum += density * content->change(here, reference);
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::quiet_NaN();
}

template <int dim>
double CapacityTerm<dim>::liquid_fraction(const State<dim> &state) const
{
  const ScalarState here = scalars.state(state, own);
  for (const auto &content : contents)
    if (const double fraction = content->liquid_fraction(here); !std::isnan(fraction))
      return fraction;
  return std::numeric_limits<double>::quiet_NaN();
}

bool depends_on_others(const Expression &formula, const Field &own, const std::vector<Field> &all)
{
  const Scalars scalars(all);
  for (unsigned int s = 0; s < scalars.size(); ++s)
    if (scalars.component(s) != own.first_component && formula.depends_on_scalar(s))
      return true;
  return false;
}

Expression read_capacity(const Section &section, const std::string &entry, const std::string &default_text,
                         const std::string &description, const std::vector<std::string> &symbols)
{
  const Expression capacity = section.read_expression(entry, default_text, {1}, description, symbols);
  const bool is_number =
      !capacity.depends_on_position() && !capacity.depends_on_time() && !capacity.depends_on_scalars();
  section.check(!is_number || capacity.value(dealii::Point<3>(), 0) >= 0, entry,
                "must be positive (or 0: " +
                    std::string(default_text == "0" ? "not given" : "nothing is stored") + ").");
  return capacity;
}

template class CapacityTerm<2>;
template class CapacityTerm<3>;

} // namespace dovetail
