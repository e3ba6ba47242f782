// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_points.h>

namespace dovetail {

template <int dim>
void evaluate_state(const unsigned int n_components, const unsigned int n_nodes, const double *shape_values,
                    const dealii::Tensor<1, dim> *shape_gradients, const double *unknowns, State<dim> &state)
{
  for (unsigned int c = 0; c < n_components; ++c, unknowns += n_nodes) {
    double value = 0;
    dealii::Tensor<1, dim> gradient;
    for (unsigned int a = 0; a < n_nodes; ++a) {
      value += shape_values[a] * unknowns[a];
      for (unsigned int d = 0; d < dim; ++d)
        gradient[d] += shape_gradients[a][d] * unknowns[a];
    }
    state.value[c] = value;
    state.gradient[c] = gradient;
  }
}

template <int dim>
void CellPoints<dim>::reinit(const dealii::FEValuesBase<dim> &values, const unsigned int q,
                             const std::vector<double> &unknowns)
{
  for (unsigned int a = 0; a < shape.size(); ++a) {
    shape[a] = values.shape_value(a, q);
    gradient[a] = values.shape_grad(a, q);
  }
  reinit(values.quadrature_point(q), shape.data(), gradient.data(), unknowns);
}

template <int dim>
void CellPoints<dim>::reinit(const dealii::Point<dim> &X, const double *shape_values,
                             const dealii::Tensor<1, dim> *shape_gradients,
                             const std::vector<double> &unknowns)
{
  state.X = X;
  if (domain.is_on_axis(X))
    state.X[0] = 0;
  evaluate_state<dim>(domain.n_components(), shape.size(), shape_values, shape_gradients, unknowns.data(),
                      state);
}

template void evaluate_state<2>(unsigned int, unsigned int, const double *, const dealii::Tensor<1, 2> *,
                                const double *, State<2> &);
template void evaluate_state<3>(unsigned int, unsigned int, const double *, const dealii::Tensor<1, 3> *,
                                const double *, State<3> &);
template class CellPoints<2>;
template class CellPoints<3>;

} // namespace dovetail
