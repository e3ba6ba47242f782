// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Heat of compression along paths of random strains, in 3D, in plane strain and around an axis (off it and on
// it), of laws that are linear, hyperelastic and plastic, with numbers and formulas, in both formulations:
// its derivatives against differences, and its value against what the step adds to dW/dT of the free energy
// W, itself found by differences. At large plastic strains that is exact in steps of any size, else of first
// order in the step.

#include "path_check.h"

namespace {

const double offset = 40, duration = 0.4;
const std::string heats = conducts +
                          "\nset Density = 1\nset Heat capacity = 1\nset Heat of compression = true\n"
                          "set Offset = 40\n";
const std::string formula =
    "\nset Expansion coefficient = 0.03 + 0.004*T + 0.0005*T^2\nset Reference temperature = 2.5";
const std::string in_time = "subsection Steps\nset Kind = transient\nend\n";

/// The elastic energy at another temperature, with the pressure that belongs to it; F and what is remembered
/// stay.
template <int dim>
double energy(Path<dim> &path, const unsigned int T, const double change, const double dp_dT)
{
  const State<dim> state = path.state;
  path.state.value[T] += change;
  if (T > dim)
    path.state.value[dim] += change * dp_dT;
  const double W = path.material.energy_density(path.state);
  path.state = state;
  return W;
}

/// The pressure at which the volume is that of the displacement, by the secant method: S_p = 0.
template <int dim>
void find_pressure(Path<dim> &path)
{
  double &p = path.state.value[dim];
  for (unsigned int i = 0; i < 20; ++i) {
    path.evaluate();
    p -= path.response.source[dim] / path.response.source_by_value[dim * (dim + 2) + dim];
  }
}

template <int dim>
void check(const std::string &name, const std::string &solid, const double size, const double tolerance,
           const std::string &geometry = "", const double r = 1)
{
  const bool is_mixed = solid.find("mixed") != std::string::npos;
  Path<dim> path(solid, heats, geometry + in_time);
  const unsigned int T = path.material.find_field("temperature")->first_component;
  Random random;
  double tangent = 0, value = 0, largest = 0;
  path.state.X[0] = r;
  path.state.value[T] = reference_temperature;
  for (unsigned int step = 0; step < 8; ++step) {
    const std::vector<double> memory = path.accepted;
    const State<dim> before = path.state;
    for (unsigned int c = 0; c < dim; ++c)
      path.state.gradient[c] += size * (step % 3 == 2 ? 0.05 : 1) * random.vector<dim>();
    path.state.value[0] += 0.5 * size * random.number();
    path.state.value[T] += 0.5 * random.number();
    path.state.t += duration;
    if (is_mixed) {
      find_pressure(path);
      path.state.value[dim] += 0.01; // elsewhere
    }
    tangent = std::max(tangent, error_of_source(path));
    if (is_mixed)
      find_pressure(path);
    path.evaluate();
    const double heat = -path.response.source[T];
    const std::vector<double> remembered = path.trial;
    // of the energies, at the new temperature
    const double h = 1e-4;
    const auto slope = [&]() {
      if (!is_mixed)
        return (energy(path, T, h, 0) - energy(path, T, -h, 0)) / (2 * h);
      std::array<double, 2> W;
      const State<dim> here = path.state;
      for (const unsigned int i : {0, 1}) {
        path.state.value[T] = here.value[T] + (i == 0 ? -h : h);
        find_pressure(path);
        W[i] = path.material.energy_density(path.state);
        path.state = here;
      }
      return (W[1] - W[0]) / (2 * h);
    };
    path.accepted = remembered;
    path.trial = remembered;
    const double at_end = slope();
    const State<dim> here = path.state;
    path.accepted = memory;
    path.trial = memory;
    path.state.gradient = before.gradient;
    for (unsigned int i = 0; i < dim; ++i)
      path.state.value[i] = before.value[i];
    const double at_start = slope();
    path.state.gradient = here.gradient;
    path.state.value = here.value;
    path.trial = remembered;
    const double expected = (here.value[T] + offset) * (at_end - at_start) / duration;
    value = std::max(value, std::abs(heat - expected));
    largest = std::max(largest, std::abs(expected));
    path.accept();
  }
  report(name + ", tangent", tangent, 1e-6);
  report(name + ", heat", value / largest, tolerance);
}

template <int dim>
void check_all(const std::string &where, const std::string &geometry, const double r)
{
  const std::string mixed = "\nset Formulation = mixed",
                    plastic = moduli + "\nset Yield stress = 0.1\nset Isotropic hardening modulus = 0.3",
                    creep =
                        moduli + "\nset Reference rate = 0.2\nset Reference stress = 0.3\nset Exponent = 4.5",
                    soft = "\nset Shear modulus = 0.8 + 0.05*T + 0.01*T^2\nset Bulk modulus = 2 + 0.1*T^2";
  const auto both = [&](const std::string &name, const std::string &law, const double size,
                        const double tolerance) {
    check<dim>(name + where, law, size, tolerance, geometry, r);
    check<dim>(name + ", mixed" + where, law + mixed, size, tolerance, geometry, r);
  };
  const double exact = 1e-6, first_order = 0.02, few = 0.05, tiny = 1e-3;
  both("linear", "set Type = linear elastic" + moduli + expansion, few, exact);
  both("linear, formula", "set Type = linear elastic" + moduli + formula, few, exact);
  both("soft", "set Type = linear elastic" + soft + formula, tiny, first_order);
  both("neo-Hookean", "set Type = neo-Hookean" + moduli + expansion, tiny, first_order);
  both("neo-Hookean, Liu, soft", "set Type = neo-Hookean\nset Volumetric = Liu" + soft + formula, tiny,
       first_order);
  both("small plastic", "set Type = J2 plasticity" + plastic + formula, few, exact);
  both("creep", "set Type = Norton creep" + creep + expansion, few, exact);
  check<dim>("large plastic" + where, "set Type = finite J2 plasticity" + plastic + expansion, few, exact,
             geometry, r);
  check<dim>("large plastic, formula" + where, "set Type = finite J2 plasticity" + plastic + formula, few,
             exact, geometry, r);
  check<dim>("large plastic, mixed" + where, "set Type = finite J2 plasticity" + plastic + formula + mixed,
             tiny, first_order, geometry, r);
}

} // namespace

int main()
{
  in_all_geometries([](const auto dim, const std::string &where, const std::string &geometry,
                       const double r) { check_all<dim>(where, geometry, r); });
}
