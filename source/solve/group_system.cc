// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "group_system.h"

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace dovetail {

GroupSystem::GroupSystem(SolveGroup given_group)
    : group(std::move(given_group)),
      can_condense(!group.multiplier_blocks.empty() && group.follower &&
                   !(group.is_of_body && std::any_of(group.multiplier_blocks.begin(),
                                                     group.multiplier_blocks.end(), group.is_of_body))),
      may_condense(can_condense)
{
  static_cast<GroupTraits &>(all_facts) = group;
  all_facts.has_multipliers = !group.multiplier_blocks.empty();
  all_facts.near_null_space = [this](const Selection *rows) { return near_null_space(rows); };
  all_facts.field_of_row = [this]() { return field_of_row(); };
  all_facts.stiffness_of_row = [this]() { return stiffness_of_row(); };
  all_facts.n_blocks = group.blocks.size();
  all_facts.contrast = [this]() {
    const std::vector<int> field = field_of_block(); // the units of several differ
    return *std::max_element(field.begin(), field.end()) == 0
               ? contrast([](unsigned int, unsigned int) { return true; })
               : 1;
  };
  if (group.linear_part)
    all_facts.linear_part = [this]() { return linear_part(); };
  if (group.mesh_levels)
    all_facts.mesh_levels = [this](const bool with_parents) { return mesh_levels(with_parents); };
  if (group.positions)
    all_facts.places = [this](const Selection *rows) { return places(rows); };
  consider_shape();
}

/// What an iteration decides by is the same in all ways.
void GroupSystem::share_facts()
{
  const double most_iterations = facts_of_iteration.most_iterations;
  const double most_before_change = facts_of_iteration.most_before_change;
  const GroupFacts::NextGoal next_goal = facts_of_iteration.next_goal;
  facts_of_iteration = all_facts;
  facts_of_iteration.most_iterations = most_iterations;
  facts_of_iteration.most_before_change = most_before_change;
  facts_of_iteration.next_goal = next_goal;
  facts_of_iteration.has_multipliers = all_facts.has_multipliers && !may_condense;
  if (facts_of_iteration.linear_part && may_condense)
    facts_of_iteration.linear_part = [this]() { return condensed->with_followers(linear_part()); };
}

void GroupSystem::consider_constraints()
{
  if (group.present_followed)
    all_facts.n_followed = group.present_followed();
  share_facts();
}

void GroupSystem::consider_shape()
{
  if (group.present_shape)
    all_facts.shape = group.present_shape();
  share_facts();
}

void GroupSystem::set_matrix(const BlockMatrix &new_matrix)
{
  matrix = &new_matrix;
  if (!merged) {
    std::vector<unsigned int> all = group.blocks;
    all.insert(all.end(), group.multiplier_blocks.begin(), group.multiplier_blocks.end());
    merged = std::make_unique<MergedMatrix>(*matrix, all);
    all_facts.n_unknowns = merged->numbering().size();
    all_facts.n_own_of_bodies = merged->numbering().first_local_of(group.blocks.size());
    consider_shape();
    merged->set_motions([this](const Epetra_CrsMatrix &entries) { return motions_of_bodies(entries); });
  }
  merged->update();
  if (group.is_still_symmetric)
    all_facts.is_symmetric = dealii::Utilities::MPI::min(static_cast<int>(group.is_still_symmetric()),
                                                         matrix->get_mpi_communicator()) == 1;
  share_facts();
}

void GroupSystem::forget_matrix()
{
  form_of_iteration = nullptr;
  condensed.reset();
  saddle.reset();
  merged.reset();
  may_condense = can_condense && !has_failed;
  share_facts();
}

void GroupSystem::make_iterated(const std::function<void()> &forget)
{
  if (!all_facts.has_multipliers)
    return;
  may_condense = may_condense && condense();
  if (condensed && !may_condense) {
    forget();
    form_of_iteration = nullptr;
    condensed.reset();
  }
  share_facts();
  if (!may_condense && !lacks_entries())
    make_saddle();
  form_of_iteration = condensed ? static_cast<const IteratedForm *>(condensed.get()) : saddle.get();
}

/// @return whether that serves
bool GroupSystem::condense()
{
  if (!condensed)
    condensed =
        std::make_unique<CondensedBodies>(*matrix, group.blocks, group.multiplier_blocks, group.degree,
                                          followers(), [this]() { return near_null_space(nullptr); });
  return condensed->update(stiffness_of_row());
}

/// Of each own multiplier of a block.
std::vector<bool> GroupSystem::dropped(const unsigned int block) const
{
  return group.dropped ? group.dropped(block)
                       : std::vector<bool>(matrix->owned_unknowns()[block].n_elements(), false);
}

/// Of each own multiplier.
std::vector<CondensedBodies::Follower> GroupSystem::followers() const
{
  const RowNumbering rows(matrix->owned_unknowns(), group.blocks, matrix->get_mpi_communicator());
  const unsigned int part = matrix->part_of(group.blocks[0]);
  const Epetra_Map &map = matrix->part(part, part).trilinos_matrix().RowMap();
  std::vector<CondensedBodies::Follower> result;
  for (unsigned int tie = 0; tie < group.multiplier_blocks.size(); ++tie) {
    const std::vector<bool> are_dropped = dropped(group.multiplier_blocks[tie]);
    const auto unknowns = group.follower(group.multiplier_blocks[tie]);
    for (unsigned int i = 0; i < unknowns.size(); ++i) {
      result.push_back({-1, tie});
      if (are_dropped[i])
        continue;
      const auto [body, index] = matrix->get_row_indices().global_to_local(unknowns[i]);
      const auto found = std::find(group.blocks.begin(), group.blocks.end(), body);
      AssertThrow(found != group.blocks.end(), dealii::ExcMessage("A multiplier belongs to another group."));
      result.back().row = map.LID(static_cast<int>(rows.row(found - group.blocks.begin(), index)));
      AssertThrow(result.back().row >= 0, dealii::ExcMessage("A multiplier belongs to another rank."));
    }
  }
  return result;
}

void GroupSystem::make_saddle()
{
  if (!saddle) {
    std::vector<MultiplierTraits> traits;
    for (const unsigned int block : group.multiplier_blocks) {
      const bool is_of_body = group.is_of_body && group.is_of_body(block);
      for (const bool is_dropped : dropped(block))
        traits.push_back({is_dropped, is_of_body});
    }
    saddle = std::make_unique<SaddlePoint>(*matrix, *merged, group.blocks, group.multiplier_blocks, traits);
  }
  saddle->update();
}

const GroupOperator &GroupSystem::iterated() const
{
  return form_of_iteration != nullptr ? static_cast<const GroupOperator &>(*form_of_iteration) : *merged;
}

/// The mean diagonal entry of each block.
std::vector<double> GroupSystem::mean_diagonals() const
{
  std::vector<double> means;
  for (const unsigned int block : group.blocks) {
    double sum = 0;
    for (const double entry : matrix->diagonal(block))
      sum += std::abs(entry);
    means.push_back(dealii::Utilities::MPI::sum(sum, matrix->get_mpi_communicator()) /
                    matrix->get_row_indices().block_size(block));
  }
  return means;
}

/// Two blocks of bodies, by their entries or by a block of multipliers.
bool GroupSystem::are_coupled(const unsigned int block, const unsigned int other) const
{
  const auto has_any = [this](const unsigned int i, const unsigned int j) {
    return matrix->has_block(i, j) || matrix->has_block(j, i);
  };
  return has_any(block, other) || std::any_of(group.multiplier_blocks.begin(), group.multiplier_blocks.end(),
                                              [&](const unsigned int between) {
                                                return has_any(block, between) && has_any(other, between);
                                              });
}

/// The largest ratio of the usual diagonal entries of two blocks that count together.
double GroupSystem::contrast(const std::function<bool(unsigned int i, unsigned int j)> &count) const
{
  if (group.blocks.size() == 1)
    return 1;
  const std::vector<double> means = usual_diagonals();
  double largest = 1;
  for (unsigned int i = 0; i < means.size(); ++i)
    for (unsigned int j = 0; j < means.size(); ++j)
      if (means[j] > 0 && count(i, j))
        largest = std::max(largest, means[i] / means[j]);
  return largest;
}

double GroupSystem::contrast_of_neighbours() const
{
  return contrast([this](const unsigned int i, const unsigned int j) {
    return are_coupled(group.blocks[i], group.blocks[j]);
  });
}

/// The geometric mean of the diagonal of each block. Of such a mean those rows are a small part to which a
/// constraint adds the stiffness of another body, where that shows.
std::vector<double> GroupSystem::usual_diagonals() const
{
  std::vector<double> means;
  for (const unsigned int block : group.blocks) {
    std::array<double, 2> mine{}; // sum of logarithms, and their number
    for (const double entry : matrix->uncondensed_diagonal(block))
      if (entry != 0) {
        mine[0] += std::log(std::abs(entry));
        ++mine[1];
      }
    const double sum = dealii::Utilities::MPI::sum(mine[0], matrix->get_mpi_communicator()),
                 number = dealii::Utilities::MPI::sum(mine[1], matrix->get_mpi_communicator());
    means.push_back(number > 0 ? std::exp(sum / number) : 0);
  }
  return means;
}

std::vector<double> GroupSystem::stiffness_of_row() const
{
  const std::vector<double> means = usual_diagonals();
  std::vector<double> result;
  for (unsigned int i = 0; i < means.size(); ++i)
    result.insert(result.end(), matrix->owned_unknowns()[group.blocks[i]].n_elements(), means[i]);
  return result;
}

bool GroupSystem::has_stiff_and_soft_bodies() const
{
  const std::vector<int> field = field_of_block();
  if (std::set<int>(field.begin(), field.end()).size() == field.size())
    return false; // one body in each field
  return contrast([&field](const unsigned int i, const unsigned int j) { return field[i] == field[j]; }) >
         GroupFacts::large_contrast;
}

/// Of a block: a temperature has one, a displacement up to six.
unsigned int GroupSystem::largest_number_of_modes() const
{
  const std::vector<int> field = field_of_block();
  const Selection none;
  unsigned int largest = 0;
  for (unsigned int i = 0; i < field.size(); ++i)
    if (std::find(field.begin(), field.begin() + i, field[i]) == field.begin() + i)
      largest = std::max<unsigned int>(largest, group.near_null_space(group.blocks[i], true, &none).size());
  return largest;
}

/// Rigid-body modes of each body for itself, zero on the others, keep the iteration count flat in any
/// contrast of the stiffness, but they double the coarse matrices of two bodies and worse for more. The modes
/// of all bodies together cost nothing extra, and some iterations at a high contrast (measured on two blocks,
/// 3D: 16 iterations for both at contrast 1, 18 against 23 at 1e6). Bodies that can come apart need their own
/// modes (two blocks with an elastic joint: 13 iterations against up to 37). Bodies that are not coupled
/// share vectors, so a chain of any length needs two sets. Where each body is a little stiffer than the one
/// before, only neighbours matter.
GroupSystem::Modes GroupSystem::near_null_space(const Selection *rows) const
{
  const unsigned int largest_number = 24;
  const unsigned int n_of_block = largest_number_of_modes();
  const std::vector<unsigned int> set_of = color_blocks();
  const unsigned int n_sets = *std::max_element(set_of.begin(), set_of.end()) + 1;
  const bool is_shared = n_sets * n_of_block > largest_number ||
                         (!group.allows_jumps && contrast_of_neighbours() <= GroupFacts::large_contrast);
  bool is_about_one_point = is_shared; // rotations; neighbours that share them turn together
  for (unsigned int i = 0; i < set_of.size(); ++i)
    for (unsigned int j = 0; j < i; ++j)
      is_about_one_point =
          is_about_one_point || (set_of[i] == set_of[j] && are_coupled(group.blocks[i], group.blocks[j]));
  const unsigned int n_rows =
      rows != nullptr ? rows->size() : merged->numbering().first_local_of(group.blocks.size());
  Modes modes(is_shared ? n_of_block : n_sets * n_of_block, std::vector<double>(n_rows, 0.));
  unsigned int first_row = 0;
  for (unsigned int i = 0; i < group.blocks.size(); ++i) {
    const Selection selected = rows != nullptr ? of_block(i, *rows) : Selection();
    const auto block_modes =
        group.near_null_space(group.blocks[i], is_about_one_point, rows != nullptr ? &selected : nullptr);
    for (unsigned int mode = 0; mode < block_modes.size(); ++mode)
      std::copy(block_modes[mode].begin(), block_modes[mode].end(),
                modes[is_shared ? mode : set_of[i] * n_of_block + mode].begin() + first_row);
    first_row += block_modes.empty() ? 0 : block_modes[0].size();
  }
  return modes;
}

/// Of bodies of one field whose stiffnesses differ much.
std::unique_ptr<BodyMotions> GroupSystem::motions_of_bodies(const Epetra_CrsMatrix &entries) const
{
  if (group.blocks.size() < 2 || !all_facts.has_large_contrast())
    return nullptr;
  Modes modes(largest_number_of_modes());
  std::vector<int> body;
  for (unsigned int i = 0; i < group.blocks.size(); ++i) {
    const Modes of_body = group.near_null_space(group.blocks[i], true, nullptr);
    for (unsigned int mode = 0; mode < of_body.size(); ++mode)
      modes[mode].insert(modes[mode].end(), of_body[mode].begin(), of_body[mode].end());
    body.insert(body.end(), matrix->owned_unknowns()[group.blocks[i]].n_elements(), static_cast<int>(i));
  }
  return std::make_unique<BodyMotions>(entries, modes, body, usual_diagonals());
}

/// Those of the i-th block, from its first row on.
Selection GroupSystem::of_block(const unsigned int i, const Selection &rows) const
{
  const unsigned int begin = merged->numbering().first_local_of(i),
                     end = merged->numbering().first_local_of(i + 1);
  Selection result(std::lower_bound(rows.begin(), rows.end(), begin),
                   std::lower_bound(rows.begin(), rows.end(), end));
  for (unsigned int &row : result)
    row -= begin;
  return result;
}

/// Numbers for the blocks of the group, from 0 on, to each in turn the smallest that it may have: other ones
/// than those of neighbours that are much stiffer or softer, of another field, or may come apart from it.
std::vector<unsigned int> GroupSystem::color_blocks() const
{
  const std::vector<double> means = mean_diagonals();
  const std::vector<int> field = field_of_block();
  std::vector<unsigned int> colors;
  for (unsigned int i = 0; i < means.size(); ++i) {
    std::set<unsigned int> taken;
    for (unsigned int j = 0; j < i; ++j) {
      const auto [softer, stiffer] = std::minmax(means[i], means[j]);
      const bool hardly_share =
          group.allows_jumps || field[i] != field[j] || stiffer > GroupFacts::large_contrast * softer;
      if (hardly_share && are_coupled(group.blocks[i], group.blocks[j]))
        taken.insert(colors[j]);
    }
    unsigned int next = 0;
    while (taken.count(next) > 0)
      ++next;
    colors.push_back(next);
  }
  return colors;
}

/// Numbers of the fields of the blocks, from 0 on.
std::vector<int> GroupSystem::field_of_block() const
{
  std::map<std::string, int> number;
  std::vector<int> result;
  for (const unsigned int block : group.blocks)
    result.push_back(number.try_emplace(group.field ? group.field(block) : "", number.size()).first->second);
  return result;
}

std::vector<int> GroupSystem::field_of_row() const
{
  const std::vector<int> field = field_of_block();
  std::vector<int> result;
  for (unsigned int i = 0; i < field.size(); ++i)
    result.insert(result.end(), matrix->owned_unknowns()[group.blocks[i]].n_elements(), field[i]);
  return result;
}

std::vector<GroupFacts::Place> GroupSystem::places(const Selection *rows) const
{
  std::vector<GroupFacts::Place> result;
  for (unsigned int i = 0; i < group.blocks.size(); ++i) {
    const Selection selected = rows != nullptr ? of_block(i, *rows) : Selection();
    const auto positions = group.positions(group.blocks[i], rows != nullptr ? &selected : nullptr);
    result.reserve(result.size() + positions.size());
    for (const auto &position : positions)
      result.push_back({group.blocks[i], position});
  }
  return result;
}

RowSums GroupSystem::linear_part() const
{
  RowSums sums;
  for (const unsigned int block : group.blocks)
    sums.append(group.linear_part(block, is_smoothed_by_products));
  renumber(sums);
  return sums;
}

MeshLevels GroupSystem::mesh_levels(const bool with_parents) const
{
  MeshLevels result;
  for (const unsigned int block : group.blocks) {
    MeshLevels of_block = group.mesh_levels(block, with_parents);
    result.step.insert(result.step.end(), of_block.step.begin(), of_block.step.end());
    result.means.append(std::move(of_block.means));
    result.has_parts = result.has_parts || of_block.has_parts;
  }
  renumber(result.means);
  return result;
}

/// From unknowns of the whole system to rows of the bodies alone.
void GroupSystem::renumber(RowSums &sums) const
{
  std::vector<unsigned int> position(matrix->n_block_rows()); // in the group
  for (unsigned int i = 0; i < group.blocks.size(); ++i)
    position[group.blocks[i]] = i;
  const RowNumbering rows(matrix->owned_unknowns(), group.blocks, matrix->get_mpi_communicator());
  sums.renumber([&](const RowSums::Index dof) {
    const auto [block, index] = matrix->get_row_indices().global_to_local(dof);
    return rows.row(position[block], index);
  });
}

} // namespace dovetail
