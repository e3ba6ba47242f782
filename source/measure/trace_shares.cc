// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/quadrature.h>
#include <dovetail/measure/trace_shares.h>

#include <deal.II/base/mpi.h>
#include <deal.II/dofs/dof_tools.h>

namespace dovetail {

template <int dim>
FluxOnFace<dim>::FluxOnFace(const Domain<dim> &domain, const double t)
    : point(domain, t), result(domain.n_components())
{
}

template <int dim>
const std::vector<double> &FluxOnFace<dim>::evaluate(const dealii::FEFaceValues<dim> &values,
                                                     const unsigned int q,
                                                     const std::vector<double> &unknowns)
{
  point.reinit(values, q, unknowns);
  const bool is_defined = point.evaluate(false);
  for (unsigned int c = 0; c < result.size(); ++c)
    result[c] = is_defined ? point.response.flux[c] * values.normal_vector(q) : 0.;
  return result;
}

template <int dim>
TraceShares<dim>::TraceShares(const Domain<dim> &domain, const Field &field, const Vector &solution,
                              const double t, const Part &part)
    : domain(domain), field(field)
{
  const MPI_Comm communicator = solution.block(0).get_mpi_communicator();
  for (auto *weights : {&area[0], &area[1], &flux[0], &flux[1]})
    weights->reinit(domain.dof_handler().locally_owned_dofs(), communicator);
  add_areas(part);
  bool has_common = false;
  for (const auto dof : domain.dof_handler().locally_owned_dofs())
    has_common = has_common || (area[0](dof) > 0 && area[1](dof) > 0);
  if (dealii::Utilities::MPI::max(has_common ? 1 : 0, communicator) == 1)
    add_fluxes(solution, t, part);
}

template <int dim>
double TraceShares<dim>::first_share(const dealii::types::global_dof_index dof, const double force) const
{
  const auto i = dof - domain.first_dof();
  const double sum = area[0](i) + area[1](i);
  return sum > 0 ? flux[0](i) + (force - flux[0](i) - flux[1](i)) * (area[0](i) / sum) : 0.;
}

template <int dim>
double TraceShares<dim>::first_area(const dealii::types::global_dof_index dof) const
{
  const auto i = dof - domain.first_dof();
  const double sum = area[0](i) + area[1](i);
  return sum > 0 ? area[0](i) / sum : 0.;
}

template <int dim>
bool TraceShares<dim>::is_common(const dealii::types::global_dof_index dof) const
{
  return area[0](dof - domain.first_dof()) > 0 && area[1](dof - domain.first_dof()) > 0;
}

template <int dim>
void TraceShares<dim>::add_areas(const Part &part)
{
  const auto &element = domain.layout().element(field.first_component);
  const unsigned int n = element.n_dofs_per_cell();
  dealii::FEFaceValues<dim> values(domain.mapping(), element,
                                   gauss_rule<dim - 1>(domain.face_shape(), domain.degree + 1),
                                   dealii::update_values | domain.measure.update_flags());
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &face : domain.boundary_faces()) {
    bool is_ready = false;
    if (face.cell->is_locally_owned())
      for (unsigned int c = 0; c < field.n_components; ++c)
        for (unsigned int a = 0; a < n; ++a)
          if (element.has_support_on_face(a, face.number))
            if (const int node_part = part(face, a, c); node_part >= 0) {
              if (!is_ready) {
                values.reinit(face.cell, face.number);
                domain.cell_dofs(domain.dof_cell(face.cell), dofs);
                is_ready = true;
              }
              double square = 0;
              for (const unsigned int q : values.quadrature_point_indices())
                square += values.shape_value(a, q) * values.shape_value(a, q) * domain.measure(values, q);
              area[node_part](dofs[domain.layout().index(field.first_component + c, a)] -
                              domain.first_dof()) += square;
            }
  }
  for (Weights &weights : area)
    conform(weights);
}

/// On the faces around nodes that both parts have.
template <int dim>
void TraceShares<dim>::add_fluxes(const Vector &solution, const double t, const Part &part)
{
  const CellLayout<dim> &layout = domain.layout();
  const auto &element = layout.element(field.first_component);
  const MPI_Comm communicator = solution.block(0).get_mpi_communicator();
  const dealii::IndexSet relevant = dealii::DoFTools::extract_locally_relevant_dofs(domain.dof_handler());
  std::array<Weights, 2> ghosted;
  for (const unsigned int p : {0, 1}) {
    ghosted[p].reinit(domain.dof_handler().locally_owned_dofs(), relevant, communicator);
    ghosted[p] = area[p];
  }
  dealii::FEFaceValues<dim> values(
      domain.mapping(), layout.shape_element(), gauss_rule<dim - 1>(domain.face_shape(), domain.degree + 2),
      dealii::update_values | dealii::update_gradients | dealii::update_quadrature_points |
          dealii::update_normal_vectors | dealii::update_JxW_values);
  FluxOnFace<dim> flux_on_face(domain, t);
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell());
  const bool has_hanging_nodes = domain.mesh().has_hanging_nodes();
  for (const auto &face : domain.boundary_faces()) {
    if (!face.cell->is_locally_owned())
      continue;
    domain.cell_dofs(domain.dof_cell(face.cell), dofs);
    std::vector<std::array<unsigned int, 4>> nodes; // local unknown, component, shape function, part
    bool has_common = has_hanging_nodes;            // masters may be elsewhere
    for (unsigned int c = 0; c < field.n_components; ++c)
      for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
        if (element.has_support_on_face(a, face.number))
          if (const int node_part = part(face, a, c); node_part >= 0) {
            const unsigned int component = field.first_component + c, i = layout.index(component, a);
            nodes.push_back(
                {{i, component, layout.shape_of_node(component, a), static_cast<unsigned int>(node_part)}});
            const auto dof = dofs[i] - domain.first_dof();
            has_common = has_common || (ghosted[0](dof) > 0 && ghosted[1](dof) > 0);
          }
    if (nodes.empty() || !has_common)
      continue;
    values.reinit(face.cell, face.number);
    solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    for (const unsigned int q : values.quadrature_point_indices()) {
      const std::vector<double> &A_N = flux_on_face.evaluate(values, q, unknowns);
      for (const auto &[i, component, shape, node_part] : nodes)
        flux[node_part](dofs[i] - domain.first_dof()) +=
            A_N[component] * values.shape_value(shape, q) * domain.measure(values, q);
    }
  }
  for (Weights &weights : flux)
    conform(weights);
}

/// Those of hanging nodes belong to the nodes they follow.
template <int dim>
void TraceShares<dim>::conform(Weights &weights) const
{
  weights.compress(dealii::VectorOperation::add);
  if (!domain.mesh().has_hanging_nodes())
    return;
  const auto hanging = domain.hanging_nodes();
  const auto &owned = domain.dof_handler().locally_owned_dofs();
  Weights passed_on(owned, weights.get_mpi_communicator());
  for (const auto &line : hanging.get_lines())
    if (owned.is_element(line.index))
      for (const auto &[other, weight] : line.entries)
        passed_on(other) += weight * weights(line.index);
  passed_on.compress(dealii::VectorOperation::add);
  weights += passed_on;
}

template class FluxOnFace<2>;
template class FluxOnFace<3>;
template class TraceShares<2>;
template class TraceShares<3>;

} // namespace dovetail
