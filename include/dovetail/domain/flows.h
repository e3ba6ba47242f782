// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What flows into a body and out of it.

#pragma once

#include <vector>

namespace dovetail {

/// Sums of positive and of negative influxes, by component.
struct Flows
{
  explicit Flows(const unsigned int n_components) : in(n_components, 0.), out(n_components, 0.) {}
  std::vector<double> in, out;

  void add(const unsigned int component, const double influx)
  {
    if (influx < 0)
      out[component] -= influx;
    else
      in[component] += influx;
  }
};

} // namespace dovetail
