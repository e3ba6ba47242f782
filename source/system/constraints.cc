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

/// Erase lines until following the entries of the others never leads back to where one started. Unknowns that
/// reach each other (Tarjan 1972) lose the line with the largest index, as often as needed; since all lines
/// that can be reached are there, each rank decides alike.
/// @return the unknowns whose lines were erased
std::set<Index> break_cycles(ConstraintLines &lines)
{
  std::set<Index> erased;
  for (bool has_cycle = true; has_cycle;) {
    has_cycle = false;
    struct Visit
    {
      unsigned int number, lowest;
      bool is_open;
    };
    std::map<Index, Visit> visits;
    std::vector<Index> open;
    std::vector<Index> largest_of_cycles;
    unsigned int n_visits = 0;
    for (const auto &start : lines) {
      if (visits.count(start.first) > 0)
        continue;
      std::vector<std::pair<Index, std::size_t>> path; // unknown, next entry
      const auto enter = [&](const Index dof) {
        visits[dof] = {n_visits, n_visits, true};
        ++n_visits;
        open.push_back(dof);
        path.emplace_back(dof, 0);
      };
      enter(start.first);
      while (!path.empty()) {
        auto &[dof, next] = path.back();
        const auto &entries = lines.at(dof).entries;
        if (next < entries.size()) {
          const Index other = entries[next++].first;
          if (lines.count(other) == 0)
            continue;
          Visit &visit = visits[dof];
          if (const auto known = visits.find(other); known == visits.end())
            enter(other);
          else if (known->second.is_open)
            visit.lowest = std::min(visit.lowest, known->second.number);
          if (other == dof) // follows itself
            largest_of_cycles.push_back(dof);
          continue;
        }
        const Index done = dof;
        const Visit visit = visits[done];
        path.pop_back();
        if (!path.empty()) {
          Visit &parent = visits[path.back().first];
          parent.lowest = std::min(parent.lowest, visit.lowest);
        }
        if (visit.lowest == visit.number) {
          Index largest = done;
          unsigned int n_members = 0;
          for (Index member = dealii::numbers::invalid_dof_index; member != done; ++n_members) {
            member = open.back();
            open.pop_back();
            visits[member].is_open = false;
            largest = std::max(largest, member);
          }
          if (n_members > 1)
            largest_of_cycles.push_back(largest);
        }
      }
    }
    for (const Index dof : largest_of_cycles) {
      has_cycle = true;
      lines.erase(dof);
      erased.insert(dof);
    }
  }
  return erased;
}

} // namespace

dealii::AffineConstraints<double> close_constraints(const ConstraintLines &owned_lines,
                                                    const Numbering &numbering,
                                                    const dealii::IndexSet &needed,
                                                    const MPI_Comm &communicator, std::set<Index> *freed)
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

  const std::set<Index> erased = break_cycles(lines);
  if (freed != nullptr)
    for (const Index dof : erased)
      if (numbering.owned.is_element(dof))
        freed->insert(dof);
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
