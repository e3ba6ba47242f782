// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Prescribed values by Nitsche's method (Nitsche 1971), symmetric: terms at a point of the boundary, and the
// penalty. Only the components that are prescribed have terms; delta A varies the gradient of the own field
// alone and, without theta, the pressure of a mixed formulation, as in the ties.

#include <dovetail/domain/cell_eigenvalues.h>
#include <dovetail/domain/cell_terms.h>
#include <dovetail/domain/pressure_of_flux.h>
#include <dovetail/domain/quadrature.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

template <int dim>
std::optional<unsigned int> pressure_of_weak_values(const Domain<dim> &domain, const Field &field)
{
  for (unsigned int f = 0; f < domain.fields().size(); ++f)
    if (domain.fields()[f].first_component == field.first_component)
      return pressure_of_flux(domain, f);
  return {};
}

/// At large strain no penalty that is frozen bounds the tangent: there the form is skew-symmetric.
template <int dim>
double theta_of_weak_values(const Domain<dim> &domain, const Field &field)
{
  return field.n_components > 1 && domain.material.has_large_strain() ? -1 : 1;
}

/// R(delta) = - A_c.N delta B_c - theta (delta A_c.N) e_c + gamma e_c delta B_c, e_c = B_c - g_c
template <int dim>
bool CellTerms<dim>::add_weak_value(const Condition<dim> &condition,
                                    const typename OpenBoundary<dim>::Point &at, const double gamma,
                                    const std::vector<double> &unknowns, std::vector<double> &residual,
                                    dealii::FullMatrix<double> *tangent)
{
  const Field &field = condition.field;
  const unsigned int first = field.first_component, n_c = field.n_components, n_nodes = layout.n_nodes(first);
  const double *phi = &at.shape_values[layout.first_shape(first)];
  const dealii::Tensor<1, dim> *gradients = &at.shape_gradients[layout.first_shape(first)];
  point.state.t = at.state.t;
  point.reinit(at.state.X, at.shape_values.data(), at.shape_gradients.data(), unknowns);
  if (!point.evaluate(true))
    return false;
  const double theta = theta_of_weak_values(domain, field);
  const std::optional<unsigned int> pressure = pressure_of_weak_values(domain, field);
  std::vector<double> is_prescribed(n_c, 0.), mismatch(n_c, 0.);
  for (const unsigned int c : condition.prescribed_components()) {
    is_prescribed[c] = at.JxW;
    mismatch[c] =
        at.JxW * (at.state.value[first + c] - condition.prescribed_value(at.state.X, at.state.t, c));
  }
  for (unsigned int c = 0; c < n_c; ++c) {
    if (is_prescribed[c] == 0)
      continue;
    const double influx = is_prescribed[c] * (point.response.flux[first + c] * at.N) - gamma * mismatch[c];
    for (unsigned int a = 0; a < n_nodes; ++a)
      add(layout.index(first + c, a), -influx * phi[a], residual);
    for (unsigned int d = 0; d < n_c; ++d) {
      const dealii::Tensor<1, dim> variation =
          theta * mismatch[c] * (at.N * point.response.by_gradient[(first + c) * n + first + d]);
      const double by_value = // of a vector: the strain around an axis
          n_c > 1 ? theta * mismatch[c] * (at.N * point.response.by_value[(first + c) * n + first + d]) : 0;
      for (unsigned int a = 0; a < n_nodes; ++a)
        add(layout.index(first + d, a), -variation * gradients[a] - by_value * phi[a], residual);
    }
    for (unsigned int a = 0; pressure && a < layout.n_nodes(*pressure); ++a)
      add(layout.index(*pressure, a),
          -mismatch[c] * (at.N * point.response.by_value[(first + c) * n + *pressure]) *
              at.shape_values[layout.first_shape(*pressure) + a],
          residual);
  }
  if (tangent != nullptr)
    add_weak_tangent(field, is_prescribed, mismatch, at, gamma, *tangent);
  return true;
}

/// Test functions of @p shares of components times the second derivative H of the flux.
template <int dim>
void add_weak_curvature(const CellLayout<dim> &layout, const typename OpenBoundary<dim>::Point &at,
                        const dealii::FullMatrix<double> &H, const std::vector<double> &shares,
                        const bool varies_by_value, dealii::FullMatrix<double> &tangent)
{
  for (unsigned int c = 0; c < shares.size(); ++c) {
    if (shares[c] == 0)
      continue;
    const double *phi_c = &at.shape_values[layout.first_shape(c)];
    for (unsigned int d = 0; d < shares.size(); ++d)
      for (unsigned int a = 0; a < layout.n_nodes(c); ++a) {
        const dealii::Tensor<1, dim> &gradient_a = at.shape_gradients[layout.first_shape(c) + a];
        dealii::Tensor<1, dim> g; // grad phi_a (and phi_a) times H, by gradient and by value of component d
        double v = varies_by_value ? phi_c[a] * H(c * (1 + dim), d * (1 + dim)) : 0;
        for (unsigned int L = 0; varies_by_value && L < dim; ++L)
          g[L] = phi_c[a] * H(c * (1 + dim), d * (1 + dim) + 1 + L);
        for (unsigned int J = 0; J < dim; ++J) {
          v += gradient_a[J] * H(c * (1 + dim) + 1 + J, d * (1 + dim));
          for (unsigned int L = 0; L < dim; ++L)
            g[L] += gradient_a[J] * H(c * (1 + dim) + 1 + J, d * (1 + dim) + 1 + L);
        }
        const unsigned int s = layout.first_shape(d);
        for (unsigned int b = 0; b < layout.n_nodes(d) && (v != 0 || g.norm_square() > 0); ++b)
          tangent(layout.index(c, a), layout.index(d, b)) +=
              shares[c] * (g * at.shape_gradients[s + b] + v * at.shape_values[s + b]);
      }
  }
}

/// The exact derivative; @p factor: the weight of the point for components that are prescribed, else 0.
template <int dim>
void CellTerms<dim>::add_weak_tangent(const Field &field, const std::vector<double> &factor,
                                      const std::vector<double> &mismatch,
                                      const typename OpenBoundary<dim>::Point &at, const double gamma,
                                      dealii::FullMatrix<double> &tangent)
{
  const unsigned int first = field.first_component, n_c = field.n_components, n_nodes = layout.n_nodes(first);
  const double *phi = &at.shape_values[layout.first_shape(first)];
  const double theta = theta_of_weak_values(domain, field);
  const std::optional<unsigned int> pressure = pressure_of_weak_values(domain, field);
  std::vector<double> flux_derivative; // dA_c.N / dx_(d,b)
  for (unsigned int c = 0; c < n_c; ++c)
    for (unsigned int d = 0; factor[c] != 0 && d < n; ++d) {
      const Coupling &coupling = domain.material.coupling(first + c, d);
      const unsigned int pair = (first + c) * n + d;
      const dealii::Tensor<1, dim> by_gradient = coupling.flux_by_gradient
                                                     ? factor[c] * (at.N * point.response.by_gradient[pair])
                                                     : dealii::Tensor<1, dim>();
      const double by_value = coupling.flux_by_value ? factor[c] * (at.N * point.response.by_value[pair]) : 0;
      const unsigned int n_columns = layout.n_nodes(d);
      const double *phi_d = &at.shape_values[layout.first_shape(d)];
      flux_derivative.resize(n_columns);
      for (unsigned int b = 0; b < n_columns; ++b)
        flux_derivative[b] = by_gradient * at.shape_gradients[layout.first_shape(d) + b];
      const bool is_own = d >= first && d < first + n_c;
      for (unsigned int a = 0; a < n_nodes; ++a) {
        double *row = &tangent(layout.index(first + c, a), layout.first(d));
        for (unsigned int b = 0; b < n_columns; ++b)
          row[b] -= phi[a] * (flux_derivative[b] + by_value * phi_d[b]);
        if (is_own)
          for (unsigned int b = 0; b < n_nodes; ++b)
            tangent(layout.index(d, a), layout.index(first + c, b)) -=
                theta * (flux_derivative[a] + (n_c > 1 ? by_value * phi[a] : 0)) * phi[b];
        if (d == first + c)
          for (unsigned int b = 0; b < n_nodes; ++b)
            row[b] += gamma * factor[c] * phi[a] * phi[b];
      }
      for (unsigned int a = 0; d == pressure && a < n_columns; ++a)
        for (unsigned int b = 0; b < n_nodes; ++b)
          tangent(layout.index(d, a), layout.index(first + c, b)) -= by_value * phi_d[a] * phi[b];
    }

  std::vector<dealii::Tensor<1, dim>> contraction(n);
  for (unsigned int c = 0; c < n_c; ++c)
    contraction[first + c] = -mismatch[c] * at.N;
  unsigned int field_index = 0;
  while (domain.fields()[field_index].first_component != first)
    ++field_index;
  if (domain.material.has_linear_flux(field_index) || !domain.material.has_curvature(field_index))
    return; // without it the updates converge linearly, as the mismatch vanishes
  dealii::FullMatrix<double> H;
  point.curvature(contraction, H);
  std::vector<double> shares(n, 0.); // of a component's test functions
  std::fill_n(shares.begin() + first, n_c, theta);
  if (pressure)
    shares[*pressure] = 1;
  add_weak_curvature(layout, at, H, shares, n_c > 1, tangent);
}

namespace {

/// Multiplies lambda; 1 is the least that is coercive. As in the ties, more where the tangent may grow in the
/// step, and where the flux of degree 1 says little about that on the face.
template <int dim>
double multiplier_of_weak_values(const Domain<dim> &domain, const unsigned int field)
{
  if (domain.fields()[field].n_components == 1 || domain.material.is_linear(field))
    return 2;
  return domain.degree == 1 ? 10 : 4;
}

/// The points of a face, with its shape functions.
template <int dim>
void add_points(const Domain<dim> &domain, const dealii::FEFaceValues<dim> &values,
                std::vector<TracePoint<dim>> &points)
{
  for (const unsigned int q : values.quadrature_point_indices()) {
    TracePoint<dim> point;
    point.weight = domain.measure(values, q);
    point.X = values.quadrature_point(q);
    point.N = values.normal_vector(q);
    for (unsigned int a = 0; a < values.dofs_per_cell; ++a) {
      const unsigned int i = domain.layout().shape_index(a);
      point.values.push_back(values.shape_value(i, q));
      point.gradients.push_back(values.shape_grad(i, q));
    }
    points.push_back(std::move(point));
  }
}

/// The owned cells with faces on which a field is prescribed weakly, and the points there.
template <int dim>
std::map<typename dealii::Triangulation<dim>::active_cell_iterator, std::vector<TracePoint<dim>>>
points_of_weak_values(const Domain<dim> &domain, const Field &field)
{
  std::map<typename dealii::Triangulation<dim>::active_cell_iterator, std::vector<TracePoint<dim>>> points;
  dealii::FEFaceValues<dim> values(domain.mapping(), domain.layout().shape_element(),
                                   gauss_rule<dim - 1>(domain.face_shape(), domain.degree + 1),
                                   dealii::update_values | dealii::update_gradients |
                                       dealii::update_quadrature_points | dealii::update_normal_vectors |
                                       dealii::update_JxW_values);
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (cell->is_locally_owned() && std::any_of(domain.conditions().begin(), domain.conditions().end(),
                                                [&, id = id](const auto &condition) {
                                                  return condition->is_weak() &&
                                                         condition->field.name == field.name &&
                                                         condition->boundary_ids.count(id) > 0;
                                                })) {
      values.reinit(cell, face);
      add_points(domain, values, points[cell]);
    }
  return points;
}

/// One more than the fields of interfaces that cover faces of a cell, each of which needs its share.
template <int dim>
unsigned int n_shares(const Domain<dim> &domain, const std::string &field, const unsigned int cell)
{
  unsigned int n = 1;
  for (const Cover<dim> &cover : domain.covers)
    if (cover.fields.count(field) > 0) {
      const auto face = cover.faces.lower_bound({cell, 0});
      n += face != cover.faces.end() && face->first.first == cell ? 1 : 0;
    }
  return n;
}

} // namespace

template <int dim>
void freeze_weak_penalties(Domain<dim> &domain, const double t,
                           const std::function<void(const std::vector<dealii::types::global_dof_index> &,
                                                    std::vector<double> &)> &unknowns)
{
  if (std::none_of(domain.conditions().begin(), domain.conditions().end(),
                   [](const auto &condition) { return condition->is_weak(); }))
    return;
  domain.weak_penalties.clear();
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> values;
  for (unsigned int f = 0; f < domain.fields().size(); ++f) {
    const Field &field = domain.fields()[f];
    if (!field.is_continuous) // has neither flux nor conditions
      continue;
    const auto components = components_for_flux(domain.material, f);
    CellEigenvalues<dim> eigenvalues(domain, field, components, t);
    for (const auto &[cell, points] : points_of_weak_values(domain, field)) {
      domain.cell_dofs(domain.dof_cell(cell), dofs);
      unknowns(dofs, values);
      double lambda = eigenvalues.evaluate(cell, points, values)[1];
      if (std::isnan(lambda))
        lambda = eigenvalues.evaluate(cell, points, std::vector<double>(values.size(), 0.))[1];
      domain.weak_penalties[{field.name, cell->active_cell_index()}] =
          multiplier_of_weak_values(domain, f) * n_shares(domain, field.name, cell->active_cell_index()) *
          lambda;
    }
  }
}

template bool CellTerms<2>::add_weak_value(const Condition<2> &, const OpenBoundary<2>::Point &, double,
                                           const std::vector<double> &, std::vector<double> &,
                                           dealii::FullMatrix<double> *);
template bool CellTerms<3>::add_weak_value(const Condition<3> &, const OpenBoundary<3>::Point &, double,
                                           const std::vector<double> &, std::vector<double> &,
                                           dealii::FullMatrix<double> *);
template void freeze_weak_penalties(
    Domain<2> &, double,
    const std::function<void(const std::vector<dealii::types::global_dof_index> &, std::vector<double> &)> &);
template void freeze_weak_penalties(
    Domain<3> &, double,
    const std::function<void(const std::vector<dealii::types::global_dof_index> &, std::vector<double> &)> &);

} // namespace dovetail
