// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What acts on the unknowns that are not free.

#pragma once

#include <dovetail/domain/constraint_lines.h>
#include <dovetail/domain/flows.h>
#include <dovetail/interface/transmission.h>
#include <dovetail/solve/ghost_exchange.h>
#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>
#include <dovetail/time/rates.h>

#include <deal.II/lac/affine_constraints.h>

#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace dovetail {

template <int dim>
class AffineResidual;

/// The forces that hold what constraints prescribe. With the residual R_i of all bodies and all terms of the
/// ties, before constraints, and with the lines B_k = sum_i C_ki B_i + b_k of hanging nodes and ties,
/// @f[ r_i = R_i + \sum_k C_{ki} r_k \qquad (r = R + C^T r). @f]
/// It vanishes at free unknowns of a solution. At an unknown that follows others it is what its line
/// transmits, at a prescribed one the reaction: what is put into the body there.
///
/// Only cells that have such an unknown are asked for their laws.
template <int dim>
class NodalForces
{
public:
  /// @param lines those of the unknowns that this rank owns, as they are
  /// @param constraints the same for all relevant unknowns, resolved
  /// @param solution ghosted
  /// @param rates ghosted, too; kept by reference
  /// @param products if not nullptr, evaluated at the solution: then no law is asked
  /// @param given_flows by domain, CellTerms::given_flows() of that time, where they are known
  /// @param exchange of the relevant unknowns. Collective.
  NodalForces(const Model<dim> &model, const std::shared_ptr<const ConstraintLines> &lines,
              const dealii::AffineConstraints<double> &constraints, const Vector &solution, double t,
              const Rates &rates, AffineResidual<dim> *products,
              std::vector<std::optional<Flows>> given_flows,
              const std::shared_ptr<const GhostExchange> &exchange);

  /// At an owned unknown that is constrained; NaN if a law is not defined somewhere.
  double operator()(const dealii::types::global_dof_index dof) const
  {
    return is_defined ? force(dof) : std::numeric_limits<double>::quiet_NaN();
  }
  bool is_prescribed(const dealii::types::global_dof_index dof) const ///< an owned one, to a value
  {
    const auto line = lines->find(dof);
    return line != lines->end() && line->second.entries.empty();
  }
  /// The line that a boundary condition gave an owned unknown; nullptr if none did.
  const ConstraintLine *line_of_condition(const dealii::types::global_dof_index dof) const
  {
    const auto line = lines->find(dof);
    return line != lines->end() && line->second.is_of_condition ? &line->second : nullptr;
  }
  /// Calls @p visit(dof, line) with these of owned unknowns from @p begin to @p end, in order.
  template <typename Visit>
  void for_each_line_of_condition(const dealii::types::global_dof_index begin,
                                  const dealii::types::global_dof_index end, const Visit &visit) const
  {
    for (auto line = lines->lower_bound(begin); line != lines->end() && line->first < end; ++line)
      if (line->second.is_of_condition)
        visit(line->first, line->second);
  }
  /// Whether a relevant unknown is prescribed, perhaps by way of others.
  bool is_fixed(dealii::types::global_dof_index dof) const;

  /// Push r_i at some unknowns, owned or not, and what these pass on. Collective.
  void add(const std::vector<std::pair<dealii::types::global_dof_index, double>> &pushes);

  /// The test function w + C w + C^2 w + ... of the entries @p w at constrained unknowns, owned: with it a
  /// sum w.r of these forces is w.R of the residual before constraints. Collective.
  Vector extended(const Vector &w) const;

  /// What the terms of an interface give to its sides, by pairs of cells of this rank.
  const std::vector<Transmission> &group_transmissions(const Interface<dim> &interface) const
  {
    return transmissions.at(&interface);
  }

  /// What the cells of a domain get by sources and conditions and what they store, by component of the
  /// domain, where that is known without asking laws; of this rank.
  struct FlowsOfCells
  {
    Flows loads, stored;
  };
  const FlowsOfCells *flows_of_cells(const unsigned int domain) const
  {
    return cell_flows.empty() ? nullptr : &cell_flows[domain];
  }

  /// What given sources put into the cells of a domain that meet no condition with a flux, likewise; nullptr:
  /// not known.
  const Flows *given_flows(const unsigned int domain) const
  {
    return all_given[domain] ? &*all_given[domain] : nullptr;
  }

  /// Rounding of all sums of a field of a body and of those that follow it: 1e-15 sum_ij |K_ij x_j|,
  /// where x_j is at least what it was before the step. In large bodies from a sample of the cells.
  /// Expensive. Collective.
  double rounding(const Domain<dim> &domain, const Field &field, const Vector &solution) const;

  const double t;
  const Rates &rates;
  const std::shared_ptr<const GhostExchange> exchange;

private:
  void take_from(AffineResidual<dim> &products, const Vector &solution, SharedSums &residual);
  void add_cells(const Domain<dim> &domain, const Vector &solution, SharedSums &residual);
  void add_groups(const Interface<dim> &interface, const Vector &solution, SharedSums &residual);
  void add_terms(const Interface<dim> &interface, const Vector &solution, SharedSums &residual) const;
  void magnitudes(const Vector &solution, const std::vector<dealii::types::global_dof_index> &dofs,
                  std::vector<double> &sizes) const;
  double rounding_of_cells(const Domain<dim> &domain, const Field &field, const Vector &solution) const;
  double rounding_of_groups(const Domain<dim> &domain, const Field &field, const Vector &solution) const;
  double sum_of_groups(const Interface<dim> &interface, const TiedField &tied, const Vector &solution) const;
  Vector passed_on(const Vector &residual) const;
  void add_at_constrained(const std::vector<dealii::types::global_dof_index> &dofs,
                          const std::vector<double> &values, SharedSums &residual) const;

  const Model<dim> &model;
  const std::shared_ptr<const ConstraintLines> lines;
  const dealii::AffineConstraints<double> &constraints;
  bool is_defined = true;
  Vector force;
  std::vector<FlowsOfCells> cell_flows;        ///< by domain
  std::vector<std::optional<Flows>> all_given; ///< likewise
  std::map<const Interface<dim> *, std::vector<Transmission>> transmissions;
};

} // namespace dovetail
