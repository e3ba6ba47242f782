// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/tie/gradient_change.h>
#include <dovetail/tie/side_states.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/symmetric_tensor.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

/// sum_i |D n_i|^2/max(1, l_i^2) with D = F_now - F and the principal stretches l_i of F along n_i: a fibre
/// that has been stretched changes less by the same displacement. One that has been pressed counts as at
/// rest.
template <int dim>
double change_of_strain(const dealii::Tensor<1, dim> *before, const dealii::Tensor<1, dim> *now)
{
  dealii::Tensor<2, 3> F = dealii::unit_symmetric_tensor<3>(), D; // also in 2D
  for (unsigned int c = 0; c < dim; ++c)
    for (unsigned int d = 0; d < dim; ++d) {
      F[c][d] += before[c][d];
      D[c][d] = now[c][d] - before[c][d];
    }
  double square = 0;
  for (const auto &[stretch_square, n] :
       eigenvectors(symmetrize(transpose(F) * F), dealii::SymmetricTensorEigenvectorMethod::jacobi))
    square += (D * n).norm_square() / std::max(1., stretch_square);
  return square;
}

} // namespace

template <int dim>
typename GradientChange<dim>::Gradients GradientChange<dim>::gradients_at(const Interface<dim> &interface,
                                                                          const ValuesOf &values_of) const
{
  Gradients result;
  SidePoints<dim> points(interface, 0);
  for_each_group(interface, values_of, [&](const auto &group, const std::vector<double> &unknowns) {
    for (unsigned int q = group.begin; q < group.end; ++q)
      for (const unsigned int side : {source, destination}) {
        points.reinit(side, q, unknowns);
        for (const TiedField &field : interface.fields)
          if (has_large_strain(interface, field))
            for (unsigned int c = 0; c < field.n_components; ++c)
              result[side].push_back(points.state[side].gradient[field.first_component[side] + c]);
      }
  });
  return result;
}

template <int dim>
void GradientChange<dim>::start(const Interface<dim> &interface, const ValuesOf &values_of)
{
  last = gradients_at(interface, values_of);
}

template <int dim>
double GradientChange<dim>::advance(const Interface<dim> &interface, const ValuesOf &values_of,
                                    const MPI_Comm &communicator)
{
  const Pairing<dim> &pairing = interface.pairing();
  const Gradients now = gradients_at(interface, values_of);
  std::vector<double> sums(3, 0.); // of both sides' changes, of the area
  for (const unsigned int side : {source, destination}) {
    const unsigned int n = now[side].size() / std::max(pairing.n_points(), 1u);
    for (unsigned int q = 0; q < pairing.n_points(); ++q) {
      double square = 0;
      for (unsigned int i = q * n; i < (q + 1) * n; i += dim)
        square += change_of_strain(&last[side][i], &now[side][i]);
      sums[side] += pairing.weight(q) * std::sqrt(square);
      sums[2] += side == source ? pairing.weight(q) : 0;
    }
  }
  last = now;
  dealii::Utilities::MPI::sum(sums, communicator, sums);
  return sums[2] > 0 ? std::max(sums[source], sums[destination]) / sums[2] : 0;
}

template class GradientChange<2>;
template class GradientChange<3>;

} // namespace dovetail
