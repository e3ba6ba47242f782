// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Factors from SI to other base units: 1 MPa is 1 N/mm^2 and 1 N is 1 t mm/s^2, so steel has 7.85e-9 t/mm^3
// and c in J/(kg K) becomes 1e6 mm^2/(s^2 K), while k in W/(m K) is mW/(mm K). In inches and pounds density
// is divided by 0.45359237 / 0.0254^3. And every function that formulas know stands in the list for the
// documents.

#include <dovetail/scene/expression.h>
#include <dovetail/scene/units.h>
#include <dovetail/scene/user_error.h>

#include <deal.II/base/mpi.h>

#include <iostream>

using namespace dovetail;

void show(const std::string &units, const std::string &unit, const double scale)
{
  const auto factor = Units(units).from_si(unit);
  std::cout << units << ": [" << unit << "] ";
  if (factor)
    std::cout << *factor * scale << std::endl;
  else
    std::cout << "not understood" << std::endl;
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string mm = "mm, t, s, K";
  show(mm, "Pa", 1e6);
  show(mm, "kg/m^3", 1e12);
  show(mm, "J/(kg K)", 1e-6);
  show(mm, "W/(m K)", 1);
  show(mm, "W/(m^2 K)", 1e3);
  show(mm, "m^2/s", 1e-6);
  show(mm, "1/(m^3 s)", 1e9);
  show(mm, "1/K", 1);
  show(mm, "-", 1);
  show("mm, kg, ms, K", "Pa", 1e9);
  show("in, lb, s, K", "kg/m^3", 0.45359237 / (0.0254 * 0.0254 * 0.0254));
  show("m, kg, min, K", "W/(m K)", 1. / 216000);
  show(mm, "m or K", 1);
  show(mm, "W/(m K", 1);
  for (const char *units : {"mm, t, s, K", "mm, kg, ms, K", "m, kg, us, K", "m, kg, min, K"})
    std::cout << units << ": frequencies in " << Units(units).of("Hz") << std::endl;
  for (const char *wrong : {"mm, t, s", "mm, t, s, C", "mm, t, s, K, A"})
    try {
      Units{wrong};
    } catch (const UserError &error) {
      std::cout << wrong << ": " << error.what() << std::endl;
    }

  std::string listed;
  for (const auto &[name, meaning] : Expression::functions())
    listed += name + " ";
  for (const std::string &name : Expression::names_of_functions())
    if (listed.find(name + "(") == std::string::npos)
      std::cout << name << " is not in the list of functions" << std::endl;
}
