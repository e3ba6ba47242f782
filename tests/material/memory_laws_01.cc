// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Laws that remember along paths of random strains: the flow rule and the yield condition of J2 plasticity
// and the creep law of Norton at each step, derivatives against differences, in plane stress, too, and the
// same state again at an accepted one.

#include "path_check.h"

namespace {

const double mu = 1.3, kappa = 2.7;

/// kappa tr(eps) I + 2 mu (dev eps - eps_i) with what is remembered now
template <int dim>
Tensor<2, 3> stress_of(const Path<dim> &path)
{
  Tensor<2, 3> H, I = dealii::unit_symmetric_tensor<3>();
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int j = 0; j < dim; ++j)
      H[i][j] = path.state.gradient[i][j];
  const Tensor<2, 3> eps = 0.5 * (H + transpose(H));
  return kappa * trace(eps) * I + 2 * mu * (eps - trace(eps) / 3 * I - tensor(path.trial, 0));
}

template <int dim>
double error_of_flux(const Path<dim> &path, const Tensor<2, 3> &P)
{
  double error = 0;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int j = 0; j < dim; ++j)
      error = std::max(error, std::abs(path.response.flux[i][j] - P[i][j]));
  return error;
}

struct Hardening
{
  double linear, saturation, rate, kinematic;
  double strength(const double a) const
  {
    return 0.1 + linear * a + (saturation > 0 ? (saturation - 0.1) * (1 - std::exp(-rate * a)) : 0);
  }
  std::string text() const
  {
    const auto set = [](const std::string &name, const double value) {
      return "\nset " + name + " = " + std::to_string(value);
    };
    return "set Type = J2 plasticity" + moduli + "\nset Yield stress = 0.1" +
           set("Isotropic hardening modulus", linear) + set("Kinematic hardening modulus", kinematic) +
           (saturation > 0 ? set("Saturation stress", saturation) + set("Saturation exponent", rate) : "");
  }
};

template <int dim>
void check_plasticity(const std::string &name, const Hardening &hardening)
{
  Path<dim> path(hardening.text());
  Random random;
  double flow = 0, surface = 0, flux = 0, tangent = 0, rest = 0;
  unsigned int n_plastic = 0;
  std::vector<Tensor<1, dim>> change(dim);
  for (unsigned int step = 0; step < 12; ++step) {
    for (unsigned int c = 0; c < dim; ++c) {
      change[c] = step % 3 == 2 ? -0.1 * change[c] : 0.06 * random.vector<dim>(); // every third one unloads
      path.state.gradient[c] += change[c];
    }
    tangent = std::max(tangent, path.error_of_tangent());
    const Tensor<2, 3> P = stress_of(path), d_plastic = tensor(path.trial, 0) - tensor(path.accepted, 0);
    const Tensor<2, 3> beta = hardening.kinematic > 0 ? tensor(path.trial, 10) : Tensor<2, 3>(),
                       before = hardening.kinematic > 0 ? tensor(path.accepted, 10) : Tensor<2, 3>(),
                       xi = Tensor<2, 3>(deviator(symmetrize(P))) - beta;
    flux = std::max(flux, error_of_flux(path, P));
    const double f = std::sqrt(1.5) * xi.norm() - hardening.strength(path.trial[9]);
    const bool yields = d_plastic.norm() > 0;
    n_plastic += yields ? 1 : 0;
    surface = std::max(surface, yields ? std::abs(f) : std::max(f, 0.));
    flow = std::max({flow, std::abs(trace(d_plastic)),
                     (d_plastic - d_plastic.norm() / xi.norm() * xi).norm() / (yields ? 1 : 1e300),
                     (beta - before - 2. / 3 * hardening.kinematic * d_plastic).norm(),
                     std::abs(path.trial[9] - path.accepted[9] - std::sqrt(2. / 3) * d_plastic.norm())});
    path.accept();
    rest = std::max(rest, error_of_rest(path));
  }
  report(name + ", yields in some steps", n_plastic > 4 && n_plastic < 12);
  report(name + ", flux", flux, 1e-14);
  report(name + ", yield condition", surface, 1e-14);
  report(name + ", flow rule", flow, 1e-15);
  report(name + ", tangent", tangent, 1e-6);
  report(name + ", accepted state", rest, 1e-15);
}

void check_creep()
{
  const std::string law = "set Type = Norton creep" + moduli +
                          "\nset Reference rate = 0.2\nset Reference stress = 0.3\nset Exponent = 4.5";
  Path<3> path(law);
  Random random;
  double flow = 0, flux = 0, tangent = 0, rest = 0;
  for (unsigned int step = 0; step < 6; ++step) {
    for (unsigned int c = 0; c < 3; ++c)
      path.state.gradient[c] += 0.06 * random.vector<3>();
    const double duration = 0.4 + 0.3 * random.number();
    path.state.t += duration;
    tangent = std::max(tangent, path.error_of_tangent());
    const Tensor<2, 3> P = stress_of(path), s = deviator(symmetrize(P));
    const double q = std::sqrt(1.5) * s.norm();
    const Tensor<2, 3> expected = duration * 0.2 * std::pow(q / 0.3, 4.5) * 1.5 / q * s;
    flow = std::max(flow, (tensor(path.trial, 0) - tensor(path.accepted, 0) - expected).norm());
    flux = std::max(flux, error_of_flux(path, P));
    path.accept();
    rest = std::max(rest, error_of_rest(path));
  }
  report("creep, flux", flux, 1e-14);
  report("creep, flow rule", flow, 1e-14);
  report("creep, tangent", tangent, 1e-6);
  report("creep, accepted state", rest, 1e-15);
  check_tangents<2>("creep, sheet", law, "set Geometry = plane stress\n");
}

} // namespace

int main()
{
  const Hardening perfect{0, 0, 0, 0}, mixed{0.3, 0.25, 30, 0.2};
  check_plasticity<3>("perfect", perfect);
  check_plasticity<3>("linear", {0.3, 0, 0, 0});
  check_plasticity<3>("Voce", {0, 0.25, 30, 0});
  check_plasticity<3>("kinematic", {0, 0, 0, 0.2});
  check_plasticity<2>("mixed, plane strain", mixed);
  check_tangents<3>("expanding", mixed.text(), "");
  check_tangents<2>("sheet", mixed.text(), "set Geometry = plane stress\n");
  check_tangents<2>("perfect sheet", perfect.text(), "set Geometry = plane stress\n");
  check_creep();
}
