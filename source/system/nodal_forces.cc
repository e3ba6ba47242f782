// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_terms.h>
#include <dovetail/system/affine_residual.h>
#include <dovetail/system/nodal_forces.h>

#include <deal.II/base/mpi.h>

#include <boost/scope_exit.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <utility>

namespace dovetail {

namespace {

using Index = dealii::types::global_dof_index;

/// Whether a vertex of the cell lies on the boundary: only then conditions and ties may hold its nodes.
template <int dim>
std::vector<bool> vertices_at_boundary(const Domain<dim> &domain)
{
  std::vector<bool> at_boundary(domain.mesh().n_vertices(), false);
  for (const auto &[cell, face, id] : domain.boundary_faces())
    for (unsigned int v = 0; v < cell->face(face)->n_vertices(); ++v)
      at_boundary[cell->face(face)->vertex_index(v)] = true;
  return at_boundary;
}

/// Of each vector, over all ranks.
std::vector<double> largest_entries(const std::vector<const Vector *> &vectors, const MPI_Comm &communicator)
{
  std::vector<double> largest;
  for (const Vector *vector : vectors) {
    largest.push_back(0);
    for (unsigned int b = 0; b < vector->n_blocks(); ++b)
      for (const double entry : vector->block(b))
        largest.back() = std::max(largest.back(), std::abs(entry));
  }
  dealii::Utilities::MPI::max(largest, communicator, largest);
  return largest;
}

} // namespace

template <int dim>
NodalForces<dim>::NodalForces(const Model<dim> &model, const std::shared_ptr<const ConstraintLines> &lines,
                              const dealii::AffineConstraints<double> &constraints, const Vector &solution,
                              const double t, const Rates &rates, AffineResidual<dim> *products,
                              std::vector<std::optional<Flows>> given_flows,
                              const std::shared_ptr<const GhostExchange> &exchange)
    : t(t), rates(rates), exchange(exchange), model(model), lines(lines), constraints(constraints),
      all_given(std::move(given_flows))
{
  SharedSums residual;
  residual.begin(*exchange);
  if (products != nullptr)
    take_from(*products, solution, residual);
  for (const auto &domain : model.domains)
    if (products == nullptr)
      add_cells(*domain, solution, residual);
  for (const auto &interface : model.interfaces) {
    transmissions.try_emplace(interface.get());
    if (interface->is_active(t) && products == nullptr) {
      if (interface->tie().parts().point_terms != nullptr)
        add_groups(*interface, solution, residual);
      add_terms(*interface, solution, residual);
    }
  }
  Vector of_constrained(model.numbering->split(model.numbering->owned), model.communicator);
  residual.finish(of_constrained);
  force = passed_on(of_constrained);
  is_defined = dealii::Utilities::MPI::min(is_defined ? 1 : 0, model.communicator) == 1;
  const double undefined = std::numeric_limits<double>::quiet_NaN();
  if (!is_defined)
    for (auto &[interface, list] : transmissions)
      for (Transmission &transmission : list)
        transmission.influx = {{undefined, undefined}};
}

template <int dim>
void NodalForces<dim>::take_from(AffineResidual<dim> &products, const Vector &solution, SharedSums &residual)
{
  for (const auto &entry : *lines)
    residual(entry.first) = products.residual()(entry.first);
  for (const auto &interface : model.interfaces)
    transmissions[interface.get()] = products.transmissions(*interface, solution);
  for (unsigned int d = 0; d < model.domains.size(); ++d)
    cell_flows.push_back({products.loads(d, solution), products.stored(d)});
}

template <int dim>
void NodalForces<dim>::add_at_constrained(const std::vector<Index> &dofs, const std::vector<double> &values,
                                          SharedSums &residual) const
{
  for (unsigned int i = 0; i < dofs.size(); ++i)
    if (values[i] != 0 && constraints.is_constrained(dofs[i]))
      residual(dofs[i]) += values[i];
}

template <int dim>
void NodalForces<dim>::add_cells(const Domain<dim> &domain, const Vector &solution, SharedSums &residual)
{
  const std::vector<bool> at_boundary = vertices_at_boundary(domain);
  const bool has_hanging_nodes = domain.mesh().has_hanging_nodes();
  CellTerms<dim> terms(domain);
  terms.set_rates(&rates);
  std::vector<Index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell()), cell_forces(unknowns.size());
  for (const auto &cell : domain.dof_handler().active_cell_iterators()) {
    if (!cell->is_locally_owned())
      continue;
    const auto vertices = cell->vertex_indices();
    if (!has_hanging_nodes && std::none_of(vertices.begin(), vertices.end(), [&](const unsigned int v) {
          return at_boundary[cell->vertex_index(v)];
        }))
      continue;
    domain.cell_dofs(cell, dofs);
    if (std::none_of(dofs.begin(), dofs.end(),
                     [this](const Index dof) { return constraints.is_constrained(dof); }))
      continue;
    solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    is_defined = terms.assemble(cell, t, unknowns, cell_forces, nullptr) && is_defined;
    add_at_constrained(dofs, cell_forces, residual);
  }
}

template <int dim>
void NodalForces<dim>::add_groups(const Interface<dim> &interface, const Vector &solution,
                                  SharedSums &residual)
{
  PointTerms<dim> &terms = *interface.tie().parts().point_terms;
  std::vector<Index> dofs;
  std::vector<double> unknowns, group_forces;
  for (const auto &group : interface.pairing().groups) {
    interface.group_dofs(group, dofs);
    unknowns.resize(dofs.size());
    solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    group_forces.assign(dofs.size(), 0.);
    is_defined = terms.assemble(interface, group, t, unknowns, group_forces, nullptr) && is_defined;
    add_at_constrained(dofs, group_forces, residual);
    for (unsigned int f = 0; f < interface.fields.size(); ++f)
      for (unsigned int c = 0; c < interface.fields[f].n_components; ++c) {
        Transmission sum = {f, c, {{0, 0}}};
        for (const unsigned int side : {source, destination}) {
          const unsigned int component = interface.fields[f].first_component[side] + c;
          const auto first = group_forces.begin() + interface.first_unknown(side, component);
          for (unsigned int a = 0; a < interface.fields[f].n_nodes[side]; ++a)
            sum.influx[side] -= first[a];
        }
        transmissions[&interface].push_back(sum);
      }
  }
}

template <int dim>
void NodalForces<dim>::add_terms(const Interface<dim> &interface, const Vector &solution,
                                 SharedSums &residual) const
{
  const Multipliers<dim> *multipliers = interface.tie().parts().multipliers;
  std::vector<double> unknowns, term_forces;
  for (unsigned int i = 0; multipliers != nullptr && i < multipliers->n_terms(); ++i) {
    const std::vector<Index> &dofs = multipliers->term_dofs(i);
    unknowns.resize(dofs.size());
    solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    term_forces.assign(dofs.size(), 0.);
    multipliers->assemble_term(i, unknowns, term_forces, nullptr);
    add_at_constrained(dofs, term_forces, residual);
  }
}

/// r = R + C^T r; a line may follow another one.
template <int dim>
Vector NodalForces<dim>::passed_on(const Vector &residual) const
{
  Vector total = residual, previous = residual;
  SharedSums passed;
  const unsigned int longest_chain = 100;
  for (unsigned int link = 0; link < longest_chain; ++link) {
    passed.begin(*exchange);
    for (const auto &[dof, line] : *lines) {
      const double constrained_force = line.entries.empty() ? 0. : total(dof);
      for (const auto &[other, weight] : line.entries)
        passed(other) += weight * constrained_force;
    }
    previous = total;
    passed.finish(total);
    total += residual;
    previous -= total;
    const std::vector<double> largest = largest_entries({&previous, &total}, model.communicator);
    if (!(largest[0] > 1e-15 * largest[1]))
      break;
  }
  return total;
}

template <int dim>
Vector NodalForces<dim>::extended(const Vector &w) const
{
  dealii::IndexSet needed = model.numbering->owned;
  for (const auto &entry : *lines)
    for (const auto &[other, weight] : entry.second.entries)
      needed.add_index(other);
  needed.compress();
  Vector total = w, change = w,
         seen(model.numbering->split(model.numbering->owned), model.numbering->split(needed),
              model.communicator);
  const unsigned int longest_chain = 100;
  for (unsigned int link = 0; link < longest_chain; ++link) {
    seen = total;
    change = total;
    total = w;
    for (const auto &[dof, line] : *lines)
      for (const auto &[other, weight] : line.entries)
        total(dof) += weight * seen(other);
    total.compress(dealii::VectorOperation::add);
    change -= total;
    if (!(change.linfty_norm() > 1e-15 * total.linfty_norm()))
      break;
  }
  return total;
}

template <int dim>
void NodalForces<dim>::add(const std::vector<std::pair<Index, double>> &pushes)
{
  Vector pushed(model.numbering->split(model.numbering->owned), model.communicator);
  for (const auto &[dof, value] : pushes)
    pushed(dof) += value;
  pushed.compress(dealii::VectorOperation::add);
  force += passed_on(pushed);
}

template <int dim>
bool NodalForces<dim>::is_fixed(const Index dof) const
{
  const auto *entries = constraints.get_constraint_entries(dof);
  return constraints.is_constrained(dof) && (entries == nullptr || entries->empty());
}

/// Of a state that has come from a larger one: x = x_old + dx has the rounding of x_old, which the rates
/// know.
template <int dim>
void NodalForces<dim>::magnitudes(const Vector &solution, const std::vector<Index> &dofs,
                                  std::vector<double> &sizes) const
{
  sizes.resize(dofs.size());
  solution.extract_subvector_to(dofs.begin(), dofs.end(), sizes.begin());
  for (double &size : sizes)
    size = std::abs(size);
  std::vector<double> rest(dofs.size());
  const auto add = [&](const Vector &rests, const double by_value) {
    if (by_value == 0 || rests.n_blocks() == 0)
      return;
    rests.extract_subvector_to(dofs.begin(), dofs.end(), rest.begin());
    for (unsigned int i = 0; i < dofs.size(); ++i)
      sizes[i] = std::max(sizes[i], std::abs(rest[i] / by_value));
  };
  // what only second rates see has none by value, and the state before may cancel in the second rest
  add(rates.rest, rates.by_value != 0 ? rates.by_value : std::sqrt(rates.second_by_value));
  add(rates.second_rest, rates.second_by_value);
}

/// Constrained bodies bring the rounding of their own body with them.
template <int dim>
double NodalForces<dim>::rounding(const Domain<dim> &domain, const Field &field, const Vector &solution) const
{
  std::set<std::pair<const Domain<dim> *, std::string>> fields = {{&domain, field.name}};
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (const auto &interface : model.interfaces)
      for (const TiedField &tied : interface->fields)
        if (interface->is_active(t) && interface->tie().parts().elimination != nullptr &&
            fields.count({interface->sides[source].domain, tied.names[source]}) > 0)
          is_new =
              fields.emplace(interface->sides[destination].domain, tied.names[destination]).second || is_new;
  }
  double of_cells = 0, of_groups = 0;
  for (const auto &body : model.domains)
    for (const Field &its : body->fields())
      if (fields.count({body.get(), its.name}) > 0) {
        of_cells += rounding_of_cells(*body, its, solution);
        of_groups += rounding_of_groups(*body, its, solution);
      }
  return 1e-15 * (of_cells + dealii::Utilities::MPI::sum(of_groups, model.communicator));
}

namespace {

/// Of so many cells in all: about 200, and the same ones whichever ranks own them.
template <typename Cell>
bool is_in_sample(const Cell &cell, const std::uint64_t n_cells)
{
  const std::uint64_t size = 200, factor = 0x9e3779b97f4a7c15; // of the golden section
  const dealii::CellId id = cell->id();                        // the indices of its children are part of it
  std::uint64_t number = id.get_coarse_cell_id();
  for (const auto child : id.get_child_indices())
    number = number * factor + child + 1;
  return n_cells < 2 * size || ((number * factor) >> 32) % (n_cells / size) == 0;
}

/// Lets @p terms find sizes of products in the rows of a field, by the terms at points or by entries.
template <int dim>
void ask_for_sizes(const Field &field, const bool by_entries, const std::vector<double> &sizes,
                   CellTerms<dim> &terms)
{
  std::vector<Asked> asked;
  for (const Field &other : terms.body().fields()) {
    asked.push_back(other.name == field.name ? Asked::derivatives : Asked::nothing);
    if (!by_entries)
      terms.leave_out_coupling(field, other);
  }
  terms.ask_for(asked);
  terms.size_products_by(sizes);
}

/// sum_j |K_ij| sizes_j of a field's rows: of entries, and of what the terms at points have given without
/// any.
template <int dim>
double sum_of_sizes(const CellTerms<dim> &terms, const Field &field,
                    const dealii::FullMatrix<double> &entries, const std::vector<double> &sizes)
{
  const CellLayout<dim> &layout = terms.body().layout();
  double sum = 0;
  for (unsigned int i = layout.first(field.first_component);
       i < layout.first(field.first_component + field.n_components); ++i) {
    sum += terms.products().empty() ? 0 : terms.products()[i];
    for (unsigned int j = 0; j < sizes.size(); ++j)
      sum += std::abs(entries(i, j)) * sizes[j];
  }
  return sum;
}

} // namespace

/// All cells are summed up by the terms at their points, where nothing cancels, and a sample of them says how
/// much less the entries are. On all ranks.
template <int dim>
double NodalForces<dim>::rounding_of_cells(const Domain<dim> &domain, const Field &field,
                                           const Vector &solution) const
{
  const std::uint64_t n_cells = domain.mesh().n_global_active_cells();
  CellTerms<dim> terms(domain), terms_with_entries(domain);
  dealii::FullMatrix<double> tangent(domain.dofs_per_cell(), domain.dofs_per_cell());
  std::vector<Index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell()), residual(unknowns.size()), sizes;
  for (CellTerms<dim> *cells : {&terms, &terms_with_entries}) {
    cells->set_rates(&rates);
    ask_for_sizes(field, cells == &terms_with_entries, sizes, *cells);
  }
  double of_all = 0, of_sample = 0, entries_of_sample = 0;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
      magnitudes(solution, dofs, sizes);
      tangent = 0; // but for what conditions and forces by position add
      if (!terms.assemble(cell, t, unknowns, residual, &tangent))
        continue;
      const double of_cell = sum_of_sizes(terms, field, tangent, sizes);
      of_all += of_cell;
      if (!is_in_sample(cell, n_cells) || !terms_with_entries.assemble(cell, t, unknowns, residual, &tangent))
        continue;
      of_sample += of_cell;
      entries_of_sample += sum_of_sizes(terms_with_entries, field, tangent, sizes);
    }
  for (double *sum : {&of_all, &of_sample, &entries_of_sample})
    *sum = dealii::Utilities::MPI::sum(*sum, model.communicator);
  return of_sample > 0 ? of_all * (entries_of_sample / of_sample) : of_all;
}

template <int dim>
double NodalForces<dim>::rounding_of_groups(const Domain<dim> &domain, const Field &field,
                                            const Vector &solution) const
{
  double sum = 0;
  for (const auto &interface : model.interfaces)
    if (interface->tie().parts().point_terms != nullptr && interface->is_active(t) &&
        std::any_of(interface->sides.begin(), interface->sides.end(),
                    [&](const auto &side) { return side.domain == &domain; }))
      for (const TiedField &tied : interface->fields)
        if (tied.ties(field.name))
          sum += sum_of_groups(*interface, tied, solution);
  return sum;
}

/// In the rows of a tied field.
template <int dim>
double NodalForces<dim>::sum_of_groups(const Interface<dim> &interface, const TiedField &tied,
                                       const Vector &solution) const
{
  double sum = 0;
  std::vector<Index> dofs;
  std::vector<double> unknowns, residual, sizes;
  dealii::FullMatrix<double> tangent;
  PointTerms<dim> &terms = *interface.tie().parts().point_terms;
  std::vector<Asked> asked(interface.fields.size(), Asked::nothing);
  asked[tied.index] = Asked::derivatives;
  BOOST_SCOPE_EXIT_ALL(&terms)
  {
    terms.ask_for({});
  };
  terms.ask_for(asked);
  for (const auto &group : interface.pairing().groups) {
    interface.group_dofs(group, dofs);
    unknowns.resize(dofs.size());
    solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    magnitudes(solution, dofs, sizes);
    const LeadingUnknowns *known = terms.leading_unknowns(interface, group);
    const LeadingUnknowns &leading = known != nullptr ? *known : interface.all_unknowns();
    residual.assign(leading.size(), 0.);
    tangent.reinit(leading.size(), leading.size());
    if (!terms.assemble_leading(interface, group, t, unknowns, residual, &tangent))
      continue;
    const std::vector<double> products = leading.sizes_of_products(tangent, sizes);
    for (const unsigned int side : {source, destination}) {
      const auto first = products.begin() + interface.first_unknown(side, tied.first_component[side]);
      sum += std::accumulate(first, first + tied.n_components * tied.n_nodes[side], 0.);
    }
  }
  return sum;
}

template class NodalForces<2>;
template class NodalForces<3>;

} // namespace dovetail
