// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/simulation.h>

#include <dovetail/domain/formulas.h>
#include <dovetail/output/balance.h>
#include <dovetail/output/directory_lock.h>
#include <dovetail/output/jumps.h>
#include <dovetail/output/measures.h>
#include <dovetail/output/resolution.h>
#include <dovetail/output/shared_file.h>
#include <dovetail/output/spectrum.h>
#include <dovetail/run/counters.h>
#include <dovetail/run/first_guess.h>
#include <dovetail/scene/plugins.h>
#include <dovetail/scene/scene_text.h>
#include <dovetail/scene/study_options.h>
#include <dovetail/system/place.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace dovetail {

namespace {

std::string read_directory(const Section &output, const SceneText &text)
{
  const auto directory = output.read<std::string>(
      "Directory", "", "Where the results go; output/ and the name of the scene's file if empty [-]");
  return directory.empty() ? "output/" + text.name() : directory;
}

bool read_spectrum(const Section &output)
{
  return output.read<bool>("Spectrum", false,
                           "Report eigenvalues and condition number of the matrix, up to " +
                               std::to_string(largest_spectrum) + " unknowns [-]");
}

} // namespace

Steps::Steps(const Section &section)
    : end_time(
          (section.choose("Kind", {"static"}, 0, "static: loads follow the time t, nothing is inert [-]"),
           section.read<double>("End time", 1., "The time t of the last step; the first step starts at 0 [s]",
                                Patterns::Double(1e-300)))),
      n_steps(section.read<unsigned int>("Number of steps", 1, "Equal steps up to the end time [-]",
                                         Patterns::Integer(1))),
      is_adaptive(section.read<bool>("Adaptive", true,
                                     "Halve a step that does not converge, down to 1/1024 of its size [-]"))
{
}

Adaptivity::Adaptivity(const Section &scene)
    : n_cycles(scene.read<unsigned int>(
          "Adaptive cycles", 0,
          "Refine where the estimated error is largest and solve the end time again, so often [-]",
          Patterns::Integer(0, 50))),
      share(scene.read<double>("Adaptive share", 0.5,
                               "The refined cells hold this share of the estimated error squared [-]",
                               Patterns::Double(0, 1)))
{
  scene.check(share > 0, "Adaptive share", "is 0, but must be larger: nothing would be refined.");
}

unsigned int read_dimension(const Section &scene)
{
  const auto dimension =
      scene.require<std::string>("Dimension", "The dimension of space [-]", Patterns::Selection("2|3"));
  scene.choose("Geometry", {"plane strain"}, 0, "What a scene in 2D means [-]");
  load_plugins(scene);
  return dimension == "2" ? 2 : 3;
}

void read_all_entries(const std::shared_ptr<SceneText> &text)
{
  const Section scene = SceneText::root(text);
  read_dimension(scene);
  const Model<3> model(scene, MPI_COMM_SELF);
  const Probes<3> probes(scene, model);
  const Steps steps(scene.subsection("Steps"));
  const Newton newton(scene.subsection("Newton"));
  const Adaptivity adaptivity(scene);
  const LinearSolver solver(scene.subsection("Linear solver"), {});
  const Section output = scene.subsection("Output");
  read_directory(output, *text);
  output.read<unsigned int>("Every steps", 1, "Write every that many steps, and the last one [-]",
                            Patterns::Integer(1));
  read_spectrum(output);
  const Paraview<3> paraview(output, model, "");
  const Reference<3> reference(output, model);
  const StudyOptions study(scene.subsection("Study"));
}

template <int dim>
Simulation<dim>::Simulation(const std::shared_ptr<SceneText> &text, const MPI_Comm &communicator)
    : communicator(communicator), text(text), scene(SceneText::root(text)), log(communicator),
      model([&]() -> Model<dim> {
        read_dimension(scene);
        const Phases::Scope scope(phases, "mesh");
        return Model<dim>(scene, communicator);
      }()),
      probes(scene, model), steps(scene.subsection("Steps")), newton(scene.subsection("Newton")),
      adaptivity(scene), linear_solver(scene.subsection("Linear solver"), solve_groups())
{
  const Section output = scene.subsection("Output");
  directory = read_directory(output, *text);
  every_steps = output.read<unsigned int>(
      "Every steps", 1, "Write every that many steps, and the last one [-]", Patterns::Integer(1));
  with_spectrum = read_spectrum(output);
  paraview = std::make_unique<Paraview<dim>>(output, model, directory);
  reference = std::make_unique<Reference<dim>>(output, model);
  StudyOptions(scene.subsection("Study")); // must be right in every run
  text->check_all_read();
  check_formulas();
  scene.check(adaptivity.n_cycles == 0 ||
                  std::any_of(model.domains.begin(), model.domains.end(),
                              [](const auto &domain) { return domain->can_refine(); }),
              "Adaptive cycles",
              "cannot be done: triangles and tetrahedra are not refined locally. Remove the entry.");

  if (!model.interfaces.empty()) {
    const Phases::Scope scope(phases, "pairing");
    model.pair();
  }
  phases.add("tie", model.pairing_seconds);
}

/// What is wrong whatever is solved is told before anything is.
template <int dim>
void Simulation<dim>::check_formulas() const
{
  for (const auto &domain : model.domains) {
    const bool are_finite = has_finite_formulas(*domain, steps.end_time / steps.n_steps, steps.end_time);
    refuse_undefined(are_finite ? Undefined() : last_undefined(), communicator);
  }
}

template <int dim>
std::vector<SolveGroup> Simulation<dim>::solve_groups() const
{
  std::vector<SolveGroup> groups;
  for (const auto &fields : model.field_groups()) {
    SolveGroup group;
    group.name = comma_separated(fields);
    group.dim = dim;
    group.degree = model.degree();
    group.is_symmetric = fields.size() == 1 && model.is_symmetric(fields[0]);
    group.allows_jumps = std::any_of(fields.begin(), fields.end(),
                                     [this](const auto &field) { return model.allows_jumps(field); });
    group.near_null_space = [this](const unsigned int block, const bool of_all_blocks) {
      return model.near_null_space(model.numbering->blocks()[block], of_all_blocks);
    };
    group.linear_part = [this](const unsigned int block) { return linear_part(block); };
    const auto &blocks = model.numbering->blocks();
    for (unsigned int b = 0; b < blocks.size(); ++b)
      if (std::find(fields.begin(), fields.end(), blocks[b].field) != fields.end()) {
        (blocks[b].is_of_multipliers ? group.multiplier_blocks : group.blocks).push_back(b);
        group.n_unknowns += blocks[b].end - blocks[b].begin;
      }
    groups.push_back(std::move(group));
  }
  return groups;
}

template <int dim>
Plan Simulation<dim>::plan() const
{
  Plan result = make_plan(model, steps.n_steps, linear_solver.description());
  const std::string pictures = "ParaView files";
  if (!paraview->is_on())
    result.left_out.push_back(pictures + ": Paraview = false");
  else
    result.needed.push_back(
        pictures + ": " +
        (every_steps == 1 ? "every step" : "every " + std::to_string(every_steps) + " steps, and the last"));
  if (adaptivity.n_cycles == 0)
    result.left_out.push_back("refinement by the estimated error: Adaptive cycles = 0");
  else {
    result.needed.push_back("refinement by the estimated error: " + std::to_string(adaptivity.n_cycles) +
                            (adaptivity.n_cycles == 1 ? " cycle" : " cycles"));
    for (const auto &domain : model.domains)
      if (!domain->can_refine())
        result.left_out.push_back("refinement of " + domain->name +
                                  ": triangles and tetrahedra stay as they are");
  }
  return result;
}

template <int dim>
std::vector<SolveGroup::Sum> Simulation<dim>::linear_part(const unsigned int block_number) const
{
  const Block &block = model.numbering->blocks()[block_number];
  auto sums = model.linear_part(block);
  for (unsigned int i = 0; i < sums.size(); ++i)
    if (const auto dof = block.begin + block.owned.nth_index_in_set(i);
        system->all_constraints().is_constrained(dof)) {
      const auto *entries = system->all_constraints().get_constraint_entries(dof);
      sums[i] = entries == nullptr ? SolveGroup::Sum() : SolveGroup::Sum(entries->begin(), entries->end());
    }
  return sums;
}

template <int dim>
void Simulation<dim>::check()
{
  log.title(text->file_name());
  log.summary(model);
  log.plan(plan());
  log.line();

  unsigned long n_points = 0, n_segments = 0;
  double bytes = 0;
  for (const auto &interface : model.interfaces) {
    const Coverage &coverage = interface->pairing().coverage();
    n_points += coverage.n_points;
    n_segments += coverage.n_segments;
    // weight; on each side position, normal, and values (twice over a gap) and gradients of the shape
    // functions
    unsigned int n_doubles = 1;
    for (const auto &side : interface->sides)
      n_doubles += 2 * dim + side.domain->n_nodes() * (2 + dim);
    bytes += static_cast<double>(coverage.n_points) * n_doubles * sizeof(double);
  }
  const double pairing = dealii::Utilities::MPI::max(model.pairing_seconds, communicator);
  const double search = dealii::Utilities::MPI::max(model.search_seconds, communicator);
  if (n_points > 0) {
    std::ostringstream words;
    words.precision(3);
    words << "pairing: " << n_points << " points in " << pairing << " s, " << 1e6 * pairing / n_points
          << " microseconds a point (the search alone " << 1e6 * search / n_points << "), "
          << bytes / n_points << " bytes a point";
    if (n_segments > 0)
      words << "; " << n_segments << " segments, " << 1e6 * pairing / n_segments << " microseconds and "
            << bytes / n_segments << " bytes a segment";
    log.line(words.str());
  }
}

template <int dim>
void Simulation<dim>::set_initial_values(const double t, const std::string &without_initial)
{
  // Of scalar fields, by domain. A linear scene needs none, and an update from a guess far from the solution
  // has the rounding of the guess.
  std::map<std::string, std::vector<double>> guesses;
  const bool may_guess = !model.is_linear();
  for (unsigned int d = 0; d < model.domains.size(); ++d) {
    const auto &domain = model.domains[d];
    const unsigned int n = domain->n_nodes();
    dealii::FEValues<dim> at_nodes(domain->mapping(), domain->scalar_element(),
                                   domain->scalar_element().get_unit_support_points(),
                                   dealii::update_quadrature_points);
    std::vector<dealii::types::global_dof_index> dofs;
    for (const Field &field : domain->fields())
      if (const Expression *initial =
              field.name == without_initial ? nullptr : domain->initial().find(field.name);
          initial || (may_guess && field.n_components == 1)) {
        if (!initial && guesses.count(field.name) == 0)
          guesses[field.name] = first_guess(model, field.name, t);
        for (const auto &cell : domain->dof_handler().active_cell_iterators())
          if (cell->is_locally_owned()) {
            at_nodes.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
            domain->cell_dofs(cell, dofs);
            for (unsigned int c = 0; c < field.n_components; ++c)
              for (unsigned int a = 0; a < n; ++a)
                if (const auto dof = dofs[(field.first_component + c) * n + a];
                    model.numbering->owned.is_element(dof))
                  solution(dof) = initial ? initial->value(at_nodes.quadrature_point(a), 0., c)
                                          : guesses.at(field.name)[d];
          }
      }
  }
  solution.compress(dealii::VectorOperation::insert);
}

/// The first step starts from a guess. If it fails from there, and by a scalar field, that begins anew: from
/// the mean of what conditions prescribe, which spreads through the bodies as if nothing else acted on them.
/// @return whether the solution is another guess now
template <int dim>
bool Simulation<dim>::guess_again(const double t)
{
  const std::string &name = model.numbering->blocks()[newton_step->convergence().worst_part()].field;
  const bool is_scalar = std::any_of(model.domains.begin(), model.domains.end(), [&](const auto &domain) {
    const Field *field = domain->material.find_field(name);
    return field != nullptr && field->n_components == 1;
  });
  if (!is_scalar)
    return false;
  log.line("  did not converge from the first guess; the " + name + " begins at what is prescribed");
  set_initial_values(t, name);
  begin_step(t);
  newton_step->spread_prescribed_values(solution);
  return true;
}

template <int dim>
void Simulation<dim>::set_up(const double t)
{
  const Phases::Scope scope(phases, "setup");
  linear_solver.forget_matrix();
  model.check_ties(t);
  system->set_up(t);
  tell_notes();
}

template <int dim>
void Simulation<dim>::tell_notes()
{
  std::vector<std::string> sentences = system->notes();
  for (const auto *others : {&linear_solver.notes(), newton_step ? &newton_step->notes() : nullptr})
    if (others != nullptr)
      sentences.insert(sentences.end(), others->begin(), others->end());
  for (const std::string &sentence : sentences)
    tell(sentence);
}

/// Once, in the log and in the report.
template <int dim>
void Simulation<dim>::tell(const std::string &note)
{
  if (report->add_note(note))
    log.line("  note: " + note);
}

/// A linear scene needs no iteration to know that a body is free; a nonlinear one may hold it once it has
/// moved.
template <int dim>
void Simulation<dim>::check_is_held() const
{
  if (const auto motion = system->find_free_motion())
    motion->bodies[0]->section.fail("Boundary conditions",
                                    "and interfaces do not hold " + motion->in_words() +
                                        ". Add a condition of Type = value, or a tie, that does.");
}

template <int dim>
void Simulation<dim>::begin_step(const double t)
{
  if (system->is_outdated(t))
    set_up(t);
  const Phases::Scope scope(phases, "setup");
  system->begin_step(t, solution);
  newton_step->begin(t, solution);
}

template <int dim>
NewtonResult Simulation<dim>::solve_step()
{
  return newton_step->solve(solution, [this]() { check_is_held(); });
}

template <int dim>
void Simulation<dim>::make_system(const double t)
{
  system = std::make_unique<BlockSystem<dim>>(model);
  set_up(t);
  newton_step = std::make_unique<NewtonStep<dim>>(model, *system, newton, linear_solver, phases, log);
}

namespace {

void append(NewtonResult &result, const NewtonResult &next)
{
  result.is_converged = next.is_converged;
  result.residuals.insert(result.residuals.end(), next.residuals.begin(), next.residuals.end());
  result.linear_iterations.insert(result.linear_iterations.end(), next.linear_iterations.begin(),
                                  next.linear_iterations.end());
}

} // namespace

template <int dim>
NewtonResult Simulation<dim>::solve_until_penalties_fit(const double t)
{
  if (model.is_linear())
    system->constrain(solution);
  NewtonResult result = solve_step();
  const unsigned int largest_number_of_passes = 5;
  for (unsigned int pass = 1;
       pass < largest_number_of_passes && result.is_converged && system->refreeze(t, solution); ++pass) {
    log.line("  penalties no longer fit the solution: solved again from here");
    append(result, solve_step());
  }
  return result;
}

/// One step to time t from the last good solution, which is that at time @p from.
template <int dim>
bool Simulation<dim>::advance(const double t, const double from)
{
  if (nothing_changes(t, from)) {
    report->add_step(t, {newton_step->convergence().tolerance()}, {});
    forces.reset();
    return true;
  }
  begin_step(t);
  tell_notes();
  const Vector last_good = solution;
  NewtonResult result = solve_until_penalties_fit(t);
  can_be_halved = false;
  const bool may_try_again = steps.is_adaptive && !model.is_linear();
  if (!result.is_converged && may_try_again && from == 0) {
    solution = last_good;
    if (guess_again(t)) {
      begin_step(t);
      append(result, solve_until_penalties_fit(t));
    }
  }
  if (!result.is_converged && may_try_again) {
    solution = last_good;
    if (from == 0) { // the guess may have been another one
      begin_step(t);
      newton_step->loads_at(solution);
    }
    can_be_halved = loads_depend_on_time(t, from);
    if (!can_be_halved)
      append(result, continue_in_load(t));
  }
  report->add_step(t, result.residuals, result.linear_iterations);
  tell_notes();
  if (result.is_converged) {
    lacks_multipliers = true;
    forces.reset();
    check_range(t);
  }
  return result.is_converged;
}

/// A scalar field that leaves the range of what is prescribed by more than its width is told of: a mesh that
/// is too coarse may overshoot, but not so far.
template <int dim>
void Simulation<dim>::check_range(const double t)
{
  const auto &blocks = model.numbering->blocks();
  for (unsigned int b = 0; b < blocks.size(); ++b) {
    if (blocks[b].is_of_multipliers ||
        model.domains[blocks[b].domain_index]->fields()[blocks[b].field_index].n_components > 1)
      continue;
    const auto range = given_range(model, blocks[b].field, t);
    if (!range)
      continue;
    const double smallest = solution.block(b).min(), largest = solution.block(b).max();
    const double allowed =
        (*range)[1] - (*range)[0] +
        Convergence::smallest_range * std::max(std::abs((*range)[0]), std::abs((*range)[1]));
    if (smallest >= (*range)[0] - allowed && largest <= (*range)[1] + allowed)
      continue;
    std::ostringstream words;
    words.precision(4);
    words << "the " << blocks[b].field << " of " << blocks[b].name << " runs from " << smallest << " to "
          << largest << ", but what is prescribed allows only " << (*range)[0] << " to " << (*range)[1]
          << ": the result is not to be trusted. Refine the mesh where the field is steep";
    tell(words.str());
  }
}

/// Whether the solution of time @p from solves the equations of time t, too. Newton's method sees that for
/// itself, unless weights and penalties of ties are frozen anew in each step: here they stay as they are.
/// Collective.
template <int dim>
bool Simulation<dim>::nothing_changes(const double t, const double from)
{
  if (from == 0 || model.is_linear() || model.interfaces.empty() || system->is_outdated(t))
    return false;
  system->set_time(t);
  newton_step->begin(t, solution);
  return newton_step->residual_at(solution) <= newton.residual_tolerance() && !system->moves_constraints();
}

/// Whether a step half as large would begin with other loads than that to time t, which has failed. A smaller
/// step of a linear scene fails in the same way, and so does one if nothing depends on t.
template <int dim>
bool Simulation<dim>::loads_depend_on_time(const double t, const double from)
{
  const auto of_failure = newton_step->loads();
  const double half = (from + t) / 2;
  if (system->is_outdated(half))
    return true;
  begin_step(half);
  const auto of_half = newton_step->loads_at(solution);
  for (const unsigned int i : {0, 1})
    if (std::abs(of_half[i] - of_failure[i]) > 1e-12 * of_failure[i])
      return true;
  return false;
}

/// Where halving the step changes nothing: Newton's homotopy in what is not in balance at the last good
/// solution.
template <int dim>
NewtonResult Simulation<dim>::continue_in_load(const double t)
{
  begin_step(t);
  log.line("  did not converge; nothing depends on t, so the load is increased bit by bit");
  system->hold_back_from(solution);
  NewtonResult result;
  double done = 0, size = 0.5;
  const double smallest_size = 1. / 1024;
  while (done < 1 && size >= smallest_size) {
    const Vector last_good = solution;
    const double next = std::min(1., done + size);
    system->set_share(next);
    append(result, next < 1 ? solve_step() : solve_until_penalties_fit(t));
    if (result.is_converged) {
      done = next;
      size *= 2;
    } else {
      solution = last_good;
      system->begin_step(t, solution); // the ties forget the share that failed
      size = (next - done) / 2;
    }
  }
  system->set_share(1);
  return result;
}

/// Where the last iteration left the largest residual, and what may help; perhaps a body is free: the tangent
/// of the last good state knows.
template <int dim>
void Simulation<dim>::explain_failure(const double t)
{
  const unsigned int part = newton_step->convergence().worst_part();
  const Block &block = model.numbering->blocks()[part];
  std::ostringstream words;
  words.precision(3);
  words << "the step to t = " << t << " did not converge: " << newton_step->what_failed() << " of the "
        << block.field << (block.is_of_multipliers ? " at " : " of ") << block.name;
  if (const auto place = place_of_largest(model, system->negative_residual(), part)) {
    words << ", in the cell at (" << (*place)[0];
    for (unsigned int d = 1; d < dim; ++d)
      words << ", " << (*place)[d];
    words << ')';
  }
  tell(words.str() + ". " + newton_step->suggestion());
  if (const Undefined &why = system->why_undefined())
    tell("a state was tried that is not defined: " + why.reason);

  if (!system->assemble(solution, true))
    return;
  if (const auto motion = system->find_free_motion(true))
    tell("nothing holds " + motion->in_words());
}

/// After a step that failed: what is measured belongs to the last good one, at time t.
template <int dim>
void Simulation<dim>::go_back(const double t)
{
  begin_step(t);
}

/// Steps up to the end or until one fails. @p t: the time of the last good one; @p n_done: the number of good
/// ones.
template <int dim>
bool Simulation<dim>::run_steps(const double nominal, double &t, unsigned int &n_done)
{
  double size = nominal;
  while (t < steps.end_time * (1 - 1e-12)) {
    const double next = std::min(t + size, steps.end_time);
    const bool is_last = next >= steps.end_time * (1 - 1e-12);
    log.step_begins(n_done + 1, steps.n_steps, is_last ? steps.end_time : next, steps.end_time);
    const Vector last_good = solution;
    bool is_good = false;
    newton_step->allow_jumps(next - t < 0.75 * nominal); // it has been halved
    try {
      is_good = advance(is_last ? steps.end_time : next, t);
    } catch (const UserError &error) { // toggles, or formulas in t: the steps before it are kept
      if (n_done == 0)
        throw;
      problem_of_step = error.what();
      can_be_halved = false;
    }
    if (is_good) {
      t = is_last ? steps.end_time : next;
      ++n_done;
      log.step_ends();
      write_output(t, n_done, is_last);
      size = std::min(nominal, 2 * size);
      continue;
    }
    solution = last_good;
    if (can_be_halved && size > nominal / 1024) {
      size = (next - t) / 2; // the last step may have been shorter than size
      log.step_ends("did not converge; half of the step is tried");
    } else {
      log.step_ends(problem_of_step.empty() ? "did not converge" : "cannot be done");
      if (problem_of_step.empty())
        explain_failure(next);
      go_back(t);
      if (n_done > 0 && n_done % every_steps != 0)
        write_output(t, n_done, true); // the last good step is always kept
      return false;
    }
  }
  return true;
}

template <int dim>
bool Simulation<dim>::run()
{
  log.title(text->file_name());
  log.summary(model);
  const Plan planned = plan();
  log.plan(planned);
  make_directory(directory, communicator);
  const auto lock = lock_directory(directory, communicator);
  report = std::make_unique<Report>(directory, communicator);
  (*report)["converged"] = false;
  (*report)["plan"] = planned.needed;
  (*report)["left out"] = planned.left_out;
  report->write(); // so that an interrupted run does not look like the one before it
  write_used();

  const double nominal = steps.end_time / steps.n_steps;
  make_system(nominal);
  solution = system->owned_vector();
  set_initial_values(nominal);

  double t = 0;
  unsigned int n_done = 0;
  bool is_converged = run_steps(nominal, t, n_done);
  if (n_done > 0) // else there is nothing that could be taken for a result
    measure(t, is_converged);
  if (is_converged)
    is_converged = run_cycles(t);
  if (n_done > 0)
    compare(t, is_converged);
  else {
    (*report)["dofs"] = model.numbering->n_dofs();
    log.line("  no results: the first step did not converge");
  }
  if (is_converged)
    explain_solution(t);
  if (with_spectrum && is_converged)
    measure_spectrum_of_groups();
  else if (with_spectrum)
    report->leave_out("spectrum: the last step did not converge");
  write_report(is_converged);
  return is_converged;
}

template <int dim>
void Simulation<dim>::write_used() const
{
  const std::string first_line = "# Every entry of a run of Dovetail with its value; ";
  std::ostringstream used;
  used << first_line << "the next run into this directory replaces this file.\n\n";
  text->print_used(used);
  if (const Obstacle obstacle =
          write_on_first_rank(directory + "/used.prm", first_line, used.str(), communicator))
    obstacle.raise(set_another_directory);
}

/// What is measured and written last stays if a cycle does not converge.
template <int dim>
bool Simulation<dim>::run_cycles(const double t)
{
  unsigned int n_newton_iterations = (*report)["steps"].back()["newton iterations"];
  for (unsigned int cycle = 0; adaptivity.n_cycles > 0; ++cycle) {
    Vector ghosted = system->ghosted_vector();
    ghosted = solution;
    const ErrorEstimate estimate = estimate_error(model, ghosted, t);
    (*report)["adaptive cycles"].push_back({{"dofs", model.numbering->n_dofs()},
                                            {"estimated error", estimate.relative},
                                            {"newton iterations", n_newton_iterations}});
    log.cycle(cycle, adaptivity.n_cycles, model.numbering->n_dofs(), estimate.relative);
    if (cycle == adaptivity.n_cycles)
      break;
    if (estimate.is_rounding()) {
      report->leave_out("adaptive cycles: the estimated error is rounding");
      break;
    }

    const NewtonResult result = solve_on_refined_meshes(estimate, t);
    if (!result.is_converged) {
      log.step_ends("did not converge; the results are those before this cycle");
      return false;
    }
    n_newton_iterations = result.linear_iterations.size();
    lacks_multipliers = true;
    write_output(t, 0, true);
    measure(t, true);
  }
  return true;
}

template <int dim>
NewtonResult Simulation<dim>::solve_on_refined_meshes(const ErrorEstimate &estimate, const double t)
{
  {
    Vector ghosted = system->ghosted_vector();
    ghosted = solution;
    phases.add("tie", system->seconds_of_ties());
    linear_solver.forget_matrix();
    take_account();
    newton_step.reset();
    forces.reset();
    system.reset(); // their memory is needed
    const Phases::Scope scope(phases, "mesh");
    solution = model.refine(mark_cells(model, estimate, adaptivity.share), ghosted);
  }
  phases.add("mesh", -model.pairing_seconds);
  phases.add("pairing", model.pairing_seconds);
  phases.add("tie", model.pairing_seconds);
  probes.locate_again();
  paraview->forget_meshes();
  make_system(t);
  begin_step(t);
  return solve_until_penalties_fit(t);
}

/// Before a system goes.
template <int dim>
void Simulation<dim>::take_account()
{
  assemblies.of_tangent += system->assemblies().of_tangent;
  assemblies.of_residual += system->assemblies().of_residual;
}

/// Nobody needs those of a step that is not looked at.
template <int dim>
void Simulation<dim>::find_forces()
{
  if (!forces) {
    forces.emplace(system->nodal_forces(solution));
    system->find_multipliers(solution, *forces);
  }
  lacks_multipliers = false;
}

template <int dim>
void Simulation<dim>::write_output(const double t, const unsigned int step, const bool is_last)
{
  if (!paraview->is_on() || problem_of_output || (step % every_steps != 0 && !is_last))
    return;
  const Phases::Scope scope(phases, "output");
  const bool with_reactions = paraview->needs_reactions();
  if (system->has_multipliers() || with_reactions)
    find_forces();
  Vector ghosted = system->ghosted_vector();
  ghosted = solution;
  std::optional<Reactions<dim>> reactions;
  if (with_reactions)
    reactions.emplace(model, *forces, ghosted);
  try_to_write([&]() { paraview->write(t, ghosted, with_reactions ? &*reactions : nullptr); });
}

/// What all ranks find alike ends no run: the numbers are still wanted.
template <int dim>
template <typename Write>
void Simulation<dim>::try_to_write(const Write &write)
{
  const auto keep = [this](const std::exception &error) {
    problem_of_output = std::current_exception();
    report->add_note(error.what());
  };
  try {
    write();
  } catch (const UserError &error) {
    keep(error);
  } catch (const OutputError &error) {
    keep(error);
  }
}

/// Relative, of the last step; zero if it took no iteration.
template <int dim>
double Simulation<dim>::last_residual() const
{
  const auto &residuals = (*report)["steps"].back()["residuals"];
  return residuals.empty() || !residuals.back().is_number() ? 0 : residuals.back().template get<double>();
}

template <int dim>
void Simulation<dim>::measure(const double t, const bool is_converged)
{
  const Phases::Scope scope(phases, "output");
  find_forces();
  Vector ghosted = system->ghosted_vector();
  ghosted = solution;
  const Reactions<dim> reactions(model, *forces, ghosted);
  std::vector<std::string> notes;
  (*report)["dofs"] = model.numbering->n_dofs();
  (*report)["domains"] = measure_domains(model, ghosted, t);
  (*report)["interfaces"] = measure_interfaces(model, ghosted, reactions);
  const double tolerance = model.is_linear() ? 10 * last_residual() : newton.residual_tolerance();
  (*report)["balance"] = measure_balance(model, reactions, ghosted, tolerance, notes);
  (*report)["probes"] = probes.evaluate(ghosted, reactions);
  for (const std::string &sentence : notes) // after a failure the ties are those of the step that failed
    if (is_converged)
      tell(sentence);
}

/// What a user should know about it.
template <int dim>
void Simulation<dim>::explain_solution(const double t)
{
  Vector ghosted = system->ghosted_vector();
  ghosted = solution;
  for (const std::string &sentence : explain_resolution(model, ghosted, t))
    tell(sentence);
  for (const std::string &sentence : explain_jumps(model, t, (*report)["domains"], (*report)["interfaces"]))
    tell(sentence);
}

/// With a run that is more exact, or for runs that are less so.
template <int dim>
void Simulation<dim>::compare(const double t, const bool is_converged)
{
  if (!reference->is_on())
    return;
  const Phases::Scope scope(phases, "comparison");
  Vector ghosted = system->ghosted_vector();
  ghosted = solution;
  try_to_write(
      [&]() { reference->compare(ghosted, t, is_converged, (*report)["domains"], (*report)["interfaces"]); });
  if (reference->has_reference())
    (*report)["errors against"] = reference->file();
}

template <int dim>
void Simulation<dim>::measure_spectrum_of_groups()
{
  const Phases::Scope scope(phases, "output");
  std::vector<std::string> sentences;
  report->add("spectrum",
              measure_spectrum(*system, *model.numbering, solve_groups(), communicator, sentences));
  for (const std::string &sentence : sentences)
    report->leave_out(sentence);
}

template <int dim>
void Simulation<dim>::write_report(const bool is_converged)
{
  (*report)["converged"] = is_converged;
  (*report)["plan"] = plan().needed; // the linear solver may have decided otherwise
  phases.add("tie", system->seconds_of_ties());
  take_account();
  (*report)["counters"] = count(model, assemblies, linear_solver, paraview->n_files());
  (*report)["seconds"] = phases.largest_of_ranks(communicator);
  try_to_write([&]() { report->write(); });
  log.finish(report->all(), directory);
  if (!problem_of_step.empty())
    throw UserError(problem_of_step);
  if (problem_of_output)
    std::rethrow_exception(problem_of_output);
}

template class Simulation<2>;
template class Simulation<3>;

} // namespace dovetail
