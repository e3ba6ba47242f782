// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/point_products.h>

#include <algorithm>
#include <limits>
#include <numeric>

namespace dovetail {

template <int dim>
void evaluate_state(const CellLayout<dim> &layout, const double *all_values,
                    const dealii::Tensor<1, dim> *all_gradients, const double *unknowns, State<dim> &state)
{
  for (unsigned int c = 0; c < layout.n_components(); ++c) {
    const unsigned int n_nodes = layout.n_nodes(c);
    const double *shape_values = all_values + layout.first_shape(c);
    const dealii::Tensor<1, dim> *shape_gradients = all_gradients + layout.first_shape(c);
    double value = 0;
    dealii::Tensor<1, dim> gradient;
    for (unsigned int a = 0; a < n_nodes; ++a) {
      value += shape_values[a] * unknowns[a];
      for (unsigned int d = 0; d < dim; ++d)
        gradient[d] += shape_gradients[a][d] * unknowns[a];
    }
    state.value[c] = value;
    state.gradient[c] = gradient;
    unknowns += n_nodes;
  }
}

template <int dim>
CellPoints<dim>::CellPoints(const Domain<dim> &domain, const double t)
    : domain(domain), state(domain.n_components()), response(domain.n_components()),
      linearised(domain.n_components()), shape(domain.layout().n_shapes()),
      gradient(domain.layout().n_shapes()), trial_memory(domain.material.initial_memory())
{
  state.t = t;
  const std::vector<double> &initial = domain.material.initial_memory();
  state.memory = {{initial.data(), initial.size()}, {trial_memory.data(), trial_memory.size()}};
}

template <int dim>
void CellPoints<dim>::remember()
{
  if (domain.memory && cell.state() == dealii::IteratorState::valid)
    state.memory.accepted = domain.memory->nearest(cell, state.X);
}

template <int dim>
void CellPoints<dim>::enter(const dealii::FEValuesBase<dim> &values, const std::vector<double> &unknowns,
                            const std::vector<bool> &needed)
{
  points = &values;
  interpolate(unknowns, needed, present);
  state.linearised_at = nullptr;
  if (domain.memory)
    cell = values.get_cell();
}

template <int dim>
void CellPoints<dim>::enter_linearised(const std::vector<double> &unknowns)
{
  interpolate(unknowns, {}, before);
  state.linearised_at = &linearised;
}

/// The numbers of one shape function at all points follow each other in deal.II's tables, as do the three of
/// a gradient.
template <int dim>
void CellPoints<dim>::interpolate(const std::vector<double> &unknowns, const std::vector<bool> &needed,
                                  AtPoints &result)
{
  const dealii::FEValuesBase<dim> &values = *points;
  const unsigned int n = values.n_quadrature_points;
  result.values.resize(domain.n_components() * n);
  result.gradients.resize(domain.n_components() * n);
  for (unsigned int c = 0; c < domain.n_components(); ++c) {
    double *const values_here = &result.values[c * n];
    dealii::Tensor<1, dim> *const gradients_here = &result.gradients[c * n];
    if (!needed.empty() && !needed[c]) {
      constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
      std::fill_n(values_here, n, unknown);
      std::fill_n(&gradients_here[0][0], n * dim, unknown);
      continue;
    }
    const unsigned int n_nodes = domain.layout().n_nodes(c);
    const double *const of_component = &unknowns[domain.layout().first(c)];
    if (std::all_of(of_component, of_component + n_nodes, [](const double x) { return x == 0; })) {
      std::fill_n(values_here, n, 0.); // as nearly all cells at the first state
      std::fill_n(gradients_here, n, dealii::Tensor<1, dim>());
      continue;
    }
    rows.resize(n_nodes);
    for (unsigned int a = 0; a < n_nodes; ++a)
      rows[a] = &values.shape_value(domain.layout().shape_of_node(c, a), 0);
    Assert(&values.shape_value(domain.layout().shape_of_node(c, 0), n - 1) == rows[0] + n - 1,
           dealii::ExcInternalError());
    combine_rows(n_nodes, rows.data(), of_component, n, values_here);
    for (unsigned int a = 0; a < n_nodes; ++a)
      rows[a] = &values.shape_grad(domain.layout().shape_of_node(c, a), 0)[0];
    Assert(&values.shape_grad(domain.layout().shape_of_node(c, 0), n - 1)[0] == rows[0] + (n - 1) * dim,
           dealii::ExcInternalError());
    combine_rows(n_nodes, rows.data(), of_component, n * dim, &gradients_here[0][0]);
  }
}

template <int dim>
void CellPoints<dim>::go_to(const unsigned int q)
{
  const unsigned int n = points->n_quadrature_points;
  set_position(points->quadrature_point(q));
  const auto set = [&](const AtPoints &all, State<dim> &of_point) {
    for (unsigned int c = 0; c < domain.n_components(); ++c) {
      of_point.value[c] = all.values[c * n + q];
      of_point.gradient[c] = all.gradients[c * n + q];
    }
  };
  set(present, state);
  if (state.linearised_at != nullptr) {
    set(before, linearised);
    linearised.X = state.X;
  }
  if (!state.rate.empty())
    evaluate_rates([&](const std::vector<double> &cell_values, const unsigned int c) {
      double sum = 0;
      for (unsigned int a = 0; a < domain.layout().n_nodes(c); ++a)
        sum += points->shape_value(domain.layout().shape_of_node(c, a), q) *
               cell_values[domain.layout().index(c, a)];
      return sum;
    });
}

template <int dim>
void CellPoints<dim>::evaluate_uniform(const Response<dim> &response, const std::vector<bool> &are_needed,
                                       const std::vector<double> &weights,
                                       std::vector<dealii::Tensor<1, dim>> &fluxes) const
{
  const unsigned int n = domain.n_components(), n_points = weights.size();
  for (unsigned int c = 0; c < n; ++c) {
    dealii::Tensor<1, dim> *const of_component = &fluxes[c * n_points];
    std::fill_n(of_component, n_points, dealii::Tensor<1, dim>());
    for (unsigned int d = 0; d < n; ++d)
      if (are_needed[c] && domain.material.coupling(c, d).flux_by_gradient)
        for (unsigned int q = 0; q < n_points; ++q)
          of_component[q] +=
              weights[q] * (response.by_gradient[c * n + d] * present.gradients[d * n_points + q]);
  }
}

template <int dim>
void CellPoints<dim>::reinit(const dealii::FEValuesBase<dim> &values, const unsigned int q,
                             const std::vector<double> &unknowns)
{
  if (domain.memory)
    cell = values.get_cell();
  for (unsigned int a = 0; a < shape.size(); ++a) {
    const unsigned int i = domain.layout().shape_index(a);
    shape[a] = values.shape_value(i, q);
    gradient[a] = values.shape_grad(i, q);
  }
  reinit(values.quadrature_point(q), shape.data(), gradient.data(), unknowns);
}

template <int dim>
void CellPoints<dim>::set_position(const dealii::Point<dim> &X)
{
  state.X = X;
  remember();
  if (domain.is_on_axis(X))
    state.X[0] = 0;
}

template <int dim>
void CellPoints<dim>::reinit(const dealii::Point<dim> &X, const double *shape_values,
                             const dealii::Tensor<1, dim> *shape_gradients,
                             const std::vector<double> &unknowns)
{
  set_position(X);
  state.linearised_at = nullptr;
  evaluate_state(domain.layout(), shape_values, shape_gradients, unknowns.data(), state);
  if (!state.rate.empty())
    evaluate_rates([&](const std::vector<double> &cell_values, const unsigned int c) {
      const double *values = shape_values + domain.layout().first_shape(c);
      return std::inner_product(values, values + domain.layout().n_nodes(c),
                                cell_values.begin() + domain.layout().first(c), 0.);
    });
}

template <int dim>
void CellPoints<dim>::move_to_node(const unsigned int a, const std::vector<double> &unknowns)
{
  const auto at_node = [&](const std::vector<double> &cell_values, const unsigned int c) {
    return a < domain.layout().n_nodes(c) ? cell_values[domain.layout().index(c, a)] : 0;
  };
  for (unsigned int c = 0; c < domain.n_components(); ++c)
    if (a < domain.layout().n_nodes(c))
      state.value[c] = at_node(unknowns, c);
  evaluate_rates(at_node);
}

template <int dim>
void CellPoints<dim>::set_rates(const Rates *rates, const std::vector<dealii::types::global_dof_index> &dofs)
{
  const auto extract = [&](const Rates::Vector &vector, const bool is_known, std::vector<double> &at_point,
                           std::vector<double> &cell_values) {
    at_point.resize(is_known ? domain.n_components() : 0);
    cell_values.resize(is_known ? dofs.size() : 0);
    if (is_known)
      vector.extract_subvector_to(dofs.begin(), dofs.end(), cell_values.begin());
  };
  const unsigned int order = rates == nullptr || !rates->has_first() ? 0 : domain.material.order_in_time();
  if (order == 0) {
    state.rate.clear();
    state.second_rate.clear();
    return;
  }
  const bool sees_past = domain.material.sees_past();
  state.past_weight = sees_past ? rates->weights : std::vector<double>();
  state.past.resize(state.past_weight.size());
  past.resize(state.past_weight.size());
  for (unsigned int j = 0; j < past.size(); ++j)
    extract(rates->past[j], true, state.past[j], past[j]);
  extract(rates->rest, true, state.rate, rest);
  extract(rates->second_rest, order > 1 && rates->has_second(), state.second_rate, second_rest);
  state.rate_by_value = rates->by_value;
  state.second_rate_by_value = rates->second_by_value;
}

template <int dim>
template <typename Function>
void CellPoints<dim>::evaluate_rates(const Function &at)
{
  for (unsigned int c = 0; c < domain.n_components(); ++c) {
    const unsigned int order = domain.material.order_in_time(c);
    if (order > 0)
      state.rate[c] = state.rate_by_value * state.value[c] + at(rest, c);
    if (order > 1)
      state.second_rate[c] = state.second_rate_by_value * state.value[c] + at(second_rest, c);
    for (unsigned int j = 0; j < past.size() && order > 0; ++j)
      state.past[j][c] = at(past[j], c);
  }
}

template void evaluate_state(const CellLayout<2> &, const double *, const dealii::Tensor<1, 2> *,
                             const double *, State<2> &);
template void evaluate_state(const CellLayout<3> &, const double *, const dealii::Tensor<1, 3> *,
                             const double *, State<3> &);
template class CellPoints<2>;
template class CellPoints<3>;

} // namespace dovetail
