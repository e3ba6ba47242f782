// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/cost_estimate.h>

#include <dovetail/domain/cell_terms.h>
#include <dovetail/domain/weak_penalties.h>
#include <dovetail/output/phases.h>
#include <dovetail/run/initial_values.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/timer.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <set>

namespace dovetail {

namespace {

// Measured on tied blocks, in seconds or in units of seconds_per_entry().
const unsigned int newton_iterations = 4; ///< of a nonlinear step
const double setup_of_entry = 100;        ///< pattern and matrix
const double bytes_of_entry = 14;
const double scatter_of_entry = 60; ///< in an assembly
const double seconds_of_output = 0.03, seconds_of_unknown_in_output = 1.2e-6;
const double seconds_of_pair_at_point = 3e-9, seconds_of_point = 1e-5;
const unsigned int n_samples = 16;  ///< cells of a body
const double longest_sample = 0.01; ///< seconds of a body

/// Of a product with a sparse matrix, of many unknowns one that is larger than the caches.
double seconds_per_entry(const unsigned int n_unknowns)
{
  const unsigned int n_rows = std::min(40000u, std::max(4000u, n_unknowns)), n_of_row = 27;
  const std::vector<double> entries(n_rows * n_of_row, 1.), x(n_rows, 1.);
  std::vector<int> columns;
  columns.reserve(entries.size());
  for (unsigned int i = 0; i < n_rows; ++i)
    for (unsigned int k = 0; k < n_of_row; ++k)
      columns.push_back((i + k * 743) % n_rows);
  std::vector<double> y(n_rows);
  double seconds = std::numeric_limits<double>::infinity();
  for (unsigned int repeat = 0; repeat < 3; ++repeat) {
    dealii::Timer timer;
    for (unsigned int i = 0; i < n_rows; ++i) {
      double sum = 0;
      for (unsigned int k = 0; k < n_of_row; ++k)
        sum += entries[i * n_of_row + k] * x[columns[i * n_of_row + k]];
      y[i] += sum;
    }
    seconds = std::min(seconds, timer.wall_time());
  }
  return y[0] > 0 ? seconds / entries.size() : 0;
}

/// Some cells of this rank, spread over the body.
template <int dim>
std::vector<typename Domain<dim>::cell_iterator> sample_cells(const Domain<dim> &domain)
{
  const double n_own = domain.mesh().n_locally_owned_active_cells(), golden = (std::sqrt(5.) - 1) / 2;
  std::set<unsigned int> chosen; // without a period, which cells may have
  for (unsigned int k = 1; k <= n_samples; ++k)
    chosen.insert(n_own * std::fmod(k * golden, 1.));
  std::vector<typename Domain<dim>::cell_iterator> cells;
  unsigned int i = 0;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned() && chosen.count(i++) > 0)
      cells.push_back(cell);
  return cells;
}

/// The cells around one: those that share a vertex with it.
template <int dim>
std::vector<typename Domain<dim>::cell_iterator>
cells_around(const typename Domain<dim>::cell_iterator &middle)
{
  std::set<unsigned int> vertices;
  for (const unsigned int v : middle->vertex_indices())
    vertices.insert(middle->vertex_index(v));
  std::vector<typename Domain<dim>::cell_iterator> cells = {middle};
  for (unsigned int i = 0; i < cells.size(); ++i)
    for (const unsigned int f : cells[i]->face_indices()) {
      if (cells[i]->at_boundary(f) || !cells[i]->neighbor(f)->is_active() ||
          cells[i]->neighbor(f)->is_artificial())
        continue;
      const typename Domain<dim>::cell_iterator next = cells[i]->neighbor(f);
      const auto corners = next->vertex_indices();
      if (std::find(cells.begin(), cells.end(), next) == cells.end() &&
          std::any_of(corners.begin(), corners.end(),
                      [&](const unsigned int v) { return vertices.count(next->vertex_index(v)) > 0; }))
        cells.push_back(next);
    }
  return cells;
}

/// [f][g]: with how many nodes of field g of its body a node of field f shares a cell, on the mean over those
/// of the samples of all ranks. A node that several cells share is met as often. Collective.
template <int dim>
std::vector<std::vector<double>>
count_neighbours(const Domain<dim> &domain, const std::vector<typename Domain<dim>::cell_iterator> &samples,
                 const MPI_Comm &communicator)
{
  const CellLayout<dim> &layout = domain.layout();
  const auto &fields = domain.fields();
  const unsigned int n_fields = fields.size();
  const auto first = [&](const unsigned int f) { return layout.first(fields[f].first_component); };
  const auto n_nodes = [&](const unsigned int f) { return layout.n_nodes(fields[f].first_component); };
  std::vector<double> sums(n_fields * n_fields, 0.), weights(n_fields, 0.);
  std::vector<dealii::types::global_dof_index> own;
  for (const auto &cell : samples) {
    domain.cell_dofs(cell, own);
    std::vector<std::vector<dealii::types::global_dof_index>> around;
    for (const auto &other : cells_around<dim>(cell))
      domain.cell_dofs(other, around.emplace_back());
    for (unsigned int f = 0; f < n_fields; ++f)
      for (unsigned int a = 0; a < n_nodes(f); ++a) {
        std::vector<std::set<dealii::types::global_dof_index>> neighbours(n_fields);
        unsigned int n_cells = 0;
        for (const auto &dofs : around) {
          const auto begin = dofs.begin() + first(f), end = begin + n_nodes(f);
          if (std::find(begin, end, own[first(f) + a]) == end)
            continue;
          ++n_cells;
          for (unsigned int g = 0; g < n_fields; ++g)
            neighbours[g].insert(dofs.begin() + first(g), dofs.begin() + first(g) + n_nodes(g));
        }
        weights[f] += 1. / n_cells;
        for (unsigned int g = 0; g < n_fields; ++g)
          sums[f * n_fields + g] += static_cast<double>(neighbours[g].size()) / n_cells;
      }
  }
  dealii::Utilities::MPI::sum(sums, communicator, sums);
  dealii::Utilities::MPI::sum(weights, communicator, weights);
  std::vector<std::vector<double>> result(n_fields, std::vector<double>(n_fields, 0.));
  for (unsigned int f = 0; f < n_fields; ++f)
    for (unsigned int g = 0; g < n_fields && weights[f] > 0; ++g)
      result[f][g] = sums[f * n_fields + g] / weights[f];
  return result;
}

/// One assembly of the cells of this rank, with the tangent or without, at a ghosted state @p x.
template <int dim>
double seconds_of_cells(Domain<dim> &domain, const std::vector<typename Domain<dim>::cell_iterator> &samples,
                        const double t, const Vector &x, const bool has_entries)
{
  const auto values_of = [&x](const std::vector<dealii::types::global_dof_index> &dofs,
                              std::vector<double> &values) {
    values.resize(dofs.size());
    x.extract_subvector_to(dofs.begin(), dofs.end(), values.begin());
  };
  freeze_weak_penalties<dim>(domain, t, values_of);
  CellTerms<dim> terms(domain);
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns, residual(domain.dofs_per_cell());
  dealii::FullMatrix<double> tangent(domain.dofs_per_cell());
  std::vector<double> seconds;
  dealii::Timer all;
  for (unsigned int i = 0; i < samples.size() && (seconds.size() < 2 || all.wall_time() < longest_sample);
       ++i) {
    domain.cell_dofs(samples[i], dofs);
    values_of(dofs, unknowns);
    dealii::Timer one;
    if (terms.assemble(samples[i], t, unknowns, residual, has_entries ? &tangent : nullptr))
      seconds.push_back(one.wall_time());
  }
  if (seconds.empty())
    return 0;
  std::nth_element(seconds.begin(), seconds.begin() + seconds.size() / 2, seconds.end());
  const double of_products = has_entries ? 1 : 2; // derivatives at points in place of a matrix
  return of_products * seconds[seconds.size() / 2] * domain.mesh().n_locally_owned_active_cells();
}

/// One assembly of the points of this rank.
template <int dim>
double seconds_of_interfaces(const Model<dim> &model)
{
  double seconds = 0;
  for (const auto &interface : model.interfaces) {
    const double n_local = interface->n_local(source) + interface->n_local(destination);
    double n_points = 0;
    for (const auto &group : interface->pairing().groups)
      n_points += group.end - group.begin;
    seconds += n_points * (seconds_of_point + n_local * n_local * seconds_of_pair_at_point);
  }
  return seconds;
}

/// The unknowns of a field of a body and their entries in the matrix of its group.
template <int dim>
void add_to(GroupSize &size, const Block &block, const Domain<dim> &domain,
            const std::vector<std::vector<double>> &neighbours, const std::vector<std::string> &group)
{
  const auto &fields = domain.fields();
  const unsigned int f = block.field_index;
  const double n_unknowns = block.end - block.begin;
  size.n_unknowns += n_unknowns;
  if (fields[f].n_components > 1)
    size.n_modes = dim == 2 ? 3 : 6;
  for (unsigned int g = 0; g < fields.size(); ++g)
    if (std::find(group.begin(), group.end(), fields[g].name) != group.end() &&
        (f == g || domain.material.depends(f, g)))
      size.n_entries += n_unknowns * neighbours[f][g] * fields[g].n_components;
}

std::string two_digits(const double number)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.2g", number);
  return number >= 99.5 ? std::to_string(std::lround(number)) : text;
}

} // namespace

std::string CostEstimate::in_words() const
{
  return two_digits(total()) + " s for " + std::to_string(n_steps) + (n_steps == 1 ? " step" : " steps") +
         (n_iterations > 1 ? " of " + std::to_string(n_iterations) + " Newton iterations" : "") + " (setup " +
         two_digits(setup) + ", assembly " + two_digits(assembly) + ", solve " +
         (knows_solver ? two_digits(solve) : "unknown") + ", output " + two_digits(output) + "), " +
         two_digits(memory) + " MiB";
}

template <int dim>
CostEstimate estimate_cost(const Model<dim> &model, const LinearSolver &solver, const Steps &steps)
{
  const MPI_Comm &communicator = model.communicator;
  const double memory_before = dealii::Utilities::MPI::sum(peak_memory_of_process(), communicator),
               n_ranks = dealii::Utilities::MPI::n_mpi_processes(communicator),
               unit = seconds_per_entry(model.numbering->n_dofs());
  const bool is_linear = model.is_linear(), is_constant = is_linear && model.has_constant_tangent();
  CostEstimate result;
  result.n_steps = steps.n_steps;
  result.n_iterations = is_linear ? 1 : newton_iterations;
  const double n_solves = result.n_steps * result.n_iterations, n_tangents = is_constant ? 1 : n_solves;
  const auto groups = model.field_groups();
  const std::vector<bool> needs_entries = solver.needs_entries();

  Vector x(model.numbering->split(model.numbering->owned), communicator);
  set_initial_values(model, steps.size(), x);
  Vector ghosted(model.numbering->split(model.numbering->owned),
                 model.numbering->split(model.numbering->relevant), communicator);
  ghosted = x;
  std::vector<GroupSize> sizes(groups.size());
  const bool has_entries = std::find(needs_entries.begin(), needs_entries.end(), true) != needs_entries.end();
  std::vector<std::vector<std::vector<double>>> neighbours; // by domain
  double assembly = seconds_of_interfaces(model);
  for (const auto &domain : model.domains) {
    const auto samples = sample_cells(*domain);
    assembly += seconds_of_cells(*domain, samples, steps.size(), ghosted, has_entries);
    neighbours.push_back(count_neighbours(*domain, samples, communicator));
  }
  for (const Block &block : model.numbering->blocks())
    for (unsigned int g = 0; g < groups.size() && !block.is_of_multipliers; ++g)
      if (std::find(groups[g].begin(), groups[g].end(), block.field) != groups[g].end())
        add_to(sizes[g], block, *model.domains[block.domain_index], neighbours[block.domain_index],
               groups[g]);

  result.assembly = n_tangents * assembly;
  double bytes = 0;
  for (unsigned int g = 0; g < groups.size(); ++g) {
    GroupSize &size = sizes[g];
    const double n_kept = needs_entries[g] ? size.n_entries : size.n_entries / 10;
    result.setup += setup_of_entry * unit * n_kept / n_ranks;
    result.assembly += n_tangents * scatter_of_entry * unit * n_kept / n_ranks;
    bytes += bytes_of_entry * n_kept;
    result.n_entries += size.n_entries;
    const auto cost = solver.expected_cost(g, size);
    result.knows_solver = result.knows_solver && cost.has_value();
    if (cost) {
      result.solve += (n_tangents * cost->prepare + n_solves * cost->solve) * unit / n_ranks;
      bytes += cost->bytes;
    }
  }
  result.output = (steps.n_steps + 1) *
                  (seconds_of_output + seconds_of_unknown_in_output * model.numbering->n_dofs() / n_ranks);
  for (double *seconds : {&result.setup, &result.assembly, &result.solve, &result.output})
    *seconds = dealii::Utilities::MPI::max(*seconds, communicator);
  result.memory = memory_before + bytes / (1024 * 1024);
  return result;
}

template CostEstimate estimate_cost(const Model<2> &, const LinearSolver &, const Steps &);
template CostEstimate estimate_cost(const Model<3> &, const LinearSolver &, const Steps &);

} // namespace dovetail
