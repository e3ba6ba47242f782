// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The id that a cell has in the mesh (the number of its physical group in Gmsh), as in "Source material ids"
// of an interface.
//
//     set Fields = material id

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class MaterialId : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    numbers.push_back(point.cell()->material_id());
  }
};

const bool registered = add_quantity<MaterialId>("material id", "", "the id of a cell in the mesh [-]");

} // namespace

} // namespace dovetail
