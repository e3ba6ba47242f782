// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Laws of joints at one point, bilinear (one mode and two) and by a formula (uncoupled and coupled): the
// derivative of the traction against central differences at random openings, from the intact and from a
// damaged joint, in tension and compression. At the state that is remembered the law gives the same traction
// and memory again. On the way back to zero the traction follows the secant; in compression it is that of the
// intact joint. A bilinear joint that is opened along a straight line does the work G(B) until it has broken,
// and says so; one by a formula says what the work along a path exceeds the energy that unloading gives back.
// The opening in series with a penalty satisfies its equation.

#include "../system/scene_model.h"

#include <dovetail/tie/joint_law.h>

using namespace test;
using dealii::Tensor;

/// Reads the law from a scene.
struct JointReader
{
  explicit JointReader(const std::string &entries)
      : text(SceneText::from_prm(set("Dimension", "2") + entries)),
        law(JointCatalogue::create_by("Joint", SceneText::root(text), "", "law"))
  {
  }
  std::shared_ptr<SceneText> text;
  std::unique_ptr<JointLaw> law;
};

/// A law with a memory.
struct Joint
{
  explicit Joint(const std::string &entries) : reader(entries)
  {
    const unsigned int n = reader.law->internal_variables().size();
    accepted.assign(n, 0.);
    trial.assign(n, 0.);
  }
  JointPlace place()
  {
    JointPlace result;
    result.stiffness = {{50, 80}};
    result.memory = {{accepted.data(), accepted.size()}, {trial.data(), trial.size()}};
    return result;
  }
  JointResponse at(const Tensor<1, 3> &opening)
  {
    JointResponse response;
    is_defined = reader.law->evaluate(place(), opening, response) && is_defined;
    return response;
  }
  void accept() { accepted = trial; }

  JointReader reader;
  std::vector<double> accepted, trial;
  bool is_defined = true;
};

Tensor<1, 3> vector(const double n, const double s, const double r)
{
  Tensor<1, 3> result;
  result[0] = n;
  result[1] = s;
  result[2] = r;
  return result;
}

void test_law(const std::string &name, const std::string &entries)
{
  double tangent = 0, again = 0, secant = 0, compression = 0, series = 0;
  for (unsigned int i = 0; i < 60; ++i) {
    Joint joint(entries);
    if (i % 2 == 1) { // some damage
      joint.at(vector(0.1 * std::abs(noise(i)), 0.1 * noise(i + 1), 0.1 * noise(i + 2)));
      joint.accept();
    }
    const Tensor<1, 3> w = vector(0.15 * noise(7 * i), 0.15 * noise(7 * i + 1), 0.15 * noise(7 * i + 2));
    const JointResponse response = joint.at(w);
    const double h = 1e-6;
    Tensor<2, 3> difference;
    for (unsigned int d = 0; d < 3; ++d) {
      Tensor<1, 3> step;
      step[d] = h;
      const Tensor<1, 3> change = (joint.at(w + step).traction - joint.at(w - step).traction) / (2 * h);
      for (unsigned int c = 0; c < 3; ++c)
        difference[c][d] = change[c];
    }
    tangent = std::max(tangent, (difference - response.by_opening).norm() / response.by_opening.norm());

    const double gamma = joint.reader.law->softening(joint.place()) + 3;
    const Tensor<1, 3> r = vector(noise(i), 2 * noise(3 * i), noise(5 * i));
    Tensor<1, 3> opening;
    JointResponse in_series;
    joint.is_defined =
        find_opening(*joint.reader.law, joint.place(), gamma, r, opening, in_series) && joint.is_defined;
    series = std::max(series, (in_series.traction + gamma * opening - r).norm() / r.norm());

    joint.at(w);
    joint.accept();
    again = std::max(again, (joint.at(w).traction - response.traction).norm());
    for (unsigned int v = 0; v < joint.trial.size(); ++v)
      again = std::max(again, std::abs(joint.trial[v] - joint.accepted[v]));
    secant = std::max(secant, (joint.at(0.3 * w).traction - 0.3 * response.traction).norm());
    compression = std::max(compression, std::abs(joint.at(vector(-0.02, 0, 0)).traction[0] + 1));
    if (!joint.is_defined)
      tangent = 1e300;
  }
  report(name + ": tangent", tangent, 1e-7);
  report(name + ": again", again, 1e-14);
  report(name + ": secant", secant, 1e-14);
  report(name + ": compression", compression, 1e-14);
  report(name + ": in series", series, 1e-11);
}

/// Work along a straight line, by a midpoint rule, until the joint has broken.
void test_energy(const std::string &name, const std::string &entries, const Tensor<1, 3> &direction,
                 const double expected)
{
  Joint joint(entries);
  double work = 0;
  const unsigned int n = 20000;
  for (unsigned int i = 0; i < n; ++i) {
    work += joint.at((i + 0.5) / n * direction).traction * direction / n;
    joint.at((i + 1.) / n * direction);
    joint.accept();
  }
  report(name + ": work", std::abs(work / expected - 1), 1e-6);
  report(name + ": dissipated", std::abs(joint.accepted[1] / expected - 1), 1e-12);
  report(name + ": broken", std::abs(joint.accepted[0] - 1), 0.);
}

/// By a formula: work along a path with a turn, less what unloading gives back; the path opens, closes by
/// half, opens further and then slides.
void test_dissipation(const std::string &entries, const double expected)
{
  Joint joint(entries);
  const std::array<Tensor<1, 3>, 5> path = {
      {vector(0, 0, 0), vector(0.05, 0, 0), vector(0.02, 0, 0), vector(0.1, 0, 0), vector(0.1, 0.06, -0.08)}};
  double work = 0;
  const unsigned int n = 2000;
  for (unsigned int leg = 0; leg + 1 < path.size(); ++leg)
    for (unsigned int i = 0; i < n; ++i) {
      const Tensor<1, 3> way = path[leg + 1] - path[leg];
      work += joint.at(path[leg] + (i + 0.5) / n * way).traction * way / n;
      joint.at(path[leg] + (i + 1.) / n * way);
      joint.accept();
    }
  const double given_back = joint.at(path.back()).traction * path.back() / 2;
  report("formula: work", std::abs((work - given_back) / expected - 1), 1e-6);
  report("formula: dissipated", std::abs(joint.accepted[2] / expected - 1), 1e-12);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string one = set("Joint", "bilinear") + set("Strength", "1") + set("Fracture energy", "0.05"),
                    two = set("Joint", "bilinear") + set("Strength", "1; 2") +
                          set("Fracture energy", "0.05; 0.2") + set("Mixed mode exponent", "1.7");
  test_law("bilinear, one mode", one);
  test_law("bilinear, two modes", two);
  test_law("formula", set("Joint", "formula") + set("Traction", "50*n*exp(-n/0.03); 80*s*exp(-s/0.05)"));
  test_law("formula, coupled",
           set("Joint", "formula") +
               set("Traction", "50*n*exp(-n/0.03 - (s/0.05)^2); 80*s*(1 + n)*exp(-n/0.04 - (s/0.05)^2)"));

  test_energy("opening", two, vector(0.3, 0, 0), 0.05);
  test_energy("sliding", two, vector(0, 0.3, 0.4), 0.2);
  const double B = 80 * 0.25 / (50 * 0.16 + 80 * 0.25);
  test_energy("both", two, vector(0.4, 0.3, -0.4), 0.05 + 0.15 * std::pow(B, 1.7));
  const auto lost = [](const double stiffness, const double length, const double m) {
    const double x = m / length;
    return stiffness * length * length * (1 - (1 + x + x * x / 2) * std::exp(-x));
  };
  test_dissipation(set("Joint", "formula") + set("Traction", "50*n*exp(-n/0.03); 80*s*exp(-s/0.05)"),
                   lost(50, 0.03, 0.1) + lost(80, 0.05, 0.1));
  test_energy("sliding under pressure, one mode", one, vector(0, 0.5, 0), 0.05);
}
