// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/block_system.h>

#include <dovetail/domain/curved_cells.h>
#include <dovetail/domain/locking.h>
#include <dovetail/domain/mesh_note.h>
#include <dovetail/domain/simplices.h>
#include <dovetail/system/affine_residual.h>
#include <dovetail/system/remember.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/timer.h>

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

} // namespace

template <int dim>
BlockSystem<dim>::BlockSystem(Model<dim> &model, const Form form)
    : model(model), stages(model), entries(model, stages, form), constraints(model, form == Form::transposed),
      sizes(*model.numbering), sums(model, stages, entries, constraints, matrix, negative_sums)
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
void BlockSystem<dim>::set_up(const double t,
                              const std::function<std::vector<bool>()> &entries_for_constraints)
{
  toggles_of_set_up = model.active_toggles(t);
  time_of_set_up = t;
  time = t;
  constraints.set_up(t);
  if (entries_for_constraints)
    choose_entries(entries_for_constraints());
  make_sparsity(t);
  right_hand_side = owned_vector();
  const Numbering &numbering = *model.numbering;
  ghosts = std::make_shared<GhostExchange>(
      numbering.split(numbering.owned), numbering.split(constraints.relevant_unknowns()),
      [&](const unsigned int block, const auto index) {
        return numbering.owner(numbering.blocks()[block].begin + index);
      },
      model.communicator);
  ghosted_scratch = ghosts->ghosted_vector();
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
  const bool has_all_terms = !cell_terms.empty() && cellwise.empty() && stages.size() == 1;
  stages.reinit(has_couplings);
  if (!has_all_terms) // some of the last set-up are products, or left out
    make_cell_terms();
  dealii::DynamicSparsityPattern pattern =
      entries.pattern(t, cell_terms, constraints.of_update(), constraints.relevant_unknowns());
  has_tangent = false;
  n_tangents = 0;
  affine.reset();
  are_products_rounded = false;
  summands.clear();
  sums.reinit();
  matrix.clear();
  matrix.reinit(model.numbering->split(model.numbering->owned), parts_of_blocks(), pattern,
                model.communicator);
  make_cell_operators(t);
}

/// The cells; ties are asked one by one.
template <int dim>
void BlockSystem<dim>::ask_for(const std::vector<bool> &of_blocks, const std::vector<bool> &residual_of)
{
  stages.ask_for(of_blocks, residual_of);
  for (unsigned int d = 0; d < model.domains.size(); ++d) {
    std::vector<Asked> of_fields;
    for (const Field &field : model.domains[d]->fields())
      of_fields.push_back(stages.what_is_asked(field.name));
    cell_terms[d]->ask_for(of_fields);
  }
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

/// Those of its fields that have some, and are asked for.
template <int dim>
std::vector<TieOperator<dim> *> BlockSystem<dim>::products_of(const Interface<dim> &interface) const
{
  std::vector<TieOperator<dim> *> products;
  for (const auto &[part, cells] : cellwise)
    for (const TiedField &field : interface.fields)
      if (TieOperator<dim> *of_field = cells->of_tie(interface, field);
          of_field != nullptr && stages.asks_tangent(matrix.numbering(part).blocks()[0]))
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
        if (stages.is_left_out(field.name, by.name))
          cell_terms[d]->leave_out_coupling(field, by);
  cellwise.clear();
  const auto &blocks = model.numbering->blocks();
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (const unsigned int part = matrix.part_of(b);
        !blocks[b].is_constraint && !entries.exist(blocks[b].field) && cellwise.count(part) == 0) {
      std::vector<typename CellwiseTangent<dim>::FieldOfTie> ties;
      for (const auto &interface : model.interfaces)
        for (const TiedField &field : interface->fields)
          if (interface->is_active(t) && entries.are_products(*interface, field) &&
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
  return ghosts->ghosted_vector();
}

template <int dim>
Vector BlockSystem<dim>::ghosted(const Vector &owned) const
{
  Vector copy = ghosted_scratch; // its layout is known
  ghosts->update(copy, owned);
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
    constraints.set_time(t);
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
  ghosts->update(ghosted_scratch, x);
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
    ghosts->update(ghosted_scratch, x);
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
  constraints.hold_back();
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
  ghosts->update(ghosted_scratch, x);
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
  ghosts->update(ghosted_scratch, x);
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

/// Only in time, where it is asked for again and again, and until rounding shows in it.
template <int dim>
AffineResidual<dim> *BlockSystem<dim>::affine_residual()
{
  if (are_products_rounded || !has_tangent || !has_rates() || !cellwise.empty() ||
      entries.form != Form::direct || stages.size() > 1 || !AffineResidual<dim>::is_possible(model, time))
    return nullptr;
  if (!affine) {
    const dealii::IndexSet &relevant = constraints.relevant_unknowns();
    dealii::AffineConstraints<double> no_lines(relevant);
    no_lines.close();
    dealii::DynamicSparsityPattern pattern = entries.pattern(time, cell_terms, no_lines, relevant);
    affine = std::make_unique<AffineResidual<dim>>(model, parts_of_blocks(), pattern, relevant, time);
  }
  return affine->is_defined() ? affine.get() : nullptr;
}

/// At @p x. @return false, and there are no products any more, if rounding shows in them.
/// @pre affine_residual()
template <int dim>
bool BlockSystem<dim>::evaluate_products(const Vector &x)
{
  std::exception_ptr fault;
  try {
    affine->find_loads(time);
  } catch (...) { // perhaps of this rank alone
    fault = std::current_exception();
  }
  throw_on_all_ranks(fault, model.communicator);
  affine->evaluate(x, owned_rates);
  if (affine->rounding_of_energy() <= largest_rounding_of_energy)
    return true;
  give_up_products();
  return false;
}

template <int dim>
bool BlockSystem<dim>::takes_products() const
{
  return affine != nullptr && affine->is_defined();
}

template <int dim>
void BlockSystem<dim>::give_up_products()
{
  are_products_rounded = true;
  affine.reset();
  summands.clear();
}

/// The residual alone. @return whether it is defined, and exact; if not, integrals are, or say where and why.
/// @pre affine_residual()
template <int dim>
bool BlockSystem<dim>::assemble_by_products(const Vector &x)
{
  ++n_assemblies.residuals_by_products;
  ghosts->update(ghosted_scratch, x);
  constraints.move_from(ghosted_scratch, share);
  if (!evaluate_products(x))
    return false;
  right_hand_side.equ(-1., affine->residual());
  std::vector<std::pair<dealii::types::global_dof_index, double>> passed_on;
  for (const auto &line : constraints.of_update().get_lines())
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

  sizes.set_forces(affine->squares_of_forces(), cell_terms[0]->longest_sum(), model.communicator);
  const std::vector<double> all_forces = sizes.forces();
  const bool is_defined = std::isfinite(std::accumulate(all_forces.begin(), all_forces.end(), 0.));
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
  const ForceSizes sizes_of_products = sizes;
  const unsigned int n_blocks = field_of_block.size();
  ghosts->update(ghosted_scratch, x);
  negative_sums.begin(*ghosts);
  sizes.begin();
  assemble_all(false);
  negative_sums.finish(right_hand_side);
  if (share < 1)
    right_hand_side.add(share - 1, held_back);
  sizes.finish([](unsigned int) { return false; }, model.communicator);
  const std::vector<double> forces_here = sizes.forces();
  right_hand_side -= by_products;
  bool is_equal = true;
  for (unsigned int b = 0; b < n_blocks; ++b)
    is_equal = is_equal && !(right_hand_side.block(b).l2_norm() > largest * forces_here[b]);
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
  negative_sums.begin(*ghosts);
  std::exception_ptr fault;
  try {
    assemble_all(true);
  } catch (...) { // perhaps of this rank alone
    fault = std::current_exception();
  }
  matrix.compress(dealii::VectorOperation::add);
  std::swap(without, step_rates);
  throw_on_all_ranks(fault, model.communicator);
  summands[0].copy_from(matrix);
  for (unsigned int order = 1; order <= model.order_in_time(); ++order) {
    summands[order].copy_from(matrix);
    summands[order] = 0;
    affine->add_mass(constraints.of_update(), order, summands[order]);
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

/// Those of the stages that are asked for are assembled anew.
template <int dim>
void BlockSystem<dim>::begin_tangent()
{
  std::vector<bool> rows;
  for (unsigned int b = 0; b < field_of_block.size(); ++b)
    rows.push_back(stages.asks_tangent(b));
  matrix.set_zero(rows);
  for (const auto &[part, cells] : cellwise)
    if (stages.asks_tangent(matrix.numbering(part).blocks()[0]))
      cells->begin(constraints.of_update());
}

template <int dim>
void BlockSystem<dim>::linearise_at(const Vector *const x)
{
  if (x != nullptr) {
    linearised = ghosts->ghosted_vector();
    ghosts->update(linearised, *x);
  }
  for (const auto &terms : cell_terms)
    terms->linearise_at(x == nullptr ? nullptr : &linearised);
}

/// Where the second tangent is that of another step, as in the start of a scheme, a third one may never come.
/// The rounding that its products stand for falls and grows with x also where the tangent is a sum.
template <int dim>
bool BlockSystem<dim>::assemble(const Vector &x, const bool with_tangent, const std::vector<bool> &of_blocks,
                                const std::vector<bool> &residual_of)
{
  const unsigned int few_tangents = 2;
  if ((!with_tangent || n_tangents >= few_tangents) && affine_residual() != nullptr) {
    if (with_tangent) {
      combine_tangent();
      sizes.set_tangent(matrix.sizes_of_products(x), cell_terms[0]->longest_sum());
    }
    if (assemble_by_products(x))
      return true;
  }
  ++(with_tangent ? n_assemblies.tangents : n_assemblies.residuals_alone);
  ghosts->update(ghosted_scratch, x);
  constraints.move_from(ghosted_scratch, share);
  negative_sums.begin(*ghosts);
  ask_for(of_blocks.empty() && !with_tangent ? residual_of : of_blocks, residual_of);
  if (with_tangent)
    begin_tangent();
  problem_here = {};
  last_undefined() = {};
  sizes.begin();

  std::exception_ptr fault;
  bool is_defined = true;
  try {
    is_defined = assemble_all(with_tangent);
  } catch (...) { // perhaps of this rank alone: the others wait for its sums
    fault = std::current_exception();
  }
  if (with_tangent)
    matrix.compress(dealii::VectorOperation::add);
  negative_sums.finish(right_hand_side);
  if (with_tangent)
    for (const auto &[part, cells] : cellwise)
      if (stages.asks_tangent(matrix.numbering(part).blocks()[0])) {
        cells->finish();
        if (moves_constraints())
          cells->subtract_moves(constraints.of_update(), right_hand_side);
      }
  if (share < 1)
    right_hand_side.add(share - 1, held_back);
  sizes.finish([&](const unsigned int b) { return with_tangent && stages.asks_tangent(b); },
               model.communicator);
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
  if (is_defined && stages.asks_all_residuals())
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
        std::max(stages.what_is_asked(field.names[source]), stages.what_is_asked(field.names[destination])));
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

template <int dim>
bool BlockSystem<dim>::assemble_domain(const unsigned int d, const Vector &ghosted, const bool with_tangent)
{
  const Domain<dim> &domain = *model.domains[d];
  CellTerms<dim> &terms = *cell_terms[d];
  const unsigned int n_local = domain.dofs_per_cell();
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(n_local), residual(n_local);
  local_matrix.reinit(n_local, n_local);
  sums.begin_domain(d, with_tangent && terms.has_entries());
  const auto &shares = stages.of_cells(d);
  if (std::none_of(shares.begin(), shares.end(),
                   [this](const auto &of_stage) { return stages.asks_residual(of_stage); }))
    return true;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      ghosted.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
      if (with_tangent)
        sums.prefetch(d, cell->active_cell_index());
      if (!terms.assemble(cell, time, unknowns, residual, with_tangent ? &local_matrix : nullptr)) {
        note_undefined("domain " + domain.name + ", the cell around " + in_words(cell->center()));
        return false;
      }
      const auto *tangent = with_tangent && terms.has_entries(cell) ? &local_matrix : nullptr;
      sizes.add(dofs, terms.forces(), unknowns, terms.longest_sum(), constraints.of_update(), tangent);
      if (with_tangent && !terms.products().empty())
        sizes.add_products(dofs, terms.products(), terms.longest_sum(), constraints.of_update());
      sums.add(d, cell->active_cell_index(), dofs, residual, tangent);
    }
  return true;
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
  sizes.add_products(dofs, leading.sizes_of_products(of_leading, unknowns), dofs.size(),
                     constraints.of_update());
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
  const unsigned int n_local = interface.n_local(source) + interface.n_local(destination);
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(n_local), residual;
  dealii::FullMatrix<double> *tangent = with_tangent && entries.exist(interface) ? &local_matrix : nullptr;
  if (tangent != nullptr)
    tangent->reinit(n_local, n_local);
  typename Stages<dim>::Shares shares; // those of all groups
  const auto &groups = interface.pairing().groups;
  for (unsigned int g = 0; g < groups.size(); ++g) {
    const auto &group = groups[g];
    interface.group_dofs(group, dofs);
    if (g == 0)
      shares = stages.shares_of(dofs);
    ghosted.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    residual.assign(n_local, 0.);
    bool is_defined = true;
    if (!products.empty())
      is_defined = assemble_products(terms, interface, g, products, dofs, unknowns, residual, tangent);
    else {
      if (tangent != nullptr)
        *tangent = 0;
      is_defined = terms.assemble(interface, group, time, unknowns, residual, tangent);
    }
    if (!is_defined) {
      note_undefined("interface " + interface.name + " near " +
                     in_words(interface.pairing().X(source, group.begin)));
      return false;
    }
    sizes.add(dofs, residual, unknowns, n_local, constraints.of_update(),
              products.empty() ? tangent : nullptr);
    if (const auto position = merge_repeated(interface, dofs); !position.empty())
      add_merged(position, dofs, residual, tangent);
    else
      sums.add(shares, dofs, residual, tangent);
  }
  return true;
}

/// Of a group with unknowns that are there twice. @p position: of each among @p dofs
template <int dim>
void BlockSystem<dim>::add_merged(const std::vector<unsigned int> &position,
                                  const std::vector<dealii::types::global_dof_index> &dofs,
                                  const std::vector<double> &residual,
                                  const dealii::FullMatrix<double> *tangent)
{
  std::vector<double> merged_residual(dofs.size(), 0.);
  dealii::FullMatrix<double> merged(dofs.size(), dofs.size());
  for (unsigned int i = 0; i < position.size(); ++i) {
    merged_residual[position[i]] += residual[i];
    for (unsigned int j = 0; tangent != nullptr && j < position.size(); ++j)
      merged(position[i], position[j]) += (*tangent)(i, j);
  }
  sums.add(stages.shares_of(dofs), dofs, merged_residual, tangent != nullptr ? &merged : nullptr);
}

template <int dim>
void BlockSystem<dim>::assemble_multipliers(const Interface<dim> &interface, const Vector &ghosted,
                                            const bool with_tangent)
{
  const Multipliers<dim> *multipliers = interface.tie().parts().multipliers;
  std::vector<double> unknowns, residual;
  if (multipliers == nullptr)
    return;
  const auto *tangent = with_tangent ? &local_matrix : nullptr;
  if (!interface.is_active(time)) { // they are zero
    local_matrix.reinit(1, 1);
    local_matrix(0, 0) = 1;
    for_each_multiplier(interface, [&](const auto dof) {
      sums.add(stages.shares_of({dof}), {dof}, {ghosted(dof)}, tangent);
    });
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
    sizes.add(dofs, row_values, unknowns, dofs.size(), constraints.of_update(), tangent);
    sums.add(stages.shares_of(dofs), dofs, residual, tangent);
  }
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
  AffineResidual<dim> *const products =
      affine_residual() != nullptr && evaluate_products(x) ? affine.get() : nullptr;
  std::vector<std::optional<Flows>> given(model.domains.size());
  for (unsigned int d = 0; d < given.size(); ++d)
    if (const Flows *flows = cell_terms[d]->given_flows(); flows != nullptr && time == time_of_given)
      given[d] = *flows;
  return NodalForces<dim>(model, constraints.lines(), constraints.of_update(), ghosted(x), time, step_rates,
                          products, given, ghosts);
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
  ghosts->update(ghosted_scratch, x);
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
  if (const auto n = dealii::Utilities::MPI::sum(constraints.n_dropped(), model.communicator); n > 0)
    all.push_back(of_dropped_constraints(
        "constraints of interfaces that meet led back to themselves and were dropped at " +
        std::to_string(n) + (n == 1 ? " unknown" : " unknowns")));
  return all;
}

template <int dim>
std::vector<double> BlockSystem<dim>::residuals() const
{
  std::vector<double> norms;
  for (unsigned int b = 0; b < right_hand_side.n_blocks(); ++b)
    norms.push_back(right_hand_side.block(b).l2_norm());
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
  std::vector<double> sizes_of_products; // where both sides may be one block
  for (unsigned int b = 0; b < dx.n_blocks(); ++b)
    if ((model.numbering->blocks()[b].is_of_pressure() || is_of_multipliers[field_of_block[b]]) && !is_zero) {
      if (sizes_of_products.empty())
        sizes_of_products = matrix.sizes_of_products(dx);
      reference[b] = std::max(reference[b], sizes_of_products[b]);
    }
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
std::optional<UnrestrainedMode<dim>> BlockSystem<dim>::find_unrestrained_mode(const Unless unless) const
{
  for (unsigned int f = 0; f < fields.size(); ++f)
    if (!is_of_multipliers[f] &&
        (unless == Unless::never ||
         !is_surely_held(model, fields[f], time, constraints.of_update(), unless == Unless::held)))
      if (const auto motion =
              dovetail::find_unrestrained_mode(model, fields[f], time, matrix, constraints.of_update()))
        return motion;
  return {};
}

template <int dim>
bool BlockSystem<dim>::remember(const double t, const Vector &x)
{
  if (!has_to_remember(model))
    return true;
  ghosts->update(ghosted_scratch, x);
  return dovetail::remember(model, cell_terms, t, ghosted_values());
}

template <int dim>
void BlockSystem<dim>::look_at_start(const Vector &x)
{
  if (!has_to_look_at_start(model))
    return;
  ghosts->update(ghosted_scratch, x);
  dovetail::look_at_start(model, cell_terms, ghosted_values());
}

template <int dim>
void BlockSystem<dim>::distribute(Vector &dx)
{
  ghosts->update(ghosted_scratch, dx);
  constraints.distribute(dx, ghosted_scratch);
}

template <int dim>
void BlockSystem<dim>::distribute_rate(Vector &rate, const bool what_is_prescribed)
{
  ghosts->update(ghosted_scratch, rate);
  constraints.distribute_rate(rate, ghosted_scratch, what_is_prescribed);
}

template <int dim>
void BlockSystem<dim>::follow(Vector &x)
{
  ghosts->update(ghosted_scratch, x);
  constraints.follow(x, ghosted_scratch);
}

template <int dim>
void BlockSystem<dim>::constrain(Vector &x)
{
  ghosts->update(ghosted_scratch, x);
  constraints.constrain(x, ghosted_scratch);
}

template class BlockSystem<2>;
template class BlockSystem<3>;

} // namespace dovetail
