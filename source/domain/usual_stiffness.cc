// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/measure_by_vertices.h>
#include <dovetail/domain/usual_stiffness.h>

#include <deal.II/base/symmetric_tensor.h>

#include <cmath>
#include <exception>
#include <vector>

namespace dovetail {

template <int dim>
double usual_stiffness(const Domain<dim> &domain, const Field &field)
{
  const unsigned int n = domain.n_components();
  std::vector<Asked> asked; // laws of other fields may not be defined at zero
  for (const Field &other : domain.fields())
    asked.push_back(other.name == field.name ? Asked::derivatives : Asked::nothing);
  for (const auto &cell : domain.mesh().active_cell_iterators()) {
    if (!cell->is_locally_owned())
      continue;
    CellPoints<dim> points(domain, 0);
    points.state.X = cell->center();
    try {
      if (!points.evaluate(asked, points.response))
        return 0;
    } catch (const std::exception &) { // of a formula, on this rank alone
      return 0;
    }
    double sum = 0;
    for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c)
      sum += dealii::trace(points.response.by_gradient[c * n + c]);
    const double h = std::pow(measure_by_vertices<dim>(cell), 1. / dim);
    return sum / (field.n_components * dim) * std::pow(h, dim - 2);
  }
  return 0;
}

template double usual_stiffness(const Domain<2> &, const Field &);
template double usual_stiffness(const Domain<3> &, const Field &);

} // namespace dovetail
