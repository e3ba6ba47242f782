// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/fields_in_toggles.h>
#include <dovetail/material/phase_choice.h>
#include <dovetail/scene/field_toggle.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

/// A member of a list in the scene that an entry refers to.
void check_is_known(const Section &section, const std::string &entry, const std::string &name,
                    const std::string &list)
{
  const auto known = dealii::Utilities::split_string_list(section.top().peek(list));
  section.check(std::find(known.begin(), known.end(), name) != known.end(), entry,
                "names '" + name + "', which is not among " + list + " (" + comma_separated(known) + "). " +
                    did_you_mean(name, known));
}

} // namespace

template <int dim>
PhaseChoice<dim>::PhaseChoice(const Section &material)
{
  Section section = material;
  std::vector<std::string> paths;
  while (true) {
    const auto toggle = section.read<std::string>(
        "Toggle", "",
        "The toggle that is on where this material is what its subsections say; it looks at scalar fields at "
        "the last good step; if empty, that is everywhere [-]");
    const auto other =
        section.read<std::string>("Otherwise", "", "The material that holds where the toggle is off [-]");
    sections.push_back(section);
    paths.push_back(section.path());
    section.check(toggle.empty() == other.empty(), toggle.empty() ? "Otherwise" : "Toggle",
                  toggle.empty()
                      ? "needs a Toggle, which says where this material holds."
                      : "needs the entry Otherwise, which names the material where the toggle is off.");
    if (toggle.empty() || section.documenting())
      return;
    check_is_known(section, "Toggle", toggle, "Toggles");
    check_is_known(section, "Otherwise", other, "Materials");
    toggles.push_back(formula_of_toggle(section, toggle));
    section.check(toggles.back().depends_on_scalars(), "Toggle",
                  "names '" + toggle +
                      "', which looks at no field. Write what changes in time as formulas of t.");
    const Section next = section.top().subsection("Material " + other);
    section.check(std::find(paths.begin(), paths.end(), next.path()) == paths.end(), "Otherwise",
                  "leads back to the material '" + other + "'. Let the last material have no Toggle.");
    section = next;
  }
}

template <int dim>
void PhaseChoice<dim>::set_fields(const std::vector<Field> &fields)
{
  if (!is_given())
    return;
  const std::vector<std::string> names = names_in_toggles(sections[0].top());
  components = components_in_toggles(sections[0].top(), fields);
  for (unsigned int m = 0; m < toggles.size(); ++m)
    for (unsigned int s = 0; s < names.size(); ++s)
      sections[m].check(components[s].has_value() || !toggles[m].depends_on_scalar(s), "Toggle",
                        "looks at the " + names[s] + ", which this material does not have.");
}

template <int dim>
std::vector<InternalVariable> PhaseChoice<dim>::internal_variables() const
{
  if (!is_given())
    return {};
  return {{"phase of the step", 1, -1}, {"phase of the next step", 1, -1}, {"time of the phases", 1, -1}};
}

template <int dim>
bool PhaseChoice<dim>::sees(const unsigned int component) const
{
  for (unsigned int s = 0; s < components.size(); ++s)
    if (components[s] == component && std::any_of(toggles.begin(), toggles.end(), [s](const auto &toggle) {
          return toggle.depends_on_scalar(s);
        }))
      return true;
  return false;
}

/// At the state itself.
template <int dim>
unsigned int PhaseChoice<dim>::find(const State<dim> &state) const
{
  std::vector<double> scalars;
  for (const auto &component : components)
    scalars.push_back(component ? state.value[*component] : 0);
  for (unsigned int m = 0; m < toggles.size(); ++m)
    if (const double is_on = toggles[m].value(state.X, state.t, 0, scalars); std::isnan(is_on))
      return not_known;
    else if (is_on != 0)
      return m;
  return toggles.size();
}

template <int dim>
unsigned int PhaseChoice<dim>::at(const State<dim> &state) const
{
  if (!is_given())
    return 0;
  if (is_new(state))
    return find(state);
  const auto &accepted = state.memory.accepted;
  return static_cast<unsigned int>(accepted[state.t == accepted[time_of_step] ? in_step : after_step]);
}

/// At the time of the last good step what has been remembered holds.
template <int dim>
void PhaseChoice<dim>::remember(const State<dim> &state) const
{
  if (!is_given() || (!is_new(state) && state.t == state.memory.accepted[time_of_step]))
    return;
  state.memory.trial[in_step] = at(state);
  state.memory.trial[after_step] = find(state);
  state.memory.trial[time_of_step] = state.t;
}

template class PhaseChoice<2>;
template class PhaseChoice<3>;

} // namespace dovetail
