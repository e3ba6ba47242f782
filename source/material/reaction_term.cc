// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/reaction_term.h>
#include <dovetail/scene/undefined.h>

#include <cmath>

namespace dovetail {

template <int dim>
ReactionTerm<dim>::ReactionTerm(const Field &field, const std::vector<Field> &all, const Section &section,
                                const std::string &entry, const Expression &reaction)
    : Term<dim>(field), scalars(all), section(section), entry(entry), reaction(reaction)
{
  const unsigned int own = scalars.number(field.first_component);
  const std::vector<double> zero(scalars.size(), 0.);
  never_grows =
      !reaction.depends_on_scalar(own) ||
      (reaction.is_affine_in_scalars() && !reaction.depends_on_position() && !reaction.depends_on_time() &&
       reaction.derivative(dealii::Point<dim>(), 0, 0, {zero.data(), zero.size()}, own) <= 0);
}

template <int dim>
Coupling ReactionTerm<dim>::coupling(const unsigned int /*c*/, const unsigned int d) const
{
  const unsigned int s = scalars.number(d);
  Coupling result;
  result.source_by_value = s < scalars.size() && reaction.depends_on_scalar(s);
  return result;
}

template <int dim>
bool ReactionTerm<dim>::add(const State<dim> &state, const bool with_derivatives,
                            Response<dim> &response) const
{
  const unsigned int c = this->field.first_component, n = state.value.size();
  const auto values = scalars.values(state);
  const double r = reaction.value(state.X, state.t, 0, values);
  if (!std::isfinite(r))
    return undefined(sentence_about(section, entry,
                                    "is not a finite number at " + in_words(state.X) +
                                        " and t = " + in_words(state.t) + "."),
                     !reaction.depends_on_scalars());
  response.source[c] -= r;
  for (unsigned int s = 0; with_derivatives && s < scalars.size(); ++s)
    if (reaction.depends_on_scalar(s)) {
      const double slope = reaction.derivative(state.X, state.t, 0, values, s);
      if (!std::isfinite(slope))
        return undefined(sentence_about(section, entry,
                                        "has a derivative that is not a finite number at " +
                                            in_words(state.X) + " and t = " + in_words(state.t) + "."));
      response.source_by_value[c * n + scalars.component(s)] -= slope;
    }
  return true;
}

template class ReactionTerm<2>;
template class ReactionTerm<3>;

} // namespace dovetail
