// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Heat of plastic work along paths of random strains, small and large, in 3D, in plane strain and around an
// axis (off it and on it), with and without thermal expansion: its derivatives against differences, and its
// value against the strength times the increment of the equivalent plastic strain, per undeformed volume.

#include "path_check.h"

namespace {

const double share = 0.9, yield_stress = 0.1, hardening = 0.3;
const std::string plastic = moduli + "\nset Yield stress = 0.1\nset Isotropic hardening modulus = 0.3";
const std::string perfect = moduli + "\nset Yield stress = 0.1";
const std::string creep =
    moduli + "\nset Reference rate = 0.2\nset Reference stress = 0.3\nset Exponent = 4.5";
const std::string heats =
    conducts + "\nset Density = 1\nset Heat capacity = 1\nset Share of plastic work = 0.9\n";

/// @param a_position of the equivalent plastic strain; 0: of creep, which has none
template <int dim>
void check(const std::string &name, const std::string &solid, const unsigned int a_position,
           const double slope, const std::string &geometry = "", const double r = 1)
{
  Path<dim> path(solid, heats, geometry + "subsection Steps\nset Kind = transient\nend\n");
  Random random;
  const bool is_large = name.find("large") != std::string::npos,
             expands = solid.find(expansion) != std::string::npos;
  double tangent = 0, value = 0;
  unsigned int n_plastic = 0;
  path.state.X[0] = r;
  path.state.value[dim] = reference_temperature;
  for (unsigned int step = 0; step < 8; ++step) {
    for (unsigned int c = 0; c < dim; ++c)
      path.state.gradient[c] += (step % 3 == 2 ? 0.003 : 0.06) * random.vector<dim>();
    path.state.value[0] += 0.03 * random.number();
    path.state.value[dim] += 0.5 * random.number();
    path.state.t += 0.4;
    tangent = std::max(tangent, error_of_source(path));
    if (a_position > 0) {
      const double a = path.trial[a_position], change = a - path.accepted[a_position],
                   s = is_large && expands ? 1 + alpha * (path.state.value[dim] - reference_temperature) : 1,
                   expected = share * (yield_stress + slope * a) * change * s * s * s / 0.4;
      n_plastic += change > 0;
      value = std::max(value, std::abs(path.response.source[dim] + expected));
    }
    path.accept();
  }
  report(name + ", tangent", tangent, 1e-6);
  if (a_position == 0)
    return;
  report(name + ", heat", value, 1e-14);
  report(name + ", flows", n_plastic > 3);
}

template <int dim>
void check_all(const std::string &where, const std::string &geometry, const double r)
{
  const std::string small = "set Type = J2 plasticity", large = "set Type = finite J2 plasticity";
  check<dim>("small" + where, small + plastic, 9, hardening, geometry, r);
  check<dim>("small, expanding" + where, small + plastic + expansion, 9, hardening, geometry, r);
  check<dim>("large" + where, large + plastic, 18, hardening, geometry, r);
  check<dim>("large, perfect" + where, large + perfect, 18, 0, geometry, r);
  check<dim>("large, expanding" + where, large + plastic + expansion, 18, hardening, geometry, r);
  check<dim>("creep" + where, "set Type = Norton creep" + creep, 0, 0, geometry, r);
}

} // namespace

int main()
{
  in_all_geometries([](const auto dim, const std::string &where, const std::string &geometry,
                       const double r) { check_all<dim>(where, geometry, r); });
}
