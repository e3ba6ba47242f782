// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/quadrature.h>
#include <dovetail/system/free_pressures.h>
#include <dovetail/system/joined_fields.h>
#include <dovetail/system/rigid_motions.h>

#include <deal.II/base/mpi.h>
#include <deal.II/fe/fe_values.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace dovetail {

namespace {

/// What equations see of a constant pressure, relative to what the cells give: less is rounding.
const double seen_by_rounding = 1e-12;
const unsigned int most_iterations = 500; ///< for multipliers
const double nearest_of_multipliers =
    1e-5; ///< of the first gradient, relative to what is left: they come no nearer

/// Whether no equation of a pressure contains the pressure. Collective.
template <int dim>
bool is_incompressible(const Model<dim> &model, const Block &block, const unsigned int number,
                       const BlockMatrix &tangent, const dealii::AffineConstraints<double> &constraints)
{
  const std::vector<double> diagonal = tangent.diagonal(number);
  bool is_here = true;
  for (unsigned int i = 0; i < diagonal.size(); ++i)
    is_here = is_here &&
              (diagonal[i] == 0 || constraints.is_constrained(block.begin + block.owned.nth_index_in_set(i)));
  return dealii::Utilities::MPI::min(is_here ? 1 : 0, model.communicator) == 1;
}

/// By the displacements that ties join: the numbers of the blocks of pressure.
template <int dim>
std::vector<std::vector<unsigned int>> joined_pressures(const Model<dim> &model, const double t,
                                                        const BlockMatrix &tangent,
                                                        const dealii::AffineConstraints<double> &constraints)
{
  const auto &blocks = model.numbering->blocks();
  std::vector<unsigned int> candidates;
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (blocks[b].is_of_pressure() && is_incompressible(model, blocks[b], b, tangent, constraints))
      candidates.push_back(b);
  if (candidates.empty())
    return {};
  const auto joined = joined_fields<dim>(
      model, [t](const auto &interface, const TiedField &) { return interface.is_active(t); });
  std::map<unsigned int, std::vector<unsigned int>> groups;
  for (const unsigned int b : candidates) {
    const auto &fields = model.domains[blocks[b].domain_index]->fields();
    const auto moves =
        std::find_if(fields.begin(), fields.end(), [](const Field &field) { return field.n_components > 1; });
    groups[joined[blocks[b].domain_index][moves - fields.begin()]].push_back(b);
  }
  std::vector<std::vector<unsigned int>> result;
  for (const auto &group : groups)
    result.push_back(group.second);
  return result;
}

/// Adds the integrals of the shape functions of a pressure.
template <int dim>
void add_weights(const Domain<dim> &domain, const Block &block, Vector &weights)
{
  const CellLayout<dim> &layout = domain.layout();
  const unsigned int component = domain.fields()[block.field_index].first_component;
  dealii::FEValues<dim> values(domain.mapping(), layout.element(component),
                               gauss_rule<dim>(domain.cell_shape(), domain.degree + 1),
                               dealii::update_values | domain.measure.update_flags());
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      domain.cell_dofs(cell, dofs);
      for (unsigned int a = 0; a < layout.n_nodes(component); ++a) {
        double integral = 0;
        for (const unsigned int q : values.quadrature_point_indices())
          integral += values.shape_value(a, q) * domain.measure(values, q);
        weights(dofs[layout.index(component, a)]) += integral;
      }
    }
}

/// With the forces of multipliers that come nearest to those of the pressure: the method of conjugate
/// gradients for min |K z|, in which the rows of the multipliers are the transposed columns.
template <int dim>
class Closing
{
public:
  Closing(const Model<dim> &model, const BlockMatrix &tangent) : model(model), tangent(tangent) {}

  /// @return what is left of K z
  double close(Vector &z, const double enough) const
  {
    Vector rest = product(z, false), along = product(rest, true), forces = along;
    double gradient = along * along, left = rest.l2_norm();
    const double least = nearest_of_multipliers * std::sqrt(gradient) / left;
    for (unsigned int i = 0; i < most_iterations && left > enough && std::sqrt(gradient) > least * left;
         ++i) {
      forces = product(along, false);
      const double square = forces * forces;
      if (!(square > 0))
        break;
      z.add(-gradient / square, along);
      rest.add(-gradient / square, forces);
      left = rest.l2_norm();
      Vector next = product(rest, true);
      const double of_next = next * next;
      along.sadd(of_next / gradient, 1., next);
      gradient = of_next;
    }
    return left;
  }

private:
  /// The rows of multipliers alone, or the others.
  Vector product(const Vector &x, const bool of_multipliers) const
  {
    Vector result = x;
    tangent.vmult(result, x);
    for (unsigned int b = 0; b < result.n_blocks(); ++b)
      if (model.numbering->blocks()[b].is_of_multipliers != of_multipliers)
        result.block(b) = 0;
    return result;
  }

  const Model<dim> &model;
  const BlockMatrix &tangent;
};

} // namespace

template <int dim>
std::string FreePressure<dim>::in_words() const
{
  return names_of(bodies);
}

template <int dim>
std::vector<FreePressure<dim>> find_free_pressures(const Model<dim> &model, const double t,
                                                   const BlockMatrix &tangent,
                                                   const dealii::AffineConstraints<double> &constraints)
{
  const auto &blocks = model.numbering->blocks();
  std::vector<FreePressure<dim>> result;
  for (const auto &group : joined_pressures(model, t, tangent, constraints)) {
    FreePressure<dim> pressure = {{}, group[0], Vector(tangent.owned_unknowns(), model.communicator), {}, 0};
    for (const unsigned int b : group) {
      const Domain<dim> &body = *model.domains[blocks[b].domain_index];
      pressure.bodies.push_back(&body);
      const auto constant = rigid_motions(body, blocks[b], body.centre(), body.typical_length())[0];
      std::copy(constant.begin(), constant.end(), pressure.mode.block(b).trilinos_vector()[0]);
    }
    Vector z = pressure.mode; // constrained unknowns have no columns
    for (const unsigned int b : group)
      for (unsigned int i = 0; i < blocks[b].owned.n_elements(); ++i)
        if (constraints.is_constrained(blocks[b].begin + blocks[b].owned.nth_index_in_set(i)))
          z.block(b).trilinos_vector()[0][i] = 0;
    double size = 0;
    for (const double of_block : tangent.sizes_of_products(z))
      size = std::hypot(size, of_block);
    if (size == 0 || // not assembled, as while another stage is solved
        Closing<dim>(model, tangent).close(z, seen_by_rounding * size) > seen_by_rounding * size)
      continue;
    for (unsigned int b = 0; b < blocks.size(); ++b)
      if (blocks[b].is_of_multipliers)
        pressure.mode.block(b) = z.block(b);
    pressure.weights.reinit(pressure.mode);
    for (const unsigned int b : group)
      add_weights(*model.domains[blocks[b].domain_index], blocks[b], pressure.weights);
    pressure.weights.compress(dealii::VectorOperation::add);
    pressure.volume = pressure.weights * pressure.mode;
    result.push_back(std::move(pressure));
  }
  return result;
}

template <int dim>
void hold(const std::vector<FreePressure<dim>> &pressures, BlockMatrix &tangent)
{
  const MPI_Comm communicator = tangent.get_mpi_communicator();
  const unsigned int this_rank = dealii::Utilities::MPI::this_mpi_process(communicator);
  for (const auto &pressure : pressures) {
    const unsigned int b = pressure.block;
    const auto &owned = tangent.owned_unknowns()[b];
    const bool may_hold = owned.n_elements() > 0 && tangent.part_operator(tangent.part_of(b)) == nullptr;
    const unsigned int rank = dealii::Utilities::MPI::min(
        may_hold ? this_rank : std::numeric_limits<unsigned int>::max(), communicator);
    double largest = 0; // of the stiffnesses
    for (unsigned int c = 0; c < tangent.n_block_rows(); ++c)
      if (tangent.has_block(b, c) && c != b)
        for (const double entry : tangent.diagonal(c))
          largest = std::max(largest, std::abs(entry));
    largest = dealii::Utilities::MPI::max(largest, communicator);
    if (rank == this_rank && largest > 0) {
      const auto first = tangent.get_row_indices().block_start(b) + owned.nth_index_in_set(0);
      std::vector<BlockMatrix::size_type> columns;
      std::vector<double> values;
      tangent.extract_row(first, columns, values);
      const double square = std::inner_product(values.begin(), values.end(), values.begin(), 0.);
      tangent.add(first, first, -square / largest);
    }
    tangent.compress(dealii::VectorOperation::add);
  }
}

template void hold(const std::vector<FreePressure<2>> &, BlockMatrix &);
template void hold(const std::vector<FreePressure<3>> &, BlockMatrix &);
template struct FreePressure<2>;
template struct FreePressure<3>;
template std::vector<FreePressure<2>> find_free_pressures(const Model<2> &, double, const BlockMatrix &,
                                                          const dealii::AffineConstraints<double> &);
template std::vector<FreePressure<3>> find_free_pressures(const Model<3> &, double, const BlockMatrix &,
                                                          const dealii::AffineConstraints<double> &);

} // namespace dovetail
