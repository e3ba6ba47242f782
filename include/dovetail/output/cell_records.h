// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Numbers of a domain by its cells, so that they do not depend on the ranks.

#pragma once

#include <dovetail/domain/numbering.h>

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace dovetail {

/// Several numbers for each of many unknowns, which any rank may own.
struct NumbersOfUnknowns
{
  unsigned int n = 1; ///< of each
  std::vector<dealii::types::global_dof_index> unknowns;
  std::vector<double> numbers;

  /// Those of unknowns that this rank owns, from all ranks. Collective.
  NumbersOfUnknowns sent_to_owners(const Numbering &numbering, const MPI_Comm &communicator) const;

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &n &unknowns &numbers;
  }
};

/// Writes and reads records of one domain. A cell is known by its CellId, an unknown by its number in the
/// cell, and each unknown stands in one of its cells.
template <int dim>
class CellRecords
{
public:
  /// By active cell index, for owned cells.
  using NumbersOfCells = std::vector<std::vector<double>>;

  explicit CellRecords(const Domain<dim> &domain);

  /// @pre This rank owns the unknowns.
  std::string pack(const NumbersOfUnknowns &own) const;
  /// Adds what stands in the cells of this rank.
  void unpack(const std::string &part, NumbersOfUnknowns &found) const;

  std::string pack(const NumbersOfCells &own) const;
  void unpack(const std::string &part, NumbersOfCells &found) const;

private:
  using Id = std::array<unsigned int, 4>;

  const Domain<dim> &domain;
  std::map<Id, typename Domain<dim>::cell_iterator> cells; ///< of this rank
};

} // namespace dovetail
