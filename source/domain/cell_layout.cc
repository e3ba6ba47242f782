// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_layout.h>
#include <dovetail/domain/quadrature.h>

#include <deal.II/fe/fe_dgp.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_simplex_p.h>
#include <deal.II/lac/full_matrix.h>

#include <algorithm>

namespace dovetail {

namespace {

/// FE_SimplexP, which before deal.II 9.6 gives every shape function a support on every face.
template <int dim>
class SimplexElement : public dealii::FE_SimplexP<dim>
{
public:
  using dealii::FE_SimplexP<dim>::FE_SimplexP;

  std::unique_ptr<dealii::FiniteElement<dim>> clone() const override
  {
    return std::make_unique<SimplexElement>(*this);
  }

  /// The nodes of face f are those where the barycentric coordinate of the opposite vertex vanishes.
  bool has_support_on_face(const unsigned int shape_function, const unsigned int face) const override
  {
    const auto shape = this->reference_cell();
    unsigned int opposite = 0;
    for (const unsigned int v : shape.vertex_indices()) {
      bool is_on_face = false;
      for (unsigned int i = 0; i < dim; ++i)
        is_on_face = is_on_face || shape.face_to_cell_vertices(face, i, 1) == v;
      if (!is_on_face)
        opposite = v;
    }
    return shape.d_linear_shape_function(this->get_unit_support_points()[shape_function], opposite) < 1e-10;
  }
};

template <int dim>
using Elements = std::vector<const dealii::FiniteElement<dim> *>;

/// Several elements of simplices. Triangles may run along a common line in either direction; deal.II's
/// FESystem takes that into account only in three dimensions (pull request 18832 of dealii, merged in August
/// 2025; 9.6 lacks it).
template <int dim>
class SystemOfSimplices : public dealii::FESystem<dim>
{
public:
  SystemOfSimplices(const Elements<dim> &elements, const std::vector<unsigned int> &multiplicities)
      : dealii::FESystem<dim>(elements, multiplicities)
  {
    std::vector<int> &shift = this->adjust_line_dof_index_for_line_orientation_table;
    unsigned int i = 0; // those of a component stand side by side
    for (unsigned int e = 0; e < elements.size(); ++e)
      for (unsigned int m = 0; m < multiplicities[e]; ++m)
        for (int on_line = 0, n = elements[e]->n_dofs_per_line(); on_line < n && i < shift.size(); ++on_line)
          shift[i++] = n - 1 - 2 * on_line;
  }

  std::unique_ptr<dealii::FiniteElement<dim>> clone() const override
  {
    Elements<dim> elements;
    std::vector<unsigned int> multiplicities;
    for (unsigned int e = 0; e < this->n_base_elements(); ++e) {
      elements.push_back(&this->base_element(e));
      multiplicities.push_back(this->element_multiplicity(e));
    }
    return std::make_unique<SystemOfSimplices>(elements, multiplicities);
  }
};

template <int dim>
std::unique_ptr<dealii::FiniteElement<dim>> make_scalar(const unsigned int degree, const bool is_continuous,
                                                        const bool simplices)
{
  if (simplices && is_continuous)
    return std::make_unique<SimplexElement<dim>>(degree);
  if (simplices)
    return std::make_unique<dealii::FE_SimplexDGP<dim>>(degree);
  if (is_continuous)
    return std::make_unique<dealii::FE_Q<dim>>(degree);
  return std::make_unique<dealii::FE_DGP<dim>>(degree);
}

template <int dim>
std::unique_ptr<dealii::FESystem<dim>> make_system(const Elements<dim> &elements,
                                                   const std::vector<unsigned int> &multiplicities,
                                                   const bool simplices)
{
  if (simplices)
    return std::make_unique<SystemOfSimplices<dim>>(elements, multiplicities);
  return std::make_unique<dealii::FESystem<dim>>(elements, multiplicities);
}

/// A multiplier, as the pressure that keeps the volume, is stable beside displacements of one degree more if
/// it is discontinuous with all polynomials (FE_DGP) on hypercubes, continuous on simplices (Taylor & Hood
/// 1973; Boffi, Brezzi & Fortin 2013, chapter 8).
bool has_continuous_element(const Field &field, const bool simplices)
{
  return field.is_continuous || (simplices && field.is_multiplier);
}

/// The coefficients of 1: the projection.
template <int dim>
std::vector<double> coefficients_of_unit(const dealii::FiniteElement<dim> &element)
{
  const unsigned int n = element.n_dofs_per_cell();
  if (element.has_support_points())
    return std::vector<double>(n, 1.);
  const auto rule = gauss_rule<dim>(element.reference_cell(), element.degree + 1);
  dealii::FullMatrix<double> mass(n, n);
  dealii::Vector<double> moments(n), unit(n);
  for (unsigned int q = 0; q < rule.size(); ++q)
    for (unsigned int i = 0; i < n; ++i) {
      const double phi = rule.weight(q) * element.shape_value(i, rule.point(q));
      moments[i] += phi;
      for (unsigned int j = 0; j < n; ++j)
        mass(i, j) += phi * element.shape_value(j, rule.point(q));
    }
  mass.gauss_jordan();
  mass.vmult(unit, moments);
  return {unit.begin(), unit.end()};
}

} // namespace

template <int dim>
unsigned int CellLayout<dim>::lowest_degree(const Field &field, const bool simplices)
{
  const int lowest = field.is_continuous || simplices || field.is_multiplier ? 1 : 0; // of the field
  return std::max(1, lowest - field.relative_degree);
}

template <int dim>
CellLayout<dim>::CellLayout(const std::vector<Field> &fields, const unsigned int degree, const bool simplices)
{
  Field lagrange;
  find_space(lagrange, degree, simplices);
  unsigned int first = 0;
  for (const Field &field : fields) {
    const unsigned int s = find_space(field, degree, simplices),
                       n_nodes = spaces[s].element->n_dofs_per_cell();
    for (unsigned int c = 0; c < field.n_components; ++c, first += n_nodes)
      components.push_back({s, first, n_nodes, spaces[s].first_shape});
  }
  components.push_back({0, first, 0, 0});
  make_systems(fields, simplices);
}

/// Makes it if it is new.
template <int dim>
unsigned int CellLayout<dim>::find_space(const Field &field, const unsigned int degree, const bool simplices)
{
  const bool is_continuous = has_continuous_element(field, simplices);
  for (unsigned int s = 0; s < spaces.size(); ++s)
    if (spaces[s].relative_degree == field.relative_degree && spaces[s].is_continuous == is_continuous)
      return s;
  Space space;
  space.element = make_scalar<dim>(degree + field.relative_degree, is_continuous, simplices);
  space.relative_degree = field.relative_degree;
  space.is_continuous = is_continuous;
  space.first_shape = number_of_shapes;
  space.unit = coefficients_of_unit(*space.element);
  number_of_shapes += space.element->n_dofs_per_cell();
  spaces.push_back(std::move(space));
  return spaces.size() - 1;
}

template <int dim>
void CellLayout<dim>::make_systems(const std::vector<Field> &fields, const bool simplices)
{
  Elements<dim> elements;
  std::vector<unsigned int> multiplicities;
  for (const Field &field : fields) {
    const auto *element = spaces[components[field.first_component].space].element.get();
    if (elements.empty() || elements.back() != element) {
      elements.push_back(element);
      multiplicities.push_back(0);
    }
    multiplicities.back() += field.n_components;
  }
  system = make_system<dim>(elements, multiplicities, simplices);
  for (unsigned int c = 0; c < n_components(); ++c)
    for (unsigned int a = 0; a < n_nodes(c); ++a)
      number_in_system.push_back(system->component_to_system_index(c, a));

  if (spaces.size() == 1)
    return;
  elements.clear();
  for (const Space &space : spaces)
    elements.push_back(space.element.get());
  shapes_of_all = make_system<dim>(elements, std::vector<unsigned int>(elements.size(), 1), simplices);
  for (unsigned int s = 0; s < spaces.size(); ++s)
    for (unsigned int a = 0; a < spaces[s].element->n_dofs_per_cell(); ++a)
      number_in_element.push_back(shapes_of_all->component_to_system_index(s, a));
}

template <int dim>
void CellLayout<dim>::nodal_values(const unsigned int c, const std::vector<double> &unknowns,
                                   std::vector<double> &values) const
{
  const auto begin = unknowns.begin() + first(c);
  values.assign(begin, begin + n_nodes(c));
  if (is_continuous(c))
    return;
  const auto &points = nodal_element(c).get_unit_support_points();
  values.assign(points.size(), 0.);
  for (unsigned int i = 0; i < points.size(); ++i)
    for (unsigned int a = 0; a < n_nodes(c); ++a)
      values[i] += begin[a] * element(c).shape_value(a, points[i]);
}

template class CellLayout<2>;
template class CellLayout<3>;

} // namespace dovetail
