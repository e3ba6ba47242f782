// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Which cell a point lies in.

#pragma once

#include <dovetail/domain/domain.h>

#include <memory>
#include <vector>

namespace dovetail {

/// Finds the owned cell of a domain in which a point lies or which is nearest to it.
template <int dim>
class CellSearch
{
public:
  explicit CellSearch(const Domain<dim> &domain);
  ~CellSearch();

  struct Place
  {
    static constexpr unsigned int nowhere = static_cast<unsigned int>(-1);
    unsigned int cell = nowhere;   ///< index for cell()
    dealii::Point<dim> unit_point; ///< may lie outside the reference cell
    double distance = 1e300;       ///< from the reference cell, in its units
  };
  /// On this rank alone; not further than about a third of a cell away.
  Place find(const dealii::Point<dim> &X) const;

  typename Domain<dim>::cell_iterator cell(const unsigned int index) const { return cells[index]; }

private:
  void compare(unsigned int index, const dealii::Point<dim> &X, Place &place) const;

  const Domain<dim> &domain;
  std::vector<typename Domain<dim>::cell_iterator> cells;
  struct Tree;
  std::unique_ptr<Tree> tree; ///< of the cells' boxes
};

} // namespace dovetail
