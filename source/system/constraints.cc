// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/constraints.h>

#include <dovetail/compatibility.h>

#include <deal.II/base/mpi.h>

#include <set>

namespace dovetail {

namespace {

using Index = dealii::types::global_dof_index;

/// A list of lines as numbers: dof, inhomogeneity, number of entries, (dof, weight) …
void pack(const Index dof, const ConstraintLine &line, std::vector<double> &numbers)
{
  numbers.push_back(dof);
  numbers.push_back(line.inhomogeneity);
  numbers.push_back(line.entries.size());
  for (const auto &[other, weight] : line.entries) {
    numbers.push_back(other);
    numbers.push_back(weight);
  }
}

void unpack(const std::vector<double> &numbers, ConstraintLines &lines)
{
  for (auto next = numbers.begin(); next != numbers.end();) {
    ConstraintLine &line = lines[static_cast<Index>(*next++)];
    line.inhomogeneity = *next++;
    line.entries.clear();
    for (unsigned int n_entries = *next++; n_entries > 0; --n_entries) {
      const Index other = static_cast<Index>(*next++);
      line.entries.emplace_back(other, *next++);
    }
  }
}

/// Ask the owners of @p dofs for their lines.
ConstraintLines fetch(const std::set<Index> &dofs, const ConstraintLines &owned_lines,
                      const Numbering &numbering, const MPI_Comm &communicator)
{
  std::map<unsigned int, std::vector<Index>> questions;
  for (const Index dof : dofs)
    questions[numbering.owner(dof)].push_back(dof);
  std::map<unsigned int, std::vector<double>> answers;
  for (const auto &[rank, asked] : dealii::Utilities::MPI::some_to_some(communicator, questions))
    for (const Index dof : asked)
      if (const auto line = owned_lines.find(dof); line != owned_lines.end())
        pack(dof, line->second, answers[rank]);
  ConstraintLines lines;
  for (const auto &of_rank : dealii::Utilities::MPI::some_to_some(communicator, answers))
    unpack(of_rank.second, lines);
  return lines;
}

/// Whether following the entries of @p lines leads back to where one started: then they have no solution.
bool has_cycle(const ConstraintLines &lines)
{
  enum State { open, active, done };
  std::map<Index, State> state;
  for (const auto &start : lines) {
    if (state[start.first] == done)
      continue;
    std::vector<std::pair<Index, std::size_t>> path = {{start.first, 0}}; // unknown, next entry
    state[start.first] = active;
    while (!path.empty()) {
      auto &[dof, next] = path.back();
      const auto &entries = lines.at(dof).entries;
      if (next == entries.size()) {
        state[dof] = done;
        path.pop_back();
        continue;
      }
      const Index other = entries[next++].first;
      if (lines.count(other) == 0 || state[other] == done)
        continue;
      if (state[other] == active)
        return true;
      state[other] = active;
      path.emplace_back(other, 0);
    }
  }
  return false;
}

} // namespace

dealii::AffineConstraints<double> close_constraints(const ConstraintLines &owned_lines,
                                                    const Numbering &numbering,
                                                    const dealii::IndexSet &needed,
                                                    const MPI_Comm &communicator)
{
  ConstraintLines lines = owned_lines;
  dealii::IndexSet known = numbering.owned;
  std::set<Index> missing;
  const auto look_for = [&](const Index dof) {
    if (!known.is_element(dof))
      missing.insert(dof);
  };
  for (const Index dof : needed)
    look_for(dof);
  for (const auto &[dof, line] : lines)
    for (const auto &entry : line.entries)
      look_for(entry.first);

  if (dealii::Utilities::MPI::n_mpi_processes(communicator) > 1)
    while (dealii::Utilities::MPI::max(missing.size(), communicator) > 0) {
      const ConstraintLines fetched = fetch(missing, owned_lines, numbering, communicator);
      known.add_indices(missing.begin(), missing.end());
      known.compress();
      missing.clear();
      for (const auto &[dof, line] : fetched) {
        lines[dof] = line;
        for (const auto &entry : line.entries)
          look_for(entry.first);
      }
    }

  if (dealii::Utilities::MPI::max(has_cycle(lines) ? 1 : 0, communicator) > 0)
    throw UserError(
        "Pointwise interfaces follow each other in a circle where they meet. Swap Source and Destination of "
        "one of them, or tie one by Type = Nitsche.");
  auto constraints = make_affine_constraints(numbering.owned, known);
  for (const auto &[dof, line] : lines) {
    constraints.add_line(dof);
    constraints.add_entries(dof, line.entries);
    constraints.set_inhomogeneity(dof, line.inhomogeneity);
  }
  constraints.close();
  return constraints;
}

} // namespace dovetail
