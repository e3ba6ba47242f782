// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The unknowns of all domains as one global block index space over the ranks.

#pragma once

#include <dovetail/domain/domain.h>

#include <deal.II/base/index_set.h>

#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// One block of unknowns: a field of a domain, or the multipliers of an interface for a field. Its global
/// indices are begin … end-1; each rank owns one contiguous range of them.
struct Block
{
  std::string name; ///< of the domain or interface
  std::string field;
  bool is_of_multipliers; ///< of an interface
  bool is_constraint;     ///< of those, or of a field that is a multiplier: its diagonal is zero or negative
  unsigned int domain_index; ///< if it is of a domain
  unsigned int field_index;  ///< among the fields of the domain
  dealii::types::global_dof_index begin, end;
  dealii::IndexSet owned;                                     ///< by this rank, relative to begin
  std::vector<dealii::types::global_dof_index> first_of_rank; ///< relative to begin, n_ranks + 1 entries

  bool is_of_pressure() const { return is_constraint && !is_of_multipliers; } ///< of a body
};

/// Order: [ u_left T_left | u_right | lambda_seam … ], domains and interfaces as in the scene, fields as in
/// the material. Calls Domain::number_from().
class Numbering
{
public:
  template <int dim>
  Numbering(const std::vector<std::unique_ptr<Domain<dim>>> &domains, const MPI_Comm &communicator);

  /// A block after all others, of which this rank owns @p n_own. Collective. @return its first own index
  dealii::types::global_dof_index add_multipliers(const std::string &interface, const std::string &field,
                                                  dealii::types::global_dof_index n_own,
                                                  const MPI_Comm &communicator);

  const std::vector<Block> &blocks() const { return all_blocks; }
  dealii::types::global_dof_index n_dofs() const { return owned.size(); }
  unsigned int block_of(dealii::types::global_dof_index dof) const;
  unsigned int owner(dealii::types::global_dof_index dof) const; ///< rank

  dealii::IndexSet owned;    ///< by this rank
  dealii::IndexSet relevant; ///< owned or on ghost cells of its domain

  /// The part of a global set in each block, relative to the block.
  std::vector<dealii::IndexSet> split(const dealii::IndexSet &set) const;

private:
  std::vector<Block> all_blocks;
};

} // namespace dovetail
