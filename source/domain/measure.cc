// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/measure.h>

#include <deal.II/base/utilities.h>

namespace dovetail {

namespace {

double thickness_of(const Section &scene)
{
  const std::string text = scene.peek("Thickness");
  return text.empty() ? 1. : dealii::Utilities::string_to_double(text);
}

} // namespace

template <int dim>
Measure<dim>::Measure(const Section &scene)
    : around_axis(dim == 2 && scene.peek("Geometry") == "axisymmetric"),
      factor(dim == 2 && !around_axis ? thickness_of(scene) : 1)
{
}

template class Measure<2>;
template class Measure<3>;

} // namespace dovetail
