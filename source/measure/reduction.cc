// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_terms.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/measure/reduction.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace dovetail {

namespace {

/// Gauss points per direction. On cells of degree m the element of degree p times the determinant of the
/// Jacobian has degree p + dim m - 1 per direction, on simplices p + dim (m - 1) in total; degree + 2 points
/// for what is no polynomial.
template <int dim>
unsigned int n_gauss_points(const Domain<dim> &domain)
{
  const unsigned int p = domain.degree, m = domain.mapping_degree();
  const unsigned int degree_of_integrand = domain.has_simplices() ? p + dim * (m - 1) : p + dim * m - 1;
  return std::max(degree_of_integrand / 2 + 1, p + 2);
}

} // namespace

template <int dim>
void visit_points(const Region<dim> &region, const Vector &solution, const double t,
                  const std::function<void(DomainPoint<dim> &point, double JxW)> &visit)
{
  const Domain<dim> &domain = *region.domain;
  DomainPoint<dim> point(domain, solution, t);
  const auto visit_all = [&](const dealii::FEValuesBase<dim> &values) {
    for (const unsigned int q : values.quadrature_point_indices()) {
      point.move_to(q);
      visit(point, domain.measure(values, q));
    }
  };
  const auto flags = DomainPoint<dim>::needed() | dealii::update_JxW_values;
  const unsigned int n = n_gauss_points(domain);
  if (!region.boundary_ids.empty()) {
    dealii::FEFaceValues<dim> values(domain.mapping(), domain.layout().shape_element(),
                                     gauss_rule<dim - 1>(domain.face_shape(), n), flags);
    for (const auto &face : domain.boundary_faces())
      if (face.cell->is_locally_owned() && region.boundary_ids.count(face.id) > 0) {
        values.reinit(face.cell, face.number);
        point.enter(values, &face);
        visit_all(values);
      }
    return;
  }
  dealii::FEValues<dim> values(domain.mapping(), domain.layout().shape_element(),
                               gauss_rule<dim>(domain.cell_shape(), n), flags);
  for (const auto &cell : domain.mesh().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(cell);
      point.enter(values);
      visit_all(values);
    }
}

namespace {

/// Of several numbers at once, each by itself, with the place of each.
template <int dim>
class Extremes
{
public:
  /// Coordinates that differ by less than @p small are the same.
  Extremes(const unsigned int n_numbers, const Reduce how, const double small)
      : sign(how == Reduce::minimum ? -1 : 1), small(small),
        largest(n_numbers, -std::numeric_limits<double>::max()), n_undefined(n_numbers, 0.), found(n_numbers)
  {
  }

  /// @p position() is asked for what may be the largest one only.
  template <typename Position>
  void add(const unsigned int i, const double number, const Position &position)
  {
    n_undefined[i] += std::isnan(number);
    if (std::isfinite(number))
      size = std::max(size, std::abs(number));
    if (!(sign * number < largest[i] - rounding()))
      keep({sign * number, position()}, found[i]);
    largest[i] = std::max(largest[i], sign * number); // which keeps what it has if this is NaN
  }

  std::vector<double> over_ranks(const MPI_Comm &communicator) const
  {
    std::vector<double> result(largest.size()), undefined(largest.size());
    dealii::Utilities::MPI::max(largest, communicator, result);
    dealii::Utilities::MPI::sum(n_undefined, communicator, undefined);
    for (unsigned int i = 0; i < result.size(); ++i)
      result[i] = undefined[i] > 0 ? std::numeric_limits<double>::quiet_NaN() : sign * result[i];
    return result;
  }

  /// Of what is no number the coordinates are none either.
  std::vector<dealii::Point<dim>> places_over_ranks(const MPI_Comm &communicator)
  {
    size = dealii::Utilities::MPI::max(size, communicator);
    std::vector<Extreme> all(found.size());
    for (const auto &of_rank : dealii::Utilities::MPI::all_gather(communicator, found))
      for (unsigned int i = 0; i < all.size(); ++i)
        keep(of_rank[i], all[i]);
    const std::vector<double> numbers = over_ranks(communicator);
    std::vector<dealii::Point<dim>> places;
    for (unsigned int i = 0; i < all.size(); ++i)
      places.push_back(std::isnan(numbers[i]) ? all[i].X * numbers[i] : all[i].X);
    return places;
  }

private:
  struct Extreme
  {
    double value = -std::numeric_limits<double>::max();
    dealii::Point<dim> X;

    template <typename Archive>
    void serialize(Archive &archive, const unsigned int)
    {
      archive &value &X;
    }
  };

  /// What solvers leave: those of the scene's tolerance, relative to the largest of all numbers.
  double rounding() const { return 1e-8 * size; }

  bool comes_before(const dealii::Point<dim> &X, const dealii::Point<dim> &Y) const
  {
    for (unsigned int d = 0; d < dim; ++d)
      if (std::abs(X[d] - Y[d]) > small)
        return X[d] < Y[d];
    return false;
  }

  void keep(const Extreme &next, Extreme &best) const
  {
    const bool is_tie = std::abs(next.value - best.value) <= rounding();
    if (is_tie ? comes_before(next.X, best.X) : next.value > best.value)
      best = next;
  }

  const double sign; ///< the smallest is minus the largest of minus the numbers
  const double small;
  double size = 0; ///< of all numbers
  std::vector<double> largest, n_undefined;
  std::vector<Extreme> found;
};

template <int dim>
double small_length(const Region<dim> &region)
{
  return 1e-9 * region.domain->typical_length();
}

/// What is stored in the cells of a region, where the terms of capacities see it (cell_terms.h): at the
/// points of Domain::cell_quadrature(), or at the nodes if they are lumped.
template <int dim>
void visit_storage(const Region<dim> &region, const Vector &solution, const double t,
                   const std::function<void(DomainPoint<dim> &point, double JxW)> &visit)
{
  const Domain<dim> &domain = *region.domain;
  const auto &shape_element = domain.layout().shape_element();
  const auto lumped = lumped_components(domain, 1);
  const auto &element = domain.layout().nodal_element(lumped.empty() ? 0 : lumped[0]);
  const auto flags = DomainPoint<dim>::needed() | dealii::update_JxW_values;
  dealii::FEValues<dim> values(domain.mapping(), shape_element, domain.cell_quadrature(), flags),
      values_at_nodes(domain.mapping(), shape_element,
                      dealii::Quadrature<dim>(element.get_unit_support_points()), DomainPoint<dim>::needed());
  dealii::FEValues<dim> &points = lumped.empty() ? values : values_at_nodes;
  DomainPoint<dim> point(domain, solution, t);
  std::vector<double> weights;
  for (const auto &cell : domain.mesh().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(cell);
      if (!lumped.empty())
        points.reinit(cell);
      weights.assign(points.n_quadrature_points, 0.);
      for (const unsigned int q : values.quadrature_point_indices())
        for (unsigned int i = 0; i < weights.size(); ++i)
          weights[i] += domain.measure(values, q) *
                        (lumped.empty() ? i == q : element.shape_value(i, values.get_quadrature().point(q)));
      point.enter(points);
      for (unsigned int i = 0; i < weights.size(); ++i) {
        point.move_to(i);
        visit(point, weights[i]);
      }
    }
}

/// @param n_numbers of which evaluate(point, numbers) appends each
template <int dim, typename Evaluate>
std::vector<double> integrate(const Region<dim> &region, const unsigned int n_numbers, const Reduce how,
                              const Vector &solution, const double t, const Evaluate &evaluate,
                              const bool is_stored = false)
{
  std::vector<double> sums(n_numbers + 1, 0.), numbers; // the last one: volume or area
  const auto visit = is_stored && region.boundary_ids.empty() ? visit_storage<dim> : visit_points<dim>;
  visit(region, solution, t, [&](DomainPoint<dim> &point, const double JxW) {
    numbers.clear();
    evaluate(point, numbers);
    AssertDimension(numbers.size(), n_numbers);
    for (unsigned int i = 0; i < n_numbers; ++i)
      sums[i] += numbers[i] * JxW;
    sums[n_numbers] += JxW;
  });
  dealii::Utilities::MPI::sum(sums, solution.block(0).get_mpi_communicator(), sums);
  const double size = how == Reduce::mean ? sums[n_numbers] : 1;
  sums.pop_back();
  for (double &sum : sums)
    sum /= size;
  return sums;
}

/// Visit the unknowns of a field at the nodes of a region: component, value and what gives the position.
template <int dim, typename Visit>
void for_each_unknown(const Region<dim> &region, const Field &field, const Vector &solution,
                      const Visit &visit)
{
  const Domain<dim> &domain = *region.domain;
  const auto &element = domain.layout().nodal_element(field.first_component);
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns, component_values;
  const auto visit_cell = [&](const auto &cell, const auto &belongs) {
    domain.cell_dofs(domain.dof_cell(cell), dofs);
    unknowns.resize(dofs.size());
    solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    for (unsigned int c = 0; c < field.n_components; ++c) {
      domain.layout().nodal_values(field.first_component + c, unknowns, component_values);
      for (unsigned int a = 0; a < component_values.size(); ++a)
        if (belongs(a))
          visit(c, component_values[a], [&]() {
            return domain.mapping().transform_unit_to_real_cell(cell, element.unit_support_point(a));
          });
    }
  };
  if (region.boundary_ids.empty()) {
    for (const auto &cell : domain.mesh().active_cell_iterators())
      if (cell->is_locally_owned())
        visit_cell(cell, [](const unsigned int) { return true; });
    return;
  }
  for (const auto &face : domain.boundary_faces())
    if (face.cell->is_locally_owned() && region.boundary_ids.count(face.id) > 0)
      visit_cell(face.cell,
                 [&](const unsigned int a) { return element.has_support_on_face(a, face.number); });
}

} // namespace

const std::vector<std::string> &names_of_reduce()
{
  static const std::vector<std::string> names = {"minimum", "maximum", "mean", "integral"};
  return names;
}

template <int dim>
std::vector<double> reduce(const Region<dim> &region, const Field &field, const Reduce how,
                           const Vector &solution, std::vector<dealii::Point<dim>> *places)
{
  if (how == Reduce::mean || how == Reduce::integral)
    return integrate(region, field.n_components, how, solution, 0,
                     [&](DomainPoint<dim> &point, std::vector<double> &numbers) {
                       const auto first = point.state().value.begin() + field.first_component;
                       numbers.insert(numbers.end(), first, first + field.n_components);
                     });
  Extremes<dim> extremes(field.n_components, how, small_length(region));
  for_each_unknown(region, field, solution,
                   [&](const unsigned int c, const double value, const auto &position) {
                     extremes.add(c, value, position);
                   });
  const MPI_Comm communicator = solution.block(0).get_mpi_communicator();
  if (places != nullptr)
    *places = extremes.places_over_ranks(communicator);
  return extremes.over_ranks(communicator);
}

template <int dim>
std::vector<double> reduce(const Region<dim> &region, const Quantity<dim> &quantity, const Reduce how,
                           const Vector &solution, const double t, std::vector<dealii::Point<dim>> *places)
{
  const unsigned int n_numbers = quantity.n_numbers();
  if (how == Reduce::mean || how == Reduce::integral)
    return integrate(
        region, n_numbers, how, solution, t,
        [&](DomainPoint<dim> &point, std::vector<double> &numbers) { quantity.evaluate(point, numbers); },
        quantity.is_stored());
  Extremes<dim> extremes(n_numbers, how, small_length(region));
  std::vector<double> numbers;
  visit_points<dim>(region, solution, t, [&](DomainPoint<dim> &point, const double) {
    numbers.clear();
    quantity.evaluate(point, numbers);
    for (unsigned int i = 0; i < n_numbers; ++i)
      extremes.add(i, numbers[i], [&]() { return point.state().X; });
  });
  const MPI_Comm communicator = solution.block(0).get_mpi_communicator();
  if (places != nullptr)
    *places = extremes.places_over_ranks(communicator);
  return extremes.over_ranks(communicator);
}

template void visit_points(const Region<2> &, const Vector &, double,
                           const std::function<void(DomainPoint<2> &, double)> &);
template void visit_points(const Region<3> &, const Vector &, double,
                           const std::function<void(DomainPoint<3> &, double)> &);
template std::vector<double> reduce(const Region<2> &, const Field &, Reduce, const Vector &,
                                    std::vector<dealii::Point<2>> *);
template std::vector<double> reduce(const Region<3> &, const Field &, Reduce, const Vector &,
                                    std::vector<dealii::Point<3>> *);
template std::vector<double> reduce(const Region<2> &, const Quantity<2> &, Reduce, const Vector &, double,
                                    std::vector<dealii::Point<2>> *);
template std::vector<double> reduce(const Region<3> &, const Quantity<3> &, Reduce, const Vector &, double,
                                    std::vector<dealii::Point<3>> *);

} // namespace dovetail
