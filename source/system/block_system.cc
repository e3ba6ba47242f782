// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/block_system.h>

#include <dovetail/compatibility.h>
#include <dovetail/domain/curved_cells.h>
#include <dovetail/domain/locking.h>
#include <dovetail/domain/mesh_note.h>
#include <dovetail/domain/point_products.h>
#include <dovetail/domain/simplices.h>
#include <dovetail/interface/side_points.h>
#include <dovetail/system/affine_residual.h>
#include <dovetail/system/constraints.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/table.h>
#include <deal.II/base/timer.h>
#include <deal.II/lac/sparsity_tools.h>

#include <boost/scope_exit.hpp>

#include <algorithm>
#include <cmath>
#include <exception>
#include <numeric>
#include <stdexcept>

namespace dovetail {

namespace {

const NoteName of_mesh("mesh", "something is remarkable about a mesh");
const NoteName of_dropped_constraints("dropped constraints",
                                      "constraints of interfaces that meet lead back to themselves");

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
BlockSystem<dim>::BlockSystem(Model<dim> &model, const Form form) : model(model), form(form)
{
  for (const auto &group : model.field_groups())
    fields.insert(fields.end(), group.begin(), group.end());
  for (const Block &block : model.numbering->blocks()) {
    if (block.is_of_multipliers)
      fields.push_back(name_of_multipliers(block.name, block.field));
    field_of_block.push_back(
        std::find(fields.begin(), fields.end(), block.is_of_multipliers ? fields.back() : block.field) -
        fields.begin());
    is_constraint.push_back(block.is_of_pressure());
  }
  tangent_at_x = products_at_x = std::vector<double>(field_of_block.size(), 0.);
  is_of_multipliers.assign(fields.size(), false);
  for (unsigned int b = 0; b < field_of_block.size(); ++b)
    is_of_multipliers[field_of_block[b]] = model.numbering->blocks()[b].is_of_multipliers;
}

template <int dim>
BlockSystem<dim>::~BlockSystem() = default;

template <int dim>
bool BlockSystem<dim>::is_outdated(const double t) const
{
  return model.active_toggles(t) != toggles_of_set_up ||
         (t != time_of_set_up &&
          std::any_of(model.interfaces.begin(), model.interfaces.end(), [t](const auto &interface) {
            return interface->is_active(t) && interface->has_moving_constraints();
          }));
}

template <int dim>
void BlockSystem<dim>::set_up(const double t)
{
  toggles_of_set_up = model.active_toggles(t);
  time_of_set_up = t;
  tie_lines.clear();
  if (!model.interfaces.empty()) {
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
ConstraintLines BlockSystem<dim>::lines_at(const double t) const
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
bool BlockSystem<dim>::prescribes_by_time() const
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
bool BlockSystem<dim>::are_prescribed(const ConstraintLines &lines) const
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
void BlockSystem<dim>::make_constraints(ConstraintLines all_lines)
{
  constraints.clear();
  unconstrained.clear();
  constraints = close_constraints(all_lines, *model.numbering, relevant, model.communicator, &unconstrained);
  for (const auto dof : unconstrained)
    all_lines.erase(dof);
  lines = std::make_shared<const ConstraintLines>(std::move(all_lines));
  prescribed.clear();
  prescribed.reserve(constraints.n_constraints());
  for (const auto &line : constraints.get_lines())
    prescribed.push_back(line.inhomogeneity);
  relevant.add_indices(constraints.get_local_lines()); // those that lines refer to, too
  relevant.compress();
}

template <int dim>
void BlockSystem<dim>::add_pattern(const CellTerms<dim> &terms,
                                   const dealii::AffineConstraints<double> &lines,
                                   dealii::DynamicSparsityPattern &pattern) const
{
  const Domain<dim> &domain = terms.body();
  const CellLayout<dim> &layout = domain.layout();
  const auto begin = [&](const Field &field) { return layout.first(field.first_component); };
  const auto end = [&](const Field &field) {
    return layout.first(field.first_component + field.n_components);
  };
  dealii::Table<2, bool> couples(domain.dofs_per_cell(), domain.dofs_per_cell());
  const auto &fields = domain.fields();
  bool all_couple = true;
  bool any_couples = false, has_all_entries = true;
  for (unsigned int f = 0; f < fields.size(); ++f)
    for (unsigned int g = 0; g < fields.size(); ++g) {
      const bool is_without_entries = f == g && !has_entries(fields[f].name);
      const bool depends =
          (form == Form::direct ? domain.material.depends(f, g) : domain.material.depends(g, f)) &&
          !is_without_entries && !is_left_out(fields[f].name, fields[g].name);
      all_couple = all_couple && depends;
      any_couples = any_couples || depends;
      has_all_entries = has_all_entries && !is_without_entries;
      for (unsigned int i = begin(fields[f]); depends && i < end(fields[f]); ++i)
        for (unsigned int j = begin(fields[g]); j < end(fields[g]); ++j)
          couples(i, j) = true;
      const bool is_diagonal = is_without_entries && terms.lumps_storage();
      any_couples = any_couples || is_diagonal;
      for (unsigned int i = begin(fields[f]); is_diagonal && i < end(fields[f]); ++i)
        couples(i, i) = true;
    }
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      const bool has_boundary_terms = !has_all_entries && terms.has_boundary_tangent(cell);
      if (!any_couples && !has_boundary_terms)
        continue;
      domain.cell_dofs(cell, dofs);
      if (all_couple)
        lines.add_entries_local_to_global(dofs, pattern, false);
      else if (has_boundary_terms) {
        dealii::Table<2, bool> with_boundary(couples);
        terms.add_boundary_couplings(cell, with_boundary);
        for (unsigned int f = 0; f < fields.size(); ++f)
          for (unsigned int g = 0; g < fields.size(); ++g)
            for (unsigned int i = begin(fields[f]);
                 is_left_out(fields[f].name, fields[g].name) && i < end(fields[f]); ++i)
              for (unsigned int j = begin(fields[g]); j < end(fields[g]); ++j)
                with_boundary(i, j) = false;
        lines.add_entries_local_to_global(dofs, pattern, false, with_boundary);
      } else
        lines.add_entries_local_to_global(dofs, pattern, false, couples);
    }
}

/// The two cells of a group couple by the jump alone, unless the tie couples their fluxes, too: an unknown
/// that is not in the jump then meets only those of the other cell that are, which leaves most of a cell of
/// high degree out. Likewise within a cell, unless the tie adds second derivatives of its flux; they belong
/// here although the cell couples all its unknowns itself, because this rank may not own it.
template <int dim>
void BlockSystem<dim>::add_pattern(const Interface<dim> &interface,
                                   const dealii::AffineConstraints<double> &lines,
                                   dealii::DynamicSparsityPattern &pattern) const
{
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<unsigned int> component; // of each local unknown, counted over both sides
  for (const unsigned int side : {source, destination})
    for (unsigned int k = 0; k < interface.components[side].size(); ++k)
      component.insert(component.end(),
                       interface.sides[side].domain->layout().n_nodes(interface.components[side][k]),
                       k + (side == source ? 0 : interface.components[source].size()));
  const unsigned int n = component.size(), n_components = component.back() + 1;
  dealii::Table<2, bool> of_components(n_components, n_components), depends(n, n);
  for (unsigned int row = 0; row < n_components; ++row)
    for (unsigned int column = 0; column < n_components; ++column)
      of_components(row, column) = has_entries(interface, row, column);
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int j = 0; j < n; ++j)
      depends(i, j) = of_components(component[i], component[j]);
  const bool by_flux = interface.tie().parts().point_terms->couples_fluxes();
  const bool by_inside = interface.tie().parts().point_terms->couples_insides(interface);
  const auto is_of_source = [&](const unsigned int i) { return i < interface.n_local(source); };

  dealii::Table<2, bool> couples(n, n);
  for (const auto &group : interface.pairing().groups) {
    interface.group_dofs(group, dofs);
    const std::vector<bool> in_jump =
        by_flux ? std::vector<bool>(n, true) : interface.unknowns_in_jump(group);
    for (unsigned int i = 0; i < n; ++i)
      for (unsigned int j = 0; j < n; ++j)
        couples(i, j) =
            depends(i, j) && (in_jump[i] || in_jump[j] || (by_inside && is_of_source(i) == is_of_source(j)));
    if (const auto position = merge_repeated(interface, dofs); !position.empty()) {
      dealii::Table<2, bool> merged(dofs.size(), dofs.size());
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int j = 0; j < n; ++j)
          merged(position[i], position[j]) = merged(position[i], position[j]) || couples(i, j);
      lines.add_entries_local_to_global(dofs, pattern, false, merged);
    } else
      lines.add_entries_local_to_global(dofs, pattern, false, couples);
  }
}

template <int dim>
dealii::DynamicSparsityPattern
BlockSystem<dim>::make_pattern(const double t, const dealii::AffineConstraints<double> &lines) const
{
  dealii::DynamicSparsityPattern pattern(relevant);
  for (const auto &terms : cell_terms)
    add_pattern(*terms, lines, pattern);
  for (const auto &interface : model.interfaces) {
    const TieParts<dim> parts = interface->tie().parts();
    if (interface->is_active(t)) {
      if (parts.point_terms != nullptr)
        add_pattern(*interface, lines, pattern);
      for (unsigned int i = 0; parts.multipliers != nullptr && i < parts.multipliers->n_terms(); ++i)
        lines.add_entries_local_to_global(parts.multipliers->term_dofs(i), pattern, false);
    } else
      for_each_multiplier(*interface, [&](const auto dof) { pattern.add(dof, dof); });
  }
  for (const Block &block : model.numbering->blocks()) // where a pressure that is not known may be held
    if (block.is_of_pressure() && block.owned.n_elements() > 0) {
      const auto first = block.begin + block.owned.nth_index_in_set(0);
      pattern.add(first, first);
    }
  dealii::SparsityTools::distribute_sparsity_pattern(pattern, model.numbering->owned, model.communicator,
                                                     relevant);
  return pattern;
}

template <int dim>
void BlockSystem<dim>::find_dropped(const double t)
{
  dropped.clear();
  for (const auto &interface : model.interfaces) {
    const TieParts<dim> parts = interface->tie().parts();
    if (!interface->is_active(t))
      for_each_multiplier(*interface, [&](const auto dof) { dropped.insert(dof); });
    else if (parts.multipliers != nullptr)
      for (unsigned int i = 0; i < parts.multipliers->n_terms(); ++i)
        if (const auto &dofs = parts.multipliers->term_dofs(i); dofs.size() == 1)
          dropped.insert(dofs[0]);
  }
}

template <int dim>
void BlockSystem<dim>::make_sparsity(const double t)
{
  dealii::Timer timer;
  find_dropped(t);
  if (!model.interfaces.empty())
    tie_seconds += timer.wall_time();
  const bool has_all_terms = !cell_terms.empty() && cellwise.empty() && asked_stages.size() == 1;
  find_shares();
  if (!has_all_terms) // some of the last set-up are products, or left out
    make_cell_terms();
  dealii::DynamicSparsityPattern pattern = make_pattern(t, constraints);
  has_tangent = false;
  n_tangents = 0;
  affine.reset();
  summands.clear();
  positions.clear();
  matrix.clear();
  matrix.reinit(model.numbering->split(model.numbering->owned), parts_of_blocks(), pattern,
                model.communicator);
  make_cell_operators(t);
}

/// Which unknowns are solved together.
template <int dim>
void BlockSystem<dim>::find_shares()
{
  stage_of_field = model.stages_of_fields();
  unsigned int n_stages = 1;
  for (auto &[field, stage] : stage_of_field) {
    stage = has_couplings ? 0 : stage;
    n_stages = std::max(n_stages, stage + 1);
  }
  stage_of_block.clear();
  for (const Block &block : model.numbering->blocks())
    stage_of_block.push_back(stage_of_field.at(block.field));
  asked_stages.assign(n_stages, true);
  stages_of_residual = asked_stages;
  shares.assign(model.domains.size(), {});
  for (unsigned int d = 0; d < model.domains.size(); ++d) {
    const auto &fields = model.domains[d]->fields();
    const CellLayout<dim> &layout = model.domains[d]->layout();
    for (unsigned int f = 0; f < fields.size(); ++f) {
      const unsigned int stage = stage_of_field.at(fields[f].name);
      auto share = std::find_if(shares[d].begin(), shares[d].end(),
                                [&](const Share &other) { return other.stage == stage; });
      if (share == shares[d].end())
        share = shares[d].insert(share, {stage, {}, {}});
      share->fields.push_back(f);
      for (unsigned int i = layout.first(fields[f].first_component);
           i < layout.first(fields[f].first_component + fields[f].n_components); ++i)
        share->unknowns.push_back(i);
    }
  }
}

template <int dim>
bool BlockSystem<dim>::is_left_out(const std::string &field, const std::string &by) const
{
  return stage_of_field.at(field) != stage_of_field.at(by);
}

template <int dim>
typename BlockSystem<dim>::Shares
BlockSystem<dim>::shares_of(const std::vector<dealii::types::global_dof_index> &dofs) const
{
  if (asked_stages.size() == 1)
    return {{0, {}, {}}};
  Shares result;
  for (unsigned int i = 0; i < dofs.size(); ++i) {
    const unsigned int stage = stage_of_block[model.numbering->block_of(dofs[i])];
    auto share =
        std::find_if(result.begin(), result.end(), [&](const Share &other) { return other.stage == stage; });
    if (share == result.end())
      share = result.insert(share, {stage, {}, {}});
    share->unknowns.push_back(i);
  }
  return result;
}

/// Those that have some of the blocks; empty: all.
template <int dim>
std::vector<bool> BlockSystem<dim>::stages_of(const std::vector<bool> &blocks) const
{
  std::vector<bool> stages(asked_stages.size(), blocks.empty());
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (blocks[b])
      stages[stage_of_block[b]] = true;
  return stages;
}

template <int dim>
Asked BlockSystem<dim>::what_is_asked(const std::string &field) const
{
  const unsigned int stage = stage_of_field.at(field);
  return !stages_of_residual[stage] ? Asked::nothing
         : asked_stages[stage]      ? Asked::derivatives
                                    : Asked::response;
}

/// The cells; ties are asked one by one.
template <int dim>
void BlockSystem<dim>::ask_for(const std::vector<bool> &of_blocks, const std::vector<bool> &residual_of)
{
  asked_stages = stages_of(of_blocks);
  stages_of_residual = stages_of(residual_of);
  for (unsigned int d = 0; d < model.domains.size(); ++d) {
    std::vector<Asked> of_fields;
    for (const Field &field : model.domains[d]->fields())
      of_fields.push_back(what_is_asked(field.name));
    cell_terms[d]->ask_for(of_fields);
  }
}

/// Whether the tangent of the cells has entries in a field's own block.
template <int dim>
bool BlockSystem<dim>::has_entries(const std::string &field) const
{
  const auto groups = model.field_groups();
  for (unsigned int g = 0; g < groups_with_entries.size(); ++g)
    if (!groups_with_entries[g] && std::find(groups[g].begin(), groups[g].end(), field) != groups[g].end())
      return false;
  return true;
}

template <int dim>
void BlockSystem<dim>::make_cell_terms()
{
  cell_terms.clear();
  time_of_given.reset();
  for (const auto &domain : model.domains) {
    cell_terms.push_back(std::make_unique<CellTerms<dim>>(*domain));
    cell_terms.back()->set_rates(&step_rates);
  }
}

/// Whether the terms of a tied field need no entries, like the cells on both sides.
template <int dim>
bool BlockSystem<dim>::is_given_as_products(const Interface<dim> &interface, const TiedField &field) const
{
  return form == Form::direct && TieOperator<dim>::is_possible(interface, field) &&
         !has_entries(field.names[source]);
}

/// Whether the tangent of a tie has entries in the row of a component and the column of another one, counted
/// over both sides.
template <int dim>
bool BlockSystem<dim>::has_entries(const Interface<dim> &interface, const unsigned int row,
                                   const unsigned int column) const
{
  if (!(form == Form::direct ? interface.couples(row, column) : interface.couples(column, row)))
    return false;
  const auto field_of = [&](const unsigned int i) -> const Field & {
    const unsigned int n = interface.components[source].size();
    const auto &side = interface.sides[i < n ? source : destination];
    const unsigned int c = i < n ? interface.components[source][i] : interface.components[destination][i - n];
    const auto &fields = side.domain->fields();
    return *std::find_if(fields.begin(), fields.end(),
                         [c](const Field &field) { return field.has_component(c); });
  };
  const std::string &name = field_of(row).name, &by = field_of(column).name;
  return !is_left_out(name, by) &&
         (name != by ||
          std::none_of(interface.fields.begin(), interface.fields.end(), [&](const auto &field) {
            return field.names[source] == name && is_given_as_products(interface, field);
          }));
}

/// Those of its fields that have some, and are asked for.
template <int dim>
std::vector<TieOperator<dim> *> BlockSystem<dim>::products_of(const Interface<dim> &interface) const
{
  std::vector<TieOperator<dim> *> products;
  for (const auto &[part, cells] : cellwise)
    for (const TiedField &field : interface.fields)
      if (TieOperator<dim> *of_field = cells->of_tie(interface, field);
          of_field != nullptr && is_asked(matrix.numbering(part).blocks()[0]))
        products.push_back(of_field);
  return products;
}

/// In place of entries, where the groups do without.
template <int dim>
void BlockSystem<dim>::make_cell_operators(const double t)
{
  for (unsigned int d = 0; d < model.domains.size(); ++d)
    for (const Field &field : model.domains[d]->fields())
      for (const Field &by : model.domains[d]->fields())
        if (is_left_out(field.name, by.name))
          cell_terms[d]->leave_out_coupling(field, by);
  cellwise.clear();
  const auto &blocks = model.numbering->blocks();
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (const unsigned int part = matrix.part_of(b);
        !blocks[b].is_constraint && !has_entries(blocks[b].field) && cellwise.count(part) == 0) {
      std::vector<typename CellwiseTangent<dim>::FieldOfTie> ties;
      for (const auto &interface : model.interfaces)
        for (const TiedField &field : interface->fields)
          if (interface->is_active(t) && is_given_as_products(*interface, field) &&
              field.names[source] == blocks[b].field)
            ties.emplace_back(interface.get(), &field);
      cellwise[part] = std::make_shared<CellwiseTangent<dim>>(model, matrix.numbering(part), ties);
      matrix.set_operator(part, cellwise[part]);
    }
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (const auto operators = cellwise.find(matrix.part_of(b)); operators != cellwise.end()) {
      const unsigned int d = blocks[b].domain_index;
      cell_terms[d]->give_tangent_to(model.domains[d]->fields()[blocks[b].field_index],
                                     operators->second->of_domain(d));
    }
}

/// Of each group of fields the blocks with a positive diagonal, and those of constraints: what a linear
/// solver wants as one matrix.
template <int dim>
std::vector<unsigned int> BlockSystem<dim>::parts_of_blocks() const
{
  std::map<std::pair<unsigned int, bool>, unsigned int> number;
  std::vector<unsigned int> parts;
  const auto groups = model.field_groups();
  for (const Block &block : model.numbering->blocks()) {
    const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto &group_fields) {
      return std::find(group_fields.begin(), group_fields.end(), block.field) != group_fields.end();
    });
    parts.push_back(
        number.try_emplace({group - groups.begin(), block.is_constraint}, number.size()).first->second);
  }
  return parts;
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
Vector BlockSystem<dim>::ghosted(const Vector &owned) const
{
  Vector copy = ghosted_scratch.n_blocks() > 0 ? ghosted_scratch : ghosted_vector(); // its layout is known
  copy = owned;
  return copy;
}

template <int dim>
void BlockSystem<dim>::set_rates(const Rates &rates)
{
  owned_rates = {};
  owned_rates.by_value = rates.by_value;
  owned_rates.second_by_value = rates.second_by_value;
  owned_rates.rest = rates.rest;
  owned_rates.second_rest = rates.second_rest;
  step_rates = {};
  step_rates.by_value = rates.by_value;
  step_rates.second_by_value = rates.second_by_value;
  if (rates.has_first())
    step_rates.rest = ghosted(rates.rest);
  if (rates.has_second())
    step_rates.second_rest = ghosted(rates.second_rest);
  step_rates.weights = rates.weights;
  for (const Vector &state : rates.past)
    step_rates.past.push_back(ghosted(state));
}

template <int dim>
void BlockSystem<dim>::set_time(const double t)
{
  share = 1;
  if (t != time) { // else set_up has made them
    if (prescribes_by_time())
      if (ConstraintLines lines_then = lines_at(t); !are_prescribed(lines_then))
        make_constraints(std::move(lines_then));
    time = t;
  }
  problem = {};
}

template <int dim>
void BlockSystem<dim>::begin_step(const double t, const Vector &x)
{
  set_time(t);
  keep_last_good(t, x);
  const bool has_weak_values =
      std::any_of(model.domains.begin(), model.domains.end(), [](const auto &domain) {
        return std::any_of(domain->conditions().begin(), domain->conditions().end(),
                           [](const auto &condition) { return condition->is_weak(); });
      });
  if (model.interfaces.empty() && !has_weak_values)
    return;
  ghosted_scratch = x;
  for (const auto &domain : model.domains)
    freeze_weak_penalties<dim>(*domain, t, ghosted_values());
  dealii::Timer timer;
  for (const auto &interface : model.interfaces)
    if (interface->is_active(t))
      interface->tie().begin_step(*interface, t, ghosted_values(), model.communicator);
  tie_seconds += timer.wall_time();
}

/// At boundary cells of domains whose conditions look at it.
template <int dim>
void BlockSystem<dim>::keep_last_good(const double t, const Vector &x)
{
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &domain : model.domains) {
    if (!domain->has_conditions_by_fields() || !domain->last_good.begin_step(t))
      continue;
    ghosted_scratch = x;
    for (const auto &cell : domain->dof_handler().active_cell_iterators())
      if (cell->is_locally_owned() && cell->at_boundary()) {
        domain->cell_dofs(cell, dofs);
        ghosted_values()(dofs, domain->last_good.unknowns()[cell->active_cell_index()]);
      }
  }
}

template <int dim>
void BlockSystem<dim>::hold_back_from(const Vector &x)
{
  share = 1;
  assemble(x, false);
  held_back = right_hand_side;
  held_moves.clear();
  for (const auto &line : constraints.get_lines())
    held_moves[line.index] = line.inhomogeneity;
}

namespace {

/// Whether @p change returns true for any; it is called for all, being collective.
template <int dim, typename Change>
bool change_active_ties(const Model<dim> &model, const double t, const Change &change)
{
  bool has_changed = false;
  for (const auto &interface : model.interfaces)
    if (interface->is_active(t) && change(*interface))
      has_changed = true;
  return has_changed;
}

} // namespace

template <int dim>
bool BlockSystem<dim>::update_penalties(const double t, const Vector &x)
{
  if (model.is_linear() || model.interfaces.empty())
    return false;
  dealii::Timer timer;
  ghosted_scratch = x;
  const bool is_any_outdated = change_active_ties(model, t, [&](const auto &interface) {
    return interface.tie().update_penalties(interface, t, ghosted_values(), model.communicator);
  });
  tie_seconds += timer.wall_time();
  return is_any_outdated;
}

template <int dim>
bool BlockSystem<dim>::adapt_ties(const double t, const Vector &x)
{
  if (model.interfaces.empty())
    return false;
  dealii::Timer timer;
  ghosted_scratch = x;
  const bool is_any_adapted = change_active_ties(model, t, [&](const auto &interface) {
    PointTerms<dim> *terms = interface.tie().parts().point_terms;
    return terms != nullptr && terms->adapt(interface, t, ghosted_values(), model.communicator);
  });
  tie_seconds += timer.wall_time();
  return is_any_adapted;
}

/// Of ghosted_scratch.
template <int dim>
ValuesOf BlockSystem<dim>::ghosted_values() const
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
  std::vector<double> largest_move(field_of_block.size(), 0.), largest_value(largest_move);
  unsigned int i = 0;
  for (const auto &line : constraints.get_lines()) {
    double target = prescribed[i++];
    for (const auto &[other, weight] : line.entries)
      target += weight * ghosted(other);
    if (share < 1)
      target -= (1 - share) * held_moves.at(line.index);
    const double distance = form == Form::transposed ? 0 : target - ghosted(line.index);
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

namespace {

/// An exception that this rank has caught, if any, or else one that another rank has.
void throw_on_all_ranks(const std::exception_ptr &fault, const MPI_Comm &communicator)
{
  if (dealii::Utilities::MPI::max(fault ? 1 : 0, communicator) == 0)
    return;
  if (fault)
    std::rethrow_exception(fault);
  throw std::runtime_error("another rank could not assemble its part.");
}

} // namespace

/// Only in time, where it is asked for again and again.
template <int dim>
AffineResidual<dim> *BlockSystem<dim>::affine_residual()
{
  if (!has_tangent || !has_rates() || !cellwise.empty() || form != Form::direct || asked_stages.size() > 1 ||
      !AffineResidual<dim>::is_possible(model, time))
    return nullptr;
  if (!affine) {
    dealii::AffineConstraints<double> no_lines(relevant);
    no_lines.close();
    dealii::DynamicSparsityPattern pattern = make_pattern(time, no_lines);
    affine = std::make_unique<AffineResidual<dim>>(model, parts_of_blocks(), pattern, relevant, time);
  }
  return affine->is_defined() ? affine.get() : nullptr;
}

/// The residual alone. @return whether it is defined; if not, integrals say where and why.
/// @pre affine_residual()
template <int dim>
bool BlockSystem<dim>::assemble_by_products(const Vector &x)
{
  ++n_assemblies.residuals_by_products;
  ghosted_scratch = x;
  move_constraints_from(ghosted_scratch);
  std::exception_ptr fault;
  try {
    affine->find_loads(time);
  } catch (...) { // perhaps of this rank alone
    fault = std::current_exception();
  }
  throw_on_all_ranks(fault, model.communicator);
  affine->evaluate(x, owned_rates);
  right_hand_side.equ(-1., affine->residual());
  std::vector<std::pair<dealii::types::global_dof_index, double>> passed_on;
  for (const auto &line : constraints.get_lines())
    if (model.numbering->owned.is_element(line.index)) {
      const unsigned int b = model.numbering->block_of(line.index);
      const Block &block = model.numbering->blocks()[b];
      double &force = right_hand_side.block(b)
                          .trilinos_vector()[0][block.owned.index_within_set(line.index - block.begin)];
      for (const auto &[other, weight] : line.entries)
        passed_on.emplace_back(other, weight * force);
      force = 0;
    }
  for (const auto &[other, force] : passed_on)
    right_hand_side(other) += force;
  right_hand_side.compress(dealii::VectorOperation::add);
  if (share < 1)
    right_hand_side.add(share - 1, held_back);

  sizes.forces = affine->squares_of_forces();
  sizes.on_free = sizes.forces;
  for (unsigned int b = 0; b < sizes.on_free.size(); ++b)
    sizes.on_free[b] *= cell_terms[0]->longest_sum();
  for (auto *block_sums : {&sizes.forces, &sizes.on_free})
    dealii::Utilities::MPI::sum(*block_sums, model.communicator, *block_sums);
  const bool is_defined = std::isfinite(std::accumulate(sizes.forces.begin(), sizes.forces.end(), 0.));
  Assert(!is_defined || is_as_integrated(x),
         dealii::ExcMessage("products and integrals give different residuals"));
  return is_defined;
}

/// Whether integrals give what products have given. Both stay within rounding of the forces, which sums of
/// many cells keep.
template <int dim>
bool BlockSystem<dim>::is_as_integrated(const Vector &x)
{
  const double largest = 1e-10;
  const Vector by_products = right_hand_side;
  const Sizes sizes_of_products = sizes;
  const unsigned int n_blocks = field_of_block.size();
  const std::vector<double> none(n_blocks, 0.);
  ghosted_scratch = x;
  right_hand_side = 0;
  sizes = {none, none, none, none};
  assemble_all(false);
  right_hand_side.compress(dealii::VectorOperation::add);
  if (share < 1)
    right_hand_side.add(share - 1, held_back);
  dealii::Utilities::MPI::sum(sizes.forces, model.communicator, sizes.forces);
  right_hand_side -= by_products;
  bool is_equal = true;
  for (unsigned int b = 0; b < n_blocks; ++b)
    is_equal = is_equal && !(right_hand_side.block(b).l2_norm() > largest * std::sqrt(sizes.forces[b]));
  right_hand_side = by_products;
  sizes = sizes_of_products;
  return is_equal;
}

/// K and M on the constraints of the update, which stay as they are when prescribed values change.
template <int dim>
void BlockSystem<dim>::find_summands()
{
  Rates without;
  std::swap(without, step_rates); // cells see them
  matrix = 0;
  assemble_all(true);
  matrix.compress(dealii::VectorOperation::add);
  right_hand_side.compress(dealii::VectorOperation::add);
  std::swap(without, step_rates);
  summands[0].copy_from(matrix);
  for (unsigned int order = 1; order <= model.order_in_time(); ++order) {
    summands[order].copy_from(matrix);
    summands[order] = 0;
    affine->add_mass(constraints, order, summands[order]);
  }
}

/// For another step. @pre affine_residual()
template <int dim>
void BlockSystem<dim>::combine_tangent()
{
  ++n_assemblies.tangents_by_sums;
  if (summands.empty())
    find_summands();
  matrix = 0;
  for (const auto &[order, summand] : summands)
    matrix.add(order == 0 ? 1. : order == 1 ? step_rates.by_value : step_rates.second_by_value, summand);
  rates_of_tangent = {{step_rates.by_value, step_rates.second_by_value}};
}

namespace {

/// By block, of sums of so many terms.
std::vector<double> squares_of_products(const BlockMatrix &matrix, const Vector &x, const double n_terms)
{
  std::vector<double> squares;
  for (unsigned int b = 0; b < x.n_blocks(); ++b)
    squares.push_back(n_terms * std::pow(matrix.size_of_product(b, x), 2));
  return squares;
}

} // namespace

/// Those of the stages that are asked for are assembled anew.
template <int dim>
void BlockSystem<dim>::begin_tangent()
{
  std::vector<bool> rows;
  for (unsigned int b = 0; b < field_of_block.size(); ++b)
    rows.push_back(is_asked(b));
  matrix.set_zero(rows);
  for (const auto &[part, cells] : cellwise)
    if (is_asked(matrix.numbering(part).blocks()[0]))
      cells->begin(constraints);
}

/// Where the second tangent is that of another step, as in the start of a scheme, a third one may never come.
/// The rounding that tangent_at_x stands for falls and grows with x also where the tangent is a sum.
template <int dim>
bool BlockSystem<dim>::assemble(const Vector &x, const bool with_tangent, const std::vector<bool> &of_blocks,
                                const std::vector<bool> &residual_of)
{
  const unsigned int few_tangents = 2;
  if ((!with_tangent || n_tangents >= few_tangents) && affine_residual() != nullptr) {
    if (with_tangent) {
      combine_tangent();
      tangent_at_x = squares_of_products(matrix, x, cell_terms[0]->longest_sum());
    }
    if (assemble_by_products(x))
      return true;
  }
  ++(with_tangent ? n_assemblies.tangents : n_assemblies.residuals_alone);
  ghosted_scratch = x;
  move_constraints_from(ghosted_scratch);
  right_hand_side = 0;
  ask_for(of_blocks.empty() && !with_tangent ? residual_of : of_blocks, residual_of);
  if (with_tangent)
    begin_tangent();
  problem_here = {};
  last_undefined() = {};
  const unsigned int n_blocks = field_of_block.size();
  const std::vector<double> none(n_blocks, 0.);
  sizes = {none, none, none, none};

  std::exception_ptr fault;
  bool is_defined = true;
  try {
    is_defined = assemble_all(with_tangent);
  } catch (...) { // perhaps of this rank alone: the others wait in compress()
    fault = std::current_exception();
  }
  if (with_tangent)
    matrix.compress(dealii::VectorOperation::add);
  right_hand_side.compress(dealii::VectorOperation::add);
  if (with_tangent)
    for (const auto &[part, cells] : cellwise)
      if (is_asked(matrix.numbering(part).blocks()[0])) {
        cells->finish();
        if (moves_constraints())
          cells->subtract_moves(constraints, right_hand_side);
      }
  if (share < 1)
    right_hand_side.add(share - 1, held_back);
  for (auto *block_sums : {&sizes.forces, &sizes.on_free, &sizes.tangents, &sizes.products})
    dealii::Utilities::MPI::sum(*block_sums, model.communicator, *block_sums);
  for (unsigned int b = 0; with_tangent && b < n_blocks; ++b)
    if (is_asked(b)) {
      tangent_at_x[b] = sizes.tangents[b];
      products_at_x[b] = sizes.products[b];
    }
  throw_on_all_ranks(fault, model.communicator);
  is_defined = dealii::Utilities::MPI::min(is_defined ? 1 : 0, model.communicator) == 1;
  has_tangent = with_tangent ? is_defined : has_tangent;
  n_tangents += with_tangent ? 1 : 0;
  if (with_tangent)
    rates_of_tangent = {{step_rates.by_value, step_rates.second_by_value}};
  if (!is_defined) {
    problem = first_of_ranks(problem_here, model.communicator);
    if (problem.is_at_every_state)
      throw UserError(problem.reason);
  }
  return is_defined;
}

template <int dim>
void BlockSystem<dim>::accept_state()
{
  for (const auto &interface : model.interfaces)
    if (PointTerms<dim> *terms = interface->tie().parts().point_terms)
      terms->accept_state();
}

/// At ghosted_scratch. Points of interfaces that are switched off belong to their bodies still.
template <int dim>
bool BlockSystem<dim>::evaluate_memory(const double t)
{
  bool is_defined = true;
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns;
  for (unsigned int d = 0; d < model.domains.size(); ++d)
    if (const Domain<dim> &domain = *model.domains[d]; domain.memory)
      for (const auto &cell : domain.dof_handler().active_cell_iterators())
        if (cell->is_locally_owned()) {
          domain.cell_dofs(cell, dofs);
          ghosted_values()(dofs, unknowns);
          is_defined = cell_terms[d]->evaluate_memory(cell, t, unknowns) && is_defined;
        }
  for (const auto &interface : model.interfaces)
    if (!interface->memory.empty())
      is_defined = (interface->is_active(t)
                        ? interface->tie().evaluate_memory(*interface, t, ghosted_values())
                        : interface->tie().Tie<dim>::evaluate_memory(*interface, t, ghosted_values())) &&
                   is_defined;
  return is_defined;
}

template <int dim>
bool BlockSystem<dim>::remember(const double t, const Vector &x)
{
  if (std::none_of(model.materials.begin(), model.materials.end(),
                   [](const auto &material) { return material->has_memory(); }) &&
      std::all_of(model.interfaces.begin(), model.interfaces.end(),
                  [](const auto &interface) { return interface->tie().internal_variables().empty(); }))
    return true;
  ghosted_scratch = x;
  std::exception_ptr fault;
  bool is_defined = true;
  try {
    is_defined = evaluate_memory(t);
  } catch (...) { // perhaps of this rank alone
    fault = std::current_exception();
  }
  throw_on_all_ranks(fault, model.communicator);
  if (dealii::Utilities::MPI::min(is_defined ? 1 : 0, model.communicator) == 0)
    return false;
  for (const auto &domain : model.domains)
    if (domain->memory)
      domain->memory->accept();
  for (const auto &interface : model.interfaces)
    interface->memory.accept();
  return true;
}

namespace {

/// At the points of an interface, of both sides.
template <int dim>
void look_at_start_of_sides(Interface<dim> &interface, const ValuesOf &values_of)
{
  SidePoints<dim> points(interface, 0);
  for_each_group(interface, values_of, [&](const auto &group, const std::vector<double> &unknowns) {
    for (unsigned int q = group.begin; q < group.end; ++q)
      for (const unsigned int side : {source, destination})
        if (const Material<dim> &material = interface.sides[side].domain->material;
            material.has_to_look_at_start()) {
          points.reinit(side, q, unknowns);
          material.look_at_start(points.state[side]);
          interface.memory.set_trial(side, q, points.state[side].memory.trial);
        }
  });
  interface.memory.accept();
}

} // namespace

template <int dim>
void BlockSystem<dim>::look_at_start(const Vector &x)
{
  const auto has_to = [](const Domain<dim> &domain) { return domain.material.has_to_look_at_start(); };
  if (std::none_of(model.domains.begin(), model.domains.end(),
                   [&](const auto &domain) { return has_to(*domain); }))
    return;
  ghosted_scratch = x;
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns;
  for (unsigned int d = 0; d < model.domains.size(); ++d)
    if (const Domain<dim> &domain = *model.domains[d]; has_to(domain)) {
      for (const auto &cell : domain.dof_handler().active_cell_iterators())
        if (cell->is_locally_owned()) {
          domain.cell_dofs(cell, dofs);
          ghosted_values()(dofs, unknowns);
          cell_terms[d]->look_at_start(cell, unknowns);
        }
      domain.memory->accept();
    }
  for (const auto &interface : model.interfaces)
    if (std::any_of(interface->sides.begin(), interface->sides.end(),
                    [&](const auto &side) { return has_to(*side.domain); }))
      look_at_start_of_sides(*interface, ghosted_values());
}

/// @return whether all laws are defined on this rank.
template <int dim>
bool BlockSystem<dim>::assemble_all(const bool with_tangent)
{
  bool is_defined = true;
  time_of_given.reset();
  for (unsigned int d = 0; d < model.domains.size(); ++d) {
    cell_terms[d]->forget_given();
    is_defined = assemble_domain(d, ghosted_scratch, with_tangent) && is_defined;
  }
  if (is_defined &&
      std::find(stages_of_residual.begin(), stages_of_residual.end(), false) == stages_of_residual.end())
    time_of_given = time;
  if (!model.interfaces.empty()) {
    dealii::Timer timer;
    for (const auto &interface : model.interfaces) {
      if (interface->is_active(time) && interface->tie().parts().point_terms != nullptr)
        is_defined = assemble_point_terms(*interface, with_tangent) && is_defined;
      assemble_multipliers(*interface, ghosted_scratch, with_tangent);
    }
    tie_seconds += timer.wall_time();
  }
  return is_defined;
}

/// At ghosted_scratch: what is asked for. Whoever asks the tie next, asks for all.
template <int dim>
bool BlockSystem<dim>::assemble_point_terms(Interface<dim> &interface, const bool with_tangent)
{
  std::vector<Asked> of_fields;
  for (const TiedField &field : interface.fields)
    of_fields.push_back(
        std::max(what_is_asked(field.names[source]), what_is_asked(field.names[destination])));
  if (std::all_of(of_fields.begin(), of_fields.end(),
                  [](const Asked asked) { return asked == Asked::nothing; }))
    return true;
  PointTerms<dim> &terms = *interface.tie().parts().point_terms;
  BOOST_SCOPE_EXIT_ALL(&terms)
  {
    terms.ask_for({});
  };
  terms.ask_for(of_fields);
  return assemble_interface(interface, ghosted_scratch, with_tangent);
}

/// Keep the reason that was left last, unless there is one of this assembly.
template <int dim>
void BlockSystem<dim>::note_undefined(const std::string &where)
{
  if (problem_here)
    return;
  problem_here = last_undefined();
  if (!problem_here)
    problem_here.reason = "a residual is not a finite number";
  problem_here.reason += " [" + where + "]";
}

/// Those stages that are asked for.
template <int dim>
void BlockSystem<dim>::scatter(const Shares &shares, const std::vector<double> &residual,
                               const std::vector<dealii::types::global_dof_index> &dofs,
                               const bool with_tangent, const unsigned int cell_index, const unsigned int d)
{
  for (unsigned int s = 0; s < shares.size(); ++s) {
    if (!stages_of_residual[shares[s].stage])
      continue;
    const std::vector<unsigned int> &unknowns = shares[s].unknowns;
    const unsigned int n = unknowns.size();
    const bool has_matrix = with_tangent && asked_stages[shares[s].stage], is_all = shares.size() == 1;
    if (!is_all) {
      residual_of_share.resize(n);
      dofs_of_share.resize(n);
      for (unsigned int i = 0; i < n; ++i) {
        residual_of_share[i] = residual[unknowns[i]];
        dofs_of_share[i] = dofs[unknowns[i]];
      }
    }
    if (!is_all && has_matrix) {
      if (matrix_of_share.m() != n)
        matrix_of_share.reinit(n, n, true);
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int j = 0; j < n; ++j)
          matrix_of_share(i, j) = local_matrix(unknowns[i], unknowns[j]);
    }
    const auto &matrix_here = is_all ? local_matrix : matrix_of_share;
    const auto &residual_here = is_all ? residual : residual_of_share;
    const auto &dofs_here = is_all ? dofs : dofs_of_share;
    const bool may_be_known =
        has_matrix && cell_index != dealii::numbers::invalid_unsigned_int && positions[d][s] != nullptr;
    if (!may_be_known || !positions[d][s]->add(cell_index, dofs_here, constraints, matrix_here, residual_here,
                                               right_hand_side))
      scatter(matrix_here, residual_here, dofs_here, has_matrix);
  }
}

template <int dim>
void BlockSystem<dim>::scatter(const dealii::FullMatrix<double> &of_matrix,
                               const std::vector<double> &residual,
                               const std::vector<dealii::types::global_dof_index> &dofs,
                               const bool with_tangent)
{
  local_rhs.reinit(residual.size(), true);
  for (unsigned int i = 0; i < residual.size(); ++i)
    local_rhs[i] = -residual[i];
  if (with_tangent && form == Form::transposed) {
    local_transpose.reinit(residual.size(), residual.size(), true);
    local_transpose.copy_transposed(of_matrix);
    distribute_local_to_global(constraints, local_transpose, local_rhs, dofs, matrix, right_hand_side);
  } else if (with_tangent)
    distribute_local_to_global(constraints, of_matrix, local_rhs, dofs, matrix, right_hand_side);
  else
    constraints.distribute_local_to_global(local_rhs, dofs, right_hand_side);
}

/// From the second tangent on.
template <int dim>
void BlockSystem<dim>::keep_positions(const unsigned int d, const bool with_tangent)
{
  positions.resize(model.domains.size());
  positions[d].resize(shares[d].size());
  if (!with_tangent || form != Form::direct || !cell_terms[d]->has_entries())
    return;
  for (unsigned int s = 0; s < shares[d].size(); ++s)
    if (asked_stages[shares[d][s].stage] &&
        std::any_of(shares[d][s].fields.begin(), shares[d][s].fields.end(), [&](const unsigned int f) {
          return shares[d].size() == 1 || has_entries(model.domains[d]->fields()[f].name);
        })) {
      if (positions[d][s])
        positions[d][s]->keep();
      else
        positions[d][s] =
            std::make_unique<KeptPositions<dim>>(*model.domains[d], shares[d][s].fields, matrix);
    }
}

template <int dim>
bool BlockSystem<dim>::assemble_domain(const unsigned int d, const Vector &ghosted, const bool with_tangent)
{
  const Domain<dim> &domain = *model.domains[d];
  const unsigned int n_local = domain.dofs_per_cell();
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(n_local), residual(n_local);
  local_matrix.reinit(n_local, n_local);
  keep_positions(d, with_tangent);
  if (std::none_of(shares[d].begin(), shares[d].end(),
                   [this](const Share &share) { return stages_of_residual[share.stage]; }))
    return true;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      ghosted.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
      for (unsigned int s = 0; with_tangent && s < shares[d].size(); ++s)
        if (positions[d][s] && asked_stages[shares[d][s].stage])
          positions[d][s]->prefetch(cell->active_cell_index());
      if (!cell_terms[d]->assemble(cell, time, unknowns, residual, with_tangent ? &local_matrix : nullptr)) {
        note_undefined("domain " + domain.name + ", the cell around " + in_words(cell->center()));
        return false;
      }
      const bool has_local_matrix = with_tangent && cell_terms[d]->has_entries(cell);
      add_sizes(dofs, cell_terms[d]->forces(), unknowns, cell_terms[d]->longest_sum(), has_local_matrix);
      if (with_tangent && !cell_terms[d]->products().empty())
        add_products(dofs, cell_terms[d]->products(), cell_terms[d]->longest_sum());
      scatter(shares[d], residual, dofs, has_local_matrix, cell->active_cell_index(), d);
    }
  return true;
}

/// Whether the tangent of a tie has entries in any row and column.
template <int dim>
bool BlockSystem<dim>::has_entries(const Interface<dim> &interface) const
{
  const unsigned int n = interface.components[source].size() + interface.components[destination].size();
  for (unsigned int row = 0; row < n; ++row)
    for (unsigned int column = 0; column < n; ++column)
      if (has_entries(interface, row, column))
        return true;
  return false;
}

/// The terms of a group. @p rest: what is not given as products
/// @return whether they are defined
template <int dim>
bool BlockSystem<dim>::assemble_products(PointTerms<dim> &terms, const Interface<dim> &interface,
                                         const unsigned int g,
                                         const std::vector<TieOperator<dim> *> &products,
                                         const std::vector<dealii::types::global_dof_index> &dofs,
                                         const std::vector<double> &unknowns, std::vector<double> &residual,
                                         dealii::FullMatrix<double> *rest)
{
  const LeadingUnknowns &leading = products[0]->leading(g);
  residual_of_leading.assign(leading.size(), 0.);
  of_leading.reinit(leading.size(), leading.size());
  const bool is_defined = terms.assemble_leading(interface, interface.pairing().groups[g], time, unknowns,
                                                 residual_of_leading, &of_leading);
  leading.expand(residual_of_leading, residual);
  for (TieOperator<dim> *of_field : products)
    of_field->add(g, of_leading);
  add_products(dofs, leading.sizes_of_products(of_leading, unknowns), dofs.size());
  if (rest == nullptr)
    return is_defined;
  leading.expand(of_leading, *rest);
  for (const TieOperator<dim> *of_field : products)
    of_field->clear_own_entries(*rest);
  return is_defined;
}

template <int dim>
bool BlockSystem<dim>::assemble_interface(Interface<dim> &interface, const Vector &ghosted,
                                          const bool with_tangent)
{
  PointTerms<dim> &terms = *interface.tie().parts().point_terms;
  const std::vector<TieOperator<dim> *> products =
      with_tangent ? products_of(interface) : std::vector<TieOperator<dim> *>();
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns, residual;
  const unsigned int n_local = interface.n_local(source) + interface.n_local(destination);
  unknowns.resize(n_local);
  const bool has_local_matrix = with_tangent && has_entries(interface);
  if (has_local_matrix)
    local_matrix.reinit(n_local, n_local);
  Shares shares_here; // those of all groups
  const auto &groups = interface.pairing().groups;
  for (unsigned int g = 0; g < groups.size(); ++g) {
    const auto &group = groups[g];
    interface.group_dofs(group, dofs);
    if (g == 0)
      shares_here = shares_of(dofs);
    ghosted.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    residual.assign(n_local, 0.);
    bool is_defined = true;
    if (!products.empty())
      is_defined = assemble_products(terms, interface, g, products, dofs, unknowns, residual,
                                     has_local_matrix ? &local_matrix : nullptr);
    else {
      if (with_tangent && has_local_matrix)
        local_matrix = 0;
      is_defined = terms.assemble(interface, group, time, unknowns, residual,
                                  has_local_matrix ? &local_matrix : nullptr);
    }
    if (!is_defined) {
      note_undefined("interface " + interface.name + " near " +
                     in_words(interface.pairing().X(source, group.begin)));
      return false;
    }
    add_sizes(dofs, residual, unknowns, n_local, has_local_matrix && products.empty());
    if (const auto position = merge_repeated(interface, dofs); !position.empty()) {
      std::vector<double> merged_residual(dofs.size(), 0.);
      dealii::FullMatrix<double> merged(dofs.size(), dofs.size());
      for (unsigned int i = 0; i < position.size(); ++i) {
        merged_residual[position[i]] += residual[i];
        for (unsigned int j = 0; has_local_matrix && j < position.size(); ++j)
          merged(position[i], position[j]) += local_matrix(i, j);
      }
      std::swap(merged, local_matrix);
      scatter(shares_of(dofs), merged_residual, dofs, has_local_matrix);
      std::swap(merged, local_matrix);
    } else
      scatter(shares_here, residual, dofs, has_local_matrix);
  }
  return true;
}

template <int dim>
void BlockSystem<dim>::assemble_multipliers(const Interface<dim> &interface, const Vector &ghosted,
                                            const bool with_tangent)
{
  const Multipliers<dim> *multipliers = interface.tie().parts().multipliers;
  std::vector<double> unknowns, residual;
  if (multipliers == nullptr)
    return;
  if (!interface.is_active(time)) { // they are zero
    local_matrix.reinit(1, 1);
    local_matrix(0, 0) = 1;
    for_each_multiplier(
        interface, [&](const auto dof) { scatter(shares_of({dof}), {ghosted(dof)}, {dof}, with_tangent); });
    return;
  }
  for (unsigned int i = 0; i < multipliers->n_terms(); ++i) {
    const auto &dofs = multipliers->term_dofs(i);
    unknowns.resize(dofs.size());
    ghosted.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    residual.assign(dofs.size(), 0.);
    local_matrix.reinit(dofs.size(), dofs.size());
    multipliers->assemble_term(i, unknowns, residual, with_tangent ? &local_matrix : nullptr);
    std::vector<double> row_values = residual;
    if (dofs.size() > 1) // in the multiplier's equation the traces cancel
      row_values.back() = multipliers->magnitude_of_term(i, unknowns);
    add_sizes(dofs, row_values, unknowns, dofs.size(), with_tangent);
    scatter(shares_of(dofs), residual, dofs, with_tangent);
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
    return interface->is_active(time) && interface->tie().parts().flux_recovery != nullptr;
  });
}

template <int dim>
NodalForces<dim> BlockSystem<dim>::nodal_forces(const Vector &x)
{
  AffineResidual<dim> *products = affine_residual();
  if (products != nullptr) {
    std::exception_ptr fault;
    try {
      products->find_loads(time);
    } catch (...) {
      fault = std::current_exception();
    }
    throw_on_all_ranks(fault, model.communicator);
    products->evaluate(x, owned_rates);
  }
  std::vector<std::optional<Flows>> given(model.domains.size());
  for (unsigned int d = 0; d < given.size(); ++d)
    if (const Flows *flows = cell_terms[d]->given_flows(); flows != nullptr && time == time_of_given)
      given[d] = *flows;
  return NodalForces<dim>(model, lines, constraints, ghosted(x), time, step_rates, products, given);
}

template <int dim>
NodalForces<dim> BlockSystem<dim>::nodal_forces(const Vector &x, const double t, const Rates &rates)
{
  const double time_before = time;
  Rates step_rates_before = step_rates, owned_rates_before = owned_rates;
  set_rates(rates);
  if (model.active_toggles(t) == toggles_of_set_up)
    set_time(t);
  NodalForces<dim> result = nodal_forces(x);
  set_time(time_before);
  step_rates = std::move(step_rates_before);
  owned_rates = std::move(owned_rates_before);
  return result;
}

template <int dim>
void BlockSystem<dim>::find_multipliers(const Vector &x, const NodalForces<dim> &forces)
{
  ghosted_scratch = x;
  for (const auto &interface : model.interfaces)
    if (FluxRecovery<dim> *recovery = interface->tie().parts().flux_recovery;
        recovery != nullptr && interface->is_active(time))
      recovery->find_multipliers(
          *interface, [&](const auto dof) { return ghosted_scratch(dof); },
          [&](const auto dof) { return forces(dof); }, model.communicator);
}

template <int dim>
NoteList BlockSystem<dim>::notes() const
{
  NoteList all;
  for (const auto &domain : model.domains) {
    if (const std::string sentence = note_on_mesh(domain->mesh()); !sentence.empty())
      all.push_back(of_mesh(sentence).of(domain->name));
    if (domain->degree == 1 && (has_curved_cells(domain->mesh()) || has_curved_simplices(domain->mesh())))
      all.push_back(
          of_mesh("the cells of the file are curved, but those of degree 1 are straight. Set Degree = 2")
              .of(domain->name));
    for (const Note &note : notes_on_locking(*domain, model.communicator))
      all.push_back(note.of(domain->name));
  }
  for (const auto &interface : model.interfaces)
    if (interface->is_active(time))
      for (const Note &note : interface->notes())
        all.push_back(note.of(interface->name));
  if (const auto n = dealii::Utilities::MPI::sum(unconstrained.size(), model.communicator); n > 0)
    all.push_back(of_dropped_constraints(
        "constraints of interfaces that meet led back to themselves and were dropped at " +
        std::to_string(n) + (n == 1 ? " unknown" : " unknowns")));
  return all;
}

/// What one cell or group of points adds to the sizes. A force on an unknown that follows others acts on
/// them; on one that is prescribed it is a reaction, in which nothing needs to cancel.
template <int dim>
void BlockSystem<dim>::add_sizes(const std::vector<dealii::types::global_dof_index> &dofs,
                                 const std::vector<double> &forces, const std::vector<double> &unknowns,
                                 const unsigned int longest_sum, const bool with_tangent)
{
  thread_local std::vector<double> row_sums;
  row_sums.assign(dofs.size(), 0.);
  if (with_tangent && std::any_of(unknowns.begin(), unknowns.end(), [](const double x) { return x != 0; }))
    add_up_sizes(dofs.size(), &local_matrix(0, 0), unknowns.data(), row_sums.data());
  unsigned int block = 0; // that of the unknown before, most often
  for (unsigned int i = 0; i < dofs.size(); ++i) {
    const double row_sum = row_sums[i];
    const auto add = [&](const unsigned int block, const double weight) {
      const double force = weight * weight * forces[i] * forces[i];
      sizes.forces[block] += force;
      sizes.on_free[block] += longest_sum * force;
      sizes.products[block] += weight * weight * row_sum * row_sum;
      sizes.tangents[block] += longest_sum * weight * weight * row_sum * row_sum;
    };
    const Block &before = model.numbering->blocks()[block];
    if (dofs[i] < before.begin || dofs[i] >= before.end)
      block = model.numbering->block_of(dofs[i]);
    if (!constraints.is_constrained(dofs[i]))
      add(block, 1.);
    else {
      sizes.forces[block] += forces[i] * forces[i];
      for (const auto &[other, weight] : *constraints.get_constraint_entries(dofs[i]))
        add(model.numbering->block_of(other), weight);
    }
  }
}

/// Likewise of the tangents of a cell that have no entries.
template <int dim>
void BlockSystem<dim>::add_products(const std::vector<dealii::types::global_dof_index> &dofs,
                                    const std::vector<double> &products, const unsigned int longest_sum)
{
  for (unsigned int i = 0; i < dofs.size(); ++i) {
    const auto add = [&](const unsigned int block, const double weight) {
      sizes.products[block] += weight * weight * products[i] * products[i];
      sizes.tangents[block] += longest_sum * weight * weight * products[i] * products[i];
    };
    if (!constraints.is_constrained(dofs[i]))
      add(model.numbering->block_of(dofs[i]), 1.);
    else
      for (const auto &[other, weight] : *constraints.get_constraint_entries(dofs[i]))
        add(model.numbering->block_of(other), weight);
  }
}

template <int dim>
std::vector<double> BlockSystem<dim>::residuals() const
{
  std::vector<double> norms;
  for (unsigned int b = 0; b < right_hand_side.n_blocks(); ++b)
    norms.push_back(right_hand_side.block(b).l2_norm());
  return norms;
}

/// Nothing is at work in the equations of a constraint of a body, as one on its volume, but the terms that
/// cancel.
template <int dim>
std::vector<double> BlockSystem<dim>::forces() const
{
  std::vector<double> norms;
  for (unsigned int b = 0; b < sizes.forces.size(); ++b)
    norms.push_back(std::sqrt(sizes.forces[b] + (is_constraint[b] ? products_at_x[b] : 0)));
  return norms;
}

/// The errors of n terms, each of relative size u, add up like a random walk: u n^(1/2) times the sum of the
/// sizes (Higham and Mary 2019); likewise those of different cells.
template <int dim>
std::vector<double> BlockSystem<dim>::rounding() const
{
  const double unit_roundoff = std::numeric_limits<double>::epsilon() / 2;
  std::vector<double> norms;
  for (unsigned int b = 0; b < sizes.on_free.size(); ++b)
    norms.push_back(unit_roundoff * (std::sqrt(sizes.on_free[b]) + std::sqrt(tangent_at_x[b])));
  return norms;
}

template <int dim>
std::vector<double> BlockSystem<dim>::linear_residuals(const Vector &dx, Vector &rest)
{
  // the forces on a block are its right-hand side, what its cells had before, and what other blocks give it
  rest = right_hand_side;
  std::vector<double> reference = residuals();
  const std::vector<double> before = forces();
  for (unsigned int row = 0; row < dx.n_blocks(); ++row)
    reference[row] = std::max(reference[row], before[row]);
  const bool is_zero = dx.linfty_norm() == 0;
  if (!is_zero)
    matrix.for_each_product(dx, [&](const unsigned int row, const unsigned int column, const auto &product) {
      rest.block(row) -= product;
      if (row != column)
        reference[row] = std::max(reference[row], product.l2_norm());
    });
  for (unsigned int b = 0; b < dx.n_blocks(); ++b)
    if ((is_constraint[b] || is_of_multipliers[field_of_block[b]]) && !is_zero) // both sides may be one block
      reference[b] = std::max(reference[b], matrix.size_of_product(b, dx));
  // a block on which nothing acts keeps the rounding of the others, with which it is solved
  std::vector<double> rounding(fields.size(), 0.);
  for (unsigned int b = 0; b < dx.n_blocks(); ++b)
    rounding[field_of_block[b]] =
        std::max(rounding[field_of_block[b]], std::numeric_limits<double>::epsilon() * reference[b]);
  std::vector<double> relative(dx.n_blocks(), 0.);
  for (unsigned int b = 0; b < dx.n_blocks(); ++b)
    if (const double norm = rest.block(b).l2_norm(); !(norm <= rounding[field_of_block[b]]))
      relative[b] = norm / reference[b];
  return relative;
}

template <int dim>
std::optional<UnrestrainedMode<dim>> BlockSystem<dim>::find_unrestrained_mode(const bool in_any_case) const
{
  for (unsigned int f = 0; f < fields.size(); ++f)
    if (!is_of_multipliers[f] && (in_any_case || !is_surely_held(model, fields[f], time, constraints)))
      if (const auto motion = dovetail::find_unrestrained_mode(model, fields[f], time, matrix, constraints))
        return motion;
  return {};
}

/// x_i = sum w x_j + b_i with b_i = @p constant(line, its number)
template <int dim>
template <typename Constant>
void BlockSystem<dim>::apply(Vector &x, const Constant &constant, const bool what_is_prescribed)
{
  ghosted_scratch = x;
  unsigned int i = 0;
  for (const auto &line : constraints.get_lines()) {
    double value = constant(line, i++);
    if (model.numbering->owned.is_element(line.index) && (what_is_prescribed || !line.entries.empty())) {
      for (const auto &[other, weight] : line.entries)
        value += weight * ghosted_scratch(other);
      x(line.index) = value;
    }
  }
  x.compress(dealii::VectorOperation::insert);
}

template <int dim>
void BlockSystem<dim>::distribute(Vector &dx)
{
  apply(dx, [](const auto &line, unsigned int) { return line.inhomogeneity; });
}

template <int dim>
void BlockSystem<dim>::distribute_rate(Vector &rate, const bool what_is_prescribed)
{
  apply(
      rate, [](const auto &, unsigned int) { return 0.; }, what_is_prescribed);
}

template <int dim>
void BlockSystem<dim>::follow(Vector &x)
{
  apply(
      x, [this](const auto &, const unsigned int i) { return prescribed[i]; }, false);
}

template <int dim>
void BlockSystem<dim>::constrain(Vector &x)
{
  apply(x, [this](const auto &, const unsigned int i) { return prescribed[i]; });
}

template class BlockSystem<2>;
template class BlockSystem<3>;

} // namespace dovetail
