// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the log says of steps, with `#` for seconds and memory: all iterations of a few steps, a line for each
// of many, and with that what the iterations of the last step have said if it fails; with --verbose all of
// them, with --quiet what is told in any case. No step is "13 of 12". Of thirty lines of a plan it says 23
// and how many are missing.
//
// ranks: 1 3

#include <dovetail/output/log.h>
#include <dovetail/output/plan.h>

#include <deal.II/base/mpi.h>

#include <iostream>
#include <regex>
#include <sstream>

using namespace dovetail;

namespace {

void show(const std::string &heading, const Detail detail, const unsigned int n_steps,
          const unsigned int n_done)
{
  std::ostringstream text;
  std::streambuf *before = std::cout.rdbuf(text.rdbuf());
  {
    Log log(MPI_COMM_WORLD, detail);
    log.title("scene.prm");
    for (unsigned int step = 1; step <= n_done; ++step) {
      log.step_begins(step, n_steps, step / double(n_done), 1.);
      for (unsigned int iteration = 1; iteration <= 2; ++iteration)
        log.newton_iteration(iteration, iteration == 1 ? 1e-3 : 1e-10, 7, 1.);
      if (step == 2)
        log.step_ends("did not converge; half of the step is tried");
      else if (step < n_done)
        log.step_ends();
    }
    log.show_details();
    log.step_ends("did not converge");
    log.tell("  results: output");
  }
  std::cout.rdbuf(before);
  if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) > 0)
    return;
  std::string lines = std::regex_replace(text.str(), std::regex("[0-9.e-]+ (s|min|h)\\b"), "# $1");
  lines = std::regex_replace(lines, std::regex("[0-9]+ MiB"), "# MiB");
  lines = std::regex_replace(lines, std::regex("Dovetail [0-9.]+[^:]*:"), "Dovetail:");
  std::cout << "-- " << heading << '\n' << lines << std::flush;
}

} // namespace

int main(int argc, char **argv)
{
  const dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  show("a few steps", Detail::usual, 3, 4);
  show("many steps", Detail::usual, 12, 13);
  show("nobody knows how many", Detail::usual, 0, 3);
  show("verbose", Detail::verbose, 11, 3);
  show("quiet", Detail::quiet, 12, 13);
  Plan plan;
  for (unsigned int i = 1; i <= 30; ++i)
    plan.left_out.push_back("line " + std::to_string(i));
  Log(MPI_COMM_WORLD).plan(plan);
}
