// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Plasticity at large strain along paths of random deformations: the yield condition, a flow that keeps the
// volume, derivatives against differences, the same state again at an accepted one, rotations before and
// after, the limit of small strain, and a tension test in one step against its closed form.

#include "path_check.h"

namespace {

const std::string law = "set Type = finite J2 plasticity" + moduli +
                        "\nset Yield stress = 0.1\nset Isotropic hardening modulus = 0.3"
                        "\nset Saturation stress = 0.25\nset Saturation exponent = 30";

double strength(const double a)
{
  return 0.1 + 0.3 * a + 0.15 * (1 - std::exp(-30 * a));
}

Tensor<2, 3> displacement_gradient(const State<3> &state)
{
  Tensor<2, 3> H;
  for (unsigned int i = 0; i < 3; ++i)
    H[i] = state.gradient[i];
  return H;
}

void set_gradient(State<3> &state, const Tensor<2, 3> &H)
{
  for (unsigned int i = 0; i < 3; ++i)
    state.gradient[i] = H[i];
}

Tensor<2, 3> stress_of(const Path<3> &path)
{
  Tensor<2, 3> P;
  for (unsigned int i = 0; i < 3; ++i)
    P[i] = path.response.flux[i];
  return P;
}

void check_path()
{
  const Tensor<2, 3> I = dealii::unit_symmetric_tensor<3>();
  Path<3> path(law);
  Random random;
  double surface = 0, volume = 0, tangent = 0, rest = 0, objectivity = 0, isotropy = 0;
  unsigned int n_plastic = 0;
  for (unsigned int step = 0; step < 8; ++step) {
    for (unsigned int c = 0; c < 3; ++c)
      path.state.gradient[c] += (step % 3 == 2 ? 0.01 : 0.2) * random.vector<3>();
    tangent = std::max(tangent, path.error_of_tangent());
    const Tensor<2, 3> H = displacement_gradient(path.state), F = I + H, P = stress_of(path);
    const double f =
        std::sqrt(1.5) * deviator(symmetrize(P * transpose(F))).norm() - strength(path.trial[18]);
    const bool yields = path.trial[18] > path.accepted[18];
    n_plastic += yields ? 1 : 0;
    surface = std::max(surface, yields ? std::abs(f) : std::max(f, 0.));
    volume = std::max(volume, std::abs(determinant(I + tensor(path.trial, 0)) - 1));
    const Tensor<2, 3> Q = random.rotation();
    set_gradient(path.state, Q * F - I);
    path.evaluate();
    objectivity = std::max(objectivity, (stress_of(path) - Q * P).norm());
    set_gradient(path.state, H);
    path.evaluate();
    path.accept();
    rest = std::max(rest, error_of_rest(path));
  }
  Path<3> first(law); // the virgin material is isotropic: P(F Q) = P(F) Q
  const Tensor<2, 3> F = I + 0.2 * Tensor<2, 3>({{1, 0.3, 0}, {0, -0.4, 0.5}, {0.2, 0, -0.3}}),
                     Q = random.rotation();
  set_gradient(first.state, F - I);
  first.evaluate();
  const Tensor<2, 3> P = stress_of(first);
  set_gradient(first.state, F * Q - I);
  first.evaluate();
  isotropy = (stress_of(first) - P * Q).norm();
  report("yields in some steps", n_plastic > 3 && n_plastic < 8);
  report("yield condition", surface, 1e-13);
  report("volume is kept by the flow", volume, 1e-14);
  report("tangent", tangent, 1e-6);
  report("accepted state", rest, 1e-14);
  report("rotation", objectivity, 1e-13);
  report("isotropy", isotropy, 1e-14);
}

/// Equal stretches, for which the axes are arbitrary.
void check_equal_stretches()
{
  Path<3> path(law);
  set_gradient(path.state, Tensor<2, 3>({{0.3, 0, 0}, {0, -0.1, 0}, {0, 0, -0.1}}));
  report("tangent of equal stretches", path.error_of_tangent(), 1e-6);
  path.accept();
  set_gradient(path.state, Tensor<2, 3>({{0.5, 0, 0}, {0, -0.15, 0}, {0, 0, -0.15}}));
  report("and in the next step", path.error_of_tangent(), 1e-6);
}

/// Where strains are small the law is that of small strains, up to terms of second order.
void check_small_strain()
{
  const std::string yields = moduli + "\nset Yield stress = 1e-7\nset Isotropic hardening modulus = 0.3";
  Path<3> large("set Type = finite J2 plasticity" + yields), small("set Type = J2 plasticity" + yields);
  Random random;
  double error = 0;
  for (unsigned int step = 0; step < 4; ++step) {
    for (unsigned int c = 0; c < 3; ++c)
      large.state.gradient[c] += 1e-6 * random.vector<3>();
    small.state.gradient = large.state.gradient;
    large.evaluate();
    small.evaluate();
    for (unsigned int c = 0; c < 3; ++c)
      error = std::max(error, (large.response.flux[c] - small.response.flux[c]).norm() / 1e-6);
    large.accept();
    small.accept();
  }
  report("limit of small strain", error, 1e-4);
}

/// With the stretch exp(Y(a)/E + a) along, the Kirchhoff stress is Y(a), and the sides are free.
void check_tension()
{
  const double a = 0.4, E = 9 * 2.7 * 1.3 / (3 * 2.7 + 1.3), nu = (3 * 2.7 - 2 * 1.3) / (2 * (3 * 2.7 + 1.3));
  const double tau = strength(a), along = std::exp(tau / E + a), across = std::exp(-nu * tau / E - a / 2);
  Path<3> path(law);
  set_gradient(path.state, Tensor<2, 3>({{along - 1, 0, 0}, {0, across - 1, 0}, {0, 0, across - 1}}));
  path.evaluate();
  const Tensor<2, 3> P = stress_of(path);
  report("tension, along", std::abs(P[0][0] - tau / along), 1e-14);
  report("tension, across", std::abs(P[1][1]) + std::abs(P[2][2]), 1e-14);
  report("tension, equivalent plastic strain", std::abs(path.trial[18] - a), 1e-14);
  report("tension, plastic strain", std::abs(path.trial[9] - a) + std::abs(path.trial[13] + a / 2), 1e-14);
  path.accept();
  report("tension, energy", std::abs(path.material.energy_density(path.state) - tau * tau / (2 * E)), 1e-14);
}

} // namespace

int main()
{
  check_path();
  check_equal_stretches();
  check_small_strain();
  check_tension();
  check_tangents<3>("expanding", law, "");
  check_tangents<2>("sheet", law, "set Geometry = plane stress\n");
}
