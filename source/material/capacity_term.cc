// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/capacity_term.h>
#include <dovetail/scene/undefined.h>

#include <cmath>

namespace dovetail {

template <int dim>
CapacityTerm<dim>::CapacityTerm(const Field &field, const std::vector<Field> &all, const Section &section,
                                const std::string &entry, const Expression &capacity, const double density)
    : Term<dim>(field), scalars(all), own(scalars.number(field.first_component)), section(section),
      entry(entry), capacity(capacity), density(density)
{
}

template <int dim>
Coupling CapacityTerm<dim>::coupling(const unsigned int /*c*/, const unsigned int d) const
{
  const unsigned int s = scalars.number(d);
  Coupling result;
  result.source_by_value = s == own || (s < scalars.size() && capacity.depends_on_scalar(s));
  return result;
}

template <int dim>
bool CapacityTerm<dim>::add(const State<dim> &state, const bool with_derivatives,
                            Response<dim> &response) const
{
  const unsigned int c = this->field.first_component, n = state.value.size();
  const auto values = scalars.values(state);
  const auto place = [&]() { return " at " + in_words(state.X) + " and t = " + in_words(state.t); };
  const double content = density * capacity.value(state.X, state.t, 0, values);
  if (!(std::isfinite(content) && content >= 0))
    return undefined(
        sentence_about(section, entry,
                       "is " + in_words(content / density) + place() + ", but must be positive."),
        !capacity.depends_on_scalars());
  response.source[c] += content * state.rate[c];
  if (!with_derivatives)
    return true;
  response.source_by_value[c * n + c] += content * state.rate_by_value;
  for (unsigned int s = 0; s < scalars.size(); ++s)
    if (capacity.depends_on_scalar(s)) {
      const double slope = density * capacity.derivative(state.X, state.t, 0, values, s);
      if (!std::isfinite(slope))
        return undefined(
            sentence_about(section, entry, "has a derivative that is not a finite number" + place() + "."));
      response.source_by_value[c * n + scalars.component(s)] += slope * state.rate[c];
    }
  return true;
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
