// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/results.h>

#include <dovetail/material/transient.h>
#include <dovetail/measure/balance.h>
#include <dovetail/measure/bending_stiffness.h>
#include <dovetail/measure/bent_cells.h>
#include <dovetail/measure/jumps.h>
#include <dovetail/measure/measures.h>
#include <dovetail/measure/probe_names.h>
#include <dovetail/measure/resolution.h>
#include <dovetail/measure/spectrum.h>
#include <dovetail/measure/used_ranges.h>
#include <dovetail/output/preview.h>
#include <dovetail/output/shared_file.h>
#include <dovetail/solve/free_memory.h>

#include <map>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_output("output", "results cannot be written");

/// Who reads probes.csv finds a column by its name without the unit. @p others: what has one besides probes
template <int dim>
void check_columns(const Probes<dim> &probes, const std::vector<std::string> &others)
{
  std::map<std::string, std::string> owner; // by column
  for (const std::string &other : others)
    owner.emplace(other, "the " + other.substr(0, other.find(' ')) + " of the step");
  const std::vector<NamesOfProbe> names = names_of_columns(probes);
  for (unsigned int i = 0; i < names.size(); ++i)
    for (const auto *of_kind : {&names[i].numbers, &names[i].places})
      for (const std::string &with_unit : *of_kind) {
        const auto &probe = probes.all()[i];
        const std::string name = with_unit.substr(0, with_unit.rfind(" ["));
        const auto [found, is_new] = owner.emplace(name, "the probe " + probe.name);
        probe.section->check(is_new, "",
                             "has the column '" + name + "' in probes.csv, and " + found->second +
                                 " has it, too. Choose another name.");
      }
}

template <int dim>
bool is_first_rank(const Model<dim> &model)
{
  return dealii::Utilities::MPI::this_mpi_process(model.communicator) == 0;
}

std::string read_directory(const Section &output, const SceneText &text)
{
  const auto directory = output.read<std::string>(
      "Directory", "", "Directory of the results; if empty, output/ and the name of the scene's file [-]");
  return directory.empty() ? "output/" + text.name() : directory;
}

} // namespace

template <int dim>
Results<dim>::Results(const SceneText &text, const Section &output, const Model<dim> &model,
                      Probes<dim> &probes, Phases &phases, Notes &notes, Log &log)
    : text(text), model(model), probes(probes), phases(phases), notes(notes), log(log),
      directory(read_directory(output, text)),
      every_steps(output.read<unsigned int>(
          "Every steps", 1, "Pictures of every n-th step, and of the last one; probes.csv has all steps [-]",
          Patterns::Integer(1))),
      checkpoint_steps(output.read<unsigned int>(
          "Checkpoint every steps", 0,
          "Keep the state after every n-th step, after the last one and where the run ends early, so that "
          "--resume can go on from there; 0: only where a signal ends the run [-]")),
      with_spectrum(output.read<bool>("Spectrum", false,
                                      "Report eigenvalues and condition number of the matrix, up to " +
                                          std::to_string(largest_spectrum) + " unknowns [-]")),
      paraview(output, model, directory), reference(output, model), used_ranges(model, text)
{
  if (output.read<bool>(
          "Energy", false,
          "Report the energy of solids with inertia after each step: kinetic, elastic, that of ties, the "
          "work of loads and supports, what the generalised alpha method takes, and what is lost [-]")) {
    output.check(
        is_transient(output) && has_inertia(output), "Energy",
        "is that of motion, which only bodies with inertia have: set Kind = transient and Inertia = true "
        "in the subsection Steps, or remove it.");
    energy_balance.emplace(model);
  }
  notes.read(output);
  if (output.documenting())
    return;
  std::vector<std::string> columns = {StepTable::first_word};
  for (const char *part : {"kinetic", "elastic", "ties", "work", "scheme", "lost"})
    if (energy_balance)
      columns.push_back(std::string("energy ") + part);
  check_columns(probes, columns);
}

template <int dim>
void Results<dim>::add_to(Plan &plan) const
{
  const std::string pictures = "ParaView files: ";
  if (!paraview.is_on())
    plan.left_out.push_back(pictures + "Paraview = false");
  else
    plan.needed.push_back(pictures + (every_steps == 1
                                          ? "every step"
                                          : "every " + std::to_string(every_steps) + " steps, and the last"));
  if (checkpoint_steps > 0)
    plan.needed.push_back("checkpoint: every " +
                          (checkpoint_steps == 1 ? "step" : std::to_string(checkpoint_steps) + " steps"));
}

template <int dim>
void Results<dim>::preview()
{
  if (!paraview.is_on())
    return;
  write_preview(model, directory);
  log.line();
  log.line("preview: " + directory + "/check.pvd");
}

template <int dim>
void Results<dim>::prepare_directory(const Plan &plan)
{
  make_directory(directory, model.communicator);
  lock = lock_directory(directory, model.communicator);
  content = std::make_unique<Report>(directory, model.communicator);
  report()["plan"] = plan.needed;
  report()["left out"] = plan.left_out;
}

template <int dim>
void Results<dim>::begin(const Plan &plan)
{
  prepare_directory(plan);
  report().write();           // so that an interrupted run does not look like the one before it
  if (is_first_rank(model)) { // likewise
    remove_file(directory + "/" + StepTable::file, StepTable::first_word);
    remove_file(checkpoint_file(), RecordFile::first_words);
  }
  write_used();
}

template <int dim>
Checkpoint<dim> Results<dim>::find_checkpoint() const
{
  return Checkpoint<dim>(checkpoint_file(), model.communicator);
}

template <int dim>
void Results<dim>::go_on(const Plan &plan, const SavedState &from)
{
  const nlohmann::ordered_json &saved = from.numbers["results"];
  prepare_directory(plan);
  report()["steps"] = saved["steps"];
  notes.recall(saved["names of notes"], saved["notes"]);
  mark_good_step();
  step_table.restore(saved["probes"]);
  if (saved.contains("used ranges")) // checkpoints of earlier versions have none
    used_ranges.restore(saved["used ranges"]);
  report().write();
  write_used();
  try_to_write([&]() { paraview.go_on_from(saved["pictures"]); });
  if (!step_table.is_empty())
    write_step_table();
  if (energy_balance && saved.contains("energy"))
    restore_energy(saved["energy"], from);
}

template <int dim>
void Results<dim>::restore_energy(const nlohmann::ordered_json &sums, const SavedState &from)
{
  typename EnergyBalance<dim>::Memory memory;
  memory.initial = sums[0];
  memory.work = sums[1];
  memory.scheme.reset();
  memory.forces = from.vectors.at("external forces");
  memory.x = from.vectors.at("solution");
  if (sums.size() > 2) {
    memory.scheme = sums[2].get<double>();
    memory.velocity = from.vectors.at("velocity");
    memory.acceleration = from.vectors.at("acceleration");
  }
  energy_balance->restore(std::move(memory));
}

template <int dim>
void Results<dim>::mark_good_step()
{
  n_steps_so_far = report()["steps"].size();
  n_notes_so_far = notes.texts().size();
}

template <int dim>
void Results<dim>::write_checkpoint(SavedState &state)
{
  const Phases::Scope scope(phases, "output");
  const auto &all_steps = report()["steps"];
  const auto so_far = [this](const std::vector<std::string> &all) {
    return std::vector<std::string>(all.begin(), all.begin() + n_notes_so_far);
  };
  state.numbers["results"] = {
      {"steps", nlohmann::ordered_json(all_steps.begin(), all_steps.begin() + n_steps_so_far)},
      {"notes", so_far(notes.texts())},
      {"names of notes", so_far(notes.names())},
      {"probes", step_table.save()},
      {"pictures", paraview.times_of_steps()},
      {"used ranges", used_ranges.save()}};
  if (energy_balance) {
    const auto &memory = energy_balance->memory();
    state.numbers["results"]["energy"] = {memory.initial, memory.work};
    state.vectors["external forces"] = memory.forces;
    if (memory.scheme) {
      state.numbers["results"]["energy"].push_back(*memory.scheme);
      state.vectors["velocity"] = memory.velocity;
      state.vectors["acceleration"] = memory.acceleration;
    }
  }
  bring_files_to_disk(); // the pictures that it tells of
  try_to_write([&]() {
    if (const Obstacle obstacle = dovetail::write_checkpoint(checkpoint_file(), text, model, state))
      obstacle.raise(set_another_directory);
  });
}

template <int dim>
void Results<dim>::write_used() const
{
  const std::string first_line = "# Every entry of a run of Dovetail with its value; ";
  std::ostringstream used;
  used << first_line << "the next run into this directory replaces this file.\n\n";
  text.print_used(used);
  if (const Obstacle obstacle = write_on_first_rank(directory + "/used.prm", first_line, used.str(),
                                                    model.communicator, OnDisk::later))
    obstacle.raise(set_another_directory);
}

/// What all ranks find alike is kept, and noted; any other exception ends the run.
template <int dim>
template <typename Write>
void Results<dim>::try_to_write(const Write &write)
{
  const auto keep = [this](const std::exception &error) {
    problem_of_output = std::current_exception();
    notes.add(of_output(error.what()));
  };
  try {
    write();
  } catch (const UserError &error) {
    keep(error);
  } catch (const OutputError &error) {
    keep(error);
  }
}

/// With the multipliers of the ties; nobody needs those of a step that is not looked at.
template <int dim>
const NodalForces<dim> &Results<dim>::nodal_forces(const Solution<dim> &solution)
{
  if (!forces) {
    forces.emplace(solution.system.nodal_forces(solution.x));
    solution.system.find_multipliers(solution.x, *forces);
  }
  return *forces;
}

template <int dim>
void Results<dim>::write_pictures(const Solution<dim> &solution)
{
  if (!paraview.is_on() || problem_of_output)
    return;
  const Phases::Scope scope(phases, "output");
  const bool with_reactions = paraview.needs_reactions();
  if (solution.system.has_multipliers() || with_reactions)
    nodal_forces(solution);
  const Vector ghosted = solution.system.ghosted(solution.x);
  std::optional<Reactions<dim>> reactions;
  if (with_reactions)
    reactions.emplace(model, nodal_forces(solution), ghosted);
  find_velocity(solution);
  try_to_write([&]() { paraview.write(solution.t, ghosted, with_reactions ? &*reactions : nullptr); });
}

template <int dim>
void Results<dim>::write_mode(const BlockSystem<dim> &system, const Vector &x, const unsigned int number)
{
  if (!paraview.is_on() || problem_of_output)
    return;
  const Phases::Scope scope(phases, "output");
  paraview.show_bodies_alone();
  try_to_write([&]() { paraview.write(number, system.ghosted(x)); });
}

template <int dim>
void Results<dim>::find_new_meshes()
{
  probes.locate_again();
  paraview.forget_meshes();
}

/// Relative, of the last step; zero if it took no iteration.
template <int dim>
double Results<dim>::last_residual() const
{
  const auto &residuals = content->all()["steps"].back()["residuals"];
  return residuals.empty() || !residuals.back().is_number() ? 0 : residuals.back().template get<double>();
}

/// What refers to it sees the last one that was found.
template <int dim>
const Vector *Results<dim>::find_velocity(const Solution<dim> &solution)
{
  velocity.reset();
  if (solution.velocity != nullptr && (energy_balance || probes.has_motion() || paraview.has_motion()))
    velocity = solution.system.ghosted(*solution.velocity);
  const Vector *const found = velocity ? &*velocity : nullptr;
  probes.set_velocity(found);
  paraview.set_velocity(found);
  return found;
}

template <int dim>
void Results<dim>::start(const Solution<dim> &solution)
{
  if (!energy_balance)
    return;
  energy_balance->start(solution.x, solution.system.ghosted(solution.x), find_velocity(solution), solution.t);
}

/// The place of a minimum or maximum stands beside it.
template <int dim>
std::vector<Columns> Results<dim>::columns_of_probes(const Vector &ghosted, const Reactions<dim> &reactions)
{
  auto values = probes.evaluate(ghosted, reactions);
  const std::vector<NamesOfProbe> names = names_of_columns(probes);
  std::vector<Columns> columns;
  for (unsigned int i = 0; i < names.size(); ++i) {
    const std::string &probe = probes.all()[i].name;
    columns.push_back({names[i].numbers, values.numbers[probe]});
    if (!names[i].places.empty())
      columns.push_back({names[i].places, values.places[probe]});
  }
  return columns;
}

template <int dim>
void Results<dim>::record_step(const Solution<dim> &solution)
{
  const Phases::Scope scope(phases, "output");
  const Vector ghosted = solution.system.ghosted(solution.x);
  const Vector *const velocity_now = find_velocity(solution);
  const Reactions<dim> reactions(model, nodal_forces(solution), ghosted);
  const double exactly = 0; // a step tells what rounding explains of more than largest_imbalance
  const Balance balance =   // its notes, of the last step, are told by measure()
      measure_balance(model, reactions, ghosted, exactly, exactly, nullptr);
  report()["steps"].back()["imbalance"] = balance.worst;
  if (balance.rounding > 0)
    report()["steps"].back()["rounding of imbalance"] = balance.rounding;
  nlohmann::ordered_json flows = balance.report;
  for (auto &domain_flows : flows)
    for (auto &field_flows : domain_flows)
      field_flows.erase("rounding");
  std::vector<Columns> columns = columns_of_probes(ghosted, reactions);
  if (energy_balance) {
    const auto energy =
        energy_balance->add_step(reactions, solution.x, ghosted, velocity_now, solution.motion);
    report()["steps"].back()["energy"] = energy;
    for (const auto &[name, value] : energy.items())
      columns.push_back({{"energy " + name + in_brackets(probes, "J")}, value});
  }
  step_table.add(solution.t, columns, flows, model.domains[0]->measure.is_axisymmetric() ? "rzt" : "xyz",
                 {in_brackets(probes, "s"), [this](const std::string &field) {
                    return in_brackets(probes, units_of_field(field).resultant);
                  }});
  write_step_table();
}

template <int dim>
void Results<dim>::write_step_table()
{
  try_to_write([&]() {
    const Obstacle obstacle =
        is_first_rank(model) ? step_table.write(directory + "/" + StepTable::file) : Obstacle();
    if (const Obstacle agreed = agree(obstacle, model.communicator))
      agreed.raise(set_another_directory);
  });
}

/// What the run has written so far.
template <int dim>
void Results<dim>::bring_files_to_disk()
{
  try_to_write([&]() {
    if (const Obstacle obstacle = bring_to_disk(model.communicator))
      obstacle.raise(set_another_directory);
  });
}

template <int dim>
void Results<dim>::measure(const Solution<dim> &solution, const double tolerance)
{
  const Phases::Scope scope(phases, "output");
  give_back_freed_memory(); // of the linear solver
  const Vector ghosted = solution.system.ghosted(solution.x);
  const Reactions<dim> reactions(model, nodal_forces(solution), ghosted);
  NoteList sentences;
  report()["dofs"] = model.numbering->n_dofs();
  report()["domains"] = measure_domains(model, ghosted, solution.t);
  report()["interfaces"] = measure_interfaces(model, ghosted, reactions);
  const double share = 10,            // the residuals of a body may add up to more than their norm
      left = share * last_residual(); // in a linear scene that is what rounding leaves
  report()["balance"] = measure_balance(model, reactions, ghosted, model.is_linear() ? 0 : left,
                                        model.is_linear() ? left : share * tolerance, &sentences)
                            .report;
  find_velocity(solution);
  auto [numbers, places] = probes.evaluate(ghosted, reactions);
  report()["probes"] = numbers;
  if (!places.empty())
    report()["places of extremes"] = places;
  if (solution.is_last) // else the ties are those of the step that failed
    notes.add(sentences);
}

template <int dim>
void Results<dim>::compare(const Solution<dim> &solution)
{
  if (!reference.is_on())
    return;
  const Phases::Scope scope(phases, "comparison");
  const Vector ghosted = solution.system.ghosted(solution.x);
  try_to_write([&]() {
    reference.compare(ghosted, solution.t, solution.is_last, report()["domains"], report()["interfaces"]);
  });
  if (reference.has_reference())
    report()["errors against"] = reference.file();
}

template <int dim>
void Results<dim>::explain(const Solution<dim> &solution)
{
  const Vector ghosted = solution.system.ghosted(solution.x);
  notes.add(explain_resolution(model, ghosted, solution.t));
  notes.add(explain_stiffness(model, ghosted, solution.t));
  notes.add(explain_bent_cells(model, ghosted, solution.t));
  notes.add(probes.notes_on_extremes(ghosted, solution.t));
  notes.add(
      explain_jumps(model, solution.t, report()["domains"], report()["balance"], report()["interfaces"]));
}

template <int dim>
void Results<dim>::record_ranges(const Solution<dim> &solution)
{
  if (used_ranges.has_any())
    used_ranges.add(solution.system.ghosted(solution.x), solution.t);
}

template <int dim>
void Results<dim>::explain_ranges(const Solution<dim> &solution)
{
  record_ranges(solution);
  notes.add(used_ranges.explain());
}

template <int dim>
void Results<dim>::measure_spectrum(const Solution<dim> &solution, const std::vector<SolveGroup> &groups)
{
  if (!with_spectrum)
    return;
  if (!solution.is_last) {
    report().leave_out("spectrum: the last step did not converge");
    return;
  }
  const Phases::Scope scope(phases, "output");
  std::vector<std::string> sentences;
  report().add("spectrum", dovetail::measure_spectrum(solution.system, *model.numbering, groups,
                                                      model.communicator, sentences));
  for (const std::string &sentence : sentences)
    report().leave_out(sentence);
}

template <int dim>
void Results<dim>::finish(const bool is_converged, const Plan &plan, const nlohmann::ordered_json &counters)
{
  report()["converged"] = is_converged;
  report()["plan"] = plan.needed;
  report()["counters"] = counters;
  report()["seconds"] = phases.largest_of_ranks(model.communicator);
  report()["memory by phase MiB"] = phases.memory(model.communicator);
  if (!step_table.is_empty())
    write_step_table();
  bring_files_to_disk(); // what the disk does not take, the notes tell
  report()["notes"] = notes.texts();
  report()["names of notes"] = notes.names();
  for (const std::string &name : notes.silenced())
    report().leave_out("notes of the name " + name + ": silenced");
  try_to_write([&]() { report().write(); });
  bring_files_to_disk();
  log.finish(report().all(), directory);
  notes.repeat();
}

template class Results<2>;
template class Results<3>;

} // namespace dovetail
