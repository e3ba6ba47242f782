// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Unknowns -> states -> responses at points of an interface. With CellPoints, the only way to the laws.

#pragma once

#include <dovetail/interface/interface.h>

#include <array>
#include <vector>

namespace dovetail {

/// The states of both sides at one point of an interface after another, and the responses of their materials.
template <int dim>
class SidePoints
{
public:
  SidePoints() : state{{State<dim>(0), State<dim>(0)}}, response{{Response<dim>(0), Response<dim>(0)}} {}
  SidePoints(const Interface<dim> &interface, const double t) : SidePoints() { reinit(interface, t); }

  void reinit(const Interface<dim> &interface, double t);

  /// The state of a side at a point, from the unknowns of its group: traces and gradients of the components
  /// that are tied or that their fluxes depend on; the values of the others are NaN.
  void reinit(const unsigned int side, const unsigned int q, const std::vector<double> &unknowns)
  {
    reinit(side, q, interface->pairing().gradients(side, q), unknowns);
  }
  /// With the gradients that the shape functions have elsewhere in the cell behind the point.
  void reinit(unsigned int side, unsigned int q, const dealii::Tensor<1, dim> *shape_gradients,
              const std::vector<double> &unknowns);
  /// The response at the state of a side; @return false if a law is not defined there.
  bool evaluate(const unsigned int side, const bool with_derivatives)
  {
    return evaluate(side, interface->sides[side].domain->material.asks_for_all(with_derivatives));
  }
  bool evaluate(unsigned int side, const std::vector<Asked> &asked); ///< by field of the side
  /// Material::curvature() there.
  void curvature(unsigned int side, const std::vector<dealii::Tensor<1, dim>> &w,
                 dealii::FullMatrix<double> &result) const;

  std::array<State<dim>, 2> state;
  std::array<Response<dim>, 2> response;
  std::array<const dealii::Tensor<1, dim> *, 2> shape_gradients{}; ///< those of the states

private:
  const Interface<dim> *interface = nullptr;
  std::array<std::vector<double>, 2> trial_memory;
};

/// The response of a side's material at a @p state, with derivatives; @return false if a law is not defined
/// there.
template <int dim>
bool respond(const Interface<dim> &interface, unsigned int side, const State<dim> &state,
             Response<dim> &response);

/// Call visit(group, unknowns) for all groups of points of this rank, in order.
template <int dim, typename Visit>
void for_each_group(const Interface<dim> &interface, const ValuesOf &values_of, const Visit &visit)
{
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns;
  for (const auto &group : interface.pairing().groups) {
    interface.group_dofs(group, dofs);
    values_of(dofs, unknowns);
    visit(group, unknowns);
  }
}

/// The values of unknowns in a vector, a ghosted one.
template <typename Vector>
auto values_in(const Vector &vector)
{
  return [&vector](const std::vector<dealii::types::global_dof_index> &dofs, std::vector<double> &values) {
    values.resize(dofs.size());
    vector.extract_subvector_to(dofs.begin(), dofs.end(), values.begin());
  };
}

} // namespace dovetail
