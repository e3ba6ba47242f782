// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Numbers of an interface by its points, so that they do not depend on the ranks.

#pragma once

#include <dovetail/interface/interface.h>
#include <dovetail/output/record_file.h>

#include <string>
#include <vector>

namespace dovetail {

/// Writes and reads records of the points of one interface. A point is known by its positions on both sides,
/// which are the same on any number of ranks up to rounding.
template <int dim>
class PointRecords
{
public:
  explicit PointRecords(const Interface<dim> &interface) : interface(interface) {}

  /// @param n of the numbers of each point of this rank, flat
  std::string pack(unsigned int n, const std::vector<double> &numbers) const;
  /// From a record of @p file, the numbers of the points of this rank; nothing if some of them miss there.
  /// Collective.
  std::vector<double> unpack(unsigned int n, const RecordReader &file, const std::string &record) const;

private:
  const Interface<dim> &interface;
};

} // namespace dovetail
