// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What every law with memory must fulfil along paths of random states.

#pragma once

#include "law_check.h"

#include <type_traits>

/// A material, its state at a point, and what it remembers there.
template <int dim>
struct Path
{
  Path(const std::string &solid, const std::string &heat = "", const std::string &scene = "")
      : material(make_material<dim>(solid, heat, "", scene)), state(material.n_components()),
        response(material.n_components())
  {
    for (const InternalVariable &variable : material.internal_variables())
      accepted.insert(accepted.end(), variable.n_components, variable.initial);
    trial = accepted;
    state.memory = {{accepted.data(), accepted.size()}, {trial.data(), trial.size()}};
  }

  bool evaluate() { return material.evaluate(state, true, response); }
  void accept() { std::copy(trial.begin(), trial.end(), accepted.begin()); }

  /// Of the derivatives, against central differences.
  double error_of_tangent()
  {
    const unsigned int n = material.n_components();
    const double h = 1e-7;
    FullMatrix<double> by_differences(n * dim, n * (1 + dim));
    for (unsigned int s = 0; s < n * (1 + dim); ++s) {
      Response<dim> plus(n), minus(n);
      const double S = entry(state, s);
      entry(state, s) = S + h;
      material.evaluate(state, false, plus);
      entry(state, s) = S - h;
      material.evaluate(state, false, minus);
      entry(state, s) = S;
      for (unsigned int c = 0; c < n; ++c)
        for (unsigned int J = 0; J < dim; ++J)
          by_differences(c * dim + J, s) = (plus.flux[c][J] - minus.flux[c][J]) / (2 * h);
    }
    evaluate();
    return relative_error(derivatives(response), by_differences);
  }

  const Material<dim> material;
  State<dim> state;
  Response<dim> response;
  std::vector<double> accepted, trial;
};

/// Of all sources, against central differences.
template <int dim>
double error_of_source(Path<dim> &path)
{
  const unsigned int n = path.material.n_components();
  const double h = 1e-6;
  FullMatrix<double> exact(n, n * (1 + dim)), by_differences = exact;
  for (unsigned int s = 0; s < n * (1 + dim); ++s) {
    Response<dim> plus(n), minus(n);
    const double S = entry(path.state, s);
    entry(path.state, s) = S + h;
    path.material.evaluate(path.state, false, plus);
    entry(path.state, s) = S - h;
    path.material.evaluate(path.state, false, minus);
    entry(path.state, s) = S;
    for (unsigned int c = 0; c < n; ++c)
      by_differences(c, s) = (plus.source[c] - minus.source[c]) / (2 * h);
  }
  path.evaluate();
  for (unsigned int c = 0; c < n; ++c)
    for (unsigned int d = 0; d < n; ++d) {
      exact(c, d * (1 + dim)) = path.response.source_by_value[c * n + d];
      for (unsigned int J = 0; J < dim; ++J)
        exact(c, d * (1 + dim) + 1 + J) = path.response.source_by_gradient[c * n + d][J];
    }
  return relative_error(exact, by_differences);
}

inline Tensor<2, 3> tensor(const std::vector<double> &numbers, const unsigned int first)
{
  Tensor<2, 3> result;
  for (unsigned int i = 0; i < 9; ++i)
    result[i / 3][i % 3] = numbers.at(first + i);
  return result;
}

/// The same flux and the same variables at the state that has been accepted.
template <int dim>
double error_of_rest(Path<dim> &path)
{
  const Response<dim> before = path.response;
  path.evaluate();
  double error = 0;
  for (unsigned int c = 0; c < dim; ++c)
    error = std::max(error, (path.response.flux[c] - before.flux[c]).norm());
  for (unsigned int i = 0; i < path.trial.size(); ++i)
    error = std::max(error, std::abs(path.trial[i] - path.accepted[i]));
  return error;
}

/// In a sheet and with a thermal strain.
template <int dim>
void check_tangents(const std::string &name, const std::string &law, const std::string &scene)
{
  Path<dim> path(law + expansion, conducts, scene);
  Random random;
  double tangent = 0, across = 0, rest = 0;
  bool is_defined = true;
  path.state.value[dim] = reference_temperature;
  for (unsigned int step = 0; step < 12; ++step) {
    for (unsigned int c = 0; c < dim; ++c)
      path.state.gradient[c] += (step % 3 == 2 ? 0.005 : 0.06) * random.vector<dim>();
    path.state.value[dim] += 0.5 * random.number();
    path.state.t += 0.3;
    tangent = std::max(tangent, path.error_of_tangent());
    is_defined = is_defined && path.evaluate();
    path.accept();
    rest = std::max(rest, error_of_rest(path));
    if (!scene.empty())
      across = std::max(across, std::abs(path.material.cauchy_stress(path.state)[2][2]));
  }
  report(name + ", defined", is_defined);
  report(name + ", tangent", tangent, 1e-6);
  report(name + ", no stress across", across, 1e-14);
  report(name + ", accepted state", rest, 1e-14);
}

/// check(dim, name, Geometry, distance from the axis) in 3D, in plane strain and around an axis, off it and
/// on it; dim is a std::integral_constant.
template <typename Check>
void in_all_geometries(const Check &check)
{
  const std::string axisymmetric = "set Geometry = axisymmetric\n";
  check(std::integral_constant<int, 3>(), "", "", 1);
  check(std::integral_constant<int, 2>(), ", plane strain", "", 1);
  check(std::integral_constant<int, 2>(), ", around an axis", axisymmetric, 0.8);
  check(std::integral_constant<int, 2>(), ", on the axis", axisymmetric, 0);
}
