// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/constraints.h>

#include <dovetail/compatibility.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/full_matrix.h>
#include <deal.II/lac/lapack_full_matrix.h>

#include <boost/serialization/map.hpp>
#include <boost/serialization/utility.hpp>
#include <boost/serialization/vector.hpp>

#include <algorithm>
#include <cmath>
#include <set>

namespace dovetail {

namespace {

using Index = dealii::types::global_dof_index;

/// Ask the owners of @p dofs for their lines.
ConstraintLines fetch(const std::set<Index> &dofs, const ConstraintLines &owned_lines,
                      const Numbering &numbering, const MPI_Comm &communicator)
{
  std::map<unsigned int, std::vector<Index>> questions;
  for (const Index dof : dofs)
    questions[numbering.owner(dof)].push_back(dof);
  std::map<unsigned int, ConstraintLines> answers;
  for (const auto &[rank, asked] : dealii::Utilities::MPI::some_to_some(communicator, questions))
    for (const Index dof : asked)
      if (const auto line = owned_lines.find(dof); line != owned_lines.end())
        answers[rank].insert(*line);
  ConstraintLines lines;
  for (auto &answer : dealii::Utilities::MPI::some_to_some(communicator, answers))
    lines.merge(answer.second);
  return lines;
}

/// The unknowns that reach each other by following the entries of the lines, and those that follow themselves
/// (Tarjan 1972).
std::vector<std::vector<Index>> circles_of(const ConstraintLines &lines)
{
  struct Visit
  {
    unsigned int number, lowest;
    bool is_open, follows_itself;
  };
  std::map<Index, Visit> visits;
  std::vector<Index> open;
  std::vector<std::vector<Index>> circles;
  for (const auto &start : lines) {
    if (visits.count(start.first) > 0)
      continue;
    std::vector<std::pair<Index, std::size_t>> path; // unknown, next entry
    const auto enter = [&](const Index dof) {
      const unsigned int number = visits.size();
      visits[dof] = {number, number, true, false};
      open.push_back(dof);
      path.emplace_back(dof, 0);
    };
    enter(start.first);
    while (!path.empty()) {
      const Index dof = path.back().first;
      const auto &entries = lines.at(dof).entries;
      Visit &visit = visits[dof];
      if (path.back().second < entries.size()) {
        const Index other = entries[path.back().second++].first;
        visit.follows_itself = visit.follows_itself || other == dof;
        if (lines.count(other) == 0)
          continue;
        if (const auto known = visits.find(other); known == visits.end())
          enter(other);
        else if (known->second.is_open)
          visit.lowest = std::min(visit.lowest, known->second.number);
        continue;
      }
      path.pop_back();
      if (!path.empty()) {
        Visit &parent = visits[path.back().first];
        parent.lowest = std::min(parent.lowest, visit.lowest);
      }
      if (visit.lowest == visit.number) {
        std::vector<Index> members;
        do {
          members.push_back(open.back());
          visits[open.back()].is_open = false;
          open.pop_back();
        } while (members.back() != dof);
        std::sort(members.begin(), members.end());
        if (members.size() > 1 || visit.follows_itself)
          circles.push_back(members);
      }
    }
  }
  return circles;
}

/// Solve the lines of unknowns that follow each other, B_i = sum_k W_ik B_k + rest_i: B = (I - W)^-1 rest.
/// @return false, and nothing changes, if I - W is singular: they have no solution for every rest.
bool solve_circle(const std::vector<Index> &members, ConstraintLines &lines)
{
  const unsigned int n = members.size();
  dealii::FullMatrix<double> inverse(n, n); // first I - W
  std::vector<ConstraintLine> rest(n);
  for (unsigned int i = 0; i < n; ++i) {
    const ConstraintLine &line = lines.at(members[i]);
    rest[i].inhomogeneity = line.inhomogeneity;
    inverse(i, i) += 1;
    for (const auto &[dof, weight] : line.entries)
      if (const auto found = std::lower_bound(members.begin(), members.end(), dof);
          found != members.end() && *found == dof)
        inverse(i, found - members.begin()) -= weight;
      else
        rest[i].entries.emplace_back(dof, weight);
  }
  dealii::LAPACKFullMatrix<double> singular_values(n);
  singular_values = inverse;
  singular_values.compute_svd();
  if (!(singular_values.singular_value(n - 1) > 1e-6))
    return false;
  inverse.gauss_jordan();
  for (unsigned int i = 0; i < n; ++i) {
    std::map<Index, double> entries;
    ConstraintLine &line = lines.at(members[i]);
    line.inhomogeneity = 0;
    for (unsigned int k = 0; k < n; ++k) {
      line.inhomogeneity += inverse(i, k) * rest[k].inhomogeneity;
      for (const auto &[dof, weight] : rest[k].entries)
        entries[dof] += inverse(i, k) * weight;
    }
    line.entries.assign(entries.begin(), entries.end());
  }
  return true;
}

/// Solve the circles in the lines. One without a solution loses a line of the interface that the scene names
/// last, that with the largest index, as often as needed. Since all lines that can be reached are there, each
/// rank decides alike.
/// @return the unknowns whose lines were erased
std::set<Index> open_circles(ConstraintLines &lines)
{
  std::set<Index> erased;
  for (auto circles = circles_of(lines); !circles.empty(); circles = circles_of(lines))
    for (const auto &members : circles)
      if (!solve_circle(members, lines)) {
        const Index last =
            *std::max_element(members.begin(), members.end(), [&](const Index a, const Index b) {
              return std::make_pair(lines.at(a).tie, a) < std::make_pair(lines.at(b).tie, b);
            });
        lines.erase(last);
        erased.insert(last);
      }
  return erased;
}

} // namespace

dealii::AffineConstraints<double> close_constraints(const ConstraintLines &owned_lines,
                                                    const Numbering &numbering,
                                                    const dealii::IndexSet &needed,
                                                    const MPI_Comm &communicator,
                                                    std::set<Index> *unconstrained)
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

  const std::set<Index> erased = open_circles(lines);
  if (unconstrained != nullptr)
    for (const Index dof : erased)
      if (numbering.owned.is_element(dof))
        unconstrained->insert(dof);
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
