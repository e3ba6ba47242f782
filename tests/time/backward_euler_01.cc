// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The backward Euler scheme: the rates of a polynomial x(t) = a + b t + c t^2 / 2 are exact for degree 1 in
// the first and the second rate, and have the error c h/2 in the first one; steps of other sizes that are not
// accepted leave no trace; sizes that differ by the rounding of the time are equal; a scheme that is restored
// from its memory goes on in the same way.
//
// ranks: 1 2

#include <dovetail/scene/scene_text.h>
#include <dovetail/time/time_scheme.h>

#include <deal.II/base/mpi.h>

#include <cmath>
#include <iostream>

namespace {

using namespace dovetail;
using Vector = Rates::Vector;

const double a = 3, b = -2;

/// The unknown i is a + b t + i t^2 / 2.
Vector state(const double t)
{
  const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD),
                     rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD), n = 5;
  std::vector<dealii::IndexSet> owned;
  for (unsigned int block = 0; block < 2; ++block) {
    owned.emplace_back(n * n_ranks);
    owned.back().add_range(n * rank, n * (rank + 1));
  }
  Vector x(owned, MPI_COMM_WORLD);
  for (const auto i : x.locally_owned_elements())
    x(i) = a + b * t + i * t * t / 2;
  x.compress(dealii::VectorOperation::insert);
  return x;
}

void report(const std::string &what, const bool is_true)
{
  const bool is_everywhere = dealii::Utilities::MPI::min(is_true ? 1 : 0, MPI_COMM_WORLD) == 1;
  if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
    std::cout << what << ": " << (is_everywhere ? "ok" : "not so") << std::endl;
}

/// Largest error of the first rates b + i t - i h/2, and of the second ones, i, of a step to @p t.
double error(const TimeScheme &scheme, const double t, const bool is_first_step)
{
  const StepTime step = scheme.step_to(t);
  const Rates rates = scheme.rates(step);
  const Vector x = state(t);
  double largest = 0;
  for (const auto i : x.locally_owned_elements()) {
    const double rate = rates.by_value * x(i) + rates.rest(i), expected = b + i * t - i * step.size / 2.;
    largest = std::max(largest, std::abs(rate - expected));
    if (!rates.has_second())
      continue;
    // with the rate of the step before, which is exact in its middle; at the beginning it is exact itself
    const double second = rates.second_by_value * x(i) + rates.second_rest(i),
                 distance = is_first_step ? step.size / 2 : step.size;
    largest = std::max(largest, std::abs(second - i * distance / step.size));
  }
  return dealii::Utilities::MPI::max(largest, MPI_COMM_WORLD);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const Section scene =
      SceneText::root(SceneText::from_prm("subsection Steps\nset Scheme = backward Euler\nend\n"));
  const auto scheme = make_time_scheme(scene.subsection("Steps"));
  report(scheme->description(), true);

  Vector velocity = state(0);
  for (const auto i : velocity.locally_owned_elements())
    velocity(i) = b;
  velocity.compress(dealii::VectorOperation::insert);
  scheme->start(state(0), velocity);
  const double h = 0.1;
  report("first step", error(*scheme, h, true) < 1e-12);
  report("a step that is not accepted", error(*scheme, 0.3, true) < 1e-12 && error(*scheme, h, true) < 1e-12);

  double t = 0;
  bool has_equal_sizes = true, is_exact = true;
  for (unsigned int n = 1; n <= 20; ++n) {
    const StepTime step = scheme->step_to(t += h);
    has_equal_sizes = has_equal_sizes && step.size == h;
    is_exact = is_exact && error(*scheme, t, n == 1) < 1e-10;
    scheme->accept_step(step, state(t));
  }
  report("equal sizes", has_equal_sizes);
  report("20 steps", is_exact);
  report("memory", scheme->memory().states.size() == 1 && scheme->memory().last.end == t);

  const auto other = make_time_scheme(scene.subsection("Steps"));
  other->restore(scheme->memory());
  report("restored", error(*other, t + h, false) < 1e-10);

  scheme->start(state(0));
  report("no second rates", !scheme->rates(scheme->step_to(h)).has_second());
  scheme->accept_step(scheme->step_to(h), state(h));
  report("nor later", scheme->memory().rates.empty() && error(*scheme, 2 * h, false) < 1e-12);
}
