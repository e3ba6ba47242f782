// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
//   run_scenes [--in DIRECTORY] [--set PATH=value]… [--wrong] SCENE [[--in DIRECTORY] …]…
//
// Runs one scene after the other in one process: to start a program that is linked with deal.II takes longer
// than most scenes of the tests. Exit status 0 if all converged, else 1.
//
// --in: from here on in this directory. --wrong: the scene must be refused as wrong input, and what the
// program would say goes to the file `errors`.

#include <dovetail/output/launcher.h>
#include <dovetail/run/simulation.h>
#include <dovetail/scene/scene_text.h>
#include <dovetail/scene/shortened.h>
#include <dovetail/scene/user_error.h>

#include <deal.II/base/exceptions.h>
#include <deal.II/base/mpi.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

using namespace dovetail;

namespace {

bool run(const std::string &scene, const std::vector<std::string> &overrides)
{
  const auto text = SceneText::from_file(scene, overrides);
  return begin_scene(SceneText::root(text)) == 2 ? Simulation<2>(text, MPI_COMM_WORLD).run()
                                                 : Simulation<3>(text, MPI_COMM_WORLD).run();
}

bool is_refused(const std::string &scene, const std::vector<std::string> &overrides)
{
  try {
    run(scene, overrides);
  } catch (const UserError &error) { // thrown on all ranks alike
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::ofstream("errors") << "Error: " << shortened(error.what()) << std::endl;
    return true;
  }
  return false;
}

/// Whether all scenes do what they should.
bool run_all(const std::vector<std::string> &words)
{
  bool succeeds = true, is_wrong = false;
  std::vector<std::string> overrides;
  for (auto word = words.begin(); word != words.end(); ++word)
    if (*word == "--set" && word + 1 != words.end())
      overrides.push_back(*++word);
    else if (*word == "--in" && word + 1 != words.end())
      std::filesystem::current_path(*++word);
    else if (*word == "--wrong")
      is_wrong = true;
    else {
      if (is_wrong ? !is_refused(*word, overrides) : !run(*word, overrides)) {
        std::cerr << *word << (is_wrong ? " was not refused" : " did not converge") << std::endl;
        succeeds = false;
      }
      overrides.clear();
      is_wrong = false;
    }
  if (!overrides.empty())
    std::cerr << "--set must come before its scene" << std::endl;
  return succeeds && overrides.empty();
}

} // namespace

int main(int argc, char **argv)
{
  skip_network_if_alone();
  int program_only = 1; // as in main.cc
  dealii::Utilities::MPI::MPI_InitFinalize mpi(program_only, argv, 1);
  dealii::deal_II_exceptions::suppress_stacktrace_in_exceptions();
  try {
    return run_all({argv + 1, argv + argc}) ? 0 : 1;
  } catch (const std::exception &error) {
    std::cerr << std::filesystem::current_path().string() << ": " << error.what() << std::endl;
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
}
