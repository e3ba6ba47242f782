// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/compatibility.h>
#include <dovetail/output/domain_picture.h>

#include <deal.II/fe/fe_simplex_p.h>

#include <algorithm>

namespace dovetail {

std::vector<std::tuple<unsigned int, unsigned int, std::string,
                       dealii::DataComponentInterpretation::DataComponentInterpretation>>
group_by_name(const std::vector<std::string> &names)
{
  std::vector<std::tuple<unsigned int, unsigned int, std::string,
                         dealii::DataComponentInterpretation::DataComponentInterpretation>>
      ranges;
  for (unsigned int begin = 0, end; begin < names.size(); begin = end) {
    for (end = begin + 1; end < names.size() && names[end] == names[begin];)
      ++end;
    if (end - begin > 1)
      ranges.emplace_back(begin, end - 1, names[begin],
                          end - begin == 9
                              ? dealii::DataComponentInterpretation::component_is_part_of_tensor
                              : dealii::DataComponentInterpretation::component_is_part_of_vector);
  }
  return ranges;
}

namespace {

/// The nodes of VTK's cell by lines along x, planes and layers, where deal.II looks for them: deal.II 9.4
/// knows the last two edges in z-direction in the old order.
dealii::Quadrature<3> nodes_of_hexahedron(const unsigned int degree)
{
  const dealii::QIterated<3> grid(dealii::QTrapezoid<1>(), degree);
  auto points = grid.get_points();
  for (unsigned int k = 1; k < degree && has_old_order_of_edges; ++k) {
    const unsigned int back = ((degree + 1) * k + degree) * (degree + 1);
    std::swap(points[back], points[back + degree]);
  }
  return dealii::Quadrature<3>(points);
}

/// The nodes of the cell that is written: of degree p on a hypercube, linear or quadratic on a simplex, in
/// the order that VTK has, too.
template <int structdim, int dim>
dealii::Quadrature<structdim> points_of_patch(const Domain<dim> &domain)
{
  if constexpr (structdim > 1)
    if (domain.has_simplices())
      return dealii::Quadrature<structdim>(
          dealii::FE_SimplexP<structdim>(std::min(std::max(domain.degree, domain.mapping_degree()), 2U))
              .get_unit_support_points());
  if constexpr (structdim == 3)
    return nodes_of_hexahedron(domain.degree);
  else
    return dealii::QIterated<structdim>(dealii::QTrapezoid<1>(), domain.degree);
}

/// One for each number.
template <int dim>
std::vector<std::string> names_of(const QuantityList<dim> &quantities)
{
  std::vector<std::string> names;
  for (const Quantity<dim> *quantity : quantities)
    for (const auto &array : quantity->arrays())
      names.insert(names.end(), array.n_components, array.name);
  return names;
}

/// The numbers at the points that @p point has entered and, in the last rows, where these are, if the patch
/// is to know that.
template <int dim, typename Patch>
void fill(const QuantityList<dim> &quantities, DomainPoint<dim> &point, const unsigned int n_points,
          const unsigned int n_numbers, Patch &patch)
{
  std::vector<double> numbers;
  patch.data.reinit(n_numbers + (patch.points_are_available ? dim : 0), n_points);
  for (unsigned int q = 0; q < n_points; ++q) {
    point.move_to(q);
    numbers.clear();
    for (const Quantity<dim> *quantity : quantities)
      quantity->evaluate(point, numbers);
    AssertDimension(numbers.size(), n_numbers);
    for (unsigned int d = 0; patch.points_are_available && d < dim; ++d)
      numbers.push_back(point.state().X[d]);
    for (unsigned int i = 0; i < numbers.size(); ++i)
      patch.data(i, q) = numbers[i];
  }
}

} // namespace

template <int structdim, int dim>
QuantityPicture<structdim, dim>::QuantityPicture(const QuantityList<dim> &quantities)
    : names(names_of(quantities))
{
}

template <int dim>
DomainPicture<dim>::DomainPicture(const Domain<dim> &domain, const QuantityList<dim> &quantities,
                                  const Vector &solution, const double t)
    : QuantityPicture<dim, dim>(quantities)
{
  DomainPoint<dim> point(domain, solution, t);
  dealii::FEValues<dim> values(domain.mapping(), domain.layout().shape_element(),
                               points_of_patch<dim>(domain), DomainPoint<dim>::needed());
  for (const auto &cell : domain.mesh().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(cell);
      point.enter(values);
      typename DomainPicture::Patch patch;
      patch.patch_index = this->patches.size();
      patch.reference_cell = domain.cell_shape();
      patch.n_subdivisions = domain.has_simplices() ? 1 : domain.degree;
      for (const unsigned int v : cell->vertex_indices())
        patch.vertices[v] = cell->vertex(v);
      patch.points_are_available =
          domain.mapping_degree() > 1 || domain.has_simplices() || (dim == 3 && domain.degree > 1);
      fill<dim>(quantities, point, values.n_quadrature_points, this->names.size(), patch);
      this->patches.push_back(std::move(patch));
    }
}

/// All points are given, because those of a face may be turned against its vertices.
template <int dim>
BoundaryPicture<dim>::BoundaryPicture(const Domain<dim> &domain, const QuantityList<dim> &quantities,
                                      const Vector &solution, const double t)
    : QuantityPicture<dim - 1, dim>(quantities)
{
  DomainPoint<dim> point(domain, solution, t);
  dealii::FEFaceValues<dim> values(domain.mapping(), domain.layout().shape_element(),
                                   points_of_patch<dim - 1>(domain), DomainPoint<dim>::needed());
  for (const auto &face : domain.boundary_faces())
    if (face.cell->is_locally_owned()) {
      values.reinit(face.cell, face.number);
      point.enter(values, &face);
      typename BoundaryPicture::Patch patch;
      patch.patch_index = this->patches.size();
      patch.reference_cell = domain.face_shape();
      patch.n_subdivisions = domain.has_simplices() && dim == 3 ? 1 : domain.degree;
      patch.points_are_available = true;
      fill<dim>(quantities, point, values.n_quadrature_points, this->names.size(), patch);
      this->patches.push_back(std::move(patch));
    }
}

template class QuantityPicture<1, 2>;
template class QuantityPicture<2, 2>;
template class QuantityPicture<2, 3>;
template class QuantityPicture<3, 3>;
template class DomainPicture<2>;
template class DomainPicture<3>;
template class BoundaryPicture<2>;
template class BoundaryPicture<3>;

} // namespace dovetail
