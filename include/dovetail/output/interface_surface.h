// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The picture of an interface.

#pragma once

#include <dovetail/interface/interface.h>
#include <dovetail/output/domain_picture.h>
#include <dovetail/system/vector.h>

#include <deal.II/base/data_out_base.h>

#include <string>
#include <vector>

namespace dovetail {

/// The integrated side of an interface as a surface of small patches, the pieces of the pairing, with what
/// the interface does there (the mean over a piece): `jump FIELD` [B], `flux FIELD` (the tie's numerical
/// influx into the source; zero while the interface is inactive), `gap` (the distance of the facing points)
/// and `normal` N of the integrated side. Parts without partner are holes.
///
/// Pieces of segments are lines, triangles and parallelograms; a mapped Gauss point has its share of the
/// face.
template <int dim>
class InterfaceSurface : public Picture<dim - 1, dim>
{
public:
  using Patch = dealii::DataOutBase::Patch<dim - 1, dim>;

  /// @pre The interface is paired.
  explicit InterfaceSurface(const Interface<dim> &interface);

  /// Evaluate the data for the next write_*().
  void update(const Vector &ghosted_solution, double t);

protected:
  const std::vector<Patch> &get_patches() const override { return patches; }
  std::vector<std::string> get_dataset_names() const override;
  std::vector<std::tuple<unsigned int, unsigned int, std::string,
                         dealii::DataComponentInterpretation::DataComponentInterpretation>>
  get_nonscalar_data_ranges() const override
  {
    return group_by_name(get_dataset_names());
  }

private:
  const Interface<dim> &interface;
  const unsigned int own; ///< the side that is shown
  std::vector<Patch> patches;
  std::vector<unsigned int> patch_of_point;
};

} // namespace dovetail
