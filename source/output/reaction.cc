// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_terms.h>
#include <dovetail/output/reaction.h>

#include <deal.II/dofs/dof_tools.h>
#include <deal.II/lac/trilinos_vector.h>

#include <limits>

namespace dovetail {

namespace {

using Weights = dealii::TrilinosWrappers::MPI::Vector;

template <int dim>
bool is_on(const typename Domain<dim>::cell_iterator &cell, const unsigned int face,
           const std::set<dealii::types::boundary_id> &boundary_ids)
{
  return cell->face(face)->at_boundary() && boundary_ids.count(cell->face(face)->boundary_id()) > 0;
}

/// The function w, in the unknowns of all components alike: 1 at the nodes of the boundary, and conforming.
template <int dim>
Weights boundary_weights(const Domain<dim> &domain, const std::set<dealii::types::boundary_id> &boundary_ids,
                         const MPI_Comm &communicator)
{
  dealii::IndexSet relevant;
  dealii::DoFTools::extract_locally_relevant_dofs(domain.dof_handler(), relevant);
  const auto &owned = domain.dof_handler().locally_owned_dofs();
  Weights w(owned, communicator);
  std::vector<dealii::types::global_dof_index> dofs;
  // the rank that owns a node sees all faces around it
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (!cell->is_artificial() && cell->at_boundary())
      for (const unsigned int face : cell->face_indices())
        if (is_on<dim>(cell, face, boundary_ids)) {
          domain.cell_dofs(cell, dofs);
          for (unsigned int i = 0; i < dofs.size(); ++i)
            if (domain.scalar_element().has_support_on_face(i % domain.n_nodes(), face) &&
                owned.is_element(dofs[i] - domain.first_dof))
              w(dofs[i] - domain.first_dof) = 1;
        }
  w.compress(dealii::VectorOperation::insert);
  if (domain.mesh().has_hanging_nodes()) {
    dealii::AffineConstraints<double> hanging(relevant);
    dealii::DoFTools::make_hanging_node_constraints(domain.dof_handler(), hanging);
    hanging.close();
    hanging.distribute(w);
  }
  Weights ghosted(owned, relevant, communicator);
  ghosted = w;
  return ghosted;
}

/// The influx that the conditions on the boundary itself prescribe, with the quadrature of CellTerms.
template <int dim>
class GivenInflux
{
public:
  GivenInflux(const Domain<dim> &domain, const std::set<dealii::types::boundary_id> &boundary_ids,
              const Field &field, const double t)
      : domain(domain), boundary_ids(boundary_ids), field(field), t(t),
        face_values(domain.mapping(), domain.scalar_element(), dealii::QGauss<dim - 1>(domain.degree + 1),
                    dealii::update_values | dealii::update_quadrature_points | dealii::update_JxW_values)
  {
    for (const auto &condition : domain.conditions())
      if (condition->adds_flux() && condition->field.name == field.name && condition->is_active(t))
        conditions.push_back(condition.get());
  }

  void add(const typename Domain<dim>::cell_iterator &cell, const std::vector<double> &unknowns,
           std::vector<double> &sum)
  {
    for (const unsigned int face : cell->face_indices())
      if (is_on<dim>(cell, face, boundary_ids))
        for (const Condition<dim> *condition : conditions)
          if (condition->boundary_ids.count(cell->face(face)->boundary_id()) > 0)
            add_face(*condition, cell, face, unknowns, sum);
  }

private:
  void add_face(const Condition<dim> &condition, const typename Domain<dim>::cell_iterator &cell,
                const unsigned int face, const std::vector<double> &unknowns, std::vector<double> &sum)
  {
    const unsigned int n_c = field.n_components, n = domain.n_nodes();
    face_values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell), face);
    std::vector<double> trace(n_c), flux(n_c);
    dealii::FullMatrix<double> d_flux(n_c, n_c);
    for (const unsigned int q : face_values.quadrature_point_indices()) {
      std::fill(trace.begin(), trace.end(), 0.);
      std::fill(flux.begin(), flux.end(), 0.);
      for (unsigned int c = 0; c < n_c; ++c)
        for (unsigned int a = 0; a < n; ++a)
          trace[c] += face_values.shape_value(a, q) * unknowns[(field.first_component + c) * n + a];
      condition.flux(face_values.quadrature_point(q), t, trace.data(), flux, d_flux);
      for (unsigned int c = 0; c < n_c; ++c)
        sum[c] += flux[c] * face_values.JxW(q);
    }
  }

  const Domain<dim> &domain;
  const std::set<dealii::types::boundary_id> &boundary_ids;
  const Field &field;
  const double t;
  dealii::FEFaceValues<dim> face_values;
  std::vector<const Condition<dim> *> conditions;
};

} // namespace

template <int dim>
std::vector<double> reaction(const Domain<dim> &domain,
                             const std::set<dealii::types::boundary_id> &boundary_ids, const Field &field,
                             const Vector &solution, const double t)
{
  const MPI_Comm communicator = solution.block(0).get_mpi_communicator();
  const Weights w = boundary_weights(domain, boundary_ids, communicator);
  const unsigned int n = domain.n_nodes(), first = field.first_component * n;
  CellTerms<dim> terms(domain);
  GivenInflux<dim> given(domain, boundary_ids, field, t);
  std::vector<double> sum(field.n_components), unknowns(domain.dofs_per_cell()),
      residual(domain.dofs_per_cell());
  std::vector<dealii::types::global_dof_index> dofs;
  double is_defined = 1;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      const auto weight = [&](const unsigned int i) { return w(dofs[i] - domain.first_dof); };
      bool touches = false;
      for (unsigned int a = 0; a < n; ++a)
        touches = touches || weight(first + a) != 0;
      if (!touches)
        continue;

      for (unsigned int i = 0; i < dofs.size(); ++i)
        unknowns[i] = solution(dofs[i]);
      if (!terms.assemble(cell, t, unknowns, residual, nullptr))
        is_defined = std::numeric_limits<double>::quiet_NaN();
      for (unsigned int c = 0; c < field.n_components; ++c)
        for (unsigned int a = 0; a < n; ++a)
          sum[c] += weight(first + c * n + a) * residual[first + c * n + a];
      given.add(cell, unknowns, sum);
    }
  for (double &component : sum)
    component *= is_defined;
  dealii::Utilities::MPI::sum(sum, communicator, sum);
  return sum;
}

template std::vector<double> reaction(const Domain<2> &, const std::set<dealii::types::boundary_id> &,
                                      const Field &, const Vector &, double);
template std::vector<double> reaction(const Domain<3> &, const std::set<dealii::types::boundary_id> &,
                                      const Field &, const Vector &, double);

} // namespace dovetail
