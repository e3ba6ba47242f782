// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/adaptive_cycles.h>

#include <algorithm>

namespace dovetail {

template <int dim>
AdaptiveCycles<dim>::AdaptiveCycles(const Section &scene, Model<dim> &model, NonlinearStep<dim> &step,
                                    Results<dim> &results, Phases &phases, Log &log)
    : model(model), step(step), results(results), phases(phases), log(log),
      n_cycles(scene.read<unsigned int>("Adaptive cycles", 0,
                                        "Number of cycles, each of which refines where the estimated error "
                                        "is largest and solves the end time again [-]",
                                        Patterns::Integer(0, 50))),
      share(scene.read<double>("Adaptive share", 0.5,
                               "Share of the squared estimated error in the cells to be refined [-]",
                               Patterns::Double(0, 1)))
{
  scene.check(share > 0, "Adaptive share", "is 0, but must be larger: nothing would be refined.");
  scene.check(n_cycles == 0 || std::any_of(model.domains.begin(), model.domains.end(),
                                           [](const auto &domain) { return domain->can_refine(); }),
              "Adaptive cycles",
              "cannot be done: triangles and tetrahedra are not refined locally. Remove the entry.");
  scene.check(
      n_cycles == 0 || model.order_in_time() == 0, "Adaptive cycles",
      "cannot be done in a transient scene, since they solve the end time again, but the steps before "
      "it would stay on the coarse meshes, nor for eigenmodes. Remove the entry and set Refinements of "
      "the meshes.");
}

template <int dim>
void AdaptiveCycles<dim>::add_to(Plan &plan) const
{
  const std::string refinement = "refinement by the estimated error: ";
  if (n_cycles == 0) {
    plan.left_out.push_back(refinement + "Adaptive cycles = 0");
    return;
  }
  plan.needed.push_back(refinement + std::to_string(n_cycles) + (n_cycles == 1 ? " cycle" : " cycles"));
  for (const auto &domain : model.domains)
    if (!domain->can_refine())
      plan.left_out.push_back("refinement of " + domain->name +
                              ": triangles and tetrahedra stay as they are");
}

template <int dim>
bool AdaptiveCycles<dim>::run(const double t, Vector &x)
{
  Report &report = results.report();
  unsigned int n_newton_iterations = report["steps"].back()["newton iterations"];
  for (unsigned int cycle = 0; n_cycles > 0; ++cycle) {
    const ErrorEstimate estimate = estimate_error(model, step.system().ghosted(x), t);
    report["adaptive cycles"].push_back({{"dofs", model.numbering->n_dofs()},
                                         {"estimated error", estimate.relative},
                                         {"newton iterations", n_newton_iterations}});
    log.cycle(cycle, n_cycles, model.numbering->n_dofs(), estimate.relative);
    if (cycle == n_cycles)
      break;
    if (estimate.is_rounding()) {
      report.leave_out("adaptive cycles: the estimated error is rounding");
      break;
    }

    const auto result = try_cycle(estimate, t, x);
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
