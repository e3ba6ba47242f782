// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A symmetry plane: nothing moves through it, u.N = 0, and nothing resists along it (no shear traction). N is
// the normal of the undeformed plane, which may be slanted. Where two or three planes meet, all of them hold;
// prescribed values come first.
//
//     subsection Boundary condition mirror
//       set Type         = symmetry
//       set Boundary ids = 0, 4
//     end

#include <dovetail/domain/condition.h>

namespace dovetail {

namespace {

template <int dim>
class Symmetry : public Condition<dim>
{
public:
  Symmetry(const Section &section, const Material<dim> &material, const Toggles &toggles)
      : Condition<dim>(section, material, toggles, {Scope::vectors, Scope::boundary})
  {
  }

  std::vector<unsigned int> prescribed_components() const override
  {
    std::vector<unsigned int> all;
    for (unsigned int c = 0; c < dim; ++c)
      all.push_back(c);
    return all;
  }
  bool constrains_normal() const override { return true; }
};

const bool registered =
    add_condition<Symmetry>("symmetry", "A plane, perhaps slanted, through which nothing moves: u.N = 0.");

} // namespace

} // namespace dovetail
