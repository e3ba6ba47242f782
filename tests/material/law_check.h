// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What every law must fulfil, at random states (fixed seeds). A law's own test gives its text in the scene
// and, for solids, its energy; every line printed ends in "ok" or in the relative error that is too large.

#pragma once

#include <dovetail/material/material.h>
#include <dovetail/scene/scene_text.h>

#include <Sacado.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iostream>
#include <random>
#include <string>

using namespace dovetail;
using dealii::FullMatrix;
using dealii::Point;
using dealii::Tensor;

/// A material from the entries of its two subsections (an empty text means no law), other entries of the
/// material, and those of the scene.
template <int dim>
Material<dim> make_material(const std::string &solid, const std::string &heat, const std::string &others = "",
                            const std::string &scene = "")
{
  const std::string text = "set Dimension = " + std::to_string(dim) + "\n" + scene +
                           "subsection Material steel\n" + others +
                           (solid.empty() ? "" : "subsection Solid\n" + solid + "\nend\n") +
                           (heat.empty() ? "" : "subsection Heat\n" + heat + "\nend\n") + "end\n";
  return Material<dim>("steel", SceneText::root(SceneText::from_prm(text)).subsection("Material steel"));
}

inline void report(const std::string &what, double error, double tolerance)
{
  std::cout << what << ": ";
  if (error < tolerance) // false if the error is not a number
    std::cout << "ok" << std::endl;
  else
    std::cout << "error " << error << std::endl;
}

inline void report(const std::string &what, bool is_true)
{
  std::cout << what << ": " << (is_true ? "ok" : "not so") << std::endl;
}

/// Numbers between -1 and 1, the same on every machine.
class Random
{
public:
  double number() { return 2. * engine() / double(std::mt19937::max()) - 1; }

  template <int dim>
  Tensor<1, dim> vector()
  {
    Tensor<1, dim> result;
    for (unsigned int i = 0; i < dim; ++i)
      result[i] = number();
    return result;
  }

  template <int dim>
  State<dim> state(const Material<dim> &material)
  {
    State<dim> result(material.n_components());
    result.X = Point<dim>(vector<dim>());
    result.t = number();
    for (unsigned int c = 0; c < material.n_components(); ++c) {
      result.value[c] = 3 + number();
      result.gradient[c] = 0.3 * vector<dim>();
    }
    return result;
  }

  Tensor<2, 3> rotation()
  {
    const Tensor<1, 3> axis = vector<3>() + Point<3>(0, 0, 2), n = axis / axis.norm();
    const double angle = 3 * number();
    Tensor<2, 3> Q =
        std::cos(angle) * dealii::unit_symmetric_tensor<3>() + (1 - std::cos(angle)) * outer_product(n, n);
    Q += std::sin(angle) * Tensor<2, 3>({{0, -n[2], n[1]}, {n[2], 0, -n[0]}, {-n[1], n[0], 0}});
    return Q;
  }

private:
  std::mt19937 engine{7};
};

/// S = (B_0, grad B_0, B_1, …) as in Material::curvature: entry number @p s of @p state.
template <int dim>
double &entry(State<dim> &state, unsigned int s)
{
  const unsigned int c = s / (1 + dim), i = s % (1 + dim);
  return i == 0 ? state.value[c] : state.gradient[c][i - 1];
}

/// The derivatives dA_cJ/dS_s as a matrix with rows c * dim + J.
template <int dim>
FullMatrix<double> derivatives(const Response<dim> &response)
{
  const unsigned int n = response.flux.size();
  FullMatrix<double> result(n * dim, n * (1 + dim));
  for (unsigned int c = 0; c < n; ++c)
    for (unsigned int d = 0; d < n; ++d)
      for (unsigned int J = 0; J < dim; ++J) {
        result(c * dim + J, d * (1 + dim)) = response.by_value[c * n + d][J];
        for (unsigned int L = 0; L < dim; ++L)
          result(c * dim + J, d * (1 + dim) + 1 + L) = response.by_gradient[c * n + d][J][L];
      }
  return result;
}

inline double relative_error(FullMatrix<double> a, const FullMatrix<double> &b)
{
  a.add(-1, b);
  return a.frobenius_norm() / std::max(1e-10, b.frobenius_norm());
}

/// Derivatives against central differences of the flux, curvature against those of the derivatives.
template <int dim>
void check_differences(const std::string &what, const Material<dim> &material)
{
  Random random;
  const unsigned int n = material.n_components();
  const double h = 1e-5;
  double error = 0, curvature_error = 0;
  bool defined = true;
  for (unsigned int sample = 0; sample < 5; ++sample) {
    State<dim> state = random.state(material);
    std::vector<Tensor<1, dim>> w(n);
    for (Tensor<1, dim> &w_c : w)
      w_c = random.vector<dim>();
    Response<dim> here(n), plus(n), minus(n);
    defined &= material.evaluate(state, true, here);
    FullMatrix<double> by_differences(n * dim, n * (1 + dim)), curvature,
        curvature_by_differences(n * (1 + dim), n * (1 + dim));
    material.curvature(state, w, curvature);
    for (unsigned int s = 0; s < n * (1 + dim); ++s) {
      const double S = entry(state, s);
      entry(state, s) = S + h;
      defined &= material.evaluate(state, true, plus);
      entry(state, s) = S - h;
      defined &= material.evaluate(state, true, minus);
      entry(state, s) = S;
      FullMatrix<double> difference = derivatives(plus);
      difference.add(-1, derivatives(minus));
      for (unsigned int c = 0; c < n; ++c)
        for (unsigned int J = 0; J < dim; ++J) {
          by_differences(c * dim + J, s) = (plus.flux[c][J] - minus.flux[c][J]) / (2 * h);
          for (unsigned int r = 0; r < n * (1 + dim); ++r)
            curvature_by_differences(r, s) += w[c][J] * difference(c * dim + J, r) / (2 * h);
        }
    }
    error = std::max(error, relative_error(derivatives(here), by_differences));
    curvature_error = std::max(curvature_error, (curvature_by_differences.frobenius_norm() < 1e-8)
                                                    ? curvature.frobenius_norm()
                                                    : relative_error(curvature, curvature_by_differences));
  }
  const std::string where = what + ", " + std::to_string(dim) + "D, ";
  report(where + "is defined", defined);
  report(where + "derivative", error, 1e-8);
  report(where + "curvature", curvature_error, 1e-7);
}

template <typename Number>
using Matrix = std::array<std::array<Number, 3>, 3>;

template <typename Number>
Number determinant_of(const Matrix<Number> &F)
{
  return F[0][0] * (F[1][1] * F[2][2] - F[1][2] * F[2][1]) -
         F[0][1] * (F[1][0] * F[2][2] - F[1][2] * F[2][0]) +
         F[0][2] * (F[1][0] * F[2][1] - F[1][1] * F[2][0]);
}

/// C = F^T F
template <typename Number>
Matrix<Number> right_cauchy_green(const Matrix<Number> &F)
{
  Matrix<Number> C;
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int j = 0; j < 3; ++j)
      C[i][j] = F[0][i] * F[0][j] + F[1][i] * F[1][j] + F[2][i] * F[2][j];
  return C;
}

/// The energy s^3 W_e(F/s), s = 1 + e, of a hyperelastic law with free thermal strain e.
template <typename ElasticEnergy>
struct Expanding
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F, const Number &e) const
  {
    const Number s = 1. + e;
    Matrix<Number> G;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        G[i][j] = F[i][j] / s;
    return s * s * s * ElasticEnergy()(G);
  }
};

const double alpha = 0.03, reference_temperature = 2.5;
const std::string expansion = "\nset Expansion coefficient = 0.03\nset Reference temperature = 2.5";
const std::string conducts = "set Type = Fourier\nset Conductivity = 1.5 + 0.2*T + 0.1*T^2";

/// Flux, derivatives and curvature of a 3D solid against the derivatives of its energy W(F, e) by Sacado.
template <typename Energy>
void check_energy(const Material<3> &material, const Energy &W)
{
  constexpr unsigned int N = 10; // F row by row, e
  using First = Sacado::Fad::SFad<double, N>;
  using Second = Sacado::Fad::SFad<First, N>;
  using Third = Sacado::Fad::SFad<Second, 1>;

  Random random;
  double flux_error = 0, error = 0, curvature_error = 0, energy_error = 0;
  for (unsigned int sample = 0; sample < 5; ++sample) {
    const State<3> state = random.state(material);
    std::vector<Tensor<1, 3>> w(4);
    for (unsigned int i = 0; i < 3; ++i)
      w[i] = random.vector<3>();
    Response<3> response(4);
    material.evaluate(state, true, response);
    FullMatrix<double> curvature;
    material.curvature(state, w, curvature);

    // W(F + tau w, e): the derivative by tau is w:P
    std::array<Third, N> S;
    for (unsigned int s = 0; s < N; ++s) {
      const double value = s < 9 ? (s / 3 == s % 3) + state.gradient[s / 3][s % 3]
                                 : alpha * (state.value[3] - reference_temperature);
      S[s] = Third(Second(N, s, First(N, s, value)));
      S[s].fastAccessDx(0) = Second(First(s < 9 ? w[s / 3][s % 3] : 0.));
    }
    Matrix<Third> F;
    for (unsigned int s = 0; s < 9; ++s)
      F[s / 3][s % 3] = S[s];
    const Third energy = W(F, S[9]);
    Matrix<Third> free; // F = (1 + e) I
    for (unsigned int s = 0; s < 9; ++s)
      free[s / 3][s % 3] = s / 3 == s % 3 ? Third(1. + S[9]) : Third(0.);
    const double stored = energy.val().val().val() - W(free, S[9]).val().val().val();
    energy_error = std::max(energy_error, std::abs(material.energy_density(state) / stored - 1));

    FullMatrix<double> P(9, 1), P_W(9, 1), D(9, N), D_W(9, N), FF(N, N), FF_W(N, N);
    const auto row = [](unsigned int s) { return s < 9 ? (s / 3) * 4 + 1 + s % 3 : 12; };
    const FullMatrix<double> derivative = derivatives(response);
    for (unsigned int s = 0; s < N; ++s)
      for (unsigned int r = 0; r < N; ++r) {
        const double by_e = (s == 9 ? 1 / alpha : 1.);
        if (r < 9) {
          P(r, 0) = response.flux[r / 3][r % 3];
          P_W(r, 0) = energy.val().val().dx(r);
          D(r, s) = derivative(r, row(s)) * by_e;
          D_W(r, s) = energy.val().dx(r).dx(s);
        }
        FF(r, s) = curvature(row(r), row(s)) * by_e * (r == 9 ? 1 / alpha : 1.);
        FF_W(r, s) = energy.dx(0).dx(r).dx(s);
      }
    flux_error = std::max(flux_error, relative_error(P, P_W));
    error = std::max(error, relative_error(D, D_W));
    curvature_error = std::max(curvature_error, relative_error(FF, FF_W));
  }
  report("energy density", energy_error, 1e-9);
  report("flux against energy", flux_error, 1e-13);
  report("derivative against energy", error, 1e-13);
  report("curvature against energy", curvature_error, 1e-13);
}

/// P as one tensor, at F and temperature T.
inline Tensor<2, 3> stress(const Material<3> &material, const Tensor<2, 3> &F, double T)
{
  State<3> state(4);
  for (unsigned int i = 0; i < 3; ++i) {
    state.gradient[i] = F[i];
    state.gradient[i][i] -= 1;
  }
  state.value[3] = T;
  Response<3> response(4);
  material.evaluate(state, false, response);
  Tensor<2, 3> P;
  for (unsigned int i = 0; i < 3; ++i)
    P[i] = response.flux[i];
  return P;
}

/// Of the linear limit of all solids that are checked.
const std::string moduli = "\nset Shear modulus = 1.3\nset Bulk modulus = 2.7";

/// All that a solid law must fulfil; W(F, e) is the energy of the law @p type with the shear modulus 1.3 and
/// the bulk modulus 2.7.
template <typename Energy>
void check_solid(const std::string &type, const Energy &W, const std::string &parameters = moduli)
{
  const std::string law = "set Type = " + type + "\n" + parameters;
  check_differences("alone", make_material<2>(law, ""));
  check_differences("alone", make_material<3>(law, ""));
  check_differences("expanding", make_material<2>(law + expansion, conducts));
  check_differences("expanding", make_material<3>(law + expansion, conducts));
  const Material<3> material = make_material<3>(law + expansion, conducts);
  check_energy(material, W);

  Random random;
  const Tensor<2, 3> I(dealii::unit_symmetric_tensor<3>());
  report("no stress at rest", stress(material, I, reference_temperature).norm(), 1e-14);
  report("free expansion", stress(material, (1 + 2 * alpha) * I, reference_temperature + 2).norm(), 1e-14);

  const Material<3> linear = make_material<3>("set Type = linear elastic" + moduli + expansion, conducts);
  double objectivity_error = 0, symmetry_error = 0, limit_error = 0, plane_strain_error = 0;
  const Material<2> plane = make_material<2>(law + expansion, conducts);
  for (unsigned int sample = 0; sample < 5; ++sample) {
    State<3> state = random.state(material);
    Tensor<2, 3> F = I, small = I;
    const double h = 1e-7, T = state.value[3];
    for (unsigned int i = 0; i < 3; ++i) {
      F[i] += state.gradient[i];
      small[i] += h * state.gradient[i];
    }
    const Tensor<2, 3> Q = random.rotation(), P = stress(material, F, T);
    objectivity_error = std::max(objectivity_error, (stress(material, Q * F, T) - Q * P).norm() / P.norm());

    const Tensor<2, 3> small_stress = stress(linear, small, reference_temperature + h * T);
    limit_error =
        std::max(limit_error, (stress(material, small, reference_temperature + h * T) - small_stress).norm() /
                                  small_stress.norm());

    Response<3> response(4);
    material.evaluate(state, true, response);
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int k = 0; k < 3; ++k)
        symmetry_error =
            std::max(symmetry_error,
                     (response.by_gradient[i * 4 + k] - transpose(response.by_gradient[k * 4 + i])).norm());

    State<2> flat = random.state(plane);
    Response<2> flat_response(3);
    plane.evaluate(flat, false, flat_response);
    Tensor<2, 3> flat_F = I;
    for (unsigned int i = 0; i < 2; ++i)
      for (unsigned int j = 0; j < 2; ++j)
        flat_F[i][j] += flat.gradient[i][j];
    const Tensor<2, 3> flat_stress = stress(material, flat_F, flat.value[2]);
    for (unsigned int i = 0; i < 2; ++i)
      for (unsigned int j = 0; j < 2; ++j)
        plane_strain_error =
            std::max(plane_strain_error, std::abs(flat_stress[i][j] - flat_response.flux[i][j]));
  }
  if (!material.is_linear(0)) {
    report("objectivity", objectivity_error, 1e-13);
    State<3> inverted(4);
    inverted.gradient[0][0] = -1.5;
    inverted.value[3] = reference_temperature;
    Response<3> response(4);
    report("not defined for J < 0", !material.evaluate(inverted, false, response));
  }
  report("symmetry of the derivative", symmetry_error, 1e-13);
  report("limit of small strain", limit_error, 1e-5);
  report("plane strain", plane_strain_error, 1e-14);
}
