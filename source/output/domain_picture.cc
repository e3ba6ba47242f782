// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_terms.h>
#include <dovetail/output/domain_picture.h>

#include <deal.II/fe/fe_simplex_p.h>

#include <limits>

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

/// A grid of degree^dim parts on a hypercube. The nodes of the linear or quadratic element on a simplex, in
/// the order that VTK has, too.
template <int dim>
dealii::Quadrature<dim> points_of_patch(const Domain<dim> &domain)
{
  if (domain.has_simplices())
    return dealii::Quadrature<dim>(
        dealii::FE_SimplexP<dim>(std::min(std::max(domain.degree, domain.mapping_degree()), 2U))
            .get_unit_support_points());
  return dealii::QIterated<dim>(dealii::QTrapezoid<1>(), domain.degree);
}

} // namespace

template <int dim>
DomainPicture<dim>::DomainPicture(const Domain<dim> &domain, const std::set<std::string> &fields,
                                  const Vector &solution, const double t)
    : material(domain.material)
{
  declare(fields);
  const unsigned int n = domain.n_components(), n_nodes = domain.n_nodes();
  const dealii::Quadrature<dim> points = points_of_patch(domain);
  dealii::FEValues<dim> values(domain.mapping(), domain.scalar_element(), points,
                               dealii::update_values | dealii::update_gradients |
                                   dealii::update_quadrature_points);
  const bool gives_points = domain.mapping_degree() > 1 || domain.has_simplices();
  State<dim> state(n);
  state.t = t;
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell()), shape(n_nodes), data;
  std::vector<dealii::Tensor<1, dim>> gradients(n_nodes);
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      const typename dealii::Triangulation<dim>::active_cell_iterator mesh_cell(cell);
      values.reinit(mesh_cell);
      domain.cell_dofs(cell, dofs);
      for (unsigned int i = 0; i < dofs.size(); ++i)
        unknowns[i] = solution(dofs[i]);

      Patch patch;
      patch.patch_index = patches.size();
      patch.reference_cell = domain.cell_shape();
      patch.n_subdivisions = domain.has_simplices() ? 1 : domain.degree;
      for (const unsigned int v : mesh_cell->vertex_indices())
        patch.vertices[v] = mesh_cell->vertex(v);
      patch.points_are_available = gives_points; // as the last rows
      patch.data.reinit(names.size() + (gives_points ? dim : 0), points.size());
      for (unsigned int q = 0; q < points.size(); ++q) {
        for (unsigned int a = 0; a < n_nodes; ++a) {
          shape[a] = values.shape_value(a, q);
          gradients[a] = values.shape_grad(a, q);
        }
        state.X = values.quadrature_point(q);
        evaluate_state<dim>(n, n_nodes, shape.data(), gradients.data(), unknowns.data(), state);
        data.clear();
        append_data(state, data);
        for (unsigned int d = 0; gives_points && d < dim; ++d)
          data.push_back(state.X[d]);
        for (unsigned int i = 0; i < data.size(); ++i)
          patch.data(i, q) = data[i];
      }
      patches.push_back(std::move(patch));
    }
}

template <int dim>
void DomainPicture<dim>::declare(const std::set<std::string> &fields)
{
  has_solution = fields.count("solution") > 0;
  if (has_solution)
    for (const Field &field : material.fields())
      names.insert(names.end(), field.n_components, field.name);
  const auto add = [&](const std::string &name, const std::string &of_field,
                       const unsigned int n_components) {
    if (fields.count(name) == 0 || material.find_field(of_field) == nullptr)
      return false;
    names.insert(names.end(), n_components, name);
    return true;
  };
  has_heat_flux = add("heat flux", "temperature", dim);
  has_stress = add("Cauchy stress", "displacement", 9);
  has_von_mises = add("von Mises", "displacement", 1);
}

template <int dim>
void DomainPicture<dim>::append_data(const State<dim> &state, std::vector<double> &data) const
{
  if (has_solution)
    data.insert(data.end(), state.value.begin(), state.value.end());
  if (has_heat_flux) {
    Response<dim> response(state.value.size());
    const bool is_defined = material.evaluate(state, false, response);
    const auto &influx = response.flux[material.find_field("temperature")->first_component];
    for (unsigned int d = 0; d < dim; ++d)
      data.push_back(is_defined ? -influx[d] : std::numeric_limits<double>::quiet_NaN());
  }
  if (!has_stress && !has_von_mises)
    return;
  const dealii::Tensor<2, 3> sigma = material.cauchy_stress(state);
  for (unsigned int i = 0; has_stress && i < 3; ++i)
    for (unsigned int j = 0; j < 3; ++j)
      data.push_back(sigma[i][j]);
  if (has_von_mises)
    data.push_back(std::sqrt(1.5) * deviator(symmetrize(sigma)).norm());
}

template class DomainPicture<2>;
template class DomainPicture<3>;

} // namespace dovetail
