// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Multigrid on two tied elastic bodies (2D, some 4 000 unknowns) with square cells and with cells that are
// twenty times as long in x or in y, degrees 1 to 3, Nitsche with theta = 1 and 0, dual and standard mortar:
// the solution of MUMPS (difference relative to it at most 1e-7) within 40 iterations. Cells that are long
// in x take up to 60 (the rank's part of a slender body is factorised by itself), with theta = 0, where only
// the symmetric part of the matrix is preconditioned, up to 90, and other cells then up to 60.
//
// ranks: 1, 3

#include "assembled_scene.h"

using namespace test;

namespace {

struct Case
{
  std::string name;
  unsigned int degree;
  std::string length, height, tie;
  unsigned int most_iterations = 40;
};

std::string body(const Case &of, const bool is_left)
{
  const unsigned int n = (is_left ? 36 : 24) / of.degree;
  const std::string cells = std::to_string(n) + ", " + std::to_string(n);
  const double length = std::stod(of.length);
  const std::string box_of_body = is_left
                                      ? "0, 0 : " + std::to_string(length / 2) + ", " + of.height
                                      : std::to_string(length / 2) + ", 0 : " + of.length + ", " + of.height;
  std::string text = set("Material", "one") + set("Degree", std::to_string(of.degree)) +
                     subsection("Source", set("displacement", "0.1; 0.2")) + box(cells + " : " + box_of_body);
  if (is_left)
    text += set("Boundary conditions", "clamp") +
            subsection("Boundary condition clamp", set("Type", "value") + set("Field", "displacement") +
                                                       set("Boundary ids", "0") + set("Expression", "0; 0"));
  return text;
}

std::string scene(const Case &of)
{
  return set("Materials", "one") + set("Domains", "left, right") + set("Interfaces", "seam") +
         subsection("Material one",
                    subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "1") +
                                            set("Poisson ratio", "0.3"))) +
         subsection("Domain left", body(of, true)) + subsection("Domain right", body(of, false)) +
         subsection("Interface seam", of.tie + set("Source", "left : 1") + set("Destination", "right : 0"));
}

void check(const Case &of)
{
  check_multigrid<2>(of.name, scene(of), of.most_iterations);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string nitsche = set("Type", "Nitsche"), mortar = set("Type", "mortar");
  const std::vector<std::vector<std::string>> shapes = {
      {"squares", "1", "1"}, {"long in x", "20", "1"}, {"long in y", "1", "20"}};
  for (const unsigned int degree : {1, 2, 3})
    for (const auto &shape : shapes) {
      const std::string name = "degree " + std::to_string(degree) + ", " + shape[0];
      const bool is_slender = shape[0] == "long in x";
      check({name + ", theta 1", degree, shape[1], shape[2], nitsche, is_slender ? 60u : 40u});
      check({name + ", theta 0", degree, shape[1], shape[2], nitsche + set("Theta", "0"),
             is_slender ? 90u : 60u});
      if (degree == 2)
        check({name + ", dual mortar", degree, shape[1], shape[2], mortar, is_slender ? 60u : 40u});
    }
  check({"degree 2, squares, standard mortar", 2, "1", "1", mortar + set("Multiplier space", "standard")});
}
