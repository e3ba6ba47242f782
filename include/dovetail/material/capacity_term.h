// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a scalar stores.

#pragma once

#include <dovetail/material/diffusion_term.h>
#include <dovetail/scene/section.h>

namespace dovetail {

/// S = rho c(scalars, X, t) dB/dt, where rho is a number: the heat stored per volume and time with the
/// density and the heat capacity, or an amount with the capacity of a species. The form with c at the new
/// state is consistent for any c and as exact as the scheme; the content per volume is the integral of rho c
/// dB, from which the sum over the steps differs by the error of the scheme where c depends on scalars
/// (doc/theory/time.md).
template <int dim>
class CapacityTerm : public Term<dim>
{
public:
  /// @param section and @p entry of the formula c, for messages
  CapacityTerm(const Field &field, const std::vector<Field> &all, const Section &section,
               const std::string &entry, const Expression &capacity, double density = 1);

  bool has_flux() const override { return false; }
  bool has_source() const override { return true; }
  unsigned int order_in_time() const override { return 1; }
  Coupling coupling(unsigned int c, unsigned int d) const override;
  bool is_linear() const override { return !capacity.depends_on_scalars(); }
  bool is_symmetric() const override { return !capacity.depends_on_scalar(own); } // else perhaps negative
  bool depends_on_time() const override { return capacity.depends_on_time(); }
  std::string description() const override { return "capacity"; }

  bool add(const State<dim> &state, bool with_derivatives, Response<dim> &response) const override;

private:
  const Scalars scalars;
  const unsigned int own; ///< number of the scalar
  const Section section;
  const std::string entry;
  const Expression capacity;
  const double density;
};

/// Reads the formula of a capacity, @p entry; an error if it is a negative number.
Expression read_capacity(const Section &section, const std::string &entry, const std::string &default_text,
                         const std::string &description, const std::vector<std::string> &symbols);

} // namespace dovetail
