// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The points of an interface that face nothing.

#pragma once

#include <dovetail/interface/interface.h>
#include <dovetail/output/picture.h>

#include <deal.II/base/data_out_base.h>

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace dovetail {

/// A cloud of points with, for each, `side` (0: source, 1: destination), `distance` to the nearest face
/// within reach and `angle` [rad] between its normal and the opposite one (both -1 if there is none).
template <int dim>
class UncoveredPoints : public Picture<0, dim>
{
public:
  explicit UncoveredPoints(const Pairing<dim> &pairing);

protected:
  const std::vector<dealii::DataOutBase::Patch<0, dim>> &get_patches() const override { return patches; }
  std::vector<std::string> get_dataset_names() const override { return {"side", "distance", "angle"}; }

private:
  std::vector<dealii::DataOutBase::Patch<0, dim>> patches;
};

/// The first @p n of them in the order of their coordinates, each as {"side", "point": [x, y(, z)]}: the same
/// on every number of ranks. Collective.
template <int dim>
nlohmann::ordered_json list_uncovered_points(const Pairing<dim> &pairing, unsigned int n,
                                             const MPI_Comm &communicator);

} // namespace dovetail
