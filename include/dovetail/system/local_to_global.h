// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// From the local residuals and tangents of cells and ties to those of the system.

#pragma once

#include <dovetail/solve/block_matrix.h>
#include <dovetail/solve/ghost_exchange.h>
#include <dovetail/system/kept_positions.h>
#include <dovetail/system/stages.h>
#include <dovetail/system/tangent_entries.h>
#include <dovetail/system/update_constraints.h>
#include <dovetail/system/vector.h>

#include <deal.II/lac/full_matrix.h>
#include <deal.II/lac/vector.h>

#include <memory>
#include <vector>

namespace dovetail {

/// Adds local tangents to K and subtracts local residuals from the right-hand side, on the constraints of the
/// update, in the rows of those stages that are asked for.
template <int dim>
class LocalToGlobal
{
public:
  using Dofs = std::vector<dealii::types::global_dof_index>;
  using Shares = typename Stages<dim>::Shares;

  /// All by reference.
  LocalToGlobal(const Model<dim> &model, const Stages<dim> &stages, const TangentEntries<dim> &entries,
                const UpdateConstraints<dim> &constraints, BlockMatrix &matrix, SharedSums &right_hand_side)
      : model(model), stages(stages), entries(entries), constraints(constraints), matrix(matrix),
        right_hand_side(right_hand_side)
  {
  }

  /// The matrix has other entries now.
  void reinit()
  {
    positions.clear();
    positions.resize(model.domains.size());
  }

  /// Before the cells of a domain come; @p have_tangents, with entries: their positions are kept from the
  /// second time on.
  void begin_domain(unsigned int domain, bool have_tangents);
  /// Asks for the memory to which the next add() of this cell goes.
  void prefetch(unsigned int domain, unsigned int cell_index) const;
  /// Of a cell. @p tangent: if it has one
  void add(unsigned int domain, unsigned int cell_index, const Dofs &dofs,
           const std::vector<double> &residual, const dealii::FullMatrix<double> *tangent);
  /// Of something else with these shares.
  void add(const Shares &shares, const Dofs &dofs, const std::vector<double> &residual,
           const dealii::FullMatrix<double> *tangent);

private:
  using Positions = std::vector<std::unique_ptr<KeptPositions<dim>>>; ///< by number of a share

  template <typename Add>
  void add_shares(const Shares &shares, const Dofs &dofs, const std::vector<double> &residual,
                  const dealii::FullMatrix<double> *tangent, const Add &add);
  void distribute(const Dofs &dofs, const std::vector<double> &residual,
                  const dealii::FullMatrix<double> *tangent);

  const Model<dim> &model;
  const Stages<dim> &stages;
  const TangentEntries<dim> &entries;
  const UpdateConstraints<dim> &constraints;
  BlockMatrix &matrix;
  SharedSums &right_hand_side;
  std::vector<Positions> positions;                       ///< by domain
  dealii::FullMatrix<double> tangent_of_share, transpose; // scratch
  std::vector<double> residual_of_share;
  Dofs dofs_of_share;
  dealii::Vector<double> negative_residual;
};

} // namespace dovetail
