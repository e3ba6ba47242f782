// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/probe_estimate.h>

#include <dovetail/measure/probe_derivative.h>
#include <dovetail/system/solve_groups.h>
#include <dovetail/system/unconstrained_products.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dovetail {

namespace {

using Index = dealii::types::global_dof_index;

const double exactness_of_weights = 1e-5; ///< residual of the dual problem; the estimate is no more exact

double length(const std::vector<double> &numbers)
{
  return std::sqrt(std::inner_product(numbers.begin(), numbers.end(), numbers.begin(), 0.));
}

nlohmann::ordered_json number_or_list(const std::vector<double> &numbers)
{
  return numbers.size() == 1 ? nlohmann::ordered_json(numbers[0]) : nlohmann::ordered_json(numbers);
}

/// One number of one probe.
struct Goal
{
  unsigned int probe;
  Vector load;          ///< J', before constraints
  double lack;          ///< of the value that has been reported
  Vector z;             ///< of the dual problem, owned
  Vector contributions; ///< of the nodes, owned
};

/// The groups of the transposed tangent: a field now follows those that depend on it.
template <int dim>
std::vector<SolveGroup> dual_groups(const Enrichment<dim> &enriched)
{
  auto groups = make_solve_groups<dim>(
      enriched.model(), [&enriched]() -> const BlockSystem<dim> & { return enriched.system(); });
  std::reverse(groups.begin(), groups.end());
  for (SolveGroup &group : groups) {
    group.why_entries = "it is the transpose of a tangent";
    group.is_symmetric = // the ties have begun a step, and a rank without points knows nothing of it
        dealii::Utilities::MPI::min(group.is_symmetric ? 1 : 0, enriched.model().communicator) == 1;
    group.is_still_symmetric = nullptr;
  }
  return groups;
}

template <int dim>
class Estimator
{
public:
  Estimator(const Model<dim> &model, BlockSystem<dim> &system, const Vector &x, const double t)
      : model(model), enriched(model, system, t, x), move(enriched.distance_to_constraints())
  {
  }

  /// Each returns why it failed, or nothing.
  std::string find_loads(const Probes<dim> &probes, const Reactions<dim> &reactions, ProbeErrors &result);
  std::string solve(const Section &linear_solver);
  std::string weigh(ProbeErrors &result);
  void share(ProbeErrors &result);

private:
  double weigh(Goal &goal, const Vector &residual, const Vector &product) const;
  Vector nodes_of(const Interface<dim> &interface) const;
  void add_to_cells(const Vector &sizes, double unit, ErrorEstimate &cells) const;

  const Model<dim> &model;
  Enrichment<dim> enriched;
  const Vector move;
  std::vector<Goal> goals;
};

template <int dim>
std::string Estimator<dim>::find_loads(const Probes<dim> &probes, const Reactions<dim> &reactions,
                                       ProbeErrors &result)
{
  std::optional<Reactions<dim>> fine; // in the enriched model
  for (const auto &probe : probes.all())
    if (probe.tolerance > 0) {
      if (is_resultant<dim>(probe) && !fine)
        fine.emplace(enriched.model(), enriched.nodal_forces(), enriched.ghosted_x());
      auto derivative = probe_derivative<dim>(probe, enriched, reactions, fine ? &*fine : nullptr);
      if (!derivative)
        return "the derivative of the probe " + probe.name + " is not defined";
      for (unsigned int i = 0; i < derivative->loads.size(); ++i)
        goals.push_back({static_cast<unsigned int>(result.probes.size()),
                         std::move(derivative->loads[i]),
                         derivative->lacks[i],
                         {},
                         {}});
      ProbeError error;
      error.name = probe.name;
      error.tolerance = probe.tolerance;
      result.probes.push_back(error);
    }
  return "";
}

template <int dim>
std::string Estimator<dim>::solve(const Section &linear_solver)
{
  if (!enriched.assemble())
    return "a law is not defined at a point of elements of one degree more";
  const auto groups = dual_groups(enriched);
  const unsigned int n_groups = groups.size();
  LinearSolver solver(linear_solver, groups, LinearSolver::Choice::by_entries);
  solver.set_matrix(enriched.system().tangent());
  for (Goal &goal : goals) {
    goal.z = enriched.system().owned_vector();
    if (!solver.solve(goal.z, enriched.condensed(goal.load), {0, n_groups, exactness_of_weights}))
      return "its dual problem could not be solved";
    enriched.distribute(goal.z);
  }
  return "";
}

template <int dim>
std::string Estimator<dim>::weigh(ProbeErrors &result)
{
  std::vector<Vector> all_z;
  for (const Goal &goal : goals)
    all_z.push_back(enriched.system().ghosted(goal.z));
  const auto products = unconstrained_products(enriched.model(), enriched.t, enriched.ghosted_x(), all_z);
  if (!products)
    return "a law is not defined at a point of elements of one degree more";
  for (unsigned int g = 0; g < goals.size(); ++g)
    result.probes[goals[g].probe].errors.push_back(
        goals[g].lack + weigh(goals[g], products->residual, products->transposed[g]));
  return "";
}

/// @param product K^T z
template <int dim>
double Estimator<dim>::weigh(Goal &goal, const Vector &residual, const Vector &product) const
{
  Vector dual_residual = goal.load;
  dual_residual -= product;
  Vector weight = goal.z;
  weight -= enriched.raised(enriched.lowered(goal.z));
  const Vector free_residual = enriched.condensed(residual);
  goal.contributions = enriched.system().owned_vector();
  for (const Index dof : enriched.model().numbering->owned)
    goal.contributions(dof) = enriched.system().is_constrained(dof) ? dual_residual(dof) * move(dof)
                                                                    : -free_residual(dof) * weight(dof);
  goal.contributions.compress(dealii::VectorOperation::insert);
  return dual_residual * move - residual * goal.z;
}

/// 1 at the nodes whose trace the interface sees, in the enriched model.
template <int dim>
Vector Estimator<dim>::nodes_of(const Interface<dim> &interface) const
{
  Vector nodes = enriched.system().owned_vector();
  std::vector<Index> dofs;
  for (const auto &group : interface.pairing().groups) {
    interface.group_dofs(group, dofs);
    const std::vector<bool> in_jump = interface.unknowns_in_jump(group);
    for (unsigned int i = 0; i < dofs.size(); ++i)
      if (in_jump[i])
        nodes(dofs[i]) += 1;
  }
  nodes.compress(dealii::VectorOperation::add);
  return nodes;
}

/// The shares of interfaces and cells in the contributions of all goals.
template <int dim>
void Estimator<dim>::share(ProbeErrors &result)
{
  const auto &interfaces = enriched.model().interfaces;
  std::vector<Vector> nodes;
  for (const auto &interface : interfaces)
    nodes.push_back(nodes_of(*interface));
  std::vector<double> sums(result.probes.size(), 0.), of_interfaces(sums.size() * interfaces.size(), 0.);
  for (Goal &goal : goals)
    for (const Index dof : enriched.model().numbering->owned) {
      const double size = std::abs(goal.contributions(dof));
      goal.contributions(dof) = size;
      sums[goal.probe] += size;
      for (unsigned int i = 0; i < nodes.size(); ++i)
        if (nodes[i](dof) > 0)
          of_interfaces[goal.probe * nodes.size() + i] += size;
    }
  dealii::Utilities::MPI::sum(sums, model.communicator, sums);
  dealii::Utilities::MPI::sum(of_interfaces, model.communicator, of_interfaces);
  for (unsigned int p = 0; p < result.probes.size(); ++p)
    for (unsigned int i = 0; i < interfaces.size(); ++i)
      result.probes[p].interfaces[interfaces[i]->name] =
          sums[p] > 0 ? of_interfaces[p * nodes.size() + i] / sums[p] : 0.;

  for (const auto &domain : model.domains)
    result.cells.squares.emplace_back(domain->mesh().n_active_cells(), 0.);
  for (Goal &goal : goals) {
    goal.contributions.compress(dealii::VectorOperation::insert);
    const ProbeError &probe = result.probes[goal.probe];
    result.cells.relative = std::max(result.cells.relative, probe.relative);
    const double unit = std::max(probe.tolerance * length(probe.values), 1e-12 * sums[goal.probe]);
    if (!probe.is_reached())
      add_to_cells(enriched.system().ghosted(goal.contributions), unit, result.cells);
  }
}

/// Each node's size in equal parts to the cells that have it.
template <int dim>
void Estimator<dim>::add_to_cells(const Vector &sizes, const double unit, ErrorEstimate &cells) const
{
  const auto visit = [this](const auto &action) {
    std::vector<Index> dofs;
    for (unsigned int d = 0; d < model.domains.size(); ++d) {
      const Domain<dim> &domain = *enriched.model().domains[d];
      for (const auto &cell : domain.dof_handler().active_cell_iterators())
        if (cell->is_locally_owned()) {
          domain.cell_dofs(cell, dofs);
          for (const Index dof : dofs)
            action(d, cell->active_cell_index(), dof);
        }
    }
  };
  Vector n_cells = enriched.system().owned_vector();
  visit([&](const unsigned int, const unsigned int, const Index dof) { n_cells(dof) += 1; });
  n_cells.compress(dealii::VectorOperation::add);
  const Vector all_n_cells = enriched.system().ghosted(n_cells);
  visit([&](const unsigned int d, const unsigned int cell, const Index dof) {
    cells.squares[d][cell] += sizes(dof) / (all_n_cells(dof) * unit);
  });
}

} // namespace

std::vector<double> ProbeError::corrected_values() const
{
  std::vector<double> result(values.size());
  std::transform(values.begin(), values.end(), errors.begin(), result.begin(), std::plus<>());
  return result;
}

CorrectedValues ProbeErrors::corrected_values() const
{
  CorrectedValues result;
  for (const ProbeError &probe : probes)
    result[probe.name] = probe.corrected_values();
  return result;
}

bool ProbeErrors::are_reached() const
{
  return failure.empty() && std::all_of(probes.begin(), probes.end(),
                                        [](const ProbeError &probe) { return probe.is_reached(); });
}

nlohmann::ordered_json ProbeErrors::errors() const
{
  auto result = nlohmann::ordered_json::object();
  for (const ProbeError &probe : probes)
    result[probe.name] = number_or_list(probe.errors);
  return result;
}

nlohmann::ordered_json ProbeErrors::estimates() const
{
  auto result = nlohmann::ordered_json::object();
  for (const ProbeError &probe : probes)
    result[probe.name] = {{"relative error", probe.relative},
                          {"tolerance", probe.tolerance},
                          {"reached", probe.is_reached()},
                          {"corrected value", number_or_list(probe.corrected_values())},
                          {"change of corrected value", probe.change},
                          {"share of interfaces", probe.interfaces}};
  return result;
}

template <int dim>
ProbeErrors estimate_probe_errors(const Model<dim> &model, BlockSystem<dim> &system,
                                  const Probes<dim> &probes, const Section &linear_solver, const Vector &x,
                                  const double t, const CorrectedValues &earlier)
{
  ProbeErrors result;
  const Vector ghosted = system.ghosted(x);
  const NodalForces<dim> forces = system.nodal_forces(x);
  system.find_multipliers(x, forces);
  const Reactions<dim> reactions(model, forces, ghosted);
  Estimator<dim> estimator(model, system, x, t);
  for (const auto &step : std::vector<std::function<std::string()>>{
           [&]() { return estimator.find_loads(probes, reactions, result); },
           [&]() { return estimator.solve(linear_solver); }, [&]() { return estimator.weigh(result); }})
    if (result.failure = step(); !result.failure.empty())
      return result;
  auto error = result.probes.begin();
  for (const auto &probe : probes.all())
    if (probe.tolerance > 0) {
      error->values = Probes<dim>::evaluate(probe, ghosted, reactions);
      if (const auto before = earlier.find(probe.name); before != earlier.end()) {
        std::vector<double> change = error->corrected_values();
        std::transform(change.begin(), change.end(), before->second.begin(), change.begin(), std::minus<>());
        error->change = length(change);
      }
      const double estimate = std::max(length(error->errors), error->change), value = length(error->values);
      error->relative = estimate > 0 ? estimate / value : 0;
      ++error;
    }
  estimator.share(result);
  return result;
}

template ProbeErrors estimate_probe_errors(const Model<2> &, BlockSystem<2> &, const Probes<2> &,
                                           const Section &, const Vector &, double, const CorrectedValues &);
template ProbeErrors estimate_probe_errors(const Model<3> &, BlockSystem<3> &, const Probes<3> &,
                                           const Section &, const Vector &, double, const CorrectedValues &);

} // namespace dovetail
