// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Which fields are solved together, and which rows are asked for.

#pragma once

#include <dovetail/material/term.h>
#include <dovetail/system/model.h>

#include <map>
#include <string>
#include <vector>

namespace dovetail {

/// Stages of a step (Model::stages), of which each has rows of its own in the residual and in the tangent.
/// An assembly asks for those of some stages.
template <int dim>
class Stages
{
public:
  /// Some of the unknowns of a cell or a group of points, all of those in one stage.
  struct Share
  {
    unsigned int stage;
    std::vector<unsigned int> unknowns, fields; ///< the latter are known of cells
  };
  using Shares = std::vector<Share>;

  explicit Stages(const Model<dim> &model) : model(model) {} ///< by reference

  /// @param are_coupled: all fields are in one stage
  void reinit(bool are_coupled);

  unsigned int size() const { return asked_of_tangent.size(); }
  /// Whether the tangent has no block of a field by another one, since their stages differ.
  bool is_left_out(const std::string &field, const std::string &by) const;
  /// Those of the unknowns of each cell of a domain.
  const Shares &of_cells(const unsigned int domain) const { return shares[domain]; }
  /// Without unknowns, where there is one stage.
  Shares shares_of(const std::vector<dealii::types::global_dof_index> &dofs) const;

  /// Of the next assembly: the rows of the tangent and those of the residual, among which these are. A stage
  /// is asked for if some of its blocks are; empty: all.
  void ask_for(const std::vector<bool> &of_blocks, const std::vector<bool> &residual_of);
  bool asks_tangent(const Share &share) const { return asked_of_tangent[share.stage]; }
  bool asks_tangent(const unsigned int block) const { return asked_of_tangent[stage_of_block[block]]; }
  bool asks_residual(const Share &share) const { return asked_of_residual[share.stage]; }
  bool asks_all_residuals() const;
  Asked what_is_asked(const std::string &field) const;

private:
  std::vector<bool> stages_of(const std::vector<bool> &blocks) const;

  const Model<dim> &model;
  std::vector<unsigned int> stage_of_block;
  std::map<std::string, unsigned int> stage_of_field;
  std::vector<bool> asked_of_tangent, asked_of_residual; ///< by stage
  std::vector<Shares> shares;                            ///< by domain
};

} // namespace dovetail
