// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Equations with one unknown on each rank, for time schemes.

#pragma once

#include <dovetail/scene/scene_text.h>
#include <dovetail/time/time_scheme.h>

#include <deal.II/base/mpi.h>

#include <cmath>
#include <cstdio>
#include <iostream>
#include <string>

namespace test {

using namespace dovetail;
using Vector = Rates::Vector;

/// One unknown on each rank has the value.
inline Vector state(const double value)
{
  const unsigned int n = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD),
                     rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD);
  dealii::IndexSet owned(n);
  owned.add_index(rank);
  Vector x(std::vector<dealii::IndexSet>{owned}, MPI_COMM_WORLD);
  x(rank) = value;
  x.compress(dealii::VectorOperation::insert);
  return x;
}

inline double value(const Vector &x)
{
  return x(dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD));
}

inline void report(const std::string &what, const bool is_true)
{
  const bool is_everywhere = dealii::Utilities::MPI::min(is_true ? 1 : 0, MPI_COMM_WORLD) == 1;
  if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
    std::cout << what << ": " << (is_everywhere ? "ok" : "not so") << std::endl;
}

inline void print(const std::string &what, const double number)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.3g", number);
  if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
    std::cout << what << ": " << text << std::endl;
}

/// Sizes from 0.7 to 1.3 of the mean, without an order.
inline double end_of_step(const unsigned int i, const unsigned int n)
{
  return i == n ? 1 : (i + 0.25 * std::sin(5. * i)) / n;
}

/// The state at the end of a step of d2x/dt2 = -w^2 x.
inline double oscillate(TimeScheme &scheme, const StepTime &step, const double w = 1)
{
  if (scheme.asks_for_second_rates(step))
    scheme.start_second_rates(state(-w * w * value(scheme.memory().states[0])));
  const Rates rates = scheme.rates(step);
  const double x = -value(rates.second_rest) / (w * w + rates.second_by_value);
  scheme.accept_step(step, state(x));
  return x;
}

/// The error at t = 1 of d2x/dt2 = -x from x = 0 with the rate 1, in n steps.
inline double error_of_oscillation(TimeScheme &scheme, const unsigned int n)
{
  scheme.start(state(0), state(1));
  double x = 0;
  for (unsigned int i = 1; i <= n; ++i)
    x = oscillate(scheme, scheme.step_to(end_of_step(i, n)));
  return x - std::sin(1.);
}

} // namespace test
