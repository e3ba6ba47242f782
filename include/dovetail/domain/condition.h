// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What happens on a boundary of a domain.

#pragma once

#include <dovetail/material/material.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/note.h>
#include <dovetail/scene/toggle.h>

#include <deal.II/base/types.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace dovetail {

/// The influx h(B, grad B) of a weak condition at a point, per area of the undeformed boundary: of each
/// component c of its field, with the derivatives by component d of the domain.
template <int dim>
class Influx
{
public:
  Influx(const unsigned int n_of_field, const unsigned int n_of_domain)
      : value(n_of_field), n(n_of_domain), values(n_of_field * n), gradients(n_of_field * n)
  {
  }
  std::vector<double> value; ///< h_c
  double &by_value(const unsigned int c, const unsigned int d) { return values[c * n + d]; }
  /// dh_c / d(grad B_d)_L
  dealii::Tensor<1, dim> &by_gradient(const unsigned int c, const unsigned int d)
  {
    return gradients[c * n + d];
  }

private:
  unsigned int n;
  std::vector<double> values;
  std::vector<dealii::Tensor<1, dim>> gradients;
};

/// On what a condition may act.
struct Scope
{
  enum { any, vectors } fields;
  enum { boundary, point } place;
};

/// A condition on one field on some boundary ids, or at a point. It prescribes components of the trace B
/// (strong), prescribes the component along the normal of planes (strong), or adds an influx to the weak form
/// (weak); a plugin overrides one of the three groups of functions. Copy value.cc, symmetry.cc or flux.cc.
template <int dim>
class Condition
{
public:
  /// Reads Field, Toggle and, if it acts on a boundary, Boundary ids. A condition on vectors finds its Field
  /// itself.
  Condition(const Section &section, const Material<dim> &material, const Toggles &toggles,
            const Scope &scope = {Scope::any, Scope::boundary});
  virtual ~Condition() = default;

  /// Components of the field (0 … n_components-1) that it may constrain; those whose value is prescribed,
  /// unless it constrains normal components.
  virtual std::vector<unsigned int> prescribed_components() const { return {}; }
  virtual double prescribed_value(const dealii::Point<dim> & /*X*/, double /*t*/,
                                  unsigned int /*component*/) const
  {
    return 0;
  }

  /// Whether the components are prescribed weakly, by Nitsche's method (weak_values.cc), not by constraints.
  virtual bool is_weak() const { return false; }

  /// Whether it constrains N.B of a vector at the nodes of its faces, which must then lie in planes.
  virtual bool constrains_normal() const { return false; }
  virtual double prescribed_normal(const dealii::Point<dim> & /*X*/, double /*t*/) const { return 0; }

  /// Where it acts, if not on a boundary: at the node there.
  virtual std::optional<dealii::Point<dim>> point() const { return {}; }

  /// What a user hardly means, although it can be solved.
  virtual NoteList notes() const { return {}; }

  virtual bool adds_flux() const { return false; }
  /// Whether it may, to a component of the field.
  virtual bool adds_flux_to(unsigned int /*component*/) const { return adds_flux(); }
  /// The influx and its derivatives at a state of the domain, all components of which are known, on a
  /// boundary with the outward normal @p N. All come in as zero. Derivatives by a component are taken only
  /// where the fluxes of its field depend on that component's field (Material::depends).
  virtual void influx(const State<dim> & /*state*/, const dealii::Tensor<1, dim> & /*N*/,
                      Influx<dim> & /*influx*/) const
  {
  }
  /// The value of a scalar at which the influx vanishes, if it is known; where all influxes are affine in the
  /// state it is found without.
  virtual std::optional<double> equilibrium_value(const dealii::Point<dim> & /*X*/, double /*t*/) const
  {
    return {};
  }
  virtual bool has_tangent() const { return adds_flux() || is_weak(); } ///< the influx has derivatives
  virtual bool sees_gradients() const { return false; }                 ///< else those of the state are zero
  virtual bool is_linear() const { return true; }                       ///< the influx is affine in the state
  virtual bool is_symmetric() const { return true; }                    ///< its derivative is
  /// Whether the derivatives are the same in all steps; if so, a linear scene assembles them once.
  virtual bool has_constant_tangent() const { return !adds_flux(); }

  /// Whether what it prescribes or gives may change with t itself, beside its toggle.
  virtual bool depends_on_time() const { return true; }

  /// Whether the condition keeps a component of the field from drifting by a constant.
  virtual bool removes_constant(const unsigned int component) const
  {
    const auto all = prescribed_components();
    return std::find(all.begin(), all.end(), component) != all.end();
  }

  bool is_active(const double t) const { return toggles->is_active(toggle, t); }
  const std::string &toggle_name() const { return toggle; }
  /// Whether its toggle looks at fields, and switches the influx point by point at the last good state.
  bool follows_fields() const { return formula.has_value(); }
  /// Of each name in toggles the component, if the toggle looks at it.
  const std::vector<std::optional<unsigned int>> &components_of_toggle() const { return components_of_names; }
  /// Whether the toggle is on at a point where the last good state has @p values in these components, and 0
  /// where there is none; nothing if its formula is not a number, with the reason left.
  std::optional<bool> is_on(const dealii::Point<dim> &X, double t, const std::vector<double> &values) const;

  const Section section;  ///< for error messages
  const std::string name; ///< the last part of its path
  const Field field;      ///< the field it acts on
  const std::set<dealii::types::boundary_id> boundary_ids;

private:
  void read_formula(const Material<dim> &material);

  const Toggles *toggles;
  const std::string toggle;
  std::optional<Expression> formula; ///< of a toggle that looks at fields
  std::vector<std::optional<unsigned int>> components_of_names;
};

/// The entry Components of a condition on @p field: x, y, z as 0, 1, 2; all if it is empty.
std::vector<unsigned int> read_components(const Section &section, const Field &field);

template <int dim>
using ConditionCatalogue = Catalogue<Condition<dim>, const Material<dim> &, const Toggles &>;

/// Register a class template over dim in both dimensions.
template <template <int> class Derived>
bool add_condition(const std::string &name, const std::string &help)
{
  return ConditionCatalogue<2>::template add<Derived<2>>(name, help) &&
         ConditionCatalogue<3>::template add<Derived<3>>(name, help);
}

} // namespace dovetail
