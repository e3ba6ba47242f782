// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/formulas.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/scene/undefined.h>

#include <deal.II/fe/fe_values.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

/// Every cell of a small mesh; of a large one about ten thousand on each rank, where the assembly comes to
/// all points again.
template <int dim, typename Visit>
bool all_looked_at(const Domain<dim> &domain, const bool is_assembled, const Visit &is_good)
{
  constexpr unsigned int enough = 10000;
  const unsigned int stride = is_assembled ? 1 + domain.mesh().n_active_cells() / enough : 1;
  for (const auto &cell : domain.mesh().active_cell_iterators())
    if (cell->is_locally_owned() && cell->active_cell_index() % stride == 0 && !is_good(cell))
      return false;
  return true;
}

template <int dim>
bool are_finite(const Domain<dim> &domain, const std::string &kind, const typename Domain<dim>::Given &given,
                const dealii::Quadrature<dim> &rule, const double t)
{
  if (given.expressions.empty())
    return true;
  const Section section = domain.section.subsection(kind);
  dealii::FEValues<dim> points(domain.mapping(), domain.scalar_element(), rule,
                               dealii::update_quadrature_points);
  std::vector<double> values;
  std::vector<std::pair<std::string, Expression>> formulas(given.expressions.begin(),
                                                           given.expressions.end());
  return all_looked_at(domain, &given == &domain.source(), [&](const auto &cell) {
    if (formulas.empty())
      return true;
    points.reinit(cell);
    for (const auto &[field, formula] : formulas)
      for (unsigned int c = 0; c < formula.n_components(); ++c) {
        formula.values(points.get_quadrature_points(), t, c, values);
        for (const unsigned int q : points.quadrature_point_indices())
          if (!std::isfinite(values[q])) {
            finite(values[q], section, field, points.quadrature_point(q), t);
            return false;
          }
      }
    // what is the same everywhere has been seen
    formulas.erase(std::remove_if(formulas.begin(), formulas.end(),
                                  [](const auto &formula) { return !formula.second.depends_on_position(); }),
                   formulas.end());
    return true;
  });
}

template <int dim>
bool is_body_force_finite(const Domain<dim> &domain, const double t)
{
  if (!domain.body_force().is_given())
    return true;
  dealii::FEValues<dim> points(domain.mapping(), domain.scalar_element(),
                               gauss_rule<dim>(domain.cell_shape(), domain.degree + 1),
                               dealii::update_quadrature_points);
  return all_looked_at(domain, true, [&](const auto &cell) {
    points.reinit(cell);
    for (const auto &X : points.get_quadrature_points())
      if (!std::isfinite(domain.body_force().value(X, t, {}).norm()))
        return false;
    return true;
  });
}

/// Where initial values are asked for.
template <int dim>
dealii::Quadrature<dim> points_of_initial(const Domain<dim> &domain)
{
  std::vector<dealii::Point<dim>> points;
  for (unsigned int s = 0; s < domain.layout().n_spaces(); ++s) {
    const auto &element = domain.layout().element_of_space(s);
    const auto space_points = domain.layout().is_continuous_space(s)
                                  ? element.get_unit_support_points()
                                  : gauss_rule<dim>(domain.cell_shape(), domain.degree + 1).get_points();
    points.insert(points.end(), space_points.begin(), space_points.end());
  }
  return dealii::Quadrature<dim>(points);
}

} // namespace

template <int dim>
bool has_finite_formulas(const Domain<dim> &domain, const double first_time, const double last_time)
{
  return are_finite(domain, "Source", domain.source(),
                    gauss_rule<dim>(domain.cell_shape(), domain.degree + 1), first_time) &&
         is_body_force_finite(domain, first_time) &&
         are_finite(domain, "Initial", domain.initial(), points_of_initial(domain), 0) &&
         are_finite(domain, "Exact", domain.exact(), gauss_rule<dim>(domain.cell_shape(), domain.degree + 3),
                    last_time);
}

template bool has_finite_formulas(const Domain<2> &, double, double);
template bool has_finite_formulas(const Domain<3> &, double, double);

} // namespace dovetail
