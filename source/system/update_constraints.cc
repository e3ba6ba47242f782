// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/update_constraints.h>

#include <dovetail/scene/undefined.h>
#include <dovetail/system/constraints.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/timer.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

template <int dim>
void UpdateConstraints<dim>::set_up(const double t)
{
  tie_lines.clear();
  if (!model.interfaces.empty())
    find_lines_of_ties(t);
  make_relevant_set(t);
  make(lines_at(t));
}

template <int dim>
void UpdateConstraints<dim>::find_lines_of_ties(const double t)
{
  TieConstraints all;
  all.t = t;
  for (const auto &domain : model.domains)
    domain->add_constraints(t, all.lines);
  dealii::Timer timer;
  for (unsigned int i = 0; i < model.interfaces.size(); ++i)
    if (Elimination<dim> *elimination = model.interfaces[i]->tie().parts().elimination;
        elimination != nullptr && model.interfaces[i]->is_active(t)) {
      all.tie = i;
      elimination->add_constraints(*model.interfaces[i], all, model.communicator);
    }
  for (const auto &[dof, line] : all.lines)
    if (line.tie >= 0)
      tie_lines.emplace_hint(tie_lines.end(), dof, line);
  tie_seconds += timer.wall_time();
}

template <int dim>
void UpdateConstraints<dim>::make_relevant_set(const double t)
{
  relevant = model.numbering->relevant;
  std::vector<dealii::types::global_dof_index> dofs, all;
  for (const auto &interface : model.interfaces)
    for (const auto &group : interface->pairing().groups) {
      interface->group_dofs(group, dofs);
      all.insert(all.end(), dofs.begin(), dofs.end());
    }
  for (const auto &interface : model.interfaces)
    if (interface->is_active(t)) {
      const TieParts<dim> parts = interface->tie().parts();
      for (unsigned int i = 0; parts.multipliers != nullptr && i < parts.multipliers->n_terms(); ++i) {
        const auto &multiplier_term = parts.multipliers->term_dofs(i);
        all.insert(all.end(), multiplier_term.begin(), multiplier_term.end());
      }
      if (parts.elimination != nullptr)
        for (const HeldUnknown &held : parts.elimination->held())
          for (const auto &[dof, weight] : held.source)
            all.push_back(dof);
    }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  relevant.add_indices(all.begin(), all.end());
  relevant.compress();
}

/// Of all constraints, for the unknowns that this rank owns. Collective.
template <int dim>
ConstraintLines UpdateConstraints<dim>::lines_at(const double t) const
{
  ConstraintLines lines;
  for (const auto &domain : model.domains)
    domain->add_constraints(t, lines);
  lines.insert(tie_lines.begin(), tie_lines.end());
  const bool are_finite = std::all_of(lines.begin(), lines.end(), [](const auto &entry) {
    return std::isfinite(entry.second.inhomogeneity);
  });
  refuse_undefined(are_finite ? Undefined() : last_undefined(), model.communicator);
  return lines;
}

/// Else the lines stay as they are until set_up().
template <int dim>
bool UpdateConstraints<dim>::depend_on_time() const
{
  return std::any_of(model.domains.begin(), model.domains.end(), [](const auto &domain) {
    return std::any_of(domain->conditions().begin(), domain->conditions().end(), [](const auto &condition) {
      return !condition->prescribed_components().empty() && condition->depends_on_time();
    });
  });
}

/// Whether the constraints that are there prescribe the same values as lines that were made after the same
/// set_up, so that all else in them is the same.
template <int dim>
bool UpdateConstraints<dim>::are_prescribed(const ConstraintLines &lines) const
{
  const auto all = constraints.get_lines(); // these, and those of other ranks, in the same order
  auto known = all.begin();
  const bool are_on_this_rank = std::all_of(lines.begin(), lines.end(), [&](const auto &entry) {
    const auto &[dof, line] = entry;
    while (known != all.end() && known->index < dof)
      ++known;
    return !line.entries.empty() || (known != all.end() && known->index == dof &&
                                     prescribed[known - all.begin()] == line.inhomogeneity);
  });
  return dealii::Utilities::MPI::min(are_on_this_rank ? 1 : 0, model.communicator) == 1;
}

template <int dim>
void UpdateConstraints<dim>::make(ConstraintLines all_lines)
{
  constraints.clear();
  unconstrained.clear();
  constraints = close_constraints(all_lines, *model.numbering, relevant, model.communicator, &unconstrained);
  for (const auto dof : unconstrained)
    all_lines.erase(dof);
  lines_of_x = std::make_shared<const ConstraintLines>(std::move(all_lines));
  prescribed.clear();
  prescribed.reserve(constraints.n_constraints());
  for (const auto &line : constraints.get_lines())
    prescribed.push_back(line.inhomogeneity);
  relevant.add_indices(constraints.get_local_lines()); // those that lines refer to, too
  relevant.compress();
}

template <int dim>
void UpdateConstraints<dim>::set_time(const double t)
{
  if (depend_on_time())
    if (ConstraintLines lines_then = lines_at(t); !are_prescribed(lines_then))
      make(std::move(lines_then));
}

template <int dim>
void UpdateConstraints<dim>::move_from(const Vector &ghosted, const double share)
{
  std::vector<double> largest_move(model.numbering->blocks().size(), 0.), largest_value(largest_move);
  unsigned int i = 0;
  for (const auto &line : constraints.get_lines()) {
    double target = prescribed[i++];
    for (const auto &[other, weight] : line.entries)
      target += weight * ghosted(other);
    if (share < 1)
      target -= (1 - share) * held_moves.at(line.index);
    const double distance = moves_nothing ? 0 : target - ghosted(line.index);
    const unsigned int block = model.numbering->block_of(line.index);
    largest_move[block] = std::max(largest_move[block], std::abs(distance));
    largest_value[block] = std::max(largest_value[block], std::abs(target));
    constraints.set_inhomogeneity(line.index, distance);
  }
  dealii::Utilities::MPI::max(largest_move, model.communicator, largest_move);
  dealii::Utilities::MPI::max(largest_value, model.communicator, largest_value);
  constraints_move.clear();
  move = 0;
  for (unsigned int b = 0; b < largest_move.size(); ++b) {
    constraints_move.push_back(largest_move[b] > 1e-14 * largest_value[b]);
    move = std::max(move, largest_move[b]);
  }
}

template <int dim>
void UpdateConstraints<dim>::hold_back()
{
  held_moves.clear();
  for (const auto &line : constraints.get_lines())
    held_moves[line.index] = line.inhomogeneity;
}

template <int dim>
bool UpdateConstraints<dim>::moves() const
{
  return std::find(constraints_move.begin(), constraints_move.end(), true) != constraints_move.end();
}

/// x_i = sum w x_j + b_i with b_i = @p constant(line, its number)
template <int dim>
template <typename Constant>
void UpdateConstraints<dim>::apply(Vector &x, const Vector &ghosted, const Constant &constant,
                                   const bool what_is_prescribed) const
{
  unsigned int i = 0;
  for (const auto &line : constraints.get_lines()) {
    double value = constant(line, i++);
    if (model.numbering->owned.is_element(line.index) && (what_is_prescribed || !line.entries.empty())) {
      for (const auto &[other, weight] : line.entries)
        value += weight * ghosted(other);
      x(line.index) = value;
    }
  }
  keep_owned_values(x);
}

template <int dim>
void UpdateConstraints<dim>::distribute(Vector &dx, const Vector &ghosted) const
{
  apply(
      dx, ghosted, [](const auto &line, unsigned int) { return line.inhomogeneity; }, true);
}

template <int dim>
void UpdateConstraints<dim>::distribute_rate(Vector &rate, const Vector &ghosted,
                                             const bool what_is_prescribed) const
{
  apply(
      rate, ghosted, [](const auto &, unsigned int) { return 0.; }, what_is_prescribed);
}

template <int dim>
void UpdateConstraints<dim>::follow(Vector &x, const Vector &ghosted) const
{
  apply(
      x, ghosted, [this](const auto &, const unsigned int i) { return prescribed[i]; }, false);
}

template <int dim>
void UpdateConstraints<dim>::constrain(Vector &x, const Vector &ghosted) const
{
  apply(
      x, ghosted, [this](const auto &, const unsigned int i) { return prescribed[i]; }, true);
}

template class UpdateConstraints<2>;
template class UpdateConstraints<3>;

} // namespace dovetail
