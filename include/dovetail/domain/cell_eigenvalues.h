// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How much larger than its energy the flux of a cell can be at points of its faces.

#pragma once

#include <dovetail/domain/domain.h>

#include <array>
#include <memory>
#include <vector>

namespace dovetail {

/// A point of a face and all shape functions (CellLayout) of the cell behind it there.
template <int dim>
struct TracePoint
{
  double weight = 0;
  dealii::Point<dim> X;
  dealii::Tensor<1, dim> N;
  std::vector<double> values;
  std::vector<dealii::Tensor<1, dim>> gradients;

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &weight &X &N &values &gradients;
  }
};

/// The largest eigenvalue lambda of
/// @f[ \sum_q w_q\, |A(v)\cdot N|^2(x_q) = \lambda \int_K A(\nabla v):\nabla v \,dV @f]
/// on cells K of a domain, with A linearised at given unknowns, over all functions v of a field but those
/// without energy (constants; rigid motions about the current position). lambda has the unit of A/B.
template <int dim>
class CellEigenvalues
{
public:
  using cell_iterator = typename dealii::Triangulation<dim>::active_cell_iterator;

  /// @p components: those that the fluxes of the field need; laws of other fields are not asked. All
  /// arguments are kept by reference.
  CellEigenvalues(const Domain<dim> &domain, const Field &field, const std::vector<unsigned int> &components,
                  double t);
  ~CellEigenvalues();

  /// That of the tangent, infinite where it is not positive on the cell, and a finite one for penalties
  /// (cell_eigenvalues.cc). NaN where a law is not defined. Most cells are alike: solved ones are compared
  /// with.
  std::array<double, 2> evaluate(const cell_iterator &cell, const std::vector<TracePoint<dim>> &points,
                                 const std::vector<double> &unknowns);

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation;
};

/// The components on which the fluxes of a field of a material depend.
template <int dim>
std::vector<unsigned int> components_for_flux(const Material<dim> &material, unsigned int field);

} // namespace dovetail
