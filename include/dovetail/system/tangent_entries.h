// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Which entries the tangent of all domains and interfaces has.

#pragma once

#include <dovetail/domain/cell_terms.h>
#include <dovetail/system/model.h>
#include <dovetail/system/stages.h>

#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>

#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// Of a tangent: K, or its transpose.
enum class Form { direct, transposed };

/// The sparsity of the tangent. Entries are there where a law or a tie makes one unknown depend on another,
/// except between fields of different stages, and where products take their place.
template <int dim>
class TangentEntries
{
public:
  using TermsOfDomains = std::vector<std::unique_ptr<CellTerms<dim>>>;

  /// All by reference.
  TangentEntries(const Model<dim> &model, const Stages<dim> &stages, const Form form)
      : form(form), model(model), stages(stages)
  {
  }

  /// Of each group of fields (Model::field_groups), whether its matrix has all entries. At first all have.
  void choose(const std::vector<bool> &of_groups) { groups_with_entries = of_groups; }

  /// Whether the tangent of the cells has entries in a field's own block.
  bool exist(const std::string &field) const;
  /// Whether the tangent of a tie has entries in the row of a component and the column of another one,
  /// counted over both sides.
  bool exist(const Interface<dim> &interface, unsigned int row, unsigned int column) const;
  /// In any row and column.
  bool exist(const Interface<dim> &interface) const;
  /// Whether the terms of a tied field need no entries, like the cells on both sides.
  bool are_products(const Interface<dim> &interface, const TiedField &field) const;

  /// For what is active at time @p t, in the rows of @p relevant unknowns. Collective.
  dealii::DynamicSparsityPattern pattern(double t, const TermsOfDomains &terms,
                                         const dealii::AffineConstraints<double> &lines,
                                         const dealii::IndexSet &relevant) const;

  const Form form;

private:
  void add(const CellTerms<dim> &terms, const dealii::AffineConstraints<double> &lines,
           dealii::DynamicSparsityPattern &pattern) const;
  void add(const Interface<dim> &interface, const dealii::AffineConstraints<double> &lines,
           dealii::DynamicSparsityPattern &pattern) const;
  bool depends(const Domain<dim> &domain, unsigned int field, unsigned int by) const;
  void leave_out(const Domain<dim> &domain, dealii::Table<2, bool> &couplings) const;
  dealii::Table<2, bool> couplings_of_components(const Interface<dim> &interface) const;

  const Model<dim> &model;
  const Stages<dim> &stages;
  std::vector<bool> groups_with_entries;
};

/// Leave each unknown once in @p dofs, sorted. A group of a body that is tied to itself may hold some twice,
/// which deal.II's constraints do not take.
/// @return for each of the former entries its position now; empty if nothing was there twice
template <int dim>
std::vector<unsigned int> merge_repeated(const Interface<dim> &interface,
                                         std::vector<dealii::types::global_dof_index> &dofs);

/// Calls @p visit with every multiplier of an interface that this rank owns.
template <int dim, typename Visit>
void for_each_multiplier(const Interface<dim> &interface, const Visit &visit)
{
  for (const TiedField &field : interface.fields)
    for (unsigned int i = 0; i < field.n_multipliers; ++i)
      visit(field.first_multiplier + i);
}

} // namespace dovetail
