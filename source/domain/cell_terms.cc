// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/point_products.h>

#include <dovetail/domain/cell_terms.h>
#include <dovetail/scene/undefined.h>
#include <dovetail/widest_vectors.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

namespace dovetail {

namespace {

/// Whether all integrals of shape functions are positive. Those of hypercubes have the nodes of Gauss and
/// Lobatto, and with 2 pi r only those of degree 1 are so beside the axis.
template <int dim>
bool has_positive_sums(const Domain<dim> &domain, const Field &field)
{
  const unsigned int degree = domain.degree + field.relative_degree;
  return field.is_continuous && (degree == 1 || (domain.mesh().all_reference_cells_are_hyper_cube() &&
                                                 !domain.measure.is_axisymmetric()));
}

void check_lumping(const Section &of_domain, const bool is_right, const unsigned int degree,
                   const std::string &entry, const std::string &where)
{
  of_domain.check(is_right, "Degree",
                  "is " + std::to_string(degree) + ", but " + entry +
                      " = true in the subsection Steps is for " + where + ". Set Degree = 1, or " + entry +
                      " = false.");
}

} // namespace

template <int dim>
std::vector<unsigned int> lumped_components(const Domain<dim> &domain, const unsigned int order_in_time)
{
  const bool is_mass = order_in_time > 1;
  const std::string entry = is_mass ? "Lumped mass" : "Lumped capacity";
  std::vector<unsigned int> lumped;
  if (domain.section.top().peek("Steps", entry) != "true")
    return lumped;
  bool is_right = true;
  for (const Field &field : domain.fields())
    for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c)
      if (domain.material.order_in_time(c) == order_in_time) {
        lumped.push_back(c);
        is_right = is_right && (is_mass ? has_positive_sums(domain, field)
                                        : field.is_continuous && domain.degree + field.relative_degree == 1);
      }
  check_lumping(
      domain.section, is_right, domain.degree, entry,
      is_mass ? "the degree 1 only, other than on quadrilaterals and hexahedra of scenes without an axis"
              : "the degree 1 only");
  return lumped;
}

namespace {

/// Those whose capacity or mass is lumped.
template <int dim>
std::vector<unsigned int> all_lumped_components(const Domain<dim> &domain)
{
  std::vector<unsigned int> lumped = lumped_components(domain, 1);
  const std::vector<unsigned int> of_mass = lumped_components(domain, 2);
  lumped.insert(lumped.end(), of_mass.begin(), of_mass.end());
  return lumped;
}

} // namespace

template <int dim>
CellTerms<dim>::CellTerms(const Domain<dim> &domain)
    : domain(domain), layout(domain.layout()), n(domain.n_components()),
      cell_values(domain.mapping(), layout.shape_element(), domain.cell_quadrature(),
                  dealii::update_values | dealii::update_gradients | dealii::update_quadrature_points |
                      dealii::update_JxW_values),
      open_boundary(domain), point(domain, 0), responses(cell_values.n_quadrature_points, point.response),
      fluxes(n * responses.size()), move(domain), uniform_response(n),
      asked_with_tangent(domain.material.asks_for_all(true)),
      asked_alone(domain.material.asks_for_all(false)), is_asked(n, true), is_in_residual(n, true),
      is_sized(n, false), lumped(all_lumped_components(domain)), lumped_response(n), given(n),
      given_of_cell(n, 0.), source_of_component(n)
{
  const auto &fields = domain.fields();
  for (unsigned int c = 0; c < n; ++c)
    for (unsigned int d = 0; d < n; ++d)
      if (const Coupling &coupling = domain.material.coupling(c, d); coupling.any())
        pairs.push_back({c, d, c * n + d, coupling});
  for (unsigned int f = 0; f < fields.size(); ++f) {
    for (unsigned int c = 0; domain.material.has_source(f) && c < fields[f].n_components; ++c)
      with_source.push_back(fields[f].first_component + c);
    has_loads = has_loads || domain.material.has_load(f);
  }
  for (const Field &field : fields)
    for (unsigned int c = 0; c < field.n_components; ++c)
      source_of_component[field.first_component + c] = {domain.source().find(field.name), c};
  for (const auto &condition : domain.conditions())
    if (condition->adds_flux() || condition->is_weak())
      flux_conditions.push_back(condition.get());
  find_uniform();
}

template <int dim>
void CellTerms<dim>::enter(const cell_iterator &cell)
{
  cell_values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
  tables.enter_cell(domain, cell_values);
  move.begin_at(cell);
}

template <int dim>
void CellTerms<dim>::enter_or_move_to(const cell_iterator &cell)
{
  if (move.vertices.empty() || !move.reaches(cell, cell_values.get_quadrature_points()))
    enter(cell);
}

template <int dim>
void CellTerms<dim>::Move::begin_at(const cell_iterator &cell)
{
  is_done = false;
  if (!is_possible)
    return;
  vertices.resize(cell->n_vertices());
  for (unsigned int v = 0; v < vertices.size(); ++v)
    vertices[v] = cell->vertex(v);
  tolerance = std::numeric_limits<double>::max();
  for (unsigned int v = 1; v < vertices.size(); ++v)
    tolerance = std::min(tolerance, 1e-12 * vertices[v].distance(vertices[0]));
}

template <int dim>
bool CellTerms<dim>::Move::reaches(const cell_iterator &cell,
                                   const std::vector<dealii::Point<dim>> &points_at_begin)
{
  is_done = vertices.size() == cell->n_vertices();
  const dealii::Tensor<1, dim> way = cell->vertex(0) - vertices[0];
  for (unsigned int v = 1; v < vertices.size() && is_done; ++v) {
    const dealii::Tensor<1, dim> difference = cell->vertex(v) - vertices[v] - way;
    for (unsigned int d = 0; d < dim; ++d)
      is_done = is_done && std::abs(difference[d]) <= tolerance;
  }
  points.resize(points_at_begin.size());
  for (unsigned int q = 0; q < points.size() && is_done; ++q)
    points[q] = points_at_begin[q] + way;
  return is_done;
}

/// What is_asked and its companions say has changed.
template <int dim>
void CellTerms<dim>::find_uniform()
{
  asked_of_uniform = asked_with_tangent;
  std::replace(asked_of_uniform.begin(), asked_of_uniform.end(), Asked::response, Asked::derivatives);
  is_uniform = !domain.body_force().depends_on_displacement();
  for (unsigned int f = 0; f < asked_of_uniform.size(); ++f)
    is_uniform = is_uniform && (asked_of_uniform[f] == Asked::nothing || domain.material.is_uniform(f));
  has_uniform_responses = false;
}

template <int dim>
void CellTerms<dim>::find_rates(const typename Domain<dim>::cell_iterator &cell)
{
  if (domain.material.order_in_time() == 0)
    return;
  if (rates != nullptr)
    domain.cell_dofs(cell, dofs);
  point.set_rates(rates, dofs);
}

template <int dim>
void CellTerms<dim>::hide_lumped_rates()
{
  if (lumped.empty() || point.state.rate.empty())
    return;
  for (const unsigned int c : lumped)
    if (domain.material.order_in_time(c) == 2) {
      point.state.second_rate_by_value = 0;
      point.state.second_rate[c] = 0;
    } else {
      point.state.rate_by_value = 0;
      point.state.rate[c] = 0;
    }
}

/// A capacity that does not depend on X is asked once at each node, when the weights of all points are known.
template <int dim>
bool CellTerms<dim>::add_lumped_storage(const unsigned int q, const double JxW,
                                        const std::vector<double> &unknowns, std::vector<double> &residual,
                                        dealii::FullMatrix<double> *tangent)
{
  if (lumped.empty() || point.state.rate.empty())
    return true;
  const unsigned int n_nodes = layout.n_nodes(lumped[0]);
  const bool is_of_point = domain.material.stores_by_position(),
             is_last = q + 1 == cell_values.n_quadrature_points;
  if (is_of_point || q == 0)
    node_weights.assign(n_nodes, 0.);
  for (unsigned int a = 0; a < n_nodes; ++a)
    node_weights[a] += cell_values.shape_value(layout.shape_of_node(lumped[0], a), q) * JxW;
  point.state.rate_by_value = rates->by_value;
  point.state.second_rate_by_value = rates->second_by_value;
  for (unsigned int a = 0; a < n_nodes && (is_of_point || is_last); ++a) {
    point.move_to_node(a, unknowns);
    if (!add_storage_of_node(a, node_weights[a], residual, tangent))
      return false;
  }
  return true;
}

template <int dim>
bool CellTerms<dim>::add_storage_of_node(const unsigned int a, const double weight,
                                         std::vector<double> &residual, dealii::FullMatrix<double> *tangent)
{
  if (!point.evaluate_storage(lumped_response))
    return false;
  for (const unsigned int c : lumped) {
    const unsigned int i = layout.index(c, a);
    add(i, lumped_response.source[c] * weight, residual);
    for (unsigned int d = 0; d < n && tangent != nullptr; ++d)
      if (const double slope = lumped_response.source_by_value[c * n + d]; slope != 0)
        (*tangent)(i, layout.index(d, a)) += slope * weight;
  }
  return true;
}

template <int dim>
bool CellTerms<dim>::assemble(const typename Domain<dim>::cell_iterator &cell, const double t,
                              const std::vector<double> &unknowns, std::vector<double> &residual,
                              dealii::FullMatrix<double> *tangent)
{
  std::fill(residual.begin(), residual.end(), 0.);
  force_sizes.assign(layout.size(), 0.);
  const bool gives_away = tangent && is_any_asked(pairs_without_entries);
  product_sizes.assign(gives_away ? layout.size() : 0, 0.);
  if (tangent && has_entries(cell))
    std::fill_n(&(*tangent)(0, 0), tangent->n_elements(), 0.);
  if (tangent && !lumped.empty())
    lumped_tangent.reinit(residual.size(), residual.size());
  point.state.t = t;
  find_rates(cell);
  if (tangent == nullptr)
    has_uniform_tangent = false; // the next cell is not compared with the one of the last tangent
  if (!(is_uniform && point.state.rate.empty() ? add_uniform_laws(cell, unknowns, residual, tangent)
                                               : add_laws(cell, unknowns, residual, tangent))) {
    has_uniform_tangent = false; // what comes next is compared with this cell
    return false;
  }
  if (gives_away)
    give_away(cell, unknowns);
  if (tangent && is_any_asked(pairs))
    add_tangent(*tangent);
  if (tangent && !lumped.empty())
    tangent->add(1, lumped_tangent);
  if (!leaves_out_given)
    add_given(cell, t, unknowns, residual, tangent);
  if (meets_flux_condition(cell)) {
    if (leaves_out_boundary)
      left_out.assign(layout.size(), 0.);
    if (!add_boundary_terms(cell, t, unknowns, leaves_out_boundary ? left_out : residual, tangent))
      return false;
  }
  return std::isfinite(std::accumulate(residual.begin(), residual.end(), 0.));
}

namespace {

/// sign S phi_a in the row of each node of a component, with S at all points of the cell times their weights.
template <int dim>
void add_sources(const CellLayout<dim> &layout, const unsigned int c,
                 const dealii::FEValues<dim> &cell_values, const double *const S, const double sign,
                 std::vector<double> &residual, std::vector<double> &sizes)
{
  for (unsigned int a = 0; a < layout.n_nodes(c); ++a) {
    const double *const phi = &cell_values.shape_value(layout.shape_of_node(c, a), 0); // at all points
    double sum = 0, size = 0;
    for (unsigned int q = 0; q < cell_values.n_quadrature_points; ++q) {
      sum += S[q] * phi[q];
      size += std::abs(S[q] * phi[q]);
    }
    residual[layout.index(c, a)] += sign * sum;
    sizes[layout.index(c, a)] += size;
  }
}

} // namespace

/// What laws remember belongs to the cell of cell_values.
template <int dim>
bool CellTerms<dim>::add_laws(const cell_iterator &cell, const std::vector<double> &unknowns,
                              std::vector<double> &residual, dealii::FullMatrix<double> *tangent)
{
  if (domain.memory)
    enter(cell);
  else
    enter_or_move_to(cell);
  has_uniform_responses = false;
  const unsigned int n_points = cell_values.n_quadrature_points;
  source_at_points.resize(with_source.size() * n_points);
  point.enter(cell_values, unknowns, is_needed);
  if (tangent && linearised_at != nullptr && domain.material.has_large_strain()) {
    domain.cell_dofs(cell, dofs);
    unknowns_before.resize(dofs.size());
    linearised_at->extract_subvector_to(dofs.begin(), dofs.end(), unknowns_before.begin());
    point.enter_linearised(unknowns_before);
  }
  for (const unsigned int q : cell_values.quadrature_point_indices()) {
    point.go_to(q);
    if (move.is_done)
      point.state.X = move.points[q];
    hide_lumped_rates();
    const double JxW = tables.JxW[q];
    // a point overwrites all that is not zero in every response
    Response<dim> &response = tangent ? responses[q] : point.response;
    if (!point.evaluate(tangent ? asked_with_tangent : asked_alone, response))
      return false;
    for (unsigned int c = 0; c < n; ++c)
      fluxes[c * n_points + q] = JxW * response.flux[c];
    for (unsigned int k = 0; k < with_source.size(); ++k)
      source_at_points[k * n_points + q] = JxW * response.source[with_source[k]];
    if (!add_lumped_storage(q, JxW, unknowns, residual, tangent ? &lumped_tangent : nullptr))
      return false;
  }
  add_fluxes(residual);
  for (unsigned int k = 0; k < with_source.size(); ++k)
    if (is_in_residual[with_source[k]])
      add_sources(layout, with_source[k], cell_values, &source_at_points[k * n_points], 1., residual,
                  force_sizes);
  return true;
}

/// The first point of all says what the response is. A cell at rest has no fluxes.
template <int dim>
bool CellTerms<dim>::add_uniform_laws(const cell_iterator &cell, const std::vector<double> &unknowns,
                                      std::vector<double> &residual, dealii::FullMatrix<double> *tangent)
{
  enter_or_move_to(cell);
  const bool is_at_rest =
      std::all_of(unknowns.begin(), unknowns.end(), [](const double x) { return x == 0; });
  if (!is_at_rest || !has_uniform_responses)
    point.enter(cell_values, unknowns, is_needed);
  domain.material.count_uniform(asked_of_uniform, responses.size() - (has_uniform_responses ? 0 : 1));
  if (!has_uniform_responses) {
    point.go_to(0);
    has_uniform_responses = point.evaluate(asked_of_uniform, responses[0]);
    std::fill(responses.begin() + 1, responses.end(), responses[0]);
  }
  if (is_at_rest && has_uniform_responses)
    return true;
  point.evaluate_uniform(responses[0], is_in_residual, tables.JxW, fluxes);
  const double *const A = &fluxes[0][0];
  if (!has_uniform_responses || !std::isfinite(std::accumulate(A, A + dim * fluxes.size(), 0.)))
    return add_laws(cell, unknowns, residual, tangent); // which finds the reason
  add_fluxes(residual);
  return true;
}

template <int dim>
const Flows *CellTerms<dim>::given_flows() const
{
  return has_loads || leaves_out_given || domain.body_force().depends_on_displacement() ? nullptr : &given;
}

template <int dim>
void CellTerms<dim>::add_given(const typename Domain<dim>::cell_iterator &cell, const double t,
                               const std::vector<double> &unknowns, std::vector<double> &residual,
                               dealii::FullMatrix<double> *tangent)
{
  std::fill(given_of_cell.begin(), given_of_cell.end(), 0.);
  add_source(t, residual);
  if (domain.body_force().is_given() && is_in_residual[domain.body_force().first_component()])
    add_body_force(t, unknowns, residual, tangent);
  for (unsigned int c = 0; c < n && !meets_flux_condition(cell); ++c)
    given.add(c, given_of_cell[c]);
}

template <int dim>
void CellTerms<dim>::add_fluxes(std::vector<double> &residual)
{
  const unsigned int n_numbers = dim * cell_values.n_quadrature_points;
  for (unsigned int c = 0; c < n; ++c) {
    const double *const A = &fluxes[c * cell_values.n_quadrature_points][0];
    if (is_in_residual[c] && !std::all_of(A, A + n_numbers, [](const double flux) { return flux == 0; }))
      add_forces(tables.table(layout, c, false, cell_values), A, &residual[layout.first(c)],
                 &force_sizes[layout.first(c)]);
  }
}

template <int dim>
void CellTerms<dim>::add_source_of_laws(const Response<dim> &response, const double JxW,
                                        std::vector<double> &residual)
{
  for (const unsigned int c : with_source) {
    if (!is_in_residual[c])
      continue;
    const unsigned int first = layout.first(c), n_nodes = layout.n_nodes(c);
    const double *values = &point.shape_values()[layout.first_shape(c)];
    for (unsigned int a = 0; a < n_nodes; ++a)
      add(first + a, response.source[c] * values[a] * JxW, residual);
  }
}

template <int dim>
bool CellTerms<dim>::assemble_loads(const typename Domain<dim>::cell_iterator &cell, const double t,
                                    const std::vector<double> &unknowns, std::vector<double> &residual)
{
  const bool has_source = has_loads || domain.body_force().is_given() ||
                          std::any_of(source_of_component.begin(), source_of_component.end(),
                                      [](const auto &source) { return source.first != nullptr; });
  const bool has_boundary = meets_flux_condition(cell);
  std::fill(residual.begin(), residual.end(), 0.);
  force_sizes.assign(layout.size(), 0.);
  if (has_source) {
    enter(cell);
    has_uniform_tangent = false; // what comes next is not compared with the cell before
    add_source(t, residual);
    if (domain.body_force().is_given())
      add_body_force(t, unknowns, residual, nullptr);
    point.state.t = t;
    point.set_rates(nullptr, {});
    for (unsigned int q = 0; has_loads && q < cell_values.n_quadrature_points; ++q) {
      point.reinit(cell_values, q, unknowns);
      const double JxW =
          point.evaluate(false) ? domain.measure(cell_values, q) : std::numeric_limits<double>::quiet_NaN();
      add_source_of_laws(point.response, JxW, residual);
    }
  }
  if (has_boundary && !add_boundary_terms(cell, t, unknowns, residual, nullptr))
    std::fill(residual.begin(), residual.end(), std::numeric_limits<double>::quiet_NaN());
  return has_source || has_boundary;
}

template <int dim>
void CellTerms<dim>::assemble_given(const typename Domain<dim>::cell_iterator &cell, const double t,
                                    std::vector<double> &residual)
{
  std::fill(residual.begin(), residual.end(), 0.);
  force_sizes.assign(layout.size(), 0.);
  enter(cell);
  has_uniform_tangent = false;
  add_source(t, residual);
  if (domain.body_force().is_given())
    add_body_force(t, std::vector<double>(layout.size(), 0.), residual, nullptr);
}

template <int dim>
bool CellTerms<dim>::assemble_boundary(const typename Domain<dim>::cell_iterator &cell, const double t,
                                       const std::vector<double> &unknowns, std::vector<double> &residual,
                                       dealii::FullMatrix<double> *tangent)
{
  std::fill(residual.begin(), residual.end(), 0.);
  force_sizes.assign(layout.size(), 0.);
  if (tangent)
    *tangent = 0;
  point.set_rates(nullptr, {});
  return flux_conditions.empty() || !cell->at_boundary() ||
         add_boundary_terms(cell, t, unknowns, residual, tangent);
}

/// The points of a cell and their rates; the next tangent is not compared with that of the cell before.
template <int dim>
void CellTerms<dim>::enter_without_tangent(const typename Domain<dim>::cell_iterator &cell, const double t)
{
  point.state.t = t;
  find_rates(cell);
  enter(cell);
  has_uniform_tangent = false;
}

template <int dim>
bool CellTerms<dim>::evaluate_memory(const typename Domain<dim>::cell_iterator &cell, const double t,
                                     const std::vector<double> &unknowns)
{
  enter_without_tangent(cell, t);
  for (const unsigned int q : cell_values.quadrature_point_indices()) {
    point.reinit(cell_values, q, unknowns);
    if (!point.evaluate(false))
      return false;
    domain.memory->set_trial(cell, q, point.state.memory.trial);
  }
  return true;
}

template <int dim>
void CellTerms<dim>::look_at_start(const typename Domain<dim>::cell_iterator &cell,
                                   const std::vector<double> &unknowns)
{
  enter_without_tangent(cell, 0);
  for (const unsigned int q : cell_values.quadrature_point_indices()) {
    point.reinit(cell_values, q, unknowns);
    domain.material.look_at_start(point.state);
    domain.memory->set_trial(cell, q, point.state.memory.trial);
  }
}

template <int dim>
bool CellTerms<dim>::assemble_storage(const typename Domain<dim>::cell_iterator &cell, const double t,
                                      const std::vector<double> &unknowns, std::vector<double> &residual,
                                      dealii::FullMatrix<double> *tangent)
{
  if (tangent)
    *tangent = 0;
  if (rates == nullptr || !rates->has_first() || domain.material.order_in_time() == 0)
    return false;
  std::fill(residual.begin(), residual.end(), 0.);
  force_sizes.assign(layout.size(), 0.);
  enter_without_tangent(cell, t);
  for (const unsigned int q : cell_values.quadrature_point_indices()) {
    point.reinit(cell_values, q, unknowns);
    hide_lumped_rates();
    const double JxW = domain.measure(cell_values, q);
    const bool is_defined = point.evaluate_storage(point.response);
    add_source_of_laws(point.response, is_defined ? JxW : std::numeric_limits<double>::quiet_NaN(), residual);
    if (tangent)
      add_storage_tangent(JxW, *tangent);
    if (!add_lumped_storage(q, JxW, unknowns, residual, tangent))
      std::fill(residual.begin(), residual.end(), std::numeric_limits<double>::quiet_NaN());
  }
  return true;
}

/// K_(c,a)(d,b) = phi_a dS_c/dB_d phi_b
template <int dim>
void CellTerms<dim>::add_storage_tangent(const double JxW, dealii::FullMatrix<double> &tangent) const
{
  const std::vector<double> &phi = point.shape_values();
  for (unsigned int c = 0; c < n; ++c)
    for (unsigned int d = 0; domain.material.order_in_time(c) > 0 && d < n; ++d)
      if (const double slope = point.response.source_by_value[c * n + d] * JxW; slope != 0)
        for (unsigned int a = 0; a < layout.n_nodes(c); ++a)
          for (unsigned int b = 0; b < layout.n_nodes(d); ++b)
            tangent(layout.index(c, a), layout.index(d, b)) +=
                slope * phi[layout.first_shape(c) + a] * phi[layout.first_shape(d) + b];
}

namespace {

/// Without a branch, since most often they are.
DOVETAIL_WIDEST_VECTORS bool are_equal(const std::size_t n, const double *const a, const double *const b)
{
  std::size_t n_different = 0;
  for (std::size_t i = 0; i < n; ++i)
    n_different += a[i] != b[i];
  return n_different == 0;
}

} // namespace

/// Of the flux by gradients those of all pairs: rows that are not asked for are zero.
template <int dim>
bool CellTerms<dim>::has_equal_derivatives(const Response<dim> &a, const Response<dim> &b) const
{
  if (!are_equal(a.by_gradient.size() * dim * dim, &a.by_gradient[0][0][0], &b.by_gradient[0][0][0]))
    return false;
  for (const Pair &pair : pairs)
    if (is_asked[pair.c] &&
        ((pair.coupling.flux_by_value && a.by_value[pair.index] != b.by_value[pair.index]) ||
         (pair.coupling.source_by_gradient &&
          a.source_by_gradient[pair.index] != b.source_by_gradient[pair.index]) ||
         (pair.coupling.source_by_value && a.source_by_value[pair.index] != b.source_by_value[pair.index])))
      return false;
  return true;
}

template <int dim>
void CellTerms<dim>::give_tangent_to(const Field &field, CellOperator<dim> &cells)
{
  operators.emplace_back(field, &cells);
  leave_out_coupling(field, field); // of the entries
}

template <int dim>
void CellTerms<dim>::leave_out_coupling(const Field &field, const Field &by)
{
  const auto middle = std::stable_partition(pairs.begin(), pairs.end(), [&](const Pair &pair) {
    return !field.has_component(pair.c) || !by.has_component(pair.d);
  });
  pairs_without_entries.insert(pairs_without_entries.end(), middle, pairs.end());
  pairs.erase(middle, pairs.end());
  find_sized();
}

template <int dim>
void CellTerms<dim>::ask_for(const std::vector<Asked> &of_fields)
{
  const std::vector<bool> before = is_asked;
  asked_with_tangent = asked_alone = of_fields;
  std::replace(asked_alone.begin(), asked_alone.end(), Asked::derivatives, Asked::response);
  for (unsigned int f = 0; f < of_fields.size(); ++f)
    for (unsigned int c = 0; c < domain.fields()[f].n_components; ++c) {
      is_asked[domain.fields()[f].first_component + c] = of_fields[f] == Asked::derivatives;
      is_in_residual[domain.fields()[f].first_component + c] = of_fields[f] != Asked::nothing;
    }
  has_uniform_tangent = has_uniform_tangent && is_asked == before;
  find_sized();
  find_uniform();
  is_needed.clear();
  for (unsigned int d = 0; d < n && !domain.material.has_memory(); ++d) {
    is_needed.push_back(is_in_residual[d] || domain.material.chooses_by(d));
    for (unsigned int c = 0; c < n; ++c)
      is_needed[d] = is_needed[d] || (is_in_residual[c] && domain.material.coupling(c, d).any());
  }
}

template <int dim>
void CellTerms<dim>::find_sized()
{
  is_sized.assign(n, false);
  for (const Pair &pair : pairs_without_entries)
    if (is_asked[pair.c])
      is_sized[pair.d] = true;
}

/// Calls @p visit with the faces of a cell and the conditions that have a tangent there.
template <int dim>
template <typename Visit>
void CellTerms<dim>::for_each_tangent(const typename Domain<dim>::cell_iterator &cell,
                                      const Visit &visit) const
{
  if (cell->at_boundary())
    for (const unsigned int face : cell->face_indices())
      if (cell->face(face)->at_boundary())
        for (const Condition<dim> *condition : flux_conditions)
          if (condition->has_tangent() && condition->boundary_ids.count(cell->face(face)->boundary_id()) > 0)
            visit(face, *condition);
}

template <int dim>
bool CellTerms<dim>::has_boundary_tangent(const typename Domain<dim>::cell_iterator &cell) const
{
  bool has_any = false;
  for_each_tangent(cell, [&](unsigned int, const Condition<dim> &) { has_any = true; });
  return has_any;
}

template <int dim>
void CellTerms<dim>::add_boundary_couplings(const typename Domain<dim>::cell_iterator &cell,
                                            dealii::Table<2, bool> &couples) const
{
  for_each_tangent(cell, [&](const unsigned int face, const Condition<dim> &condition) {
    const auto is_in = [&](const unsigned int c, const unsigned int a) {
      return condition.is_weak() || !layout.is_continuous(c) ||
             layout.element(c).has_support_on_face(a, face);
    };
    std::vector<unsigned int> rows, columns;
    for (unsigned int c = 0; c < n; ++c)
      for (unsigned int a = 0; a < layout.n_nodes(c); ++a) {
        if (condition.field.has_component(c) && is_in(c, a))
          rows.push_back(layout.index(c, a));
        if (condition.sees_gradients() || is_in(c, a))
          columns.push_back(layout.index(c, a));
      }
    for (const unsigned int row : rows)
      for (const unsigned int column : columns)
        couples(row, column) = true;
  });
}

template <int dim>
bool CellTerms<dim>::has_operator(const unsigned int component) const
{
  return std::any_of(operators.begin(), operators.end(),
                     [&](const auto &entry) { return entry.first.has_component(component); });
}

namespace {

/// sums[i] += |x row[i]|.
DOVETAIL_WIDEST_VECTORS void add_sizes_of_row(const std::size_t n, const double x, const double *const row,
                                              double *const __restrict__ sums)
{
  const double size = std::abs(x);
  for (std::size_t i = 0; i < n; ++i)
    sums[i] += size * std::abs(row[i]);
}

/// sum_i |row[i]| factors[i].
DOVETAIL_WIDEST_VECTORS double sum_of_sizes(const std::size_t n, const double *const row,
                                            const double *const factors)
{
  constexpr unsigned int width = 8;
  double s[width] = {};
  std::size_t i = 0;
  for (; i + width <= n; i += width)
    for (unsigned int k = 0; k < width; ++k)
      s[k] += std::abs(row[i + k]) * factors[i + k];
  for (; i < n; ++i)
    s[0] += std::abs(row[i]) * factors[i];
  for (unsigned int k = 1; k < width; ++k)
    s[0] += s[k];
  return s[0];
}

} // namespace

/// The derivatives at all points, and the sizes of their products with the unknowns.
template <int dim>
void CellTerms<dim>::give_away(const typename Domain<dim>::cell_iterator &cell,
                               const std::vector<double> &unknowns)
{
  const BodyForce<dim> &force = domain.body_force();
  const bool has_force = force.depends_on_displacement() && has_operator(force.first_component()) &&
                         is_asked[force.first_component()];
  find_sizes_at_points(sizes_of_unknowns != nullptr ? *sizes_of_unknowns : unknowns);
  for (const unsigned int q : cell_values.quadrature_point_indices()) {
    const auto add_force = [&](const double factor, const dealii::Tensor<2, dim> &derivative) {
      for (unsigned int c = 0; c < dim; ++c)
        for (unsigned int d = 0; d < dim; ++d)
          responses[q].source_by_value[(force.first_component() + c) * n + force.first_component() + d] +=
              factor * derivative[c][d];
    };
    dealii::Tensor<2, dim> by_position;
    if (has_force) {
      by_position = force.derivative(points_of_cell()[q], point.state.t);
      add_force(-1, by_position);
    }
    const double JxW = tables.JxW[q];
    for (const auto &[field, cells] : operators)
      if (is_asked[field.first_component])
        cells->set_tangent(cell->active_cell_index(), q, JxW / cell_values.JxW(q), responses[q]);
    add_products_of_point(q, JxW, has_force);
    if (has_force) // the next cell begins with what laws leave at zero
      add_force(1, by_position);
  }
  add_up_products();
}

/// The numbers of one shape function at all points follow each other in deal.II's tables.
template <int dim>
void CellTerms<dim>::find_sizes_at_points(const std::vector<double> &unknowns)
{
  const std::size_t n_points = cell_values.n_quadrature_points;
  value_sizes.assign(n * n_points, 0.);
  gradient_sizes.assign(n * n_points, {});
  source_sizes.assign(n * n_points, 0.);
  flux_sizes.assign(n * n_points, {});
  for (unsigned int d = 0; d < n; ++d)
    for (unsigned int a = 0; is_sized[d] && a < layout.n_nodes(d); ++a) {
      const unsigned int shape = layout.shape_of_node(d, a);
      const double x = unknowns[layout.index(d, a)];
      add_sizes_of_row(n_points, x, &cell_values.shape_value(shape, 0), &value_sizes[d * n_points]);
      add_sizes_of_row(n_points * dim, x, &cell_values.shape_grad(shape, 0)[0],
                       &gradient_sizes[d * n_points][0]);
    }
}

template <int dim>
void CellTerms<dim>::add_products_of_point(const unsigned int q, const double JxW, const bool has_force)
{
  const Response<dim> &response = responses[q];
  const std::size_t n_points = cell_values.n_quadrature_points;
  for (const auto &[c, d, index, coupling] : pairs_without_entries) {
    if (!is_asked[c])
      continue;
    const double value = JxW * value_sizes[d * n_points + q];
    const dealii::Tensor<1, dim> gradient = JxW * gradient_sizes[d * n_points + q];
    dealii::Tensor<1, dim> &flux = flux_sizes[c * n_points + q];
    double &source = source_sizes[c * n_points + q];
    if (coupling.source_by_value || has_force)
      source += std::abs(response.source_by_value[index]) * value;
    for (unsigned int J = 0; J < dim; ++J) {
      if (coupling.flux_by_value)
        flux[J] += std::abs(response.by_value[index][J]) * value;
      if (coupling.source_by_gradient)
        source += std::abs(response.source_by_gradient[index][J]) * gradient[J];
      for (unsigned int L = 0; coupling.flux_by_gradient && L < dim; ++L)
        flux[J] += std::abs(response.by_gradient[index][J][L]) * gradient[L];
    }
  }
}

template <int dim>
void CellTerms<dim>::add_up_products()
{
  const std::size_t n_points = cell_values.n_quadrature_points;
  for (unsigned int c = 0; c < n; ++c) {
    const auto sources = source_sizes.begin() + c * n_points;
    const bool has_source = std::any_of(sources, sources + n_points, [](const double s) { return s != 0; });
    for (unsigned int a = 0; is_asked[c] && a < layout.n_nodes(c); ++a) {
      const unsigned int shape = layout.shape_of_node(c, a);
      double &size = product_sizes[layout.index(c, a)];
      size +=
          sum_of_sizes(n_points * dim, &cell_values.shape_grad(shape, 0)[0], &flux_sizes[c * n_points][0]);
      if (has_source)
        size += sum_of_sizes(n_points, &cell_values.shape_value(shape, 0), &source_sizes[c * n_points]);
    }
  }
}

namespace {

/// Gradients at the points of a cell of the shape functions of a component, and their values if asked for.
template <int dim>
void tabulate(const CellLayout<dim> &layout, const unsigned int component,
              const dealii::FEValues<dim> &cell_values, const bool with_value, ShapeTable &table)
{
  table.reinit(cell_values.n_quadrature_points, dim + (with_value ? 1 : 0), layout.n_nodes(component));
  for (const unsigned int q : cell_values.quadrature_point_indices())
    for (unsigned int a = 0; a < layout.n_nodes(component); ++a) {
      const unsigned int i = layout.shape_of_node(component, a);
      const dealii::Tensor<1, dim> &gradient = cell_values.shape_grad(i, q);
      for (unsigned int d = 0; d < dim; ++d)
        table.row(q, d)[a] = gradient[d];
      if (with_value)
        table.row(q, dim)[a] = cell_values.shape_value(i, q);
    }
}

/// The derivatives of a pair of components at a point, times JxW: of flux and source by gradient and value.
template <int dim>
void fill_derivatives(const Response<dim> &response, const unsigned int pair, const Coupling &coupling,
                      const double JxW, const unsigned int n_rows, const unsigned int n_columns, double *D)
{
  if (n_rows == dim && n_columns == dim) { // of the flux by the gradient alone
    const dealii::Tensor<2, dim> &by_gradient = response.by_gradient[pair];
    for (unsigned int I = 0; I < dim; ++I)
      for (unsigned int J = 0; J < dim; ++J)
        D[I * dim + J] = JxW * by_gradient[I][J];
    return;
  }
  std::fill_n(D, n_rows * n_columns, 0.);
  for (unsigned int I = 0; I < dim; ++I) {
    for (unsigned int J = 0; coupling.flux_by_gradient && J < dim; ++J)
      D[I * n_columns + J] = JxW * response.by_gradient[pair][I][J];
    if (coupling.flux_by_value)
      D[I * n_columns + dim] = JxW * response.by_value[pair][I];
    if (coupling.source_by_gradient)
      D[dim * n_columns + I] = JxW * response.source_by_gradient[pair][I];
  }
  if (coupling.source_by_value)
    D[dim * n_columns + dim] = JxW * response.source_by_value[pair];
}

/// Of a block of a matrix with rows that begin @p row_length apart.
void copy_transposed(const unsigned int n_rows, const unsigned int n_columns, const double *from, double *to,
                     const std::size_t row_length)
{
  for (unsigned int b = 0; b < n_columns; ++b)
    for (unsigned int a = 0; a < n_rows; ++a)
      to[b * row_length + a] = from[a * row_length + b];
}

/// Whether both components belong to a field whose own tangent is symmetric.
template <int dim>
bool is_symmetric(const Domain<dim> &domain, const unsigned int c, const unsigned int d)
{
  for (unsigned int f = 0; f < domain.fields().size(); ++f)
    if (domain.fields()[f].has_component(c))
      return domain.fields()[f].has_component(d) && domain.material.is_symmetric(f);
  return false;
}

} // namespace

template <int dim>
void CellTerms<dim>::Tables::enter_cell(const Domain<dim> &domain, const dealii::FEValues<dim> &cell_values)
{
  if (cell_values.get_cell_similarity() != dealii::CellSimilarity::translation)
    for (auto &table : all)
      table.second.is_of_this_cell = false;
  JxW.resize(cell_values.n_quadrature_points);
  for (const unsigned int q : cell_values.quadrature_point_indices())
    JxW[q] = domain.measure(cell_values, q);
}

template <int dim>
const ShapeTable &CellTerms<dim>::Tables::table(const CellLayout<dim> &layout, const unsigned int component,
                                                const bool with_value,
                                                const dealii::FEValues<dim> &cell_values)
{
  Table &result = all[{layout.first_shape(component), with_value}];
  if (!result.is_of_this_cell)
    tabulate(layout, component, cell_values, with_value, result);
  result.is_of_this_cell = true;
  return result;
}

/// K_(c,a)(d,b) = grad phi_a . ( dA_c/dgrad B_d . grad phi_b + dA_c/dB_d phi_b )
///              + phi_a ( dS_c/dgrad B_d . grad phi_b + dS_c/dB_d phi_b )
template <int dim>
void CellTerms<dim>::add_pairs(dealii::FullMatrix<double> &tangent)
{
  for (const auto &[c, d, index, coupling] : pairs) {
    const bool is_from_symmetry = is_symmetric(domain, c, d);
    if (!is_asked[c] || (is_from_symmetry && d < c))
      continue; // or it has been copied
    const ShapeTable &rows = tables.table(layout, c, coupling.in_source(), cell_values),
                     &columns = tables.table(layout, d, coupling.flux_by_value || coupling.source_by_value,
                                             cell_values);
    const unsigned int n_entries = rows.n_directions * columns.n_directions;
    derivatives.resize(responses.size() * n_entries);
    for (unsigned int q = 0; q < responses.size(); ++q)
      fill_derivatives(responses[q], index, coupling, tables.JxW[q], rows.n_directions, columns.n_directions,
                       &derivatives[q * n_entries]);
    add_cell_matrix(rows, columns, derivatives, is_from_symmetry && c == d,
                    &tangent(layout.first(c), layout.first(d)), tangent.n());
    if (is_from_symmetry && c != d)
      copy_transposed(layout.n_nodes(c), layout.n_nodes(d), &tangent(layout.first(c), layout.first(d)),
                      &tangent(layout.first(d), layout.first(c)), tangent.n());
  }
}

template <int dim>
void CellTerms<dim>::add_tangent(dealii::FullMatrix<double> &tangent)
{
  // around an axis the measure of a cell changes with its position
  const bool is_translated =
      move.is_done || (!domain.measure.is_axisymmetric() &&
                       cell_values.get_cell_similarity() == dealii::CellSimilarity::translation);
  const bool are_equal = has_uniform_responses ||
                         std::all_of(responses.begin() + 1, responses.end(), [this](const auto &at_point) {
                           return has_equal_derivatives(at_point, responses[0]);
                         });
  if (are_equal && is_translated && has_uniform_tangent &&
      has_equal_derivatives(responses[0], uniform_response)) {
    std::copy_n(&uniform_tangent(0, 0), uniform_tangent.n_elements(), &tangent(0, 0)); // no new memory
    return;
  }
  add_pairs(tangent);
  has_uniform_tangent = are_equal;
  if (are_equal) {
    uniform_tangent = tangent;
    uniform_response = responses[0];
  }
}

namespace {

template <int dim>
std::string field_of_component(const Domain<dim> &domain, const unsigned int c)
{
  for (const Field &field : domain.fields())
    if (field.has_component(c))
      return field.name;
  return {};
}

} // namespace

template <int dim>
void CellTerms<dim>::add_source(const double t, std::vector<double> &residual)
{
  for (unsigned int c = 0; c < n; ++c)
    if (const auto &[source, component] = source_of_component[c]; source != nullptr && is_in_residual[c]) {
      source->values(points_of_cell(), t, component, source_at_points);
      for (const unsigned int q : cell_values.quadrature_point_indices()) {
        const double value = source_at_points[q];
        if (!std::isfinite(value))
          finite(value, domain.section.subsection("Source"), field_of_component(domain, c),
                 points_of_cell()[q], t);
        source_at_points[q] *= tables.JxW[q];
        given_of_cell[c] += source_at_points[q];
      }
      add_sources(layout, c, cell_values, source_at_points.data(), -1., residual, force_sizes);
    }
}

template <int dim>
void CellTerms<dim>::add_body_force(const double t, const std::vector<double> &unknowns,
                                    std::vector<double> &residual, dealii::FullMatrix<double> *tangent)
{
  const BodyForce<dim> &force = domain.body_force();
  const unsigned int first = force.first_component(), n_nodes = layout.n_nodes(first);
  std::vector<double> phi(n_nodes);
  for (const unsigned int q : cell_values.quadrature_point_indices()) {
    const double JxW = tables.JxW[q];
    for (unsigned int a = 0; a < n_nodes; ++a)
      phi[a] = cell_values.shape_value(layout.shape_of_node(first, a), q);
    dealii::Tensor<1, dim> u;
    for (unsigned int c = 0; force.depends_on_displacement() && c < dim; ++c)
      u[c] = std::inner_product(phi.begin(), phi.end(), unknowns.begin() + layout.first(first + c), 0.);
    const dealii::Tensor<1, dim> b = force.value(points_of_cell()[q], t, u);
    for (unsigned int c = 0; c < dim; ++c) {
      given_of_cell[first + c] += b[c] * JxW;
      for (unsigned int i = 0; i < n_nodes; ++i)
        add(layout.index(first + c, i), -b[c] * phi[i] * JxW, residual);
    }
    if (tangent == nullptr || !force.depends_on_displacement() || has_operator(first))
      continue;
    const dealii::Tensor<2, dim> derivative = force.derivative(points_of_cell()[q], t);
    for (unsigned int c = 0; c < dim; ++c)
      for (unsigned int d = 0; d < dim; ++d)
        for (unsigned int i = 0; derivative[c][d] != 0 && i < n_nodes; ++i)
          for (unsigned int j = 0; j < n_nodes; ++j)
            (*tangent)(layout.index(first + c, i), layout.index(first + d, j)) -=
                derivative[c][d] * phi[i] * phi[j] * JxW;
  }
}

template <int dim>
bool CellTerms<dim>::add_boundary_terms(const typename Domain<dim>::cell_iterator &cell, const double t,
                                        const std::vector<double> &unknowns, std::vector<double> &residual,
                                        dealii::FullMatrix<double> *tangent)
{
  bool is_defined = true;
  point.enter(cell);
  for (const unsigned int face : cell->face_indices())
    if (cell->face(face)->at_boundary())
      for (const Condition<dim> *condition : flux_conditions) {
        if (!is_in_residual[condition->field.first_component])
          continue;
        open_boundary.for_each_point(cell, face, *condition, t, unknowns, [&](const auto &at) {
          if (condition->is_weak())
            is_defined =
                add_weak_value(*condition, at,
                               domain.weak_penalties.at({condition->field.name, cell->active_cell_index()}),
                               unknowns, residual, tangent) &&
                is_defined;
          else
            add_influx(*condition, at, residual, tangent);
        });
      }
  return is_defined;
}

template <int dim>
void CellTerms<dim>::add_influx(const Condition<dim> &condition, const typename OpenBoundary<dim>::Point &at,
                                std::vector<double> &residual, dealii::FullMatrix<double> *tangent)
{
  const unsigned int first = condition.field.first_component, n_c = condition.field.n_components;
  Influx<dim> influx(n_c, n);
  condition.influx(at.state, at.N, influx);
  for (unsigned int c = 0; c < n_c; ++c)
    for (unsigned int a = 0; a < layout.n_nodes(first); ++a) {
      const double test = at.shape_values[layout.first_shape(first) + a] * at.JxW;
      if (test == 0) // of a node that is not on the face
        continue;
      const unsigned int i = layout.index(first + c, a);
      add(i, -test * influx.value[c], residual);
      if (tangent == nullptr)
        continue;
      for (unsigned int d = 0; d < n; ++d) {
        const unsigned int n_nodes = layout.n_nodes(d), s = layout.first_shape(d);
        double *row = &(*tangent)(i, layout.first(d));
        if (const double by_value = influx.by_value(c, d); by_value != 0)
          for (unsigned int b = 0; b < n_nodes; ++b)
            row[b] -= test * by_value * at.shape_values[s + b];
        if (const dealii::Tensor<1, dim> &by_gradient = influx.by_gradient(c, d);
            by_gradient != dealii::Tensor<1, dim>())
          for (unsigned int b = 0; b < n_nodes; ++b)
            row[b] -= test * (by_gradient * at.shape_gradients[s + b]);
      }
    }
}

template std::vector<unsigned int> lumped_components(const Domain<2> &, unsigned int);
template std::vector<unsigned int> lumped_components(const Domain<3> &, unsigned int);
template class CellTerms<2>;
template class CellTerms<3>;

} // namespace dovetail
