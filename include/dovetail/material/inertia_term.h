// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The inertia of a solid.

#pragma once

#include <dovetail/material/term.h>

namespace dovetail {

/// S = rho d2u/dt2 with the density rho of the undeformed body, so that it is linear at any deformation: the
/// rate of the momentum per volume.
template <int dim>
class InertiaTerm : public Term<dim>
{
public:
  InertiaTerm(const Field &field, const double density) : Term<dim>(field), density(density) {}

  bool has_flux() const override { return false; }
  bool has_source() const override { return true; }
  unsigned int order_in_time() const override { return 2; }
  Coupling coupling(const unsigned int c, const unsigned int d) const override
  {
    Coupling result;
    result.source_by_value = c == d;
    return result;
  }
  bool is_linear() const override { return true; }
  bool is_symmetric() const override { return true; }
  bool depends_on_time() const override { return false; }
  std::string description() const override { return "inertia"; }

  bool add(const State<dim> &state, const bool with_derivatives, Response<dim> &response) const override
  {
    const unsigned int n = state.value.size(), first = this->field.first_component;
    for (unsigned int c = first; c < first + this->field.n_components; ++c) {
      response.source[c] += density * state.second_rate[c];
      if (with_derivatives)
        response.source_by_value[c * n + c] += density * state.second_rate_by_value;
    }
    return true;
  }

private:
  const double density;
};

} // namespace dovetail
