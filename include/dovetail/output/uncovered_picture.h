// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The points of an interface that face nothing.

#pragma once

#include <dovetail/interface/interface.h>
#include <dovetail/output/picture.h>

#include <deal.II/base/data_out_base.h>

#include <string>
#include <vector>

namespace dovetail {

/// A cloud of points with, for each, `side` (0: source, 1: destination), `distance` to the nearest face
/// within reach and `angle` [rad] between its normal and the opposite one (both -1 if there is none).
template <int dim>
class UncoveredPicture : public Picture<0, dim>
{
public:
  explicit UncoveredPicture(const Pairing<dim> &pairing);

protected:
  const std::vector<dealii::DataOutBase::Patch<0, dim>> &get_patches() const override { return patches; }
  std::vector<std::string> get_dataset_names() const override { return {"side", "distance", "angle"}; }

private:
  std::vector<dealii::DataOutBase::Patch<0, dim>> patches;
};

} // namespace dovetail
