// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The command line: arguments, one catch, the dimension dispatched once.

#include <dovetail/output/launcher.h>
#include <dovetail/output/mesh_report.h>
#include <dovetail/output/new_file.h>
#include <dovetail/run/simulation.h>
#include <dovetail/scene/note.h>
#include <dovetail/scene/scene_text.h>
#include <dovetail/scene/shortened.h>
#include <dovetail/scene/user_error.h>
#include <dovetail/study/run_picture.h>
#include <dovetail/study/study.h>

#include <deal.II/base/exceptions.h>
#include <deal.II/base/mpi.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <functional>
#include <iostream>
#include <map>
#include <poll.h>
#include <string>
#include <thread>
#include <vector>

/// OpenBLAS, where it is the BLAS: the ranks are the parallelism, its threads would only fight for the cores.
extern "C" void openblas_set_num_threads(int) __attribute__((weak));

using namespace dovetail;

namespace {

enum Status { done = 0, wrong_input = 1, not_converged = 2, failed = 3 };

const char *const usage = R"(Dovetail: heat and solids on several bodies whose meshes do not match.

  dovetail scene.prm                          run (several ranks: mpirun -np 4 dovetail scene.prm)
  dovetail --check scene.prm                  read, make meshes and pairings, print the plan, solve nothing
  dovetail --resume scene.prm                 go on from the last checkpoint, on any number of ranks
  dovetail --set 'PATH=value' … scene.prm     override an entry, for instance 'Interface seam/Theta=-1'
  dovetail --study scene.prm                  error against run time over the levels and variants of subsection Study
  dovetail --mesh FILE                        what a mesh file holds: cells, extents, names, quality; a preview for ParaView
  dovetail --plot DIRECTORY                   residuals, run time and probes of a run that has ended, by gnuplot
  dovetail --quiet scene.prm                  print results and notes only, no tables and steps
  dovetail --verbose scene.prm                print all iterations; else runs of more than 10 steps print a line for each
  dovetail --parameters                       every entry of a scene, as Markdown
  dovetail --version | --help | -h

Options stand before or after the scene, which is a .prm or .json file.
Exit status: 0 done, 1 the input is wrong, 2 the solver did not converge, or a signal (Ctrl-C, SIGTERM, SIGUSR1)
asked a run of several steps to end (the last good step is written, and --resume goes on from it), 3 anything else.
)";

struct Arguments
{
  bool help = false, version = false, parameters = false, check = false, study = false, resume = false;
  bool quiet = false, verbose = false;
  std::vector<std::string> overrides;
  std::string scene, mesh, plot;
};

/// Those without a value, with where they are stored.
const std::map<std::string, bool Arguments::*> switches = {
    {"--help", &Arguments::help},       {"-h", &Arguments::help},
    {"--version", &Arguments::version}, {"--parameters", &Arguments::parameters},
    {"--check", &Arguments::check},     {"--study", &Arguments::study},
    {"--resume", &Arguments::resume},   {"--quiet", &Arguments::quiet},
    {"--verbose", &Arguments::verbose}};

void check_together(const Arguments &arguments)
{
  if (arguments.study && arguments.check)
    throw UserError(
        "--check and --study exclude each other; a study checks its variants before the first run.");
  if (arguments.resume && (arguments.study || arguments.check))
    throw UserError(
        std::string("--resume and ") + (arguments.study ? "--study" : "--check") + " exclude each other" +
        (arguments.study ? ": a study that is started again leaves out the runs that have ended." : "."));
  if (arguments.quiet && arguments.verbose)
    throw UserError("--quiet and --verbose exclude each other.");
  if ((arguments.quiet || arguments.verbose) &&
      (arguments.study || !arguments.mesh.empty() || !arguments.plot.empty()))
    throw UserError(std::string(arguments.quiet ? "--quiet" : "--verbose") +
                    " is for runs and for --check only. Remove it.");
}

Arguments parse(const int argc, char **argv)
{
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (const auto found = switches.find(word); found != switches.end())
      arguments.*(found->second) = true;
    else if (word == "--set") {
      if (i + 1 == argc)
        throw UserError("--set needs an argument, for instance --set 'Interface seam/Theta=-1'.");
      arguments.overrides.push_back(argv[++i]);
    } else if (word == "--mesh") {
      if (i + 1 == argc)
        throw UserError("--mesh needs the name of a mesh file.");
      arguments.mesh = argv[++i];
    } else if (word == "--plot") {
      if (i + 1 == argc)
        throw UserError("--plot needs the Directory of the Output of a run.");
      arguments.plot = argv[++i];
    } else if (!word.empty() && word[0] == '-') {
      std::vector<std::string> known = {"--set", "--mesh", "--plot"};
      for (const auto &one : switches)
        known.push_back(one.first);
      throw UserError("The option '" + word + "' is not known. " + did_you_mean(word, known) +
                      " See dovetail --help.");
    } else if (!arguments.scene.empty())
      throw UserError("Two scenes are given, " + arguments.scene + " and " + word + "; run them one by one.");
    else
      arguments.scene = word;
  }
  check_together(arguments);
  return arguments;
}

template <int dim>
Status run(const std::shared_ptr<SceneText> &text, const Arguments &arguments)
{
  Simulation<dim> simulation(text, MPI_COMM_WORLD,
                             arguments.quiet     ? Detail::quiet
                             : arguments.verbose ? Detail::verbose
                                                 : Detail::usual);
  if (arguments.check) {
    simulation.check();
    return done;
  }
  return (arguments.resume ? simulation.resume() : simulation.run()) ? done : not_converged;
}

std::string needs_scene(const Arguments &arguments)
{
  if (arguments.scene.empty())
    throw UserError("Which scene? For instance: dovetail prm/quick_start.prm. See dovetail --help.");
  return arguments.scene;
}

/// An error is one of all ranks.
void on_first_rank(const bool is_first_rank, const std::function<void()> &action)
{
  std::string problem;
  bool is_of_output = false;
  if (is_first_rank)
    try {
      action();
    } catch (const std::exception &error) {
      problem = error.what();
      is_of_output = dynamic_cast<const OutputError *>(&error) != nullptr;
    }
  problem = dealii::Utilities::MPI::broadcast(MPI_COMM_WORLD, problem);
  is_of_output = dealii::Utilities::MPI::broadcast(MPI_COMM_WORLD, is_of_output);
  if (is_of_output)
    throw OutputError(problem);
  if (!problem.empty())
    throw UserError(problem);
}

void print_names_of_notes()
{
  std::cout
      << "\n## Names of notes\n\nThe entry `Silenced notes` of the subsection Output switches them off.\n\n"
         "| name | told when |\n|---|---|\n";
  for (const auto &[name, occasions] : occasions_of_notes()) {
    std::cout << "| " << name << " | ";
    for (const std::string &occasion : occasions)
      std::cout << (&occasion == &occasions.front() ? "" : "; ") << occasion;
    std::cout << " |\n";
  }
}

Status run(const Arguments &arguments, const bool is_first_rank)
{
  if (!arguments.mesh.empty()) {
    on_first_rank(is_first_rank, [&]() { report_on_mesh(arguments.mesh, std::cout); });
    return done;
  }
  if (!arguments.plot.empty()) {
    on_first_rank(is_first_rank, [&]() { draw_run(arguments.plot, std::cout); });
    return done;
  }
  if (arguments.version || arguments.help || arguments.parameters) {
    if (!is_first_rank)
      return done;
    if (arguments.version)
      std::cout << "Dovetail " << DOVETAIL_VERSION << std::endl;
    else if (arguments.help)
      std::cout << usage << std::flush;
    else {
      const auto text = SceneText::for_documentation();
      read_all_entries(text);
      text->print_reference(std::cout);
      print_names_of_notes();
    }
    return done;
  }
  const auto text = SceneText::from_file(needs_scene(arguments), arguments.overrides);
  return begin_scene(SceneText::root(text)) == 2 ? run<2>(text, arguments) : run<3>(text, arguments);
}

/// Deal.II's reason without its banner.
std::string reason(const std::exception &error)
{
  const auto *exception = dynamic_cast<const dealii::ExceptionBase *>(&error);
  if (exception == nullptr)
    return error.what();
  std::ostringstream text;
  text << exception->get_exc_name() << ": ";
  exception->print_info(text);
  return text.str();
}

void ignore_signals_of_writing()
{
  for (const int signal : {SIGPIPE, SIGXFSZ})
    std::signal(signal, SIG_IGN);
}

/// What is printed must not land in a file that is opened in the place of a closed standard stream. And when
/// nobody reads the log any more, or a file grows beyond a limit, writing fails and is told as other
/// failures: no signal ends the run.
void be_robust_against_surroundings()
{
  for (const int stream : {0, 1, 2})
    if (fcntl(stream, F_GETFD) < 0)
      open("/dev/null", stream == 0 ? O_RDONLY : O_WRONLY);
  ignore_signals_of_writing();
}

/// Done, unless what was printed is lost. Whoever has stopped reading (head, less) did not want it.
Status status_of_log(const Status status)
{
  std::cout.flush();
  if (std::cout)
    return status;
  pollfd output = {1, 0, 0};
  if (poll(&output, 1, 0) > 0 && (output.revents & POLLERR) != 0)
    return status;
  std::cerr << "Error: What was printed to the standard output is not complete. Is the disk full?"
            << std::endl;
  return status == done ? failed : status;
}

/// A study starts each of its runs as a process of its own, which may use MPI; itself it must not.
bool asks_for_study(const int argc, char **argv)
{
  return std::find(argv + 1, argv + argc, std::string("--study")) != argv + argc;
}

Status study(const int argc, char **argv)
{
  try {
    const Arguments arguments = parse(argc, argv);
    return status_of_log(run_study(needs_scene(arguments), arguments.overrides) ? done : not_converged);
  } catch (const UserError &error) {
    if (is_first_of_launched())
      std::cerr << "Error: " << shortened(error.what()) << std::endl;
    return wrong_input;
  } catch (const OutputError &error) {
    std::cerr << "Error: " << shortened(error.what()) << std::endl;
    return failed;
  } catch (const std::exception &error) {
    std::cerr << "Dovetail stopped: " << shortened(reason(error)) << std::endl;
    return failed;
  }
}

/// mpirun ends a job with the first rank that fails, and may lose what it has not read until then.
void tell(const std::string &error)
{
  std::cerr << "Error: " << shortened(error) << std::endl;
  if (is_launched())
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

} // namespace

int main(int argc, char **argv)
{
  be_robust_against_surroundings();
  if (asks_for_study(argc, argv))
    return study(argc, argv);
  skip_network_if_alone();
  int program_only = 1; // PETSc, which deal.II starts, would take the rest for options of its own
  dealii::Utilities::MPI::MPI_InitFinalize mpi(program_only, argv, 1);
  ignore_signals_of_writing(); // libraries have set handlers of their own
  if (openblas_set_num_threads != nullptr)
    openblas_set_num_threads(1);
  dealii::deal_II_exceptions::suppress_stacktrace_in_exceptions();
  const bool is_first_rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;
  Status status = done;
  try {
    status = run(parse(argc, argv), is_first_rank);
  } catch (const UserError &error) {
    // thrown on all ranks alike
    if (is_first_rank)
      tell(error.what());
    MPI_Barrier(MPI_COMM_WORLD);
    return wrong_input;
  } catch (const OutputError &error) { // likewise
    if (is_first_rank)
      tell(error.what());
    MPI_Barrier(MPI_COMM_WORLD);
    return failed;
  } catch (const std::exception &error) {
    // perhaps on one rank only: the others may wait for it
    std::cerr << "Dovetail stopped on rank " << dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD)
              << ": " << shortened(reason(error)) << std::endl;
    if (dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) > 1)
      MPI_Abort(MPI_COMM_WORLD, failed);
    return failed;
  } catch (...) { // muParser's errors are no std::exception
    std::cerr << "Dovetail stopped: a formula cannot be evaluated." << std::endl;
    MPI_Abort(MPI_COMM_WORLD, failed);
    return failed;
  }
  MPI_Barrier(MPI_COMM_WORLD); // an early exit of one rank would end the others before they have written
  return is_first_rank ? status_of_log(status) : status;
}
