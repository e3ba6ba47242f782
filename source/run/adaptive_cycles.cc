// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/adaptive_cycles.h>
#include <dovetail/scene/undefined.h>

#include <algorithm>

namespace dovetail {

namespace {

/// Of scenes whose probes have tolerances, if they do not say it.
constexpr unsigned int cycles_to_tolerance = 20;
constexpr double share_of_probes = 0.8;

const NoteName of_tolerance("tolerance", "the error of a probe is more than its Tolerance, or not known");

} // namespace

template <int dim>
AdaptiveCycles<dim>::AdaptiveCycles(const Section &scene, Model<dim> &model, const Probes<dim> &probes,
                                    NonlinearStep<dim> &step, Results<dim> &results, Phases &phases,
                                    Notes &notes, Log &log)
    : model(model), probes(probes), linear_solver(scene.subsection("Linear solver")), step(step),
      results(results), phases(phases), notes(notes), log(log),
      n_cycles(scene.read<unsigned int>("Adaptive cycles", 0,
                                        "Number of cycles, each of which refines where the estimated error "
                                        "is largest and solves the end time "
                                        "again; with a Tolerance of a probe the largest number, and 0: " +
                                            std::to_string(cycles_to_tolerance) + " [-]",
                                        Patterns::Integer(0, 50))),
      largest_number_of_unknowns(scene.read<unsigned int>(
          "Adaptive unknowns", 1000000, "Meshes with so many unknowns, or more, are not refined again [-]",
          Patterns::Integer(1))),
      share(scene.read<double>("Adaptive share", probes.has_tolerance() ? share_of_probes : 0.5,
                               "Share of the squared estimated error in the cells to be refined; with a "
                               "Tolerance of a probe, of the sizes of all contributions, and " +
                                   in_words(share_of_probes) + " if the scene does not set it [-]",
                               Patterns::Double(0, 1)))
{
  scene.check(share > 0, "Adaptive share", "is 0, but must be larger: nothing would be refined.");
  scene.check(n_cycles == 0 || can_refine(), "Adaptive cycles",
              "cannot be done: triangles and tetrahedra are not refined locally. Remove the entry.");
  scene.check(
      n_cycles == 0 || model.order_in_time() == 0, "Adaptive cycles",
      "cannot be done in a transient scene, since they solve the end time again, but the steps before "
      "it would stay on the coarse meshes, nor for eigenmodes. Remove the entry and set Refinements of "
      "the meshes.");
  scene.check(
      n_cycles == 0 || !model.has_conditions_by_fields(), "Adaptive cycles",
      "cannot be done with a boundary condition whose Toggle looks at fields: they solve the end time "
      "again, but the toggle would be asked anew in each of them. Remove the entry and set "
      "Refinements of the meshes.");
  for (const auto &interface : model.interfaces) {
    scene.check(n_cycles == 0 || !interface->tie().follows_fields(), "Adaptive cycles",
                "cannot be done with the toggle of the interface " + interface->name +
                    ", which looks at fields: they solve the end time again, but the toggle would be asked "
                    "anew in each of them. Remove the entry and set Refinements of the meshes.");
    scene.check(n_cycles == 0 || interface->tie().internal_variables().empty(), "Adaptive cycles",
                "cannot be done with the joint of the interface " + interface->name +
                    ": they solve the end time again, but what the joint remembers would stay that of the "
                    "coarse meshes. Remove the entry and set Refinements of the meshes.");
  }
  if (probes.has_tolerance() && n_cycles == 0)
    n_cycles = can_refine() ? cycles_to_tolerance : 0;
}

template <int dim>
bool AdaptiveCycles<dim>::can_refine() const
{
  return std::any_of(model.domains.begin(), model.domains.end(),
                     [](const auto &domain) { return domain->can_refine(); });
}

template <int dim>
void AdaptiveCycles<dim>::add_to(Plan &plan) const
{
  const std::string refinement = "refinement by the estimated error: ";
  if (n_cycles == 0 && !probes.has_tolerance()) {
    plan.left_out.push_back(refinement + "Adaptive cycles = 0");
    return;
  }
  const std::string number = std::to_string(n_cycles) + (n_cycles == 1 ? " cycle" : " cycles");
  plan.needed.push_back(probes.has_tolerance()
                            ? "refinement until the tolerances of probes are reached: at most " + number
                            : refinement + number);
  for (const auto &domain : model.domains)
    if (!domain->can_refine())
      plan.left_out.push_back("refinement of " + domain->name +
                              ": triangles and tetrahedra stay as they are");
}

/// Why the meshes are not refined any more; empty if they are.
template <int dim>
std::string AdaptiveCycles<dim>::end_of_cycles(const unsigned int cycle, const ErrorEstimate &estimate) const
{
  if (!can_refine())
    return "triangles and tetrahedra are not refined locally: set Refinements of the meshes";
  if (cycle == n_cycles)
    return "all " + std::to_string(n_cycles) + " cycles are done: set Adaptive cycles";
  if (model.numbering->n_dofs() >= largest_number_of_unknowns)
    return "the meshes have " + std::to_string(model.numbering->n_dofs()) +
           " unknowns: set Adaptive unknowns";
  if (estimate.is_rounding())
    return "the estimated error is rounding";
  if (!dovetail::can_refine(model, estimate))
    return "all cells that err are the finest that there can be";
  return "";
}

/// Nothing if no further cycle is wanted. @p entry: of the list of cycles in the report.
template <int dim>
std::optional<ErrorEstimate> AdaptiveCycles<dim>::estimate(const unsigned int cycle, const double t,
                                                           const Vector &x, nlohmann::ordered_json &entry)
{
  ErrorEstimate estimate = estimate_error(model, step.system().ghosted(x), t);
  entry["estimated error"] = estimate.relative;
  log.cycle(cycle, n_cycles, model.numbering->n_dofs(), estimate.relative);
  const std::string reason = end_of_cycles(cycle, estimate);
  if (reason.empty())
    return estimate;
  if (cycle < n_cycles)
    results.report().leave_out("adaptive cycles: " + reason);
  return {};
}

/// Likewise.
template <int dim>
std::optional<ErrorEstimate> AdaptiveCycles<dim>::estimate_probes(const unsigned int cycle, const double t,
                                                                  const Vector &x,
                                                                  nlohmann::ordered_json &entry)
{
  ProbeErrors estimate = [&]() {
    const Phases::Scope scope(phases, "estimate");
    return estimate_probe_errors(model, step.system(), probes, linear_solver, x, t, corrected_before);
  }();
  if (!estimate.failure.empty()) {
    notes.add(of_tolerance("the error of the probes is not estimated: " + estimate.failure));
    return {};
  }
  corrected_before = estimate.corrected_values();
  Report &report = results.report();
  report["probe errors"] = estimate.errors();
  report["probe estimates"] = estimate.estimates();
  entry["probes"] = report["probes"];
  entry["probe errors"] = report["probe errors"];
  entry["estimated error"] = estimate.cells.relative;
  log.cycle(cycle, n_cycles, model.numbering->n_dofs(), report.all());
  if (estimate.are_reached())
    return {};
  const std::string reason = end_of_cycles(cycle, estimate.cells);
  if (reason.empty())
    return estimate.cells;
  for (const ProbeError &probe : estimate.probes)
    if (!probe.is_reached())
      notes.add(of_tolerance("the tolerance of the probe " + probe.name + " is not reached: " + reason));
  return {};
}

template <int dim>
bool AdaptiveCycles<dim>::run(const double t, Vector &x)
{
  Report &report = results.report();
  unsigned int n_newton_iterations = report["steps"].back()["newton iterations"];
  for (unsigned int cycle = 0; n_cycles > 0 || probes.has_tolerance(); ++cycle) {
    nlohmann::ordered_json entry = {{"dofs", model.numbering->n_dofs()}};
    const auto cells =
        probes.has_tolerance() ? estimate_probes(cycle, t, x, entry) : estimate(cycle, t, x, entry);
    entry["newton iterations"] = n_newton_iterations;
    report["adaptive cycles"].push_back(entry);
    if (!cells)
      break;

    const auto result = try_cycle(*cells, t, x);
    if (!result || !result->is_converged) {
      log.step_ends(std::string(result ? "did not converge" : "cannot be done") +
                    "; the results are those before this cycle");
      return false;
    }
    n_newton_iterations = result->linear_iterations.size();
    results.write_pictures({step.system(), x, t, true});
    results.measure({step.system(), x, t, true}, step.tolerance());
    results.compare({step.system(), x, t, true});
  }
  return true;
}

/// Nothing if the refined meshes show that the input is wrong.
template <int dim>
std::optional<NewtonResult> AdaptiveCycles<dim>::try_cycle(const ErrorEstimate &estimate, const double t,
                                                           Vector &x)
{
  try {
    NewtonResult result = solve_on_refined_meshes(estimate, t, x);
    result.is_converged = result.is_converged && step.remember(t, x);
    step.add_notes();
    if (result.is_converged)
      step.explain_solution(t, x);
    else
      step.explain_failure(t, x);
    return result;
  } catch (const UserError &) {
    problem_of_cycle = std::current_exception();
    return {};
  }
}

template <int dim>
NewtonResult AdaptiveCycles<dim>::solve_on_refined_meshes(const ErrorEstimate &estimate, const double t,
                                                          Vector &x)
{
  {
    const Vector ghosted = step.system().ghosted(x);
    results.forget_solution();
    step.release_system(); // its memory is needed
    const Phases::Scope scope(phases, "mesh");
    x = model.refine(mark_cells(model, estimate, share), ghosted);
  }
  phases.add("mesh", -model.pairing_seconds);
  phases.add("pairing", model.pairing_seconds);
  phases.add("tie", model.pairing_seconds);
  results.find_new_meshes();
  step.make_system(t);
  step.begin(t, x);
  return step.solve(x);
}

template class AdaptiveCycles<2>;
template class AdaptiveCycles<3>;

} // namespace dovetail
