// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Two cubes that conduct heat through a tie, for tests of solvers.

#pragma once

#include "../system/scene_model.h"

namespace test {

/// @param tie: the entries of the interface
inline std::string tied_cubes(const std::string &tie)
{
  const auto body = [](const std::string &arguments, const std::string &id, const std::string &value) {
    return set("Material", "one") + set("Boundary conditions", "end") +
           subsection("Boundary condition end", set("Type", "value") + set("Field", "temperature") +
                                                    set("Boundary ids", id) + set("Expression", value)) +
           box(arguments);
  };
  return set("Materials", "one") + set("Domains", "left, right") + set("Interfaces", "seam") +
         subsection("Material one", subsection("Heat", set("Type", "Fourier") + set("Conductivity", "3"))) +
         subsection("Domain left", body("4, 4, 5 : 0, 0, 0 : 1, 1, 1", "0", "y*z")) +
         subsection("Domain right", body("3, 5, 4 : 1, 0, 0 : 2, 1, 1", "1", "2 + y")) +
         subsection("Interface seam", tie + set("Source", "left : 1") + set("Destination", "right : 0"));
}

} // namespace test
