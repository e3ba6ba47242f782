// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/measure_by_vertices.h>
#include <dovetail/measure/bending_stiffness.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <array>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_bending("locking", "a solid of degree 1 bends with cells that are long beside its height");

/// Of the energy of a strain as large as the gradients and the displacement in the diameter of its cell:
/// less is that of a motion of a rigid body and rounding.
const double smallest_share = 1e-14;

template <int dim>
using Strain = dealii::Tensor<2, dim>;

/// Half of E : D : E, by its components.
template <int dim>
class ElasticEnergy
{
public:
  /// With the tangent at rest in the first cell of the first rank that has one. Collective.
  ElasticEnergy(const Domain<dim> &domain, const Field &displacement, const MPI_Comm &communicator)
  {
    const unsigned int n = domain.n_components(), u = displacement.first_component;
    std::vector<double> components; // of this rank
    CellPoints<dim> point(domain, 0);
    for (const auto &cell : domain.dof_handler().active_cell_iterators())
      if (cell->is_locally_owned()) {
        point.state.X = cell->center();
        for (const Field &field : domain.fields())
          if (const Expression *initial = domain.initial().find(field.name);
              initial != nullptr && field.n_components == 1)
            point.state.value[field.first_component] = initial->value(point.state.X, 0., 0);
        const bool is_evaluated = point.evaluate(true);
        for (unsigned int i = 0; i < dim && is_evaluated; ++i)
          for (unsigned int j = 0; j < dim; ++j) {
            const dealii::Tensor<2, dim> block = point.response.by_gradient[(u + i) * n + u + j];
            for (unsigned int k = 0; k < dim * dim; ++k)
              components.push_back(block[k / dim][k % dim]);
          }
        break;
      }
    for (const auto &of_rank : dealii::Utilities::MPI::all_gather(communicator, components))
      if (!is_defined && !of_rank.empty()) {
        is_defined = true;
        auto component = of_rank.begin();
        for (auto &row : tangent)
          for (auto &block : row)
            for (unsigned int k = 0; k < dim * dim; ++k)
              block[k / dim][k % dim] = *component++;
      }
  }

  double operator()(const Strain<dim> &E) const
  {
    double energy = 0;
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        energy += 0.5 * (E[i] * (tangent[i][j] * E[j]));
    return energy;
  }

  /// Of a strain of the size of H and w.
  double of_gradient(const dealii::Tensor<2, dim> &H, const dealii::Tensor<1, dim> &w) const
  {
    return 0.5 * tangent[0][0][0][0] * (H.norm_square() + w.norm_square());
  }

  bool is_defined = false;

private:
  std::array<std::array<dealii::Tensor<2, dim>, dim>, dim> tangent;
};

template <int dim>
dealii::Tensor<2, dim> displacement_gradient(const dealii::FEValues<dim> &values, const unsigned int q,
                                             const std::vector<dealii::Tensor<1, dim>> &displacements)
{
  dealii::Tensor<2, dim> H;
  for (unsigned int a = 0; a < displacements.size(); ++a)
    H += dealii::outer_product(displacements[a], values.shape_grad(a, q));
  return H;
}

template <int dim>
Strain<dim> strain(const dealii::Tensor<2, dim> &H, const bool is_large)
{
  Strain<dim> twice = H + transpose(H);
  if (is_large)
    twice += transpose(H) * H;
  return 0.5 * twice;
}

} // namespace

template <int dim>
StiffnessShare stiffness_share(const Domain<dim> &domain, const Field &displacement, const Vector &solution,
                               const MPI_Comm &communicator)
{
  const ElasticEnergy<dim> energy(domain, displacement, communicator);
  const bool is_large = domain.material.has_large_strain();
  const auto &element = domain.scalar_element();
  const unsigned int n_vertices = element.dofs_per_cell;
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell());
  std::vector<dealii::Tensor<1, dim>> displacements(n_vertices);
  const auto enter = [&](const auto &cell, dealii::FEValues<dim> &values) {
    values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
    domain.cell_dofs(cell, dofs);
    solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    for (unsigned int a = 0; a < n_vertices; ++a)
      for (unsigned int d = 0; d < dim; ++d)
        displacements[a][d] = unknowns[domain.layout().index(displacement.first_component + d, a)];
  };

  std::vector<Strain<dim>> at_vertex(domain.mesh().n_vertices());
  std::vector<double> volume_at_vertex(domain.mesh().n_vertices(), 0.);
  dealii::FEValues<dim> vertices(domain.mapping(), element,
                                 dealii::Quadrature<dim>(element.get_unit_support_points()),
                                 dealii::update_gradients);
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (!cell->is_artificial()) {
      enter(cell, vertices);
      const double volume = measure_by_vertices<dim>(cell);
      for (unsigned int a = 0; a < n_vertices; ++a) {
        at_vertex[cell->vertex_index(a)] +=
            volume * strain(displacement_gradient(vertices, a, displacements), is_large);
        volume_at_vertex[cell->vertex_index(a)] += volume;
      }
    }

  StiffnessShare share;
  dealii::FEValues<dim> values(domain.mapping(), element, domain.cell_quadrature(),
                               dealii::update_values | dealii::update_gradients | dealii::update_JxW_values |
                                   dealii::update_quadrature_points);
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned() && energy.is_defined) {
      enter(cell, values);
      for (const unsigned int q : values.quadrature_point_indices()) {
        const auto H = displacement_gradient(values, q, displacements);
        const Strain<dim> E = strain(H, is_large);
        Strain<dim> difference = E;
        for (unsigned int a = 0; a < n_vertices; ++a) {
          const unsigned int vertex = cell->vertex_index(a);
          difference -= values.shape_value(a, q) / volume_at_vertex[vertex] * at_vertex[vertex];
        }
        const double dV = domain.measure(values, q);
        share.jumping += energy(difference) * dV;
        share.all += energy(E) * dV;
        dealii::Tensor<1, dim> u;
        for (unsigned int a = 0; a < n_vertices; ++a)
          u += values.shape_value(a, q) * displacements[a];
        share.of_gradients += energy.of_gradient(H, u / cell->diameter()) * dV;
      }
    }
  return share;
}

template <int dim>
NoteList explain_stiffness(const Model<dim> &model, const Vector &solution)
{
  NoteList notes;
  for (const auto &domain : model.domains) {
    const Field *displacement = domain->material.solid_field();
    if (displacement == nullptr || domain->degree > 1)
      continue;
    const StiffnessShare own = stiffness_share(*domain, *displacement, solution, model.communicator);
    const double jumping = dealii::Utilities::MPI::sum(own.jumping, model.communicator),
                 all = dealii::Utilities::MPI::sum(own.all, model.communicator),
                 of_gradients = dealii::Utilities::MPI::sum(own.of_gradients, model.communicator);
    if (!(jumping > largest_stiffness_share * all) || !(all > smallest_share * of_gradients))
      continue;
    std::ostringstream words;
    words.precision(2);
    words << domain->name << ": neighbouring cells of degree 1 disagree about " << 100 * jumping / all
          << " % of its strain energy, as in a body that bends with one to three cells across its height, or "
             "with long ones: it is too stiff by about as much, or more. Set Degree = 2, or refine the mesh";
    notes.push_back(of_bending(words.str()));
  }
  return notes;
}

template StiffnessShare stiffness_share(const Domain<2> &, const Field &, const Vector &, const MPI_Comm &);
template StiffnessShare stiffness_share(const Domain<3> &, const Field &, const Vector &, const MPI_Comm &);
template NoteList explain_stiffness(const Model<2> &, const Vector &);
template NoteList explain_stiffness(const Model<3> &, const Vector &);

} // namespace dovetail
