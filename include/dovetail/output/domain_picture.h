// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The pictures of a domain and of its boundary.

#pragma once

#include <dovetail/measure/quantity.h>
#include <dovetail/output/picture.h>

#include <deal.II/base/data_out_base.h>

#include <string>
#include <tuple>
#include <vector>

namespace dovetail {

/// Which components of the data of a picture belong together; vectors and tensors are recognised by equal
/// names, in sequence, of more than one and of nine components.
std::vector<std::tuple<unsigned int, unsigned int, std::string,
                       dealii::DataComponentInterpretation::DataComponentInterpretation>>
group_by_name(const std::vector<std::string> &names);

/// Quantities of one domain, in the order in which they are shown.
template <int dim>
using QuantityList = std::vector<const Quantity<dim> *>;

/// Patches of dimension structdim with some quantities of a domain, evaluated in each cell and not averaged
/// between cells.
template <int structdim, int dim>
class QuantityPicture : public Picture<structdim, dim>
{
public:
  using Patch = dealii::DataOutBase::Patch<structdim, dim>;

protected:
  explicit QuantityPicture(const QuantityList<dim> &quantities);

  const std::vector<Patch> &get_patches() const override { return patches; }
  std::vector<std::string> get_dataset_names() const override { return names; }
  std::vector<std::tuple<unsigned int, unsigned int, std::string,
                         dealii::DataComponentInterpretation::DataComponentInterpretation>>
  get_nonscalar_data_ranges() const override
  {
    return group_by_name(names);
  }

  const std::vector<std::string> names; ///< one for each number
  std::vector<Patch> patches;
};

/// The undeformed cells of a domain at one time.
///
/// A hypercube is a patch for a cell of VTK of its degree, a simplex is one linear or quadratic cell of VTK.
/// deal.II's DataOut would do, but knows only names without blanks and tensors of the dimension of space.
template <int dim>
class DomainPicture : public QuantityPicture<dim, dim>
{
public:
  DomainPicture(const Domain<dim> &domain, const QuantityList<dim> &quantities,
                const Vector &ghosted_solution, double t);
};

/// The faces of its boundary, for quantities that are known only there.
template <int dim>
class BoundaryPicture : public QuantityPicture<dim - 1, dim>
{
public:
  BoundaryPicture(const Domain<dim> &domain, const QuantityList<dim> &quantities,
                  const Vector &ghosted_solution, double t);
};

} // namespace dovetail
