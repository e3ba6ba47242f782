// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The part of degree one of a body of any degree, from which multigrid interpolates: sums of sums, followed
// to the unknowns that remain, reproduce a function of degree one in each direction (1e-13), and where an
// edge is long, one of the full degree along it. The number of unknowns that remain is that of degree one,
// but in the long direction of the full degree. Where only edges that are more than four times as long keep
// the degree, those that are three times as long do so in the cells beside a tied boundary.
//
// ranks: 1

#include "scene_model.h"

#include <dovetail/system/linear_part.h>

using namespace test;

namespace {

template <int dim>
std::string scene(const unsigned int degree, const std::string &mesh)
{
  return set("Materials", "one") + set("Domains", "body") +
         subsection("Material one", subsection("Heat", set("Type", "Fourier") + set("Conductivity", "1"))) +
         subsection("Domain body", set("Material", "one") + set("Degree", std::to_string(degree)) + mesh +
                                       set("Boundary conditions", "air") +
                                       subsection("Boundary condition air",
                                                  set("Type", "convection") + set("Field", "temperature") +
                                                      set("Boundary ids", "0") + set("Coefficient", "1") +
                                                      set("Ambient", "0")));
}

template <int dim>
void check(const std::string &name, const unsigned int degree, const std::string &mesh,
           const std::function<double(const dealii::Point<dim> &)> &function, const unsigned int n_expected,
           const double smallest_stretch = dovetail::smallest_stretch,
           const std::set<dealii::types::boundary_id> &tied = {})
{
  SceneModel<dim> scene_model(scene<dim>(degree, mesh));
  BlockSystem<dim> system(scene_model.model);
  system.set_up(1.);
  const Model<dim> &model = scene_model.model;
  Vector x = system.owned_vector();
  interpolate<dim>(
      model, [&](unsigned int, unsigned int, const dealii::Point<dim> &X) { return function(X); }, x);
  const auto sums = linear_part(*model.domains[0], model.numbering->blocks()[0],
                                dealii::AffineConstraints<double>(), smallest_stretch, tied);

  const std::function<double(unsigned int)> value = [&](const unsigned int i) {
    if (sums.is_only(i, i))
      return double(x(i));
    double result = 0;
    for (unsigned int k = 0; k < sums[i].n; ++k)
      result += sums[i].weights[k] * value(sums[i].columns[k]);
    return result;
  };
  double error = 0;
  unsigned int n_remaining = 0;
  for (unsigned int i = 0; i < sums.size(); ++i) {
    error = std::max(error, std::abs(value(i) - x(i)));
    n_remaining += sums.is_only(i, i);
  }
  report(name + ", degree " + std::to_string(degree) + ", values", error, 1e-13);
  report(name + ", degree " + std::to_string(degree) + ", unknowns", n_remaining == n_expected);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const unsigned int p : {1, 2, 3, 4}) {
    const auto power = [p](const double x) { return std::pow(x, double(p)); };
    check<2>(
        "squares", p, box("3, 2 : 0, 0 : 3, 2"), [](const auto &X) { return (1 + X[0]) * (2 - X[1]); },
        4 * 3);
    check<2>(
        "long in x", p, box("3, 2 : 0, 0 : 9, 2"),
        [&](const auto &X) { return (1 + power(X[0] / 9)) * (2 - X[1]); }, (3 * p + 1) * 3);
    const auto linear = [](const auto &X) { return (1 + X[0]) * (2 - X[1]); };
    check<2>("less long in x", p, box("3, 2 : 0, 0 : 9, 2"), linear, 4 * 3, smallest_stretch_beside_solves);
    check<2>("tied", p, box("3, 2 : 0, 0 : 9, 2"), linear, (3 + p) * 3, smallest_stretch_beside_solves, {1});
    if (p > 3)
      continue; // many unknowns
    check<3>(
        "long in z", p, box("1, 2, 2 : 0, 0, 0 : 1, 2, 20"),
        [&](const auto &X) { return (1 + X[0]) * (2 - X[1]) * (1 + power(X[2] / 20)); }, 2 * 3 * (2 * p + 1));
    check<3>(
        "flat", p, box("2, 2, 1 : 0, 0, 0 : 20, 20, 1"),
        [&](const auto &X) { return (1 + power(X[0] / 20)) * (2 - power(X[1] / 20)) * (1 + X[2]); },
        (2 * p + 1) * (2 * p + 1) * 2);
  }
}
