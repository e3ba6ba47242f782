// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/uncovered_picture.h>

#include <cmath>

namespace dovetail {

template <int dim>
UncoveredPicture<dim>::UncoveredPicture(const Pairing<dim> &pairing)
{
  for (const auto &point : pairing.uncovered) {
    dealii::DataOutBase::Patch<0, dim> patch;
    patch.vertices[0] = point.X;
    patch.patch_index = patches.size();
    patch.data.reinit(3, 1);
    const bool has_candidate = std::isfinite(point.distance);
    patch.data(0, 0) = point.side;
    patch.data(1, 0) = has_candidate ? point.distance : -1;
    patch.data(2, 0) = has_candidate ? point.angle : -1;
    patches.push_back(patch);
  }
}

template class UncoveredPicture<2>;
template class UncoveredPicture<3>;

} // namespace dovetail
