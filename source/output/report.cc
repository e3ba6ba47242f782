// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/phases.h>
#include <dovetail/output/report.h>
#include <dovetail/output/shared_file.h>

#include <deal.II/base/mpi.h>

#include <cstdlib>

namespace dovetail {

namespace {

bool speaks(const MPI_Comm &communicator)
{
  return dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
}

} // namespace

void make_directory(const std::string &directory, const MPI_Comm &communicator)
{
  if (const Obstacle obstacle =
          agree(speaks(communicator) ? make_directories(directory) : Obstacle(), communicator))
    obstacle.raise(set_another_directory);
}

Report::Report(const std::string &directory, const MPI_Comm &communicator)
    : file_name(directory + "/report.json"), communicator(communicator)
{
  make_directory(directory, communicator);
  const char *run = std::getenv("DOVETAIL_RUN"); // of the module for Python, which knows its report by it
  content = {{"version", DOVETAIL_VERSION},
             {"dealii", DEAL_II_PACKAGE_VERSION},
             {"ranks", dealii::Utilities::MPI::n_mpi_processes(communicator)},
             {"dofs", 0},
             {"converged", false},
             {"errors against", "Exact, where it is given"}};
  if (run != nullptr)
    content["run"] = run;
  for (const char *key : {"domains", "interfaces", "balance", "probes", "places of extremes"})
    content[key] = nlohmann::ordered_json::object();
  for (const char *key : {"steps", "adaptive cycles"})
    content[key] = nlohmann::ordered_json::array();
  content["seconds"] = nlohmann::ordered_json::object();
  content["peak memory MiB"] = 0;
  content["memory by phase MiB"] = nlohmann::ordered_json::object();
  content["counters"] = nlohmann::ordered_json::object();
  for (const char *key : {"notes", "names of notes", "plan", "left out"})
    content[key] = nlohmann::ordered_json::array();
}

nlohmann::ordered_json &Report::operator[](const std::string &key)
{
  Assert(content.contains(key), dealii::ExcMessage("The report has no key " + key));
  return content[key];
}

void Report::add_step(const double time, const std::vector<double> &residuals,
                      const std::vector<unsigned int> &linear_iterations)
{
  content["steps"].push_back({{"time", time},
                              {"newton iterations", linear_iterations.size()},
                              {"residuals", residuals},
                              {"linear iterations", linear_iterations}});
}

void Report::leave_out(const std::string &sentence)
{
  content["left out"].push_back(sentence);
}

void Report::write()
{
  content["peak memory MiB"] = dealii::Utilities::MPI::sum(peak_memory_of_process(), communicator);
  const std::string text =
      content.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  if (const Obstacle obstacle =
          write_on_first_rank(file_name, "{\n  \"version\":", text, communicator, OnDisk::later))
    obstacle.raise(set_another_directory);
}

} // namespace dovetail
