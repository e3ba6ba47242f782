// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/affine_residual.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/sparsity_tools.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dovetail {

/// A body that is tied to itself has groups that hold an unknown twice.
template <int dim>
bool AffineResidual<dim>::is_possible(const Model<dim> &model, const double t)
{
  if (!model.has_constant_tangent() || model.sees_past())
    return false;
  for (const auto &domain : model.domains) {
    if (domain->material.has_memory())
      return false;
    for (unsigned int c = 0; c < domain->n_components(); ++c)
      if (domain->material.order_in_time(c) > 0 && !domain->layout().is_continuous(c))
        return false;
  }
  return std::none_of(model.interfaces.begin(), model.interfaces.end(), [&](const auto &interface) {
    return interface->is_active(t) &&
           (interface->has_moving_jump() ||
            interface->sides[source].domain == interface->sides[destination].domain);
  });
}

template <int dim>
AffineResidual<dim>::AffineResidual(const Model<dim> &model, const std::vector<unsigned int> &part_of_block,
                                    dealii::DynamicSparsityPattern &pattern, const dealii::IndexSet &relevant,
                                    const double t)
    : model(model), time(t), time_of_loads(std::numeric_limits<double>::quiet_NaN())
{
  const std::vector<dealii::IndexSet> owned = model.numbering->split(model.numbering->owned);
  for (Vector *vector : {&loads_at_rest, &moving_loads, &product, &unpaired, &storage, &rate, &all, &last_x})
    vector->reinit(owned, model.communicator);
  for (Vector &sums : row_sums)
    sums.reinit(owned, model.communicator);
  find_components();
  no_constraints.reinit(relevant);
  no_constraints.close();
  stiffness.reinit(owned, part_of_block, pattern, model.communicator);

  for (const auto &domain : model.domains) {
    bodies.push_back(std::make_unique<Body>(*domain));
    Body &body = *bodies.back();
    const auto &sources = domain->source().expressions;
    body.has_moving_sources = domain->body_force().depends_on_time() ||
                              std::any_of(sources.begin(), sources.end(),
                                          [](const auto &source) { return source.second.depends_on_time(); });
    for (const auto &condition : domain->conditions())
      if (condition->adds_flux() || condition->is_weak()) {
        follows_fields = follows_fields || condition->follows_fields();
        body.has_moving_boundary =
            body.has_moving_boundary || condition->depends_on_time() || condition->follows_fields();
      }
    has_moving_loads = has_moving_loads || body.has_moving_sources || body.has_moving_boundary;
    if (body.has_moving_sources)
      body.terms.leave_out_given();
    if (body.has_moving_boundary)
      body.terms.leave_out_boundary();
  }
  assemble_stiffness();
  dealii::DynamicSparsityPattern pattern_of_mass(relevant);
  for (const auto &domain : model.domains) {
    const CellLayout<dim> &layout = domain->layout();
    dealii::Table<2, bool> couples(domain->dofs_per_cell(), domain->dofs_per_cell());
    for (unsigned int c = 0; c < domain->n_components(); ++c)
      for (unsigned int a = 0; domain->material.order_in_time(c) > 0 && a < layout.n_nodes(c); ++a)
        for (unsigned int b = 0; b < layout.n_nodes(c); ++b)
          couples(layout.index(c, a), layout.index(c, b)) = true;
    std::vector<Index> dofs;
    for (const auto &cell : domain->dof_handler().active_cell_iterators())
      if (cell->is_locally_owned()) {
        domain->cell_dofs(cell, dofs);
        no_constraints.add_entries_local_to_global(dofs, pattern_of_mass, false, couples);
      }
  }
  dealii::SparsityTools::distribute_sparsity_pattern(pattern_of_mass, model.numbering->owned,
                                                     model.communicator, relevant);
  mass.reinit(owned, part_of_block, pattern_of_mass, model.communicator);
  add_mass(no_constraints, 0, mass);
  all_are_defined = dealii::Utilities::MPI::min(all_are_defined ? 1 : 0, model.communicator) == 1;
  find_kinds();
}

template <int dim>
void AffineResidual<dim>::assemble_stiffness()
{
  for (unsigned int d = 0; d < bodies.size(); ++d)
    assemble_body(d);
  for (const auto &interface : model.interfaces) {
    if (interface->is_active(time) && interface->tie().parts().point_terms != nullptr)
      assemble_joint(*interface);
    if (interface->tie().parts().multipliers != nullptr)
      assemble_multipliers(*interface);
  }
  stiffness.compress(dealii::VectorOperation::add);
  loads_at_rest.compress(dealii::VectorOperation::add);
  for (Vector &sums : row_sums)
    sums.compress(dealii::VectorOperation::add);
}

/// Of vectors.
template <int dim>
void AffineResidual<dim>::find_components()
{
  std::vector<Index> dofs;
  for (const auto &domain : model.domains)
    for (const auto &cell : domain->dof_handler().active_cell_iterators()) {
      if (cell->is_artificial() || domain->material.solid_field() == nullptr)
        continue;
      domain->cell_dofs(cell, dofs);
      for (const Field &field : domain->fields())
        for (unsigned int c = 1; c < field.n_components; ++c)
          for (unsigned int a = 0; a < domain->layout().n_nodes(field.first_component + c); ++a)
            component_of[dofs[domain->layout().index(field.first_component + c, a)]] = c;
    }
  std::vector<Index> group_dofs; // of interfaces, also of cells of other ranks
  for (const auto &interface : model.interfaces)
    for (const auto &group : interface->pairing().groups) {
      interface->group_dofs(group, group_dofs);
      for (const TiedField &field : interface->fields)
        for (const unsigned int side : {source, destination})
          for (unsigned int c = 1; c < field.n_components; ++c) {
            const unsigned int first = interface->first_unknown(side, field.first_component[side] + c);
            for (unsigned int a = 0; a < field.n_nodes[side]; ++a)
              component_of[group_dofs[first + a]] = c;
          }
    }
}

/// What local_matrix makes of constants. @pre It has no terms by which these would vanish.
template <int dim>
void AffineResidual<dim>::add_row_sums(const std::vector<Index> &dofs)
{
  const auto component = [this](const Index dof) {
    const auto found = component_of.find(dof);
    return found == component_of.end() ? 0 : found->second;
  };
  const auto &blocks = model.numbering->blocks();
  for (unsigned int i = 0; i < dofs.size(); ++i)
    for (unsigned int j = 0; j < dofs.size(); ++j) {
      const Block &row = blocks[model.numbering->block_of(dofs[i])],
                  &column = blocks[model.numbering->block_of(dofs[j])];
      if (local_matrix(i, j) != 0 && row.field == column.field && !row.is_of_multipliers &&
          !column.is_of_multipliers)
        row_sums[component(dofs[j])](dofs[i]) += local_matrix(i, j);
    }
}

/// local_matrix and a residual at x = 0.
template <int dim>
void AffineResidual<dim>::add_to_stiffness(const std::vector<Index> &dofs,
                                           const std::vector<double> &residual)
{
  local_vector.reinit(dofs.size(), true);
  std::copy(residual.begin(), residual.end(), local_vector.begin());
  distribute_local_to_global(no_constraints, local_matrix, local_vector, dofs, stiffness, loads_at_rest);
}

template <int dim>
void AffineResidual<dim>::assemble_body(const unsigned int d)
{
  Body &body = *bodies[d];
  const Domain<dim> &domain = *model.domains[d];
  const unsigned int n = domain.n_components(), n_local = domain.dofs_per_cell();
  body.influx.assign(domain.mesh().n_active_cells() * n, 0.);
  body.moving_influx = body.influx;
  std::vector<Index> dofs;
  const std::vector<double> zero(n_local, 0.);
  std::vector<double> residual(n_local);
  bool sees_values = domain.material.has_load_by_state();
  for (const Field &field : domain.fields()) {
    sees_values = sees_values || domain.measure.has_hoop_strain(field);
    for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c)
      for (unsigned int e = field.first_component; e < field.first_component + field.n_components; ++e)
        sees_values = sees_values || domain.material.coupling(c, e).flux_by_value ||
                      domain.material.coupling(c, e).source_by_gradient;
  }
  local_matrix.reinit(n_local, n_local);
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      all_are_defined = body.terms.assemble(cell, time, zero, residual, &local_matrix) && all_are_defined;
      add_to_stiffness(dofs, residual);
      const std::size_t first = cell->active_cell_index() * n;
      for (unsigned int c = 0; c < n; ++c) {
        const std::vector<double> &unit = domain.layout().unit(c);
        body.influx[first + c] =
            -std::inner_product(unit.begin(), unit.end(), residual.begin() + domain.layout().first(c), 0.);
      }
      if (sees_values) {
        add_row_sums(dofs);
        add_loads_by_state(body, first, dofs);
      } else if (body.terms.has_boundary_tangent(cell)) {
        body.terms.assemble_boundary(cell, time, zero, residual, &local_matrix);
        add_row_sums(dofs);
        add_loads_by_state(body, first, dofs);
      }
    }
  body.by_state.close();
}

/// Minus the sum of the rows of a component: fluxes do not count in it, since the gradients of all shape
/// functions add up to zero.
template <int dim>
void AffineResidual<dim>::add_loads_by_state(Body &body, const std::size_t first_entry,
                                             const std::vector<Index> &dofs)
{
  const CellLayout<dim> &layout = body.terms.body().layout();
  std::vector<double> sum(dofs.size());
  for (unsigned int c = 0; c < layout.n_components(); ++c) {
    std::fill(sum.begin(), sum.end(), 0.);
    for (unsigned int a = 0; a < layout.n_nodes(c); ++a)
      for (unsigned int j = 0; j < dofs.size(); ++j)
        sum[j] -= layout.unit(c)[a] * local_matrix(layout.index(c, a), j);
    body.by_state.add(dofs, sum);
    body.entries.push_back(first_entry + c);
  }
}

template <int dim>
void AffineResidual<dim>::assemble_joint(const Interface<dim> &interface)
{
  PointTerms<dim> &terms = *interface.tie().parts().point_terms;
  Joint &joint = joints[&interface];
  const unsigned int n_local = interface.n_local(source) + interface.n_local(destination);
  const std::vector<double> zero(n_local, 0.);
  std::vector<double> residual(n_local), sum(n_local);
  std::vector<Index> dofs;
  const bool is_of_jumps = // of one field, which vanish for constants
      std::none_of(interface.fields.begin(), interface.fields.end(), [&](const TiedField &field) {
        const Domain<dim> &domain = *interface.sides[source].domain;
        return field.has_partition() || field.names[source] != field.names[destination] ||
               domain.measure.has_hoop_strain(domain.fields()[field.field[source]]);
      });
  local_matrix.reinit(n_local, n_local);
  for (const auto &group : interface.pairing().groups) {
    interface.group_dofs(group, dofs);
    std::fill(residual.begin(), residual.end(), 0.);
    local_matrix = 0;
    all_are_defined =
        terms.assemble(interface, group, time, zero, residual, &local_matrix) && all_are_defined;
    add_to_stiffness(dofs, residual);
    if (!is_of_jumps)
      add_row_sums(dofs);
    for (unsigned int f = 0; f < interface.fields.size(); ++f)
      for (unsigned int c = 0; c < interface.fields[f].n_components; ++c) {
        Transmission at_zero = {f, c, {{0, 0}}};
        for (const unsigned int side : {source, destination}) {
          const TiedField &field = interface.fields[f];
          const unsigned int first = interface.first_unknown(side, field.first_component[side] + c);
          std::fill(sum.begin(), sum.end(), 0.);
          for (unsigned int a = first; a < first + field.n_nodes[side]; ++a) {
            at_zero.influx[side] -= residual[a];
            for (unsigned int j = 0; j < n_local; ++j)
              sum[j] -= local_matrix(a, j);
          }
          joint.by_state.add(dofs, sum);
        }
        joint.at_zero.push_back(at_zero);
      }
  }
  joint.by_state.close();
}

/// Those of a tie that is switched off are zero.
template <int dim>
void AffineResidual<dim>::assemble_multipliers(const Interface<dim> &interface)
{
  const Multipliers<dim> &multipliers = *interface.tie().parts().multipliers;
  if (!interface.is_active(time)) {
    local_matrix.reinit(1, 1);
    local_matrix(0, 0) = 1;
    for (const TiedField &field : interface.fields)
      for (unsigned int i = 0; i < field.n_multipliers; ++i)
        add_to_stiffness({field.first_multiplier + i}, {0.});
    return;
  }
  for (unsigned int i = 0; i < multipliers.n_terms(); ++i) {
    const std::vector<Index> &dofs = multipliers.term_dofs(i);
    std::vector<double> residual(dofs.size(), 0.);
    local_matrix.reinit(dofs.size(), dofs.size());
    multipliers.assemble_term(i, std::vector<double>(dofs.size(), 0.), residual, &local_matrix);
    add_to_stiffness(dofs, residual);
  }
}

/// What is stored at rates of one per unknown.
template <int dim>
void AffineResidual<dim>::add_mass(const dealii::AffineConstraints<double> &constraints,
                                   const unsigned int order, BlockMatrix &matrix)
{
  Rates unit;
  unit.by_value = unit.second_by_value = 1;
  unit.rest.reinit(model.numbering->split(model.numbering->owned),
                   model.numbering->split(no_constraints.get_local_lines()), model.communicator);
  unit.second_rest = unit.rest;
  for (unsigned int d = 0; d < bodies.size(); ++d)
    if (model.domains[d]->material.order_in_time() > 0) {
      bodies[d]->terms.set_rates(&unit);
      add_mass_of(d, constraints, order, matrix);
      bodies[d]->terms.set_rates(nullptr);
    }
  matrix.compress(dealii::VectorOperation::add);
}

template <int dim>
void AffineResidual<dim>::add_mass_of(const unsigned int d,
                                      const dealii::AffineConstraints<double> &constraints,
                                      const unsigned int order, BlockMatrix &matrix)
{
  const Domain<dim> &domain = *model.domains[d];
  const unsigned int n_local = domain.dofs_per_cell();
  const std::vector<double> zero(n_local, 0.);
  std::vector<double> residual(n_local);
  std::vector<Index> dofs;
  Vector nothing = all; // of the local vectors, which are zero
  local_matrix.reinit(n_local, n_local);
  local_vector.reinit(n_local);
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      bodies[d]->terms.assemble_storage(cell, time, zero, residual, &local_matrix);
      all_are_defined =
          all_are_defined && std::isfinite(std::accumulate(residual.begin(), residual.end(), 0.));
      for (unsigned int c = 0; c < domain.n_components() && order > 0; ++c)
        for (unsigned int a = 0; domain.material.order_in_time(c) != order && a < domain.layout().n_nodes(c);
             ++a)
          for (unsigned int j = 0; j < n_local; ++j)
            local_matrix(domain.layout().index(c, a), j) = 0;
      distribute_local_to_global(constraints, local_matrix, local_vector, dofs, matrix, nothing);
    }
}

template <int dim>
void AffineResidual<dim>::find_loads(const double t)
{
  if (!has_moving_loads || (t == time_of_loads && !follows_fields))
    return;
  time_of_loads = std::numeric_limits<double>::quiet_NaN(); // until all are found
  moving_loads = 0;
  for (unsigned int d = 0; d < bodies.size(); ++d)
    if (bodies[d]->has_moving_sources || bodies[d]->has_moving_boundary)
      find_moving_loads(d, t);
  time_of_loads = t;
}

template <int dim>
void AffineResidual<dim>::find_moving_loads(const unsigned int d, const double t)
{
  Body &body = *bodies[d];
  const Domain<dim> &domain = *model.domains[d];
  const unsigned int n = domain.n_components(), n_local = domain.dofs_per_cell();
  const std::vector<double> zero(n_local, 0.);
  std::vector<double> residual(n_local);
  std::vector<Index> dofs;
  std::fill(body.moving_influx.begin(), body.moving_influx.end(), 0.);
  const auto add = [&](const auto &cell) {
    domain.cell_dofs(cell, dofs);
    local_vector.reinit(n_local, true);
    std::copy(residual.begin(), residual.end(), local_vector.begin());
    no_constraints.distribute_local_to_global(local_vector, dofs, moving_loads);
    for (unsigned int c = 0; c < n; ++c) {
      const std::vector<double> &unit = domain.layout().unit(c);
      body.moving_influx[cell->active_cell_index() * n + c] -=
          std::inner_product(unit.begin(), unit.end(), residual.begin() + domain.layout().first(c), 0.);
    }
  };
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      if (body.has_moving_sources) {
        body.terms.assemble_given(cell, t, residual);
        add(cell);
      }
      if (body.has_moving_boundary && cell->at_boundary()) {
        if (!body.terms.assemble_boundary(cell, t, zero, residual))
          std::fill(residual.begin(), residual.end(), std::numeric_limits<double>::quiet_NaN());
        add(cell);
      }
    }
}

template <int dim>
void AffineResidual<dim>::find_kinds()
{
  const auto &blocks = model.numbering->blocks();
  std::map<std::string, int> number_of_field;
  components = all;
  components = 0;
  for (const auto &[dof, c] : component_of)
    if (model.numbering->owned.is_element(dof))
      components(dof) = c;
  components.compress(dealii::VectorOperation::insert);

  unsigned int n_parts = 0;
  for (unsigned int b = 0; b < blocks.size(); ++b) {
    n_parts = std::max(n_parts, stiffness.part_of(b) + 1);
    is_vector.push_back(false);
    if (blocks[b].is_of_multipliers)
      continue;
    number_of_field.try_emplace(blocks[b].field, number_of_field.size());
    const Domain<dim> &domain = *model.domains[blocks[b].domain_index];
    is_vector.back() = domain.fields()[blocks[b].field_index].n_components > 1;
  }
  has_vectors = std::find(is_vector.begin(), is_vector.end(), true) != is_vector.end();
  kinds.resize(n_parts);
  for (unsigned int p = 0; p < n_parts; ++p) {
    const Epetra_CrsMatrix &matrix = stiffness.part(p, p).trilinos_matrix();
    const RowNumbering &numbering = stiffness.numbering(p);
    const auto field_of = [&](const unsigned int i) {
      const Block &block = blocks[numbering.blocks()[i]];
      return block.is_of_multipliers ? -1 : number_of_field.at(block.field);
    };
    const Epetra_Vector of_columns = stiffness.ghosted(p, p, components);
    for (int k = 0; k < matrix.NumMyCols(); ++k) {
      kinds[p].fields.push_back(field_of(numbering.unknown(matrix.GCID(k)).first));
      kinds[p].components.push_back(static_cast<int>(of_columns[k]));
    }
    std::array<int, dim> nowhere;
    nowhere.fill(-1);
    for (unsigned int i = 0; i < numbering.blocks().size(); ++i)
      for (unsigned int row = numbering.first_local_of(i); row < numbering.first_local_of(i + 1); ++row) {
        kinds[p].fields_of_rows.push_back(field_of(i));
        kinds[p].at_node.push_back(nowhere);
        kinds[p].at_node.back()[0] = matrix.LCID(matrix.GRID(row)); // of a scalar
      }
    find_nodes(p);
  }
}

/// Of vectors.
template <int dim>
void AffineResidual<dim>::find_nodes(const unsigned int p)
{
  const auto &blocks = model.numbering->blocks();
  const Epetra_CrsMatrix &matrix = stiffness.part(p, p).trilinos_matrix();
  const RowNumbering &numbering = stiffness.numbering(p);
  std::vector<Index> dofs;
  for (unsigned int i = 0; i < numbering.blocks().size(); ++i) {
    const Block &block = blocks[numbering.blocks()[i]];
    if (block.is_of_multipliers)
      continue;
    const Domain<dim> &domain = *model.domains[block.domain_index];
    const Field &field = domain.fields()[block.field_index];
    for (const auto &cell : domain.dof_handler().active_cell_iterators()) {
      if (field.n_components == 1 || !cell->is_locally_owned())
        continue;
      domain.cell_dofs(cell, dofs);
      for (unsigned int a = 0; a < domain.layout().n_nodes(field.first_component); ++a) {
        std::array<int, dim> columns, rows;
        for (unsigned int c = 0; c < dim; ++c) {
          const Index row =
              numbering.row(i, dofs[domain.layout().index(field.first_component + c, a)] - block.begin);
          columns[c] = matrix.LCID(static_cast<int>(row));
          rows[c] = matrix.LRID(static_cast<int>(row));
        }
        for (const int row : rows)
          if (row >= 0)
            kinds[p].at_node[row] = columns;
      }
    }
  }
}

template <int dim>
unsigned int AffineResidual<dim>::order_in_time(const Block &block) const
{
  if (block.is_of_multipliers)
    return 0;
  const Domain<dim> &domain = *model.domains[block.domain_index];
  return domain.material.order_in_time(domain.fields()[block.field_index].first_component);
}

/// K x, if it is not known.
template <int dim>
void AffineResidual<dim>::multiply(const Vector &x)
{
  bool is_known = has_product;
  for (unsigned int b = 0; b < x.n_blocks() && is_known; ++b) {
    const unsigned int n = model.numbering->blocks()[b].owned.n_elements();
    const double *const values = x.block(b).trilinos_vector()[0];
    is_known = std::equal(values, values + n, last_x.block(b).trilinos_vector()[0]);
  }
  if (dealii::Utilities::MPI::min(is_known ? 1 : 0, model.communicator) == 1)
    return;
  last_x = x;
  has_product = true;
  product = 0;
  unpaired = 0;
  pair_squares.assign(x.n_blocks(), 0.);
  if (has_vectors)
    find_means(x);
  for (unsigned int p = 0; p < kinds.size(); ++p)
    for (unsigned int q = 0; q < kinds.size(); ++q)
      if (stiffness.has_part(p, q))
        multiply_part(p, q, x);
  if (has_vectors)
    find_rounding();
}

/// Of the components of vectors, and the sum of the squares beside them.
template <int dim>
void AffineResidual<dim>::find_means(const Vector &x)
{
  const auto for_each = [&](const auto &visit) {
    for (unsigned int b = 0; b < x.n_blocks(); ++b) {
      const double *const component = components.block(b).trilinos_vector()[0];
      const double *const values = x.block(b).trilinos_vector()[0];
      for (unsigned int k = 0; is_vector[b] && k < model.numbering->blocks()[b].owned.n_elements(); ++k)
        visit(static_cast<unsigned int>(component[k]), values[k]);
    }
  };
  std::vector<double> sums(2 * dim, 0.); // of values, and of ones
  for_each([&](const unsigned int c, const double value) {
    sums[c] += value;
    sums[dim + c] += 1;
  });
  dealii::Utilities::MPI::sum(sums, model.communicator, sums);
  for (unsigned int c = 0; c < dim; ++c)
    means[c] = sums[c] / sums[dim + c];
  own_energy = {{0, 0}};
  square_beside_means = 0;
  for_each([&](const unsigned int c, const double value) {
    square_beside_means += (value - means[c]) * (value - means[c]);
  });
}

/// Of vectors, whose means the pairs in a product do not see.
template <int dim>
void AffineResidual<dim>::find_rounding()
{
  std::vector<double> sums = {own_energy[0], own_energy[1], square_beside_means, 0.};
  for (unsigned int b = 0; b < is_vector.size(); ++b)
    sums[3] += is_vector[b] ? pair_squares[b] : 0.;
  dealii::Utilities::MPI::sum(sums, model.communicator, sums);
  const double rounding = std::numeric_limits<double>::epsilon() / 2 * std::sqrt(sums[2] * sums[3]);
  share_of_rounding = rounding > 0 ? rounding / std::max(std::abs(sums[0]), std::abs(sums[1])) : 0.;
}

/// As sum_j K_ij (x_j - x_i) + s_i x_i over the columns of the field of the row, where i is the same
/// component at its node, so that values that are large beside their differences bring no rounding: what
/// pairs of unknowns exchange adds up to nothing. Beside it the squares of these pairs, and what is left.
template <int dim>
void AffineResidual<dim>::multiply_part(const unsigned int p, const unsigned int q, const Vector &x)
{
  const Epetra_CrsMatrix &matrix = stiffness.part(p, q).trilinos_matrix();
  const RowNumbering &numbering = stiffness.numbering(p);
  const Epetra_Vector values_of_x = stiffness.ghosted(p, q, x);
  const double *const factors = values_of_x.Values();
  const Kinds &kind = kinds[p];
  for (unsigned int i = 0; i < numbering.blocks().size(); ++i) {
    const unsigned int block = numbering.blocks()[i], first = numbering.first_local_of(i);
    double *const sums = product.block(block).trilinos_vector()[0], *const rests = unpaired.block(block)
                                                                                       .trilinos_vector()[0];
    double squares = 0;
    for (unsigned int row = first; row < numbering.first_local_of(i + 1); ++row) {
      int n = 0, *columns = nullptr;
      double *values = nullptr;
      matrix.ExtractMyRowView(row, n, values, columns);
      double of_others = 0, of_pairs = 0;
      const bool is_of_field = p == q && kind.fields_of_rows[row] >= 0;
      for (int k = 0; k < n; ++k) {
        const int column = columns[k];
        if (is_of_field && kind.fields[column] == kind.fields_of_rows[row]) {
          const double of_pair =
              values[k] * (factors[column] - factors[kind.at_node[row][kind.components[column]]]);
          of_pairs += of_pair;
          squares += of_pair * of_pair;
        } else
          of_others += values[k] * factors[column];
      }
      double of_own = 0;
      for (unsigned int c = 0; is_of_field && c < dim; ++c)
        if (const int own = kind.at_node[row][c]; own >= 0)
          of_own += row_sums[c].block(block).trilinos_vector()[0][row - first] * factors[own];
      sums[row - first] += of_pairs + of_others + of_own;
      rests[row - first] += of_others + of_own;
      if (is_of_field && is_vector[block]) {
        const unsigned int c = components.block(block).trilinos_vector()[0][row - first];
        const double own_x = factors[kind.at_node[row][c]];
        own_energy[0] += own_x * (of_pairs + of_own);
        own_energy[1] += (own_x - means[c]) * (of_pairs + of_own);
      }
    }
    pair_squares[block] += squares;
  }
}

template <int dim>
void AffineResidual<dim>::find_rates(const Vector &x, const Rates &rates)
{
  for (unsigned int b = 0; b < x.n_blocks(); ++b) {
    const Block &block = model.numbering->blocks()[b];
    const unsigned int order = order_in_time(block), n = block.owned.n_elements();
    double *const values = rate.block(b).trilinos_vector()[0];
    std::fill_n(values, n, 0.);
    if (order == 0)
      continue;
    const double by_value = order == 1 ? rates.by_value : rates.second_by_value;
    const double *const state = x.block(b).trilinos_vector()[0],
                        *const rest =
                            (order == 1 ? rates.rest : rates.second_rest).block(b).trilinos_vector()[0];
    for (unsigned int k = 0; k < n; ++k)
      values[k] = by_value * state[k] + rest[k];
  }
}

template <int dim>
void AffineResidual<dim>::find_storage(const Vector &x, const Rates &rates)
{
  find_rates(x, rates);
  storage = 0;
  storage_squares.assign(x.n_blocks(), 0.);
  if (rate.linfty_norm() == 0)
    return;
  for (unsigned int p = 0; p < kinds.size(); ++p) {
    const Epetra_CrsMatrix &matrix = mass.part(p, p).trilinos_matrix();
    const RowNumbering &numbering = mass.numbering(p);
    const Epetra_Vector rates_of_columns = mass.ghosted(p, p, rate);
    const double *const factors = rates_of_columns.Values();
    for (unsigned int i = 0; i < numbering.blocks().size(); ++i) {
      const unsigned int block = numbering.blocks()[i], first = numbering.first_local_of(i);
      double *const sums = storage.block(block).trilinos_vector()[0], squares = 0;
      for (unsigned int row = first; row < numbering.first_local_of(i + 1); ++row) {
        int n = 0, *columns = nullptr;
        double *values = nullptr;
        matrix.ExtractMyRowView(row, n, values, columns);
        double sum = 0;
        for (int k = 0; k < n; ++k) {
          const double term = values[k] * factors[columns[k]];
          sum += term;
          squares += term * term;
        }
        sums[row - first] = sum;
      }
      storage_squares[block] = squares;
    }
  }
}

template <int dim>
void AffineResidual<dim>::evaluate(const Vector &x, const Rates &rates)
{
  if (has_moving_loads)
    moving_loads.compress(dealii::VectorOperation::add);
  multiply(x);
  find_storage(x, rates);
  force_squares.assign(x.n_blocks(), 0.);
  for (unsigned int b = 0; b < x.n_blocks(); ++b) {
    const auto entries = [b](const Vector &vector) { return vector.block(b).trilinos_vector()[0]; };
    const double *const of_product = entries(product), *const alone = entries(unpaired),
                        *const stored = entries(storage), *const at_rest = entries(loads_at_rest),
                        *const moving = entries(moving_loads);
    double *const sum = entries(all), squares = 0;
    for (unsigned int k = 0; k < model.numbering->blocks()[b].owned.n_elements(); ++k) {
      const double load = at_rest[k] + moving[k];
      sum[k] = of_product[k] + stored[k] + load;
      squares += (alone[k] + load) * (alone[k] + load);
    }
    force_squares[b] = pair_squares[b] + storage_squares[b] + squares;
  }
}

template <int dim>
Flows AffineResidual<dim>::loads(const unsigned int d, const Vector &ghosted)
{
  const Body &body = *bodies[d];
  const unsigned int n = model.domains[d]->n_components();
  std::vector<double> influx = body.influx, sums;
  for (std::size_t i = 0; i < influx.size(); ++i)
    influx[i] += body.moving_influx[i];
  body.by_state.evaluate(ghosted, sums);
  for (unsigned int k = 0; k < sums.size(); ++k)
    influx[body.entries[k]] += sums[k];
  Flows flows(n);
  for (std::size_t i = 0; i < influx.size(); ++i)
    flows.add(i % n, influx[i]);
  return flows;
}

template <int dim>
Flows AffineResidual<dim>::stored(const unsigned int d) const
{
  const Domain<dim> &domain = *model.domains[d];
  Flows flows(domain.n_components());
  for (unsigned int p = 0; p < kinds.size(); ++p) {
    const RowNumbering &numbering = stiffness.numbering(p);
    for (unsigned int i = 0; i < numbering.blocks().size(); ++i) {
      const unsigned int b = numbering.blocks()[i];
      const Block &block = model.numbering->blocks()[b];
      if (block.is_of_multipliers || block.domain_index != d || order_in_time(block) == 0)
        continue;
      const unsigned int first = domain.fields()[block.field_index].first_component;
      const double *const values = storage.block(b).trilinos_vector()[0];
      const Epetra_CrsMatrix &matrix = stiffness.part(p, p).trilinos_matrix();
      for (unsigned int row = numbering.first_local_of(i); row < numbering.first_local_of(i + 1); ++row)
        flows.add(first + kinds[p].components[matrix.LCID(matrix.GRID(row))],
                  values[row - numbering.first_local_of(i)]);
    }
  }
  return flows;
}

template <int dim>
std::vector<Transmission> AffineResidual<dim>::transmissions(const Interface<dim> &interface,
                                                             const Vector &ghosted)
{
  const auto found = joints.find(&interface);
  if (found == joints.end())
    return {};
  std::vector<Transmission> result = found->second.at_zero;
  std::vector<double> sums;
  found->second.by_state.evaluate(ghosted, sums);
  for (unsigned int k = 0; k < result.size(); ++k)
    for (const unsigned int side : {source, destination})
      result[k].influx[side] += sums[2 * k + side];
  return result;
}

template class AffineResidual<2>;
template class AffineResidual<3>;

} // namespace dovetail
