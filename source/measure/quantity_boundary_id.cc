// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The id that a face of the boundary has in the mesh, as in "Boundary ids" of a condition.
//
//     set Fields = solution, boundary id

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class BoundaryId : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  bool is_of_boundary() const override { return true; }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    numbers.push_back(point.face()->id);
  }
};

const bool registered = add_quantity<BoundaryId>("boundary id", "", "that of a face, on a surface [-]");

} // namespace

} // namespace dovetail
