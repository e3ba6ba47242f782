// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Every quantity of the catalogue against its closed form.
//
// rubber, neo-Hookean with mu = 2 in simple shear u = (g y, 0, 0), g = 1/2, so J = 1 and b = F F^T:
//         sigma = mu dev b = (mu/3) (2 g^2, 3 g, 0; 3 g, -g^2, 0; 0, 0, -g^2)
//         von Mises = mu sqrt(g^4 + 3 g^2);  E = (0, g/2, 0; g/2, g^2/2, 0; 0, 0, 0)
//         principal stresses: mu (l - 1 - g^2/3) with l = 1 + g^2/2 +- g sqrt(1 + g^2/4) and 1
//         T = x^2 on cells of 1/2, k = 2: q_x = -1 and -3 in the cells left and right of x = 1/2, where the
//         probe lies on the edge of four cells: their mean is -2
// bar,    linear elastic with E = 200, nu = 0.3 in uniaxial tension e = 0.01: sigma_11 = von Mises = E e,
//         strain (e, -nu e, -nu e), J = (1 + e)(1 - nu e)^2; the ids 1 and 4 have areas of 1 and 3, so the
//         integral of the boundary id is 13
//
// ranks: 1 2 3

#include "given_solution.h"

#include <dovetail/measure/probes.h>

using namespace test;

namespace {

std::string condition(const std::string &name, const std::string &field, const std::string &value)
{
  return subsection("Boundary condition " + name, set("Type", "value") + set("Field", field) +
                                                      set("Boundary ids", "0") + set("Expression", value));
}

std::string probe(const std::string &name, const std::string &entries)
{
  return subsection("Probe " + name, entries);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::vector<std::string> of_rubber = {"Cauchy stress",      "strain",    "J",           "von Mises",
                                              "principal stresses", "heat flux", "material id", "solution"};
  const std::vector<std::string> of_bar = {"Cauchy stress", "strain", "J", "von Mises", "principal stresses"};
  std::string names, probes;
  for (const std::string &quantity : of_rubber) {
    names += (names.empty() ? "" : ", ") + ("rubber " + quantity);
    probes += probe("rubber " + quantity,
                    set("Domain", "rubber") + set("Point", "0.5; 0.5; 0.3") + set("Quantity", quantity));
  }
  for (const std::string &quantity : of_bar) {
    names += ", bar " + quantity;
    probes += probe("bar " + quantity,
                    set("Domain", "bar") + set("Point", "0.3; 0; 0.5") + set("Quantity", quantity));
  }
  names += ", ids";
  probes += probe("ids",
                  set("Boundary", "bar : 1, 4") + set("Reduce", "integral") + set("Quantity", "boundary id"));

  const GivenSolution<3> given(
      set("Materials", "soft, stiff") + set("Domains", "rubber, bar") + set("Probes", names) +
      subsection("Material soft", subsection("Solid", set("Type", "neo-Hookean") + set("Shear modulus", "2") +
                                                          set("Bulk modulus", "5")) +
                                      subsection("Heat", set("Type", "Fourier") + set("Conductivity", "2"))) +
      subsection("Material stiff",
                 subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "200") +
                                         set("Poisson ratio", "0.3"))) +
      subsection("Domain rubber",
                 set("Material", "soft") + set("Boundary conditions", "held, cold") +
                     box("2, 2, 1 : 0, 0, 0 : 1, 1, 1") + condition("held", "displacement", "y/2; 0; 0") +
                     condition("cold", "temperature", "0") +
                     subsection("Exact", set("displacement", "y/2; 0; 0") + set("temperature", "x^2"))) +
      subsection("Domain bar", set("Material", "stiff") + set("Boundary conditions", "held") +
                                   box("3, 2, 2 : 0, 0, 0 : 3, 1, 1") +
                                   condition("held", "displacement", "0; 0; 0") +
                                   subsection("Exact", set("displacement", "0.01*x; -0.003*y; -0.003*z"))) +
      probes);

  const Probes<3> all(given.scene, given.model);
  const auto values = all.evaluate(given.solution, *given.reactions).numbers;
  for (const auto &[name, value] : values.items())
    print(name,
          value.is_array() ? value.get<std::vector<double>>() : std::vector<double>{value.get<double>()});

  const double mu = 2, g = 0.5, e = 0.01, nu = 0.3, E = 200, root = g * std::sqrt(1 + g * g / 4);
  std::cout.precision(6);
  print("by hand: rubber von Mises", {mu * std::sqrt(std::pow(g, 4) + 3 * g * g)});
  print("by hand: rubber principal stresses",
        {mu * (g * g / 6 + root), -mu * g * g / 3, mu * (g * g / 6 - root)});
  print("by hand: bar J, von Mises", {(1 + e) * std::pow(1 - nu * e, 2), E * e});
}
