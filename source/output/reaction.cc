// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/compatibility.h>
#include <dovetail/domain/cell_terms.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/output/reaction.h>

#include <deal.II/dofs/dof_tools.h>
#include <deal.II/lac/trilinos_vector.h>

#include <algorithm>
#include <limits>

namespace dovetail {

namespace {

using Weights = dealii::TrilinosWrappers::MPI::Vector;

/// Some of the boundary faces.
template <int dim>
using Faces = typename SideFaces<dim>::Selection;

template <int dim>
bool is_on(const typename Domain<dim>::cell_iterator &cell, const unsigned int face, const Faces<dim> &faces)
{
  return cell->face(face)->at_boundary() && faces(cell, cell->face(face)->boundary_id());
}

/// Faces off Gamma where the field is prescribed.
template <int dim>
Faces<dim> prescribed_elsewhere(const Domain<dim> &domain, const Faces<dim> &gamma, const Field &field)
{
  std::set<dealii::types::boundary_id> ids;
  for (const auto &condition : domain.conditions())
    if (condition->field.name == field.name && !condition->prescribed_components().empty())
      ids.insert(condition->boundary_ids.begin(), condition->boundary_ids.end());
  return [ids, &gamma](const auto &cell, const auto id) { return ids.count(id) > 0 && !gamma(cell, id); };
}

/// Faces off Gamma where the field is tied.
template <int dim>
Faces<dim> tied_elsewhere(const Model<dim> &model, const Domain<dim> &domain, const Faces<dim> &gamma,
                          const Field &field)
{
  std::vector<const InterfaceSide<dim> *> sides;
  for (const auto &interface : model.interfaces)
    for (const auto &side : interface->sides)
      for (const TiedField &tied : interface->fields)
        if (side.domain == &domain && tied.name == field.name)
          sides.push_back(&side);
  return [sides, &gamma](const auto &cell, const auto id) {
    return !gamma(cell, id) &&
           std::any_of(sides.begin(), sides.end(), [&](const auto *side) { return side->belongs(cell, id); });
  };
}

/// Which nodes of the cells behind a boundary are meant.
enum class Nodes { of_faces, of_cells };

/// Set the function, in the unknowns of all components alike, at owned nodes of a boundary. The rank that
/// owns a node sees all cells around it.
template <int dim>
void set_nodes(const Domain<dim> &domain, const Faces<dim> &faces, const Nodes nodes, const double value,
               Weights &w)
{
  const auto &owned = domain.dof_handler().locally_owned_dofs();
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (!cell->is_artificial() && cell->at_boundary())
      for (const unsigned int face : cell->face_indices())
        if (is_on<dim>(cell, face, faces)) {
          domain.cell_dofs(cell, dofs);
          for (unsigned int i = 0; i < dofs.size(); ++i)
            if (owned.is_element(dofs[i] - domain.first_dof) &&
                (nodes == Nodes::of_cells ||
                 domain.scalar_element().has_support_on_face(i % domain.n_nodes(), face)))
              w(dofs[i] - domain.first_dof) = value;
        }
}

/// The function w, conforming at hanging nodes.
template <int dim>
Weights make_weights(const Model<dim> &model, const Domain<dim> &domain, const Faces<dim> &gamma,
                     const Field &field)
{
  const dealii::IndexSet relevant = dealii::DoFTools::extract_locally_relevant_dofs(domain.dof_handler());
  const auto &owned = domain.dof_handler().locally_owned_dofs();
  Weights w(owned, model.communicator);
  set_nodes(domain, gamma, Nodes::of_cells, 1, w);
  set_nodes(domain, tied_elsewhere(model, domain, gamma, field), Nodes::of_cells, 0, w);
  set_nodes(domain, prescribed_elsewhere(domain, gamma, field), Nodes::of_faces, 0, w);
  set_nodes(domain, gamma, Nodes::of_faces, 1, w);
  w.compress(dealii::VectorOperation::insert);
  if (domain.mesh().has_hanging_nodes()) {
    auto hanging = make_affine_constraints(owned, relevant);
    dealii::DoFTools::make_hanging_node_constraints(domain.dof_handler(), hanging);
    hanging.close();
    hanging.distribute(w);
  }
  Weights ghosted(owned, relevant, model.communicator);
  ghosted = w;
  return ghosted;
}

/// The influx that the conditions on the boundary itself prescribe, with the quadrature of CellTerms.
template <int dim>
class GivenInflux
{
public:
  GivenInflux(const Domain<dim> &domain, const Faces<dim> &gamma, const Field &field, const double t)
      : domain(domain), gamma(gamma), field(field), t(t), open_boundary(domain)
  {
    for (const auto &condition : domain.conditions())
      if (condition->adds_flux() && condition->field.name == field.name)
        conditions.push_back(condition.get());
  }

  void add(const typename Domain<dim>::cell_iterator &cell, const std::vector<double> &unknowns,
           std::vector<double> &sum)
  {
    const unsigned int n_c = field.n_components, n = domain.n_nodes();
    std::vector<double> trace(n_c), flux(n_c);
    dealii::FullMatrix<double> d_flux(n_c, n_c);
    for (const unsigned int face : cell->face_indices())
      if (is_on<dim>(cell, face, gamma))
        for (const Condition<dim> *condition : conditions)
          open_boundary.for_each_point(
              cell, face, *condition, t,
              [&](const dealii::Point<dim> &X, const std::vector<double> &shape_values, const double JxW) {
                std::fill(trace.begin(), trace.end(), 0.);
                std::fill(flux.begin(), flux.end(), 0.);
                for (unsigned int c = 0; c < n_c; ++c)
                  for (unsigned int a = 0; a < n; ++a)
                    trace[c] += shape_values[a] * unknowns[(field.first_component + c) * n + a];
                condition->flux(X, t, trace.data(), flux, d_flux);
                for (unsigned int c = 0; c < n_c; ++c)
                  sum[c] += flux[c] * JxW;
              });
  }

private:
  const Domain<dim> &domain;
  const Faces<dim> &gamma;
  const Field &field;
  const double t;
  OpenBoundary<dim> open_boundary;
  std::vector<const Condition<dim> *> conditions;
};

} // namespace

template <int dim>
std::vector<double> reaction(const Model<dim> &model, const Domain<dim> &domain, const Faces<dim> &gamma,
                             const Field &field, const Vector &solution, const double t)
{
  const Weights w = make_weights(model, domain, gamma, field);
  const unsigned int n = domain.n_nodes(), first = field.first_component * n;
  CellTerms<dim> terms(domain);
  GivenInflux<dim> given(domain, gamma, field, t);
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
  dealii::Utilities::MPI::sum(sum, model.communicator, sum);
  return sum;
}

template std::vector<double> reaction(const Model<2> &, const Domain<2> &, const Faces<2> &, const Field &,
                                      const Vector &, double);
template std::vector<double> reaction(const Model<3> &, const Domain<3> &, const Faces<3> &, const Field &,
                                      const Vector &, double);

} // namespace dovetail
