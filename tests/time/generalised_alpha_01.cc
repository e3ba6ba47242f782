// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The generalised alpha method: of order 2 with steps of any size, also after a new start; with the spectral
// radius 1 an oscillator keeps its energy over 1000 periods; of a frequency far beyond what the steps
// resolve, each step leaves the spectral radius; the low ones are hardly damped; the first rates are those of
// BDF2.
//
// ranks: 1 2

#include "one_unknown.h"

namespace {

using namespace test;

std::unique_ptr<TimeScheme> scheme_of(const std::string &entries)
{
  return make_time_scheme(
      SceneText::root(SceneText::from_prm("subsection Steps\n" + entries + "end\n")).subsection("Steps"));
}

std::unique_ptr<TimeScheme> generalised_alpha(const double radius)
{
  return scheme_of("set Scheme = generalised alpha\nset Spectral radius = " + std::to_string(radius) + "\n");
}

double energy(const TimeScheme &scheme, const double w)
{
  return std::pow(w * value(scheme.memory().states[0]), 2) + std::pow(value(scheme.memory().rates[0]), 2);
}

/// Smallest and largest energy, relative to that of the beginning.
void check_energy()
{
  const auto scheme = generalised_alpha(1);
  scheme->start(state(1), state(0.5));
  const double w = 2 * dealii::numbers::PI;
  const unsigned int n = 20;
  const double first = energy(*scheme, w);
  double least = 2, most = 0;
  for (unsigned int i = 1; i <= 1000 * n; ++i) {
    oscillate(*scheme, scheme->step_to(double(i) / n), w);
    least = std::min(least, energy(*scheme, w) / first);
    most = std::max(most, energy(*scheme, w) / first);
  }
  report("energy of 1000 periods", std::abs(least - 1) < 1e-9 && std::abs(most - 1) < 1e-9);
}

/// What a step leaves of the largest x among a few, far from the beginning.
double damping(const double radius, const double w)
{
  const auto scheme = generalised_alpha(radius);
  scheme->start(state(1), state(0));
  const unsigned int n = 40;
  double before = 0, after = 0;
  for (unsigned int i = 1; i <= 2 * n; ++i) {
    const double x = std::abs(oscillate(*scheme, scheme->step_to(i), w));
    (i <= n ? before : after) = std::max(i % n == 1 ? 0. : (i <= n ? before : after), x);
  }
  return std::pow(after / before, 1. / n);
}

double error_with_new_start(const unsigned int n)
{
  const auto scheme = generalised_alpha(0.8);
  scheme->start(state(0), state(1));
  double x = 0;
  for (unsigned int i = 1; i <= n; ++i)
    x = oscillate(*scheme, scheme->step_to(end_of_step(i, n), i == n / 2));
  return x - std::sin(1.);
}

void check_first_rates()
{
  const auto scheme = generalised_alpha(0.8), bdf2 = scheme_of("");
  for (TimeScheme *s : {scheme.get(), bdf2.get()}) {
    s->start(state(1), state(2));
    for (const double t : {0.3, 0.5, 0.9}) {
      if (s->asks_for_second_rates(s->step_to(t)))
        s->start_second_rates(state(1));
      s->accept_step(s->step_to(t), state(std::exp(t)));
    }
  }
  const Rates rates = scheme->rates(scheme->step_to(1)), expected = bdf2->rates(bdf2->step_to(1));
  report("first rates", rates.by_value == expected.by_value && value(rates.rest) == value(expected.rest));
  scheme->start(state(1));
  scheme->accept_step(scheme->step_to(0.3), state(2));
  report("no second rates", !scheme->rates(scheme->step_to(0.5)).has_second());
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const double radius : {0., 0.5, 1.}) {
    print("spectral radius", radius);
    print("  order", std::log2(error_of_oscillation(*generalised_alpha(radius), 80) /
                               error_of_oscillation(*generalised_alpha(radius), 160)));
    print("  damping of a period of 20 steps", damping(radius, 2 * dealii::numbers::PI / 20));
    if (radius > 0)
      print("  damping of a high frequency", damping(radius, 1e4));
  }
  print("order with a new start", std::log2(error_with_new_start(80) / error_with_new_start(640)) / 3);
  check_energy();
  check_first_rates();
}
