// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/magnitudes.h>
#include <dovetail/run/simulation.h>

#include <dovetail/domain/formulas.h>
#include <dovetail/measure/meeting_bodies.h>
#include <dovetail/output/rehearsal.h>
#include <dovetail/run/cost_estimate.h>
#include <dovetail/run/counters.h>
#include <dovetail/run/first_guess.h>
#include <dovetail/run/initial_values.h>
#include <dovetail/scene/plugins.h>
#include <dovetail/scene/study_options.h>
#include <dovetail/scene/units.h>

#include <algorithm>

namespace dovetail {

unsigned int begin_scene(const Section &scene)
{
  const auto dimension =
      scene.require<std::string>("Dimension", "The dimension of space [-]", Patterns::Selection("2|3"));
  const unsigned int geometry = scene.choose(
      "Geometry", {"plane strain", "plane stress", "axisymmetric"}, 0,
      "What a body in 2D is: thick, without strain across the plane; a thin sheet without stress across it; "
      "or a body of revolution, where x is the radius, y the axis, and all integrals are over the whole "
      "circle (2 pi r) [-]");
  scene.check(geometry == 0 || dimension == "2", "Geometry", "is a choice in two dimensions only.");
  const double thickness = scene.read<double>(
      "Thickness", 1,
      "Thickness of the bodies in plane strain and plane stress, a factor of all integrals: forces, heat, "
      "areas and volumes are those of the whole thickness [m]");
  scene.check(thickness > 0, "Thickness", "must be positive.");
  scene.check(thickness == 1 || (dimension == "2" && geometry < 2), "Thickness",
              "belongs to plane strain and plane stress in two dimensions only.");
  scene.read<std::string>(
      "Materials file", "",
      "Files with subsections Material NAME in SI: what the scene does not say about its Materials is taken "
      "from "
      "there and converted to its Units; Type = none leaves out a part, Solid or Heat [-]");
  const auto units = scene.read<std::string>(
      "Units", "",
      "The units of length, mass, time and temperature of all numbers in the scene and of its results, for "
      "instance mm, t, s, K; empty: any consistent set [-]");
  if (!units.empty())
    try {
      Units{units};
    } catch (const UserError &error) {
      scene.fail("Units", error.what());
    }
  load_plugins(scene);
  return dimension == "2" ? 2 : 3;
}

void read_all_entries(const std::shared_ptr<SceneText> &text)
{
  const Simulation<3> simulation(text, MPI_COMM_SELF);
}

template <int dim>
Simulation<dim>::Simulation(const std::shared_ptr<SceneText> &text, const MPI_Comm &communicator,
                            const Detail detail)
    : text(text), scene(SceneText::root(text)), log(communicator, detail), notes(log),
      steps(scene.subsection("Steps")), model([&]() -> Model<dim> {
        begin_scene(scene);
        const Phases::Scope scope(phases, "mesh");
        return Model<dim>(scene, communicator);
      }()),
      probes(scene, model), step(scene, model, steps.n_equal(), phases, notes, log),
      results(*text, scene.subsection("Output"), model, probes, phases, notes, log),
      step_control(steps, step, results, notes, log, communicator),
      adaptive_cycles(scene, model, probes, step, results, phases, notes, log),
      eigenmodes(scene, model, step, results, phases, notes, log)
{
  StudyOptions(scene.subsection("Study")); // must be right in every run
  if (scene.documenting())
    return;
  text->check_all_read();
  check_path();
  check_formulas();

  if (!model.interfaces.empty()) {
    const Phases::Scope scope(phases, "pairing");
    model.pair();
    step.solver().consider_shapes();
  }
  phases.add("tie", model.pairing_seconds);
}

template <int dim>
void Simulation<dim>::check_path() const
{
  if (!steps.follows_path())
    return;
  const Section section = scene.subsection("Steps");
  section.check(!model.is_linear(), "Kind",
                "is arc length, but the scene is linear: its path is straight. Set Kind = static.");
  bool has_toggles = false;
  for (const auto &interface : model.interfaces)
    has_toggles = has_toggles || interface->has_toggle();
  for (const auto &domain : model.domains)
    for (const auto &condition : domain->conditions())
      has_toggles = has_toggles || !condition->toggle_name().empty();
  section.check(!has_toggles, "Kind",
                "cannot be arc length with toggles: on a path t may rise and fall within a step, so that "
                "a switch has no place on it. Remove the toggles, or set Kind = static.");
  section.check(model.field_groups().size() == 1, "Kind",
                "cannot be arc length with several fields that are solved one after the other.");
  const auto &domains = model.domains;
  section.check(std::all_of(domains.begin(), domains.end(),
                            [](const auto &domain) {
                              const auto &fields = domain->fields();
                              return std::any_of(fields.begin(), fields.end(),
                                                 [](const Field &field) { return field.n_components > 1; });
                            }),
                "Kind",
                "is arc length, which measures the displacement: every material needs a subsection Solid.");
}

/// What is wrong whatever is solved is told before anything is.
template <int dim>
void Simulation<dim>::check_formulas() const
{
  for (const auto &domain : model.domains) {
    const bool are_finite = has_finite_formulas(*domain, steps.size(), steps.end_time);
    refuse_undefined(are_finite ? Undefined() : last_undefined(), model.communicator);
  }
}

template <int dim>
Plan Simulation<dim>::plan() const
{
  const bool has_steps = !(steps.finds_modes() && model.is_linear());
  Plan result = make_plan(model, has_steps ? steps.n_steps : 0, step.solver().description());
  step.add_to(result);
  results.add_to(result);
  adaptive_cycles.add_to(result);
  if (steps.finds_modes())
    eigenmodes.add_to(result);
  return result;
}

template <int dim>
Plan Simulation<dim>::introduce()
{
  log.title(text->file_name());
  if (const std::string units = scene.peek("Units"); !units.empty())
    log.line("units: " + units);
  log.summary(model);
  const Plan planned = plan();
  log.plan(planned);
  notes.add(notes_on_magnitudes(model, scene));
  notes.add(notes_on_sides(model));
  notes.add(notes_on_untied_bodies(model));
  notes.add(notes_on_first_guess(model, steps));
  notes.add(probes.notes());
  return planned;
}

template <int dim>
void Simulation<dim>::check()
{
  introduce();
  std::vector<double> times; // of the ends of steps, as far as toggles may differ in them
  const unsigned int n_times = std::min(50u, steps.n_steps);
  for (unsigned int i = 1; i <= n_times; ++i)
    times.push_back(steps.end_time * i / n_times);
  rehearse(model, *text, scene, times, log, notes);
  results.preview();
  log.line();
  log.line("estimate: " + estimate_cost(model, step.solver(), steps).in_words() +
           "; meshes and pairings are not counted");
  log.cost_of_pairing(model);
  notes.repeat();
}

template <int dim>
void Simulation<dim>::measure(const Vector &x, const bool is_converged)
{
  const double t = step_control.time();
  const bool has_results = step_control.n_done() > 0; // else nothing could be taken for a result
  if (has_results) {
    results.measure({step.system(), x, t, is_converged, step.velocity()}, step.tolerance());
    results.compare({step.system(), x, t, is_converged});
  } else {
    results.report()["dofs"] = model.numbering->n_dofs();
    log.tell("  no results: the first step did not converge");
  }
}

template <int dim>
bool Simulation<dim>::run_steps(Vector &x)
{
  const bool is_converged = step_control.run(x);
  step.explain_steps();
  measure(x, is_converged);
  return is_converged && adaptive_cycles.run(step_control.time(), x);
}

/// What is measured is the state about which a nonlinear scene vibrates.
template <int dim>
bool Simulation<dim>::find_modes(Vector &x)
{
  results.report()["dofs"] = model.numbering->n_dofs();
  if (!model.is_linear()) {
    const bool is_converged = step_control.run(x);
    measure(x, is_converged);
    if (!is_converged)
      return false;
  }
  return eigenmodes.run(model.is_linear() ? steps.end_time : step_control.time(), x);
}

template <int dim>
Vector Simulation<dim>::begin()
{
  results.begin(introduce());
  step.make_system(steps.size());
  Vector x = step.system().owned_vector();
  set_initial_values(model, steps.size(), x);
  step.start(steps.size(), x);
  results.start({step.system(), x, 0, true, step.velocity()});
  return x;
}

/// What is wrong is told before anything is written.
template <int dim>
Vector Simulation<dim>::go_on()
{
  const Checkpoint<dim> checkpoint = results.find_checkpoint();
  checkpoint.check_scene(*text);
  checkpoint.check_meshes(model);
  SavedState saved;
  saved.numbers = checkpoint.numbers();
  const Plan planned = introduce();
  log.line();
  step_control.go_on(saved.numbers["step control"]);
  const double t = step_control.time();
  step.make_system(t);
  saved.vectors = checkpoint.vectors(model, step.system().owned_vector());
  const Vector x = saved.vectors.at("solution");
  step_control.go_on_path(saved);
  step.go_on(checkpoint, saved, t, x);
  results.go_on(planned, saved);
  results.report().add(
      "resumed", {{"step", step_control.n_done()}, {"time", t}, {"ranks before", checkpoint.n_ranks()}});
  return x;
}

template <int dim>
bool Simulation<dim>::run()
{
  return run_from(begin());
}

template <int dim>
bool Simulation<dim>::resume()
{
  return run_from(go_on());
}

template <int dim>
bool Simulation<dim>::run_from(Vector x)
{
  if (const std::string units = scene.peek("Units"); !units.empty())
    results.report().add("units", units);
  bool is_converged = steps.finds_modes() ? find_modes(x) : run_steps(x);
  const double t = step_control.time();
  if (step.has_system() && !steps.finds_modes()) {
    const Solution<dim> solution = {step.system(), x, t, is_converged};
    if (is_converged)
      results.explain(solution);
    results.explain_ranges(solution);
    results.measure_spectrum(solution, step.solve_groups());
  }
  if (step.has_system())
    phases.add("tie", step.system().seconds_of_ties());
  results.finish(is_converged, plan(), // the linear solver may have decided otherwise
                 count(model, step.assemblies(), step.solver(), step.n_predicted(), results.n_files()));
  for (const auto &problem : {step_control.problem(), adaptive_cycles.problem(), results.problem()})
    if (problem)
      std::rethrow_exception(problem);
  return is_converged;
}

template class Simulation<2>;
template class Simulation<3>;

} // namespace dovetail
