// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Two tied elastic bodies in 3D whose cells are long in some directions, for tests of solvers.

#pragma once

#include "assembled_scene.h"

#include <string>

namespace test {

/// @param cells, @param begin and @param end of the box
/// @param set_degree and @param in_mesh: more entries of the domain and of its mesh
struct SlenderBody
{
  std::string cells, begin, end;
  std::string set_degree = set("Degree", "1"), in_mesh = "";
};

inline std::string slender_body(const SlenderBody &body, const std::string &more = "")
{
  return set("Material", "one") + body.set_degree +
         subsection("Source", set("displacement", "0; 1e-3; 2e-3")) +
         box(body.cells + " : " + body.begin + " : " + body.end, body.in_mesh) + more;
}

/// Clamped at x = 0 or another face, tied at the left end of the right one.
inline std::string slender_bodies(const SlenderBody &left, const SlenderBody &right,
                                  const std::string &tie = "Nitsche", const std::string &clamped = "0")
{
  const std::string clamp =
      set("Boundary conditions", "clamp") +
      subsection("Boundary condition clamp", set("Type", "value") + set("Field", "displacement") +
                                                 set("Boundary ids", clamped) + set("Expression", "0; 0; 0"));
  return set("Materials", "one") + set("Domains", "left, right") + set("Interfaces", "seam") +
         subsection("Material one",
                    subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "1") +
                                            set("Poisson ratio", "0.3"))) +
         subsection("Domain left", slender_body(left, clamp)) +
         subsection("Domain right", slender_body(right)) +
         subsection("Interface seam",
                    set("Type", tie) + set("Source", "left : 1") + set("Destination", "right : 0"));
}

/// With 4 764 unknowns. @param half: where they meet. @param length: of both; height and width are one
inline std::string slender_bodies(const std::string &half, const std::string &length)
{
  return slender_bodies({"4, 8, 8", "0, 0, 0", half + ", 1, 1"},
                        {"6, 12, 12", half + ", 0, 0", length + ", 1, 1"});
}

} // namespace test
