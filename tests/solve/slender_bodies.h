// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Two tied elastic bodies in 3D (4 764 unknowns) whose cells are long in x, for tests of solvers.

#pragma once

#include "assembled_scene.h"

#include <string>

namespace test {

inline std::string slender_body(const std::string &mesh, const std::string &more = "")
{
  return set("Material", "one") + set("Degree", "1") +
         subsection("Source", set("displacement", "0; 1e-3; 2e-3")) + box(mesh) + more;
}

/// @param half: where they meet. @param length: of both; height and width are one
inline std::string slender_bodies(const std::string &half, const std::string &length)
{
  const std::string clamp =
      set("Boundary conditions", "clamp") +
      subsection("Boundary condition clamp", set("Type", "value") + set("Field", "displacement") +
                                                 set("Boundary ids", "0") + set("Expression", "0; 0; 0"));
  return set("Materials", "one") + set("Domains", "left, right") + set("Interfaces", "seam") +
         subsection("Material one",
                    subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "1") +
                                            set("Poisson ratio", "0.3"))) +
         subsection("Domain left", slender_body("4, 8, 8 : 0, 0, 0 : " + half + ", 1, 1", clamp)) +
         subsection("Domain right", slender_body("6, 12, 12 : " + half + ", 0, 0 : " + length + ", 1, 1")) +
         subsection("Interface seam",
                    set("Type", "Nitsche") + set("Source", "left : 1") + set("Destination", "right : 0"));
}

} // namespace test
