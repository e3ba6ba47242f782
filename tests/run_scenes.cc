// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
//   run_scenes [--set PATH=value]… SCENE [[--set PATH=value]… SCENE]…
//
// Runs one scene after the other in one process: to start a program that is linked with deal.II takes longer
// than most scenes of the tests. Exit status 0 if all converged, else 1.

#include <dovetail/output/launcher.h>
#include <dovetail/run/simulation.h>
#include <dovetail/scene/scene_text.h>

#include <deal.II/base/mpi.h>

#include <iostream>
#include <string>
#include <vector>

using namespace dovetail;

namespace {

bool run(const std::shared_ptr<SceneText> &text)
{
  return begin_scene(SceneText::root(text)) == 2 ? Simulation<2>(text, MPI_COMM_WORLD).run()
                                                 : Simulation<3>(text, MPI_COMM_WORLD).run();
}

} // namespace

int main(int argc, char **argv)
{
  skip_network_if_alone();
  int program_only = 1; // as in main.cc
  dealii::Utilities::MPI::MPI_InitFinalize mpi(program_only, argv, 1);
  std::vector<std::string> overrides;
  for (int i = 1; i < argc; ++i)
    if (std::string(argv[i]) == "--set" && i + 1 < argc)
      overrides.push_back(argv[++i]);
    else
      try {
        if (!run(SceneText::from_file(argv[i], overrides)))
          return 1;
        overrides.clear();
      } catch (const std::exception &error) {
        std::cerr << argv[i] << ": " << error.what() << std::endl;
        MPI_Abort(MPI_COMM_WORLD, 1);
      }
  if (!overrides.empty()) {
    std::cerr << "--set must come before its scene" << std::endl;
    return 1;
  }
}
