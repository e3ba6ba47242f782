// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A node that is held: prescribed components u_c = 0 at one node of the mesh. Two in 2D, three in 3D remove
// the rigid motions of a body without holding a face, and carry no force where the loads are in balance.
//
//     subsection Boundary condition corner
//       set Type       = point support
//       set Point      = 0; 0
//       set Components = x, y
//     end

#include <dovetail/domain/condition.h>

namespace dovetail {

namespace {

template <int dim>
class PointSupport : public Condition<dim>
{
public:
  PointSupport(const Section &section, const Material<dim> &material, const Toggles &toggles)
      : Condition<dim>(section, material, toggles, {Scope::vectors, Scope::point}),
        components(read_components(section, this->field))
  {
    const auto X = section.require_point("Point", "Where a node of the mesh is held [m]");
    for (unsigned int d = 0; d < dim; ++d)
      place[d] = X[d];
  }

  std::vector<unsigned int> prescribed_components() const override { return components; }
  std::optional<dealii::Point<dim>> point() const override { return place; }

private:
  const std::vector<unsigned int> components;
  dealii::Point<dim> place;
};

const bool registered = add_condition<PointSupport>("point support", "One node is held, u = 0.");

} // namespace

} // namespace dovetail
