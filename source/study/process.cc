// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "process.h"

#include <dovetail/output/launcher.h>
#include <dovetail/output/new_file.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <filesystem>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

extern char **environ;

namespace dovetail {

namespace {

bool starts_with(const std::string &text, const std::string &beginning)
{
  return text.compare(0, beginning.size(), beginning) == 0;
}

/// What mpirun tells the processes it starts would confuse an mpirun among them; what a person sets to make
/// mpirun work (.ci/mpi_environment) stays.
bool belongs_to_launcher(const std::string &variable)
{
  for (const char *kept :
       {"OMPI_ALLOW_RUN_AS_ROOT", "OMPI_MCA_rmaps_base_oversubscribe=", "OMPI_MCA_hwloc_base_binding_policy=",
        "OMPI_MCA_mpi_yield_when_idle=", "OMPI_MCA_pml=", "PRTE_MCA_rmaps_default_mapping_policy=",
        "PRTE_MCA_hwloc_default_binding_policy="})
    if (starts_with(variable, kept))
      return false;
  for (const char *launcher :
       {"OMPI_", "PMIX_", "PRTE_", "PMI_", "ORTE_", "OPAL_", "HYDI_", "HYDRA_", "MPIR_"})
    if (starts_with(variable, launcher))
      return true;
  return false;
}

/// Pointers to "NAME=value", ended by nullptr.
std::vector<char *> environment_of_children()
{
  std::vector<char *> result;
  const bool was_launched = is_launched();
  static char terminal[] = "TERM=dumb";
  for (char **variable = environ; *variable != nullptr; ++variable)
    if (!starts_with(*variable, "TERM=") && !(was_launched && belongs_to_launcher(*variable)))
      result.push_back(*variable);
  result.push_back(terminal);
  result.push_back(nullptr);
  return result;
}

/// Between fork and exec only calls that are safe there.
[[noreturn]] void execute(char *const *arguments, char **variables, const int output, const int error,
                          const sigset_t &signals)
{
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGTERM);
#endif
  const int nothing = open("/dev/null", O_RDONLY);
  dup2(nothing, 0);
  dup2(output, 1);
  dup2(error, 2);
  for (const int ignored_here : {SIGPIPE, SIGXFSZ})
    std::signal(ignored_here, SIG_DFL);
  sigprocmask(SIG_SETMASK, &signals, nullptr);
  environ = variables;
  execvp(arguments[0], arguments);
  const char message[] = "Error: the program cannot be started: ";
  for (const char *words : {message, static_cast<const char *>(arguments[0]), "\n"})
    if (write(2, words, std::strlen(words)) < 0)
      break;
  _exit(127);
}

unsigned int number_in_environment(const std::initializer_list<const char *> names,
                                   const unsigned int otherwise)
{
  for (const char *name : names)
    if (const char *text = std::getenv(name))
      return std::strtoul(text, nullptr, 10);
  return otherwise;
}

/// A file of this program, or the place where everything vanishes; opening a pipe would wait.
int open_to_write(const std::string &file)
{
  if (const Obstacle obstacle = file == "/dev/null" ? Obstacle() : obstacle_to_replacing(file, ""))
    obstacle.raise(set_another_directory);
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0)
    obstacle_of_system(file, errno).raise(set_another_directory);
  return descriptor;
}

} // namespace

Outcome run_process(const std::vector<std::string> &command, const std::string &output_file,
                    const std::string &error_file, const std::function<void()> &each_second)
{
  std::vector<char *> arguments;
  for (const std::string &word : command)
    arguments.push_back(const_cast<char *>(word.c_str()));
  arguments.push_back(nullptr);
  std::vector<char *> variables = environment_of_children();
  const int output = open_to_write(output_file), error = open_to_write(error_file);

  // the end of a child is a signal that waits until it is asked for
  sigset_t end_of_child, before;
  sigemptyset(&end_of_child);
  sigaddset(&end_of_child, SIGCHLD);
  std::signal(SIGCHLD, SIG_DFL);
  sigprocmask(SIG_BLOCK, &end_of_child, &before);

  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0)
    execute(arguments.data(), variables.data(), output, error, before);
  close(output);
  close(error);
  if (child < 0) {
    sigprocmask(SIG_SETMASK, &before, nullptr);
    throw std::runtime_error(std::string("No process can be started: ") + std::strerror(errno) + ".");
  }

  int state = 0;
  while (waitpid(child, &state, WNOHANG) == 0) {
    const timespec second{1, 0};
    if (sigtimedwait(&end_of_child, nullptr, &second) < 0)
      each_second();
  }
  Outcome outcome;
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  outcome.status = WIFEXITED(state) ? WEXITSTATUS(state) : -WTERMSIG(state);
  sigprocmask(SIG_SETMASK, &before, nullptr);
  return outcome;
}

unsigned int launched_rank()
{
  return number_in_environment({"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"}, 0);
}

unsigned int launched_ranks()
{
  return std::max(1U, number_in_environment({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}, 1));
}

std::string this_program()
{
  std::error_code error;
  const auto file = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error)
    throw std::runtime_error("The file of this program cannot be found: " + error.message() + ".");
  return file.string();
}

} // namespace dovetail
