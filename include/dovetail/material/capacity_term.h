// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a scalar stores.

#pragma once

#include <dovetail/material/content.h>
#include <dovetail/material/diffusion_term.h>
#include <dovetail/scene/section.h>

namespace dovetail {

/// S = d(rho H)/dt, where rho is a number and H the sum of some contents: the heat stored per volume and time
/// with the density and the enthalpy, or an amount with the capacity of a species. A scheme in time gives
/// dB/dt = a B + sum_j w_j B_j with the values B_j of the steps before and a + sum_j w_j = 0, so
/// @f[ S = -\rho \sum_j w_j\,(H(B) - H(B_j)) @f]
/// with the other scalars, X and t as they are now: rho c dB/dt for a capacity c that depends on no scalar.
/// What a step stores is the content that the next one finds, whatever c does in between
/// (doc/theory/time.md).
template <int dim>
class CapacityTerm : public Term<dim>
{
public:
  /// @param section of the entries, for messages @param reference where content() begins
  CapacityTerm(const Field &field, const std::vector<Field> &all, const Section &section, Contents contents,
               double density = 1, double reference = 0);

  bool has_flux() const override { return false; }
  bool has_source() const override { return true; }
  unsigned int order_in_time() const override { return 1; }
  Coupling coupling(unsigned int c, unsigned int d) const override;
  bool is_linear() const override { return is_affine; }
  bool is_symmetric() const override { return true; } // and not negative
  bool depends_on_time() const override;
  bool stores_by_position() const override;
  bool sees_past() const override { return !is_affine; }
  std::string description() const override { return "capacity"; }

  bool add(const State<dim> &state, bool with_derivatives, Response<dim> &response) const override;
  double content(const State<dim> &state) const override;
  double liquid_fraction(const State<dim> &state) const override;

private:
  template <typename Predicate>
  bool any(const Predicate &is) const;
  double change(const Content &content, const State<dim> &state, const ScalarState &scalars) const;
  bool add_slopes(const Content &content, const State<dim> &state, const ScalarState &here,
                  Response<dim> &response) const;
  bool refuse(const Content &content, const State<dim> &state, const std::string &what,
              const std::string &end = ".") const;
  double past(const State<dim> &state, unsigned int j) const
  {
    return state.past[j][this->field.first_component];
  }

  const Scalars scalars;
  const unsigned int own; ///< number of the scalar
  const Section section;
  const Contents contents;
  const double density, reference;
  const bool is_affine;
};

/// Whether a formula depends on another scalar of a material than @p own.
bool depends_on_others(const Expression &formula, const Field &own, const std::vector<Field> &all);

/// Reads the formula of a capacity, @p entry; an error if it is a negative number.
Expression read_capacity(const Section &section, const std::string &entry, const std::string &default_text,
                         const std::string &description, const std::vector<std::string> &symbols);

} // namespace dovetail
