// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/gaps.h>

#include <deal.II/base/mpi.h>

#include <algorithm>

namespace dovetail {

template <int dim>
double signed_gap(const Interface<dim> &interface, const unsigned int q)
{
  const Pairing<dim> &pairing = interface.pairing();
  const dealii::Tensor<1, dim> r = (pairing.X(destination, q) + interface.sides[destination].shift) -
                                   (pairing.X(source, q) + interface.sides[source].shift);
  return (r * (pairing.N(source, q) - pairing.N(destination, q)) < 0 ? -1 : 1) * r.norm();
}

template <int dim>
Gaps find_gaps(const Interface<dim> &interface, const MPI_Comm &communicator)
{
  double gap = 0, overlap = 0;
  for (unsigned int q = 0; q < interface.pairing().n_points(); ++q) {
    gap = std::max(gap, signed_gap(interface, q));
    overlap = std::max(overlap, -signed_gap(interface, q));
  }
  return {dealii::Utilities::MPI::max(gap, communicator), dealii::Utilities::MPI::max(overlap, communicator)};
}

template double signed_gap(const Interface<2> &, unsigned int);
template double signed_gap(const Interface<3> &, unsigned int);
template Gaps find_gaps(const Interface<2> &, const MPI_Comm &);
template Gaps find_gaps(const Interface<3> &, const MPI_Comm &);

} // namespace dovetail
