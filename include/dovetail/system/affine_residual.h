// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The residual of scenes whose derivatives never change, by products in place of integrals.

#pragma once

#include <dovetail/domain/cell_terms.h>
#include <dovetail/domain/flows.h>
#include <dovetail/interface/transmission.h>
#include <dovetail/solve/block_matrix.h>
#include <dovetail/system/linear_sums.h>
#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>
#include <dovetail/time/rates.h>

#include <deal.II/lac/dynamic_sparsity_pattern.h>

#include <array>
#include <map>
#include <memory>
#include <vector>

namespace dovetail {

/// The residual of all bodies and ties, before constraints,
/// @f[ R(x) = K x + M r(x) + f(t) @f]
/// with the derivatives K of all that stores nothing, the mass M, the rate r of each unknown (of the order
/// its material asks for), and the loads f, the residual at x = 0 without storage. K and M are assembled
/// once; f is renewed where it depends on t. What flows in and out of the bodies comes from the same
/// numbers.
template <int dim>
class AffineResidual
{
public:
  /// Whether the residual has this form at time @p t, as far as what the parts of the model say of
  /// themselves, until toggles switch.
  static bool is_possible(const Model<dim> &model, double t);

  /// @p part_of_block, @p pattern: as BlockMatrix::reinit() has them, the latter without constraints.
  /// @p relevant: all unknowns of terms of this rank. Collective. @pre is_possible(model, t)
  AffineResidual(const Model<dim> &model, const std::vector<unsigned int> &part_of_block,
                 dealii::DynamicSparsityPattern &pattern, const dealii::IndexSet &relevant, double t);
  /// Whether all laws are defined where they have been asked; if not, this is of no use. On all ranks alike.
  bool is_defined() const { return all_are_defined; }

  /// Add those of the derivatives of what is stored that go with the rates of an order, 0 for all of them.
  /// Collective.
  void add_mass(const dealii::AffineConstraints<double> &constraints, unsigned int order,
                BlockMatrix &matrix);

  /// f at time @p t, of this rank: it may throw on this rank alone.
  void find_loads(double t);
  /// At @p x, owned, and with owned rates. Collective. @pre find_loads()
  void evaluate(const Vector &x, const Rates &rates);
  const Vector &residual() const { return all; }
  /// Of evaluate(): what rounding may change of x . K x with the entries K of vectors among themselves,
  /// relative to that or to the same beside the means @f$ \bar x @f$ of components, if it is larger:
  /// @f$ u \, \| x - \bar x \| (\sum_{ij} (K_{ij} (x_j - x_i))^2)^{1/2} / | x \cdot K x | @f$ [-]. Pairs of
  /// unknowns see no translation, but entries of K are rounded, so that a rotation of a stiff body has
  /// forces.
  double rounding_of_energy() const { return share_of_rounding; }
  /// As BlockSystem::forces(), the squares of this rank by block: of what each pair of unknowns gives, loads,
  /// and what is stored.
  const std::vector<double> &squares_of_forces() const { return force_squares; }
  /// What cells of this rank get by sources and conditions, and what its unknowns store, by component of the
  /// domain, at the state that evaluate() saw, which is @p ghosted here.
  Flows loads(unsigned int domain, const Vector &ghosted);
  Flows stored(unsigned int domain) const;
  /// What the points of an interface give to its sides, likewise.
  std::vector<Transmission> transmissions(const Interface<dim> &interface, const Vector &ghosted);

private:
  using Index = dealii::types::global_dof_index;

  /// Of a domain.
  struct Body
  {
    explicit Body(const Domain<dim> &domain) : terms(domain) {}
    CellTerms<dim> terms;
    bool has_moving_sources = false, has_moving_boundary = false;
    std::vector<double> influx, moving_influx; ///< at x = 0, of its cells, at cell * n_components + component
    LinearSums by_state;                       ///< what depends on x, of these entries
    std::vector<std::size_t> entries;
  };
  /// Of an interface.
  struct Joint
  {
    std::vector<Transmission> at_zero;
    LinearSums by_state; ///< of each of them, of the source and of the destination
  };
  /// Of the rows and columns of a part of the stiffness: field and component, -1 for multipliers; and for
  /// each row the columns of the components of its field at the same node.
  struct Kinds
  {
    std::vector<int> fields_of_rows, fields, components;
    std::vector<std::array<int, dim>> at_node;
  };

  void assemble_stiffness();
  void assemble_body(unsigned int d);
  void assemble_joint(const Interface<dim> &interface);
  void assemble_multipliers(const Interface<dim> &interface);
  void add_mass_of(unsigned int d, const dealii::AffineConstraints<double> &constraints, unsigned int order,
                   BlockMatrix &matrix);
  void add_to_stiffness(const std::vector<Index> &dofs, const std::vector<double> &residual);
  void add_loads_by_state(Body &body, std::size_t cell, const std::vector<Index> &dofs);
  void add_row_sums(const std::vector<Index> &dofs);
  void find_moving_loads(unsigned int d, double t);
  void find_components();
  void find_kinds();
  void find_nodes(unsigned int part);
  void multiply(const Vector &x);
  void find_means(const Vector &x);
  void find_rounding();
  void multiply_part(unsigned int row, unsigned int column, const Vector &x);
  void find_storage(const Vector &x, const Rates &rates);
  void find_rates(const Vector &x, const Rates &rates);
  unsigned int order_in_time(const Block &block) const;

  const Model<dim> &model;
  const double time; ///< of everything that does not depend on it
  bool all_are_defined = true, has_moving_loads = false, follows_fields = false;
  double time_of_loads;
  dealii::AffineConstraints<double> no_constraints;
  BlockMatrix stiffness, mass;
  /// By component, of each row the sum of the stiffness over the columns of this component of its own field:
  /// what a constant gives. Kept apart, since rounding in K would make something of it where that is nothing.
  std::array<Vector, dim> row_sums;
  std::map<Index, unsigned int> component_of; ///< of unknowns of this rank's terms, where it is not 0
  Vector components;                          ///< of the unknowns of this rank
  std::vector<bool> is_vector;                ///< by block: whether its field has several components
  bool has_vectors = false;
  std::array<double, dim> means{};    ///< of their components
  double square_beside_means = 0;     ///< of this rank, as what follows
  std::array<double, 2> own_energy{}; ///< x . K x, and that beside the means
  double share_of_rounding = 0;
  Vector loads_at_rest, moving_loads, product, unpaired, storage, rate, all, last_x;
  bool has_product = false;
  std::vector<double> pair_squares, storage_squares, force_squares; ///< by block
  std::vector<std::unique_ptr<Body>> bodies;
  std::map<const Interface<dim> *, Joint> joints;
  std::vector<Kinds> kinds; ///< by part

  dealii::FullMatrix<double> local_matrix; // scratch
  dealii::Vector<double> local_vector;
};

} // namespace dovetail
