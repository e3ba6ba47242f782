// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// One number of all that a body or a part of its boundary has.

#pragma once

#include <dovetail/measure/quantity.h>

#include <functional>
#include <set>
#include <string>
#include <vector>

namespace dovetail {

/// A domain, or the faces of its boundary that have one of these ids.
template <int dim>
struct Region
{
  const Domain<dim> *domain = nullptr;
  std::set<dealii::types::boundary_id> boundary_ids; ///< empty: the whole domain
};

enum class Reduce { minimum, maximum, mean, integral };
const std::vector<std::string> &names_of_reduce(); ///< in this order, as in the scene

/// Visit the points of the quadrature of a region, each with its share of the volume or area. @p solution is
/// ghosted.
template <int dim>
void visit_points(const Region<dim> &region, const Vector &solution, double t,
                  const std::function<void(DomainPoint<dim> &point, double JxW)> &visit);

/// Of each component of a field by itself. Minimum and maximum are those of the nodes; the mean is the
/// integral over the volume or area of the undeformed region. Integrals are exact but for rounding, on curved
/// faces in 3D nearly so. Collective; @p solution is ghosted. @p places: of minima and maxima the point; of
/// several with the same number, up to rounding, the one with the smallest x, then y, then z.
template <int dim>
std::vector<double> reduce(const Region<dim> &region, const Field &field, Reduce how, const Vector &solution,
                           std::vector<dealii::Point<dim>> *places = nullptr);

/// Of each number of a quantity by itself; all four from the same Gauss points of each cell or face, so that
/// the mean lies between the minimum and the maximum. NaN if the quantity is NaN at one of them. Collective.
template <int dim>
std::vector<double> reduce(const Region<dim> &region, const Quantity<dim> &quantity, Reduce how,
                           const Vector &solution, double t,
                           std::vector<dealii::Point<dim>> *places = nullptr);

} // namespace dovetail
