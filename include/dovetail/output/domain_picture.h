// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The picture of a domain.

#pragma once

#include <dovetail/domain/domain.h>
#include <dovetail/output/picture.h>
#include <dovetail/system/vector.h>

#include <deal.II/base/data_out_base.h>

#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace dovetail {

/// Which components of the data of a picture belong together; vectors and tensors are recognised by equal
/// names, in sequence, of more than one and of nine components.
std::vector<std::tuple<unsigned int, unsigned int, std::string,
                       dealii::DataComponentInterpretation::DataComponentInterpretation>>
group_by_name(const std::vector<std::string> &names);

/// The undeformed cells of a domain at one time: its fields (`solution`) and, where the material has the law
/// for them, the `heat flux` q = -k grad T (the physical one: minus the influx A of heat_law.h), the `Cauchy
/// stress` (a three-dimensional tensor also in 2D) and its `von Mises` measure. The latter are evaluated in
/// each cell and not averaged between cells.
///
/// A hypercube of degree p is one patch of p^dim parts, a simplex is one linear or quadratic cell of VTK.
/// deal.II's DataOut would do, but knows only names without blanks and tensors of the dimension of space.
template <int dim>
class DomainPicture : public Picture<dim>
{
public:
  using Patch = dealii::DataOutBase::Patch<dim>;

  /// @p fields: of solution, heat flux, Cauchy stress, von Mises.
  DomainPicture(const Domain<dim> &domain, const std::set<std::string> &fields,
                const Vector &ghosted_solution, double t);

protected:
  const std::vector<Patch> &get_patches() const override { return patches; }
  std::vector<std::string> get_dataset_names() const override { return names; }
  std::vector<std::tuple<unsigned int, unsigned int, std::string,
                         dealii::DataComponentInterpretation::DataComponentInterpretation>>
  get_nonscalar_data_ranges() const override
  {
    return group_by_name(names);
  }

private:
  void declare(const std::set<std::string> &fields);
  /// The data at a point, in the order of the names.
  void append_data(const State<dim> &state, std::vector<double> &data) const;

  const Material<dim> &material;
  bool has_solution = false, has_heat_flux = false, has_stress = false, has_von_mises = false;
  std::vector<std::string> names;
  std::vector<Patch> patches;
};

} // namespace dovetail
