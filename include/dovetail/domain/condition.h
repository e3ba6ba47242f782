// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What happens on a boundary of a domain.

#pragma once

#include <dovetail/material/material.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/toggle.h>

#include <deal.II/base/types.h>

#include <set>
#include <string>
#include <vector>

namespace dovetail {

/// A condition on one field on some boundary ids. It prescribes components of the trace B (strong), or adds
/// an influx to the weak form (weak); a plugin overrides one of the two pairs of functions. Copy flux.cc or
/// value.cc.
template <int dim>
class Condition
{
public:
  /// Reads Field, Boundary ids and Toggle, which every condition has.
  Condition(const Section &section, const std::vector<Field> &fields, const Toggles &toggles);
  virtual ~Condition() = default;

  /// Components of the field (0 … n_components-1) whose value is prescribed.
  virtual std::vector<unsigned int> prescribed_components() const { return {}; }
  virtual double prescribed_value(const dealii::Point<dim> & /*X*/, double /*t*/,
                                  unsigned int /*component*/) const
  {
    return 0;
  }

  virtual bool adds_flux() const { return false; }
  /// The influx per area of the undeformed boundary for each component of the field, and its derivative by
  /// the trace, d_flux(c, d). Both come in as zero.
  virtual void flux(const dealii::Point<dim> & /*X*/, double /*t*/, const double * /*trace*/,
                    std::vector<double> & /*flux*/, dealii::FullMatrix<double> & /*d_flux*/) const
  {
  }
  virtual bool is_linear() const { return true; } ///< the flux is affine in the trace
  /// Whether d_flux is the same in all steps; if so, a linear scene assembles it once.
  virtual bool has_constant_tangent() const { return !adds_flux(); }

  /// Whether the condition keeps the value of the field from drifting by a constant.
  virtual bool removes_constants() const { return false; }

  bool is_active(const double t) const { return toggles->is_active(toggle, t); }
  const std::string &toggle_name() const { return toggle; }

  const Section section;  ///< for error messages
  const std::string name; ///< the last part of its path
  const Field field;      ///< the field it acts on
  const std::set<dealii::types::boundary_id> boundary_ids;

private:
  const Toggles *toggles;
  const std::string toggle;
};

template <int dim>
using ConditionCatalogue = Catalogue<Condition<dim>, const std::vector<Field> &, const Toggles &>;

/// Register a class template over dim in both dimensions.
template <template <int> class Derived>
bool add_condition(const std::string &name, const std::string &help)
{
  return ConditionCatalogue<2>::template add<Derived<2>>(name, help) &&
         ConditionCatalogue<3>::template add<Derived<3>>(name, help);
}

} // namespace dovetail
