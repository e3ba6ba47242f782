// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How two parts of a boundary share what acts on a node that both have.

#pragma once

#include <dovetail/domain/cell_points.h>
#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <deal.II/fe/fe_values.h>
#include <deal.II/lac/trilinos_vector.h>

#include <array>
#include <functional>
#include <memory>

namespace dovetail {

/// A_h.N of all components of a domain at a point of a face; zero where a law is not defined.
template <int dim>
class FluxOnFace
{
public:
  FluxOnFace(const Domain<dim> &domain, double t);
  const std::vector<double> &evaluate(const dealii::FEFaceValues<dim> &values, unsigned int q,
                                      const std::vector<double> &unknowns);

private:
  CellPoints<dim> point;
  std::vector<double> result;
};

/// Of a force r_i that acts on node i by two parts of the boundary, part b has the share
/// @f[ r_i^b = \int_b A_h\cdot N\,\phi_i\,dA
///           + \Bigl(r_i - \sum_c \int_c A_h\cdot N\,\phi_i\,dA\Bigr) \frac{m_i^b}{\sum_c m_i^c},
///     \qquad m_i^b = \int_b \phi_i^2\,dA . @f]
/// The shares add up to r_i; where A_h is exact they are so, too.
template <int dim>
class TraceShares
{
public:
  /// The part (0 or 1) that a node of a face counts to for a component of the field; -1: to neither.
  using Part = std::function<int(const typename Domain<dim>::BoundaryFace &face, unsigned int node,
                                 unsigned int component)>;

  /// @p solution: ghosted. Collective.
  TraceShares(const Domain<dim> &domain, const Field &field, const Vector &solution, double t,
              const Part &part);

  /// The share that part 0 has of a force on an owned unknown.
  double first_share(dealii::types::global_dof_index dof, double force) const;
  /// m_i^0 / (m_i^0 + m_i^1) of an owned unknown; zero if neither part has it.
  double first_area(dealii::types::global_dof_index dof) const;
  bool is_common(dealii::types::global_dof_index dof) const; ///< both parts have it

private:
  using Weights = dealii::TrilinosWrappers::MPI::Vector;
  void add_areas(const Part &part);
  void add_fluxes(const Vector &solution, double t, const Part &part);
  void conform(Weights &weights) const;

  const Domain<dim> &domain;
  const Field &field;
  std::array<Weights, 2> area, flux; ///< owned, in the numbering of the domain
};

} // namespace dovetail
