// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "process.h"

#include <dovetail/output/new_file.h>
#include <dovetail/scene/input_file.h>
#include <dovetail/scene/user_error.h>
#include <dovetail/study/run.h>

#include <fstream>
#include <sstream>

namespace dovetail {

using nlohmann::ordered_json;

namespace {

/// An empty object if there is no such file or it is broken.
ordered_json read_json(const std::string &file)
{
  if (!obstacle_to_reading(file).empty())
    return ordered_json::object();
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

/// The report of a run that ended with this status, or an empty object: one that is broken, or that the run
/// did not write to its end, is none.
ordered_json read_report(const std::string &file, const std::string &status)
{
  ordered_json report = read_json(file);
  const auto converged = report.find("converged");
  const bool is_whole = converged != report.end() && converged->is_boolean() &&
                        *converged == (status == "converged") && report.contains("counters") &&
                        !report["counters"].empty();
  return is_whole ? report : ordered_json::object();
}

/// Of a file that a study has written, or that is as good as not there.
std::string text_of(const ordered_json &object, const std::string &key)
{
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
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

std::string error_message(const std::string &error_file)
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
  if (text_of(kept, "fingerprint") != run.fingerprint)
    return;
  const std::string status = text_of(kept, "status");
  const bool has_report = status == "converged" || status == "not converged";
  if (!has_report && status != "wrong input") // perhaps the machine's fault
    return;
  const ordered_json report = read_report(run.directory + "/report.json", status);
  const auto seconds = kept.find("seconds wall");
  if ((has_report && report.empty()) || seconds == kept.end() || !seconds->is_number())
    return;
  run.status = status;
  run.message = text_of(kept, "message");
  run.seconds = *seconds;
  if (has_report)
    run.report = report;
}

void perform(StudyRun &run, const std::string &scene, const std::function<void()> &each_second)
{
  if (const Obstacle obstacle = make_directories(run.directory))
    obstacle.raise(set_another_directory);
  const std::string kept = run.directory + "/run.json", report = run.directory + "/report.json",
                    error_file = run.directory + "/errors.txt";
  remove_file(kept, "{\n");
  remove_file(report, "{\n");

  const Outcome outcome =
      run_process(command_of(run, scene), run.directory + "/log.txt", error_file, each_second);
  run.seconds = outcome.seconds;
  run.status = status_of(outcome.status);
  run.message.clear();
  run.report = ordered_json();
  if (run.status == "converged" || run.status == "not converged") {
    run.report = read_report(report, run.status);
    if (run.report.empty()) {
      run.status = "failed";
      run.message = "it left no whole report";
    } else if (run.report.contains("seconds")) // what only the study wanted to know
      run.seconds -= run.report["seconds"].value("comparison", 0.);
  } else {
    run.message = error_message(error_file);
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
  if (const Obstacle obstacle =
          write_file(kept, "{\n", content.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n"))
    obstacle.raise(set_another_directory);
}

} // namespace dovetail
