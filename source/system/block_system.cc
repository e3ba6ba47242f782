// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/block_system.h>

#include <dovetail/compatibility.h>
#include <dovetail/system/constraints.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/table.h>
#include <deal.II/base/timer.h>
#include <deal.II/lac/block_sparsity_pattern.h>
#include <deal.II/lac/sparsity_tools.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

/// As no field of a domain is called.
std::string name_of_multipliers(const std::string &interface, const std::string &field)
{
  return interface + " : " + field;
}

/// Leave each unknown once in @p dofs, sorted. A group of a body that is tied to itself may hold some twice,
/// which deal.II's constraints do not take.
/// @return for each of the former entries its position now; empty if nothing was there twice
template <int dim>
std::vector<unsigned int> merge_repeated(const Interface<dim> &interface,
                                         std::vector<dealii::types::global_dof_index> &dofs)
{
  if (interface.sides[source].domain != interface.sides[destination].domain)
    return {};
  std::vector<dealii::types::global_dof_index> sorted = dofs;
  std::sort(sorted.begin(), sorted.end());
  const auto end = std::unique(sorted.begin(), sorted.end());
  if (end == sorted.end())
    return {};
  sorted.erase(end, sorted.end());
  std::vector<unsigned int> position;
  for (const auto dof : dofs)
    position.push_back(std::lower_bound(sorted.begin(), sorted.end(), dof) - sorted.begin());
  dofs = sorted;
  return position;
}

} // namespace

template <int dim>
BlockSystem<dim>::BlockSystem(Model<dim> &model) : scatters_on(&update_constraints), model(model)
{
  for (const auto &group : model.field_groups())
    fields.insert(fields.end(), group.begin(), group.end());
  for (const Block &block : model.numbering->blocks()) {
    if (block.is_of_multipliers)
      fields.push_back(name_of_multipliers(block.name, block.field));
    field_of_block.push_back(
        std::find(fields.begin(), fields.end(), block.is_of_multipliers ? fields.back() : block.field) -
        fields.begin());
  }
  for (unsigned int f = 0; f < fields.size(); ++f)
    is_of_multipliers.push_back(false);
  for (unsigned int b = 0; b < field_of_block.size(); ++b)
    is_of_multipliers[field_of_block[b]] = model.numbering->blocks()[b].is_of_multipliers;
  for (const auto &domain : model.domains)
    cell_terms.push_back(std::make_unique<CellTerms<dim>>(*domain));
}

template <int dim>
std::vector<bool> BlockSystem<dim>::active_toggles(const double t) const
{
  std::vector<bool> active;
  for (const auto &domain : model.domains)
    for (const auto &condition : domain->conditions())
      active.push_back(condition->is_active(t));
  for (const auto &interface : model.interfaces)
    active.push_back(interface->is_active(t));
  return active;
}

template <int dim>
bool BlockSystem<dim>::is_outdated(const double t) const
{
  return active_toggles(t) != toggles_of_set_up;
}

template <int dim>
void BlockSystem<dim>::set_up(const double t)
{
  toggles_of_set_up = active_toggles(t);
  tie_lines.clear();
  hanging_lines.clear();
  if (!model.interfaces.empty()) {
    TieConstraints all;
    for (const auto &domain : model.domains)
      domain->add_constraints(t, all.lines);
    const ConstraintLines given = all.lines;
    for (const auto &[dof, line] : given)
      if (!line.entries.empty()) // prescribed values have none
        hanging_lines.emplace(dof, line);
    dealii::Timer timer;
    for (unsigned int i = 0; i < model.interfaces.size(); ++i)
      if (model.interfaces[i]->is_active(t)) {
        model.interfaces[i]->tie().add_constraints(*model.interfaces[i], all, model.communicator);
        for (const auto &[dof, line] : all.lines)
          if (given.count(dof) == 0 && tie_lines.emplace(dof, line).second)
            tie_lines.at(dof).tie = i;
      }
    tie_seconds += timer.wall_time();
  }

  time = t;
  make_relevant_set(t);
  make_constraints(lines_at(t));
  make_sparsity(t);
  right_hand_side = owned_vector();
  ghosted_scratch = ghosted_vector();
}

template <int dim>
void BlockSystem<dim>::make_relevant_set(const double t)
{
  relevant = model.numbering->relevant;
  std::vector<dealii::types::global_dof_index> dofs, all;
  for (const auto &interface : model.interfaces)
    for (const auto &group : interface->pairing().groups) {
      interface->group_dofs(group, dofs);
      all.insert(all.end(), dofs.begin(), dofs.end());
    }
  for (const auto &interface : model.interfaces)
    if (interface->is_active(t))
      for (unsigned int i = 0; i < interface->tie().n_terms(); ++i) {
        const auto &of_term = interface->tie().term_dofs(i);
        all.insert(all.end(), of_term.begin(), of_term.end());
      }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  relevant.add_indices(all.begin(), all.end());
  relevant.compress();
}

/// Of all constraints, for the unknowns that this rank owns.
template <int dim>
ConstraintLines BlockSystem<dim>::lines_at(const double t) const
{
  ConstraintLines lines;
  for (const auto &domain : model.domains)
    domain->add_constraints(t, lines);
  lines.insert(tie_lines.begin(), tie_lines.end());
  return lines;
}

/// Whether the constraints that are there prescribe the same values as lines that were made after the same
/// set_up, so that all else in them is the same.
template <int dim>
bool BlockSystem<dim>::are_prescribed(const ConstraintLines &lines) const
{
  const bool are_on_this_rank = std::all_of(lines.begin(), lines.end(), [this](const auto &entry) {
    const auto &[dof, line] = entry;
    return !line.entries.empty() ||
           (constraints.is_constrained(dof) && constraints.get_inhomogeneity(dof) == line.inhomogeneity);
  });
  return dealii::Utilities::MPI::min(are_on_this_rank ? 1 : 0, model.communicator) == 1;
}

template <int dim>
void BlockSystem<dim>::make_constraints(const ConstraintLines &lines)
{
  constraints.clear();
  freed.clear();
  constraints = close_constraints(lines, *model.numbering, relevant, model.communicator, &freed);
  update_constraints.clear();
  update_constraints.copy_from(constraints);
  relevant.add_indices(constraints.get_local_lines()); // those that lines refer to, too
  relevant.compress();
}

template <int dim>
void BlockSystem<dim>::make_sparsity(const double t)
{
  const auto relevant_parts = model.numbering->split(relevant);
  dealii::BlockDynamicSparsityPattern pattern(relevant_parts);
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &domain : model.domains) {
    const unsigned int n = domain->n_nodes();
    dealii::Table<2, bool> couples(domain->dofs_per_cell(), domain->dofs_per_cell());
    const auto &fields = domain->fields();
    bool all_couple = true;
    for (unsigned int f = 0; f < fields.size(); ++f)
      for (unsigned int g = 0; g < fields.size(); ++g) {
        const bool depends = domain->material.depends(f, g);
        all_couple = all_couple && depends;
        for (unsigned int i = 0; depends && i < fields[f].n_components * n; ++i)
          for (unsigned int j = 0; j < fields[g].n_components * n; ++j)
            couples(fields[f].first_component * n + i, fields[g].first_component * n + j) = true;
      }
    for (const auto &cell : domain->dof_handler().active_cell_iterators())
      if (cell->is_locally_owned()) {
        domain->cell_dofs(cell, dofs);
        if (all_couple)
          constraints.add_entries_local_to_global(dofs, pattern, false);
        else
          constraints.add_entries_local_to_global(dofs, pattern, false, couples);
      }
  }

  dealii::Timer timer;
  for (const auto &interface : model.interfaces)
    if (interface->is_active(t) && interface->tie().adds_terms()) {
      dealii::Table<2, bool> couples;
      bool all_couple = true;
      for (const auto &group : interface->pairing().groups) {
        interface->group_dofs(group, dofs);
        if (couples.n_rows() == 0) {
          couples.reinit(dofs.size(), dofs.size());
          std::vector<unsigned int> component; // of each local unknown, counted over both sides
          for (const unsigned int side : {source, destination})
            for (unsigned int k = 0; k < interface->components[side].size(); ++k)
              component.insert(component.end(), interface->sides[side].domain->n_nodes(),
                               k + (side == source ? 0 : interface->components[source].size()));
          for (unsigned int i = 0; i < dofs.size(); ++i)
            for (unsigned int j = 0; j < dofs.size(); ++j) {
              couples(i, j) = interface->couples(component[i], component[j]);
              all_couple = all_couple && couples(i, j);
            }
        }
        if (const auto position = merge_repeated(*interface, dofs); !position.empty()) {
          dealii::Table<2, bool> merged(dofs.size(), dofs.size());
          for (unsigned int i = 0; i < position.size(); ++i)
            for (unsigned int j = 0; j < position.size(); ++j)
              merged(position[i], position[j]) = merged(position[i], position[j]) || couples(i, j);
          constraints.add_entries_local_to_global(dofs, pattern, false, merged);
        } else if (all_couple) // faster
          constraints.add_entries_local_to_global(dofs, pattern, false);
        else
          constraints.add_entries_local_to_global(dofs, pattern, false, couples);
      }
    }
  for (const auto &interface : model.interfaces) {
    const Tie<dim> &tie = interface->tie();
    if (interface->is_active(t))
      for (unsigned int i = 0; i < tie.n_terms(); ++i)
        constraints.add_entries_local_to_global(tie.term_dofs(i), pattern, false);
    else
      for_each_multiplier(*interface, [&](const auto dof) { pattern.add(dof, dof); });
  }
  if (!model.interfaces.empty())
    tie_seconds += timer.wall_time();

  dealii::SparsityTools::distribute_sparsity_pattern(pattern, model.numbering->owned, model.communicator,
                                                     relevant);
  has_tangent = false;
  matrix.clear();
  matrix.reinit(model.numbering->split(model.numbering->owned), pattern, model.communicator, false);
}

template <int dim>
Vector BlockSystem<dim>::owned_vector() const
{
  return Vector(model.numbering->split(model.numbering->owned), model.communicator);
}

template <int dim>
Vector BlockSystem<dim>::ghosted_vector() const
{
  return Vector(model.numbering->split(model.numbering->owned), model.numbering->split(relevant),
                model.communicator);
}

template <int dim>
void BlockSystem<dim>::begin_step(const double t, const Vector &x)
{
  if (t != time) { // else set_up has made them
    if (const ConstraintLines lines = lines_at(t); !are_prescribed(lines))
      make_constraints(lines);
    time = t;
  }
  reset_norms();
  if (model.interfaces.empty())
    return;
  dealii::Timer timer;
  ghosted_scratch = x;
  for (const auto &interface : model.interfaces)
    if (interface->is_active(t))
      interface->tie().begin_step(*interface, t, ghosted_values(), model.communicator);
  tie_seconds += timer.wall_time();
}

template <int dim>
bool BlockSystem<dim>::refreeze(const double t, const Vector &x)
{
  if (model.is_linear() || model.interfaces.empty())
    return false;
  dealii::Timer timer;
  ghosted_scratch = x;
  bool is_any_outdated = false;
  for (const auto &interface : model.interfaces)
    if (interface->is_active(t) &&
        interface->tie().refreeze(*interface, t, ghosted_values(), model.communicator))
      is_any_outdated = true;
  tie_seconds += timer.wall_time();
  return is_any_outdated;
}

/// Of ghosted_scratch.
template <int dim>
typename Tie<dim>::Unknowns BlockSystem<dim>::ghosted_values() const
{
  return [this](const std::vector<dealii::types::global_dof_index> &dofs, std::vector<double> &values) {
    values.resize(dofs.size());
    ghosted_scratch.extract_subvector_to(dofs.begin(), dofs.end(), values.begin());
  };
}

/// The update's constraints from those of x: dx_i = sum w dx_j + (b_i + sum w x_j - x_i).
template <int dim>
void BlockSystem<dim>::move_constraints_from(const Vector &ghosted)
{
  double largest_move = 0, largest_value = 0;
  for (const auto &line : constraints.get_lines()) {
    double target = line.inhomogeneity;
    for (const auto &[other, weight] : line.entries)
      target += weight * ghosted(other);
    const double move = target - ghosted(line.index);
    largest_move = std::max(largest_move, std::abs(move));
    largest_value = std::max(largest_value, std::abs(target));
    update_constraints.set_inhomogeneity(line.index, move);
  }
  largest_move = dealii::Utilities::MPI::max(largest_move, model.communicator);
  largest_value = dealii::Utilities::MPI::max(largest_value, model.communicator);
  constraints_move = largest_move > 1e-14 * largest_value;
  move = largest_move;
}

template <int dim>
bool BlockSystem<dim>::assemble(const Vector &x, const bool with_tangent)
{
  ++(with_tangent ? n_assemblies.of_tangent : n_assemblies.of_residual);
  ghosted_scratch = x;
  move_constraints_from(ghosted_scratch);
  right_hand_side = 0;
  if (with_tangent)
    matrix = 0;
  local_scale.assign(2 * fields.size(), 0.);

  bool is_defined = true;
  for (unsigned int d = 0; d < model.domains.size(); ++d)
    is_defined = assemble_domain(d, ghosted_scratch, with_tangent) && is_defined;
  if (!model.interfaces.empty()) {
    dealii::Timer timer;
    for (const auto &interface : model.interfaces) {
      if (interface->is_active(time) && interface->tie().adds_terms())
        is_defined = assemble_interface(*interface, ghosted_scratch, with_tangent) && is_defined;
      assemble_multipliers(*interface, ghosted_scratch, with_tangent);
    }
    tie_seconds += timer.wall_time();
  }

  if (with_tangent)
    matrix.compress(dealii::VectorOperation::add);
  right_hand_side.compress(dealii::VectorOperation::add);
  dealii::Utilities::MPI::sum(local_scale, model.communicator, local_scale);
  scale.assign(local_scale.begin(), local_scale.begin() + fields.size());
  if (with_tangent)
    magnitude.assign(local_scale.begin() + fields.size(), local_scale.end());
  is_defined = dealii::Utilities::MPI::min(is_defined ? 1 : 0, model.communicator) == 1;
  has_tangent = with_tangent ? is_defined : has_tangent;
  return is_defined;
}

template <int dim>
void BlockSystem<dim>::scatter(const std::vector<double> &residual,
                               const std::vector<dealii::types::global_dof_index> &dofs,
                               const bool with_tangent)
{
  local_rhs.reinit(residual.size(), true);
  for (unsigned int i = 0; i < residual.size(); ++i)
    local_rhs[i] = -residual[i];
  if (with_tangent)
    scatters_on->distribute_local_to_global(local_matrix, local_rhs, dofs, matrix, right_hand_side);
  else
    scatters_on->distribute_local_to_global(local_rhs, dofs, right_hand_side);
}

template <int dim>
bool BlockSystem<dim>::assemble_domain(const unsigned int d, const Vector &ghosted, const bool with_tangent)
{
  const Domain<dim> &domain = *model.domains[d];
  const unsigned int n_local = domain.dofs_per_cell(), n_nodes = domain.n_nodes();
  std::vector<unsigned int> field; // of each component
  for (const Field &of_domain : domain.fields())
    field.insert(field.end(), of_domain.n_components,
                 std::find(fields.begin(), fields.end(), of_domain.name) - fields.begin());
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(n_local), residual(n_local);
  local_matrix.reinit(n_local, n_local);
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      ghosted.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
      if (!cell_terms[d]->assemble(cell, time, unknowns, residual, with_tangent ? &local_matrix : nullptr))
        return false;
      for (unsigned int i = 0; i < n_local; ++i) {
        const unsigned int f = field[i / n_nodes];
        local_scale[f] += residual[i] * residual[i];
        double of_row = 0;
        for (unsigned int j = 0; with_tangent && j < n_local; ++j)
          of_row += std::abs(local_matrix(i, j) * unknowns[j]);
        local_scale[fields.size() + f] += of_row * of_row;
      }
      scatter(residual, dofs, with_tangent);
    }
  return true;
}

template <int dim>
bool BlockSystem<dim>::assemble_interface(Interface<dim> &interface, const Vector &ghosted,
                                          const bool with_tangent)
{
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns, residual;
  const unsigned int n_local = interface.n_local(source) + interface.n_local(destination);
  unknowns.resize(n_local);
  local_matrix.reinit(n_local, n_local);
  for (const auto &group : interface.pairing().groups) {
    interface.group_dofs(group, dofs);
    ghosted.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    residual.assign(n_local, 0.);
    if (with_tangent)
      local_matrix = 0;
    if (!interface.tie().assemble(interface, group, time, unknowns, residual,
                                  with_tangent ? &local_matrix : nullptr))
      return false;
    if (const auto position = merge_repeated(interface, dofs); !position.empty()) {
      std::vector<double> merged_residual(dofs.size(), 0.);
      dealii::FullMatrix<double> merged(dofs.size(), dofs.size());
      for (unsigned int i = 0; i < position.size(); ++i) {
        merged_residual[position[i]] += residual[i];
        for (unsigned int j = 0; with_tangent && j < position.size(); ++j)
          merged(position[i], position[j]) += local_matrix(i, j);
      }
      std::swap(merged, local_matrix);
      scatter(merged_residual, dofs, with_tangent);
      std::swap(merged, local_matrix);
    } else
      scatter(residual, dofs, with_tangent);
  }
  return true;
}

template <int dim>
void BlockSystem<dim>::assemble_multipliers(const Interface<dim> &interface, const Vector &ghosted,
                                            const bool with_tangent)
{
  const Tie<dim> &tie = interface.tie();
  std::vector<double> unknowns, residual;
  if (!interface.is_active(time)) { // they are zero
    local_matrix.reinit(1, 1);
    local_matrix(0, 0) = 1;
    for_each_multiplier(interface, [&](const auto dof) { scatter({ghosted(dof)}, {dof}, with_tangent); });
    return;
  }
  for (unsigned int i = 0; i < tie.n_terms(); ++i) {
    const auto &dofs = tie.term_dofs(i);
    unknowns.resize(dofs.size());
    ghosted.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    residual.assign(dofs.size(), 0.);
    local_matrix.reinit(dofs.size(), dofs.size());
    tie.assemble_term(i, unknowns, residual, with_tangent ? &local_matrix : nullptr);
    // the size of what cancels in the multiplier's equation
    const unsigned int f = field_of_block[model.numbering->block_of(dofs.back())];
    double magnitude_of_row = 0;
    if (dofs.size() > 1)
      magnitude_of_row = tie.magnitude_of_term(i, unknowns);
    local_scale[f] += magnitude_of_row * magnitude_of_row;
    scatter(residual, dofs, with_tangent);
  }
}

/// Calls @p visit with every multiplier of an interface that this rank owns.
template <int dim>
template <typename Visit>
void BlockSystem<dim>::for_each_multiplier(const Interface<dim> &interface, const Visit &visit) const
{
  for (const TiedField &field : interface.fields)
    for (unsigned int i = 0; i < field.n_multipliers; ++i)
      visit(field.first_multiplier + i);
}

template <int dim>
bool BlockSystem<dim>::has_multipliers() const
{
  return std::any_of(model.interfaces.begin(), model.interfaces.end(), [this](const auto &interface) {
    return interface->is_active(time) && interface->tie().has_multipliers();
  });
}

/// What acts on each unknown: the residual, and what those that follow it pass on.
template <int dim>
Vector BlockSystem<dim>::forces(const Vector &x)
{
  const dealii::AffineConstraints<double> none = [this]() {
    auto empty = make_affine_constraints(model.numbering->owned, relevant);
    empty.close();
    return empty;
  }();
  scatters_on = &none;
  assemble(x, false);
  scatters_on = &update_constraints;
  Vector residual = owned_vector();
  residual.equ(-1., right_hand_side);

  Vector total = residual, passed_on = owned_vector(), previous = owned_vector();
  const unsigned int longest_chain = 100;
  for (unsigned int link = 0; link < longest_chain; ++link) {
    passed_on = 0;
    for (const ConstraintLines *lines : {&hanging_lines, &tie_lines})
      for (const auto &[dof, line] : *lines)
        if (freed.count(dof) == 0) {
          const double force = total(dof);
          for (const auto &[master, weight] : line.entries)
            passed_on(master) += weight * force;
        }
    passed_on.compress(dealii::VectorOperation::add);
    previous = total;
    total = residual;
    total += passed_on;
    previous -= total;
    if (previous.linfty_norm() <= 1e-15 * total.linfty_norm())
      break;
  }
  return total;
}

template <int dim>
void BlockSystem<dim>::find_multipliers(const Vector &x)
{
  if (!has_multipliers())
    return;
  const bool needs_forces =
      std::any_of(model.interfaces.begin(), model.interfaces.end(), [this](const auto &interface) {
        return interface->is_active(time) && interface->tie().needs_forces();
      });
  const Vector force = needs_forces ? forces(x) : Vector();
  for (const auto &interface : model.interfaces)
    if (interface->is_active(time) && interface->tie().has_multipliers())
      interface->tie().find_multipliers(
          *interface, [&](const auto dof) { return x(dof); }, [&](const auto dof) { return force(dof); },
          model.communicator);
}

template <int dim>
std::vector<std::string> BlockSystem<dim>::notes() const
{
  std::vector<std::string> sentences;
  for (const auto &interface : model.interfaces)
    if (interface->is_active(time))
      for (const std::string &sentence : interface->tie().notes())
        sentences.push_back(interface->name + ": " + sentence);
  if (const auto n = dealii::Utilities::MPI::sum(freed.size(), model.communicator); n > 0)
    sentences.push_back("constraints of interfaces that meet led back to themselves and were dropped at " +
                        std::to_string(n) + (n == 1 ? " unknown" : " unknowns"));
  return sentences;
}

template <int dim>
void BlockSystem<dim>::reset_norms()
{
  largest.assign(fields.size(), 0.);
  at_start.clear();
}

namespace {

/// Norms of the blocks of a vector, summed by field.
std::vector<double> norms_by_field(const Vector &vector, const std::vector<unsigned int> &field_of_block,
                                   const unsigned int n_fields)
{
  std::vector<double> squares(n_fields, 0.);
  for (unsigned int b = 0; b < vector.n_blocks(); ++b)
    squares[field_of_block[b]] += std::pow(vector.block(b).l2_norm(), 2);
  for (double &square : squares)
    square = std::sqrt(square);
  return squares;
}

} // namespace

template <int dim>
double BlockSystem<dim>::residual_norm(const double absolute_tolerance)
{
  const std::vector<double> residuals = norms_by_field(right_hand_side, field_of_block, fields.size());
  norms = residuals;
  for (unsigned int f = 0; f < fields.size(); ++f) {
    if (!std::isfinite(residuals[f]))
      return std::numeric_limits<double>::quiet_NaN();
    if (is_of_multipliers[f]) // right when the jump is small compared with the traces
      norms[f] = std::sqrt(scale[f]);
  }
  if (at_start.empty()) {
    at_start = norms;
    noise_at_start.clear();
    accept_residual();
  }
  double relative = 0;
  for (unsigned int f = 0; f < fields.size(); ++f) {
    // terms that cancel leave rounding: those of a cell among cells, and within a cell those of K x
    const double of_cells = std::sqrt(scale[f]), of_tangent = std::sqrt(magnitude[f]);
    const double noise = std::max(1e-13 * of_cells, 1e-15 * of_tangent);
    if (noise_at_start.size() == f)
      noise_at_start.push_back(noise);
    if (!is_of_multipliers[f] && noise > largest_noise * largest[f] &&
        noise > largest_growth * noise_at_start[f] && noise_at_start[f] > 0)
      return std::numeric_limits<double>::quiet_NaN(); // a state so far off that its residual says nothing
    if (residuals[f] <= std::max(noise, absolute_tolerance))
      continue;
    const double reference =
        std::min(largest[f], largest_of_reference * std::max({at_start[f], of_cells, of_tangent}));
    const double of_field = reference > 0 ? residuals[f] / reference : 1.;
    relative = std::max(relative, of_field <= largest_growth ? std::min(of_field, 1.) : of_field);
  }
  return relative;
}

template <int dim>
void BlockSystem<dim>::accept_residual()
{
  for (unsigned int f = 0; f < fields.size(); ++f)
    largest[f] = std::max(largest[f], norms[f]);
}

template <int dim>
double BlockSystem<dim>::linear_residual_norm(const Vector &dx)
{
  // the loads of a field are its right-hand side and what other fields give it; the equations of multipliers
  // have neither, in them the traces of the bodies cancel
  Vector difference = right_hand_side;
  std::vector<double> reference = norms_by_field(right_hand_side, field_of_block, fields.size());
  for (unsigned int row = 0; row < dx.n_blocks(); ++row)
    for (unsigned int column = 0; column < dx.n_blocks(); ++column)
      if (matrix.block(row, column).n_nonzero_elements() > 0) {
        dealii::TrilinosWrappers::MPI::Vector product(difference.block(row));
        matrix.block(row, column).vmult(product, dx.block(column));
        difference.block(row) -= product;
        const unsigned int f = field_of_block[row], g = field_of_block[column];
        if (is_of_multipliers[f] || (f != g && !is_of_multipliers[g]))
          reference[f] = std::max(reference[f], product.l2_norm());
      }
  const std::vector<double> norms = norms_by_field(difference, field_of_block, fields.size());
  double relative = 0;
  for (unsigned int f = 0; f < fields.size(); ++f) {
    if (!std::isfinite(norms[f]))
      return std::numeric_limits<double>::quiet_NaN();
    if (const double of_field = std::max(largest[f], reference[f]); of_field > 0)
      relative = std::max(relative, norms[f] / of_field);
  }
  return relative;
}

template <int dim>
std::optional<FreeMotion<dim>> BlockSystem<dim>::find_free_motion(const bool in_any_case) const
{
  for (unsigned int f = 0; f < fields.size(); ++f)
    if (!is_of_multipliers[f] && (in_any_case || !is_surely_held(model, fields[f], time)))
      if (const auto motion = dovetail::find_free_motion(model, fields[f], matrix, update_constraints))
        return motion;
  return {};
}

/// x_i = sum w x_j + b_i
template <int dim>
void BlockSystem<dim>::apply(const dealii::AffineConstraints<double> &lines, Vector &x) const
{
  ghosted_scratch = x;
  for (const auto &line : lines.get_lines())
    if (model.numbering->owned.is_element(line.index)) {
      double value = line.inhomogeneity;
      for (const auto &[other, weight] : line.entries)
        value += weight * ghosted_scratch(other);
      x(line.index) = value;
    }
  x.compress(dealii::VectorOperation::insert);
}

template <int dim>
void BlockSystem<dim>::distribute(Vector &dx) const
{
  apply(update_constraints, dx);
}

template <int dim>
void BlockSystem<dim>::constrain(Vector &x) const
{
  apply(constraints, x);
}

template class BlockSystem<2>;
template class BlockSystem<3>;

} // namespace dovetail
