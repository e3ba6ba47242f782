// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/content_update.h>

#include <boost/math/tools/toms748_solve.hpp>

#include <cmath>
#include <limits>

namespace dovetail {

template <int dim>
ContentUpdate<dim>::ContentUpdate(const Material<dim> &material, const unsigned int component)
    : material(material), component(component),
      is_curved(material.sees_past() && !material.stores_by_position() &&
                material.order_in_time(component) == 1),
      state(material.n_components()), response(material.n_components()), memory(material.initial_memory())
{
  const unsigned int n = material.n_components();
  for (unsigned int d = 0; d < n; ++d)
    is_curved = is_curved && (d == component || !material.coupling(component, d).source_by_value);
  state.rate.resize(n);
  state.second_rate.resize(n);
  state.rate_by_value = 1;
  state.memory = {{memory.data(), memory.size()}, {memory.data(), memory.size()}};
}

/// NaN where it is not defined.
template <int dim>
double ContentUpdate<dim>::capacity(const double value) const
{
  state.value[component] = value;
  return material.evaluate_storage(state, response)
             ? response.source_by_value[component * material.n_components() + component]
             : std::nan("");
}

template <int dim>
double ContentUpdate<dim>::content(const double value) const
{
  state.value[component] = value;
  return material.content(state, component);
}

template <int dim>
double ContentUpdate<dim>::after(const double value, const double change) const
{
  const double slope = capacity(value), growth = slope * change;
  if (!(std::isfinite(growth) && growth * change > 0))
    return value + change;
  const double here = content(value),
               rounding = std::numeric_limits<double>::epsilon() * (std::abs(here) + std::abs(slope * value));
  if (std::abs(growth) <= 1e3 * rounding) // what is left of it is noise
    return value + change;
  const auto rest = [&](const double factor) { // grows with it
    return (content(value + factor * change) - here) / growth - 1;
  };
  const double hardly_curved = 0.1, farthest = 1e6;
  double end = 1, at_end = rest(end);
  if (!(std::abs(at_end) > hardly_curved)) // or NaN
    return value + change;
  while (at_end < 0 && end < farthest) {
    end *= 2;
    at_end = rest(end);
  }
  if (!(at_end >= 0))
    return value + change;
  boost::uintmax_t n_evaluations = 60;
  const auto [below, above] = boost::math::tools::toms748_solve(
      rest, 0., end, -1., at_end, boost::math::tools::eps_tolerance<double>(40), n_evaluations);
  return value + (below + above) / 2 * change;
}

template class ContentUpdate<2>;
template class ContentUpdate<3>;

} // namespace dovetail
