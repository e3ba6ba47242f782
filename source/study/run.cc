// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "process.h"

#include <dovetail/scene/user_error.h>
#include <dovetail/study/run.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace dovetail {

using nlohmann::ordered_json;

namespace {

/// An empty object if there is no such file or it is broken.
ordered_json read_json(const std::string &file)
{
  std::ifstream in(file);
  auto content = ordered_json::parse(in, nullptr, false);
  return content.is_object() ? content : ordered_json::object();
}

std::string status_of(const int exit_status)
{
  switch (exit_status) {
  case 0:
    return "converged";
  case 1:
    return "wrong input";
  case 2:
    return "not converged";
  default:
    return "failed";
  }
}

std::vector<std::string> command_of(const StudyRun &run, const std::string &scene)
{
  std::vector<std::string> command;
  if (run.ranks > 1)
    command = {"mpirun", "-np", std::to_string(run.ranks)};
  command.push_back(this_program());
  for (const std::string &assignment : run.overrides)
    command.insert(command.end(), {"--set", assignment});
  command.insert(command.end(), {"--set", "Output/Directory=" + run.directory, scene});
  return command;
}

} // namespace

std::string last_words(const std::string &error_file)
{
  std::ifstream in(error_file);
  std::string line, last;
  while (std::getline(in, line)) {
    if (line.rfind("Error: ", 0) == 0)
      return line.substr(7);
    if (!line.empty())
      last = line;
  }
  return last;
}

void recall(StudyRun &run)
{
  const ordered_json kept = read_json(run.directory + "/run.json");
  if (kept.value("fingerprint", "") != run.fingerprint)
    return;
  const ordered_json report = read_json(run.directory + "/report.json");
  const std::string status = kept.value("status", "");
  if (report.empty() && (status == "converged" || status == "not converged"))
    return;
  if (status == "failed") // perhaps the machine's fault
    return;
  run.status = status;
  run.message = kept.value("message", "");
  run.seconds = kept.value("seconds wall", 0.);
  if (status == "converged" || status == "not converged")
    run.report = report;
}

void perform(StudyRun &run, const std::string &scene, const std::function<void()> &each_second)
{
  std::error_code error;
  std::filesystem::create_directories(run.directory, error);
  if (error)
    throw UserError("The directory '" + run.directory + "' for a run cannot be made: " + error.message() +
                    ". Set Directory in the subsection Output to a place where you may write.");
  const std::string kept = run.directory + "/run.json", report = run.directory + "/report.json",
                    error_file = run.directory + "/errors.txt";
  std::filesystem::remove(kept, error);
  std::filesystem::remove(report, error);

  const Outcome outcome =
      run_process(command_of(run, scene), run.directory + "/log.txt", error_file, each_second);
  run.seconds = outcome.seconds;
  run.status = status_of(outcome.status);
  run.message.clear();
  run.report = ordered_json();
  if (run.status == "converged" || run.status == "not converged") {
    run.report = read_json(report);
    if (run.report.empty()) {
      run.status = "failed";
      run.message = "it left no report";
    } else if (run.report.contains("seconds")) // what only the study wanted to know
      run.seconds -= run.report["seconds"].value("comparison", 0.);
  } else {
    run.message = last_words(error_file);
    if (outcome.status < 0)
      run.message = "signal " + std::to_string(-outcome.status) +
                    (run.message.empty() ? std::string() : ": " + run.message);
    else if (run.message.empty())
      run.message = "exit status " + std::to_string(outcome.status);
  }

  const ordered_json content = {{"status", run.status},
                                {"message", run.message},
                                {"seconds wall", run.seconds},
                                {"fingerprint", run.fingerprint}};
  std::ofstream(kept + ".new") << content.dump(2, ' ', false, ordered_json::error_handler_t::replace)
                               << std::endl;
  std::filesystem::rename(kept + ".new", kept, error);
  if (error)
    throw UserError("The file '" + kept + "' cannot be written. Is the disk full?");
}

} // namespace dovetail
