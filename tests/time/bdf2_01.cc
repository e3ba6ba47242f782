// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// BDF2 with variable steps: the rates of polynomials of degree 2 are exact, those of a step that starts anew
// are those of backward Euler; the solution of dx/dt = -x is of order 2 with steps of any size, and so is
// that of d2x/dt2 = -x; the estimated error of a step is that of a polynomial of degree 3, and follows the
// one of the solution.
//
// ranks: 1 2

#include "one_unknown.h"

namespace {

using namespace test;

std::unique_ptr<TimeScheme> bdf2()
{
  auto scheme = make_time_scheme(SceneText::root(SceneText::from_prm("")).subsection("Steps"));
  scheme->estimate_errors();
  return scheme;
}

/// The error at t = 1 of dx/dt = -x from 1, in n steps.
double error_of_decay(const unsigned int n)
{
  const auto scheme = bdf2();
  scheme->start(state(1));
  double x = 1;
  for (unsigned int i = 1; i <= n; ++i) {
    const StepTime step = scheme->step_to(end_of_step(i, n));
    const Rates rates = scheme->rates(step);
    x = -value(rates.rest) / (1 + rates.by_value);
    scheme->accept_step(step, state(x));
  }
  return x - std::exp(-1.);
}

/// The estimated error of the last of n steps from the exact solution, relative to the true one.
double ratio_of_estimate(const unsigned int n)
{
  const auto scheme = bdf2();
  scheme->start(state(1));
  for (unsigned int i = 1; i < n; ++i)
    scheme->accept_step(scheme->step_to(end_of_step(i, n)), state(std::exp(-end_of_step(i, n))));
  const StepTime step = scheme->step_to(1);
  const Rates rates = scheme->rates(step);
  const double x = -value(rates.rest) / (1 + rates.by_value);
  return value(scheme->local_error(step, state(std::exp(-1.))).state_error) / (x - std::exp(-1.));
}

void check_polynomials()
{
  const auto scheme = bdf2();
  const auto square = [](const double t) { return 3 - 2 * t + t * t; };
  const auto cube = [](const double t) { return t * t * t; };
  scheme->start(state(square(0)));
  scheme->accept_step(scheme->step_to(0.3), state(square(0.3)));
  const Rates rates = scheme->rates(scheme->step_to(0.8));
  report("degree 2", std::abs(rates.by_value * square(0.8) + value(rates.rest) - (2 * 0.8 - 2)) < 1e-13);
  const Rates anew = scheme->rates(scheme->step_to(0.8, true));
  report("a new start",
         std::abs(anew.by_value - 2) < 1e-13 && std::abs(value(anew.rest) + 2 * square(0.3)) < 1e-13);
  const Rates of_first = scheme->rates(scheme->step_to(0.8).with_new_first_rates());
  report("new first rates", of_first.by_value == anew.by_value && value(of_first.rest) == value(anew.rest));
  const Rates long_step = scheme->rates(scheme->step_to(1.));
  report("a long step", std::abs(long_step.by_value - 1 / 0.7) < 1e-13);

  scheme->start(state(cube(0)));
  report("nothing is known", scheme->local_error(scheme->step_to(0.3), state(1)).order == 0);
  for (const double t : {0.3, 0.5})
    scheme->accept_step(scheme->step_to(t), state(cube(t)));
  const StepTime step = scheme->step_to(0.7);
  const StepError error = scheme->local_error(step, state(cube(0.7)));
  // the rate of the polynomial through the last three states misses that of the cube by (t - t_1)(t - t_2)
  report("error of degree 3", error.order == 2 && std::abs(value(error.state_error) -
                                                           0.2 * 0.4 / scheme->rates(step).by_value) < 1e-13);
  scheme->accept_step(scheme->step_to(0.7, true), state(cube(0.7)));
  report("memory after a new start",
         scheme->memory().states.size() == 2 && scheme->memory().sizes.size() == 1);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_polynomials();
  print("order of a decay", std::log2(error_of_decay(40) / error_of_decay(80)));
  report("estimated error", std::abs(ratio_of_estimate(80) - 1) < 0.05);
  print("order of an oscillation",
        std::log2(error_of_oscillation(*bdf2(), 80) / error_of_oscillation(*bdf2(), 160)));
}
