// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/side_ratios.h>

#include <deal.II/base/mpi.h>

#include <sstream>

namespace dovetail {

namespace {

template <int dim>
double mean_face_size(const InterfaceSide<dim> &side, const MPI_Comm &communicator)
{
  std::array<double, 2> sums = {{0, 0}}; // of sizes, of faces
  for (const auto &face : faces_of(side).faces) {
    sums[0] += face.size;
    sums[1] += 1;
  }
  return dealii::Utilities::MPI::sum(sums[0], communicator) /
         dealii::Utilities::MPI::sum(sums[1], communicator);
}

/// 0 if the law is not defined.
template <int dim>
double stiffness(const Domain<dim> &domain, const unsigned int first_component,
                 const unsigned int n_components)
{
  const unsigned int n = domain.n_components();
  State<dim> state(n);
  state.X = domain.centre();
  Response<dim> response(n);
  if (!domain.material.evaluate(state, true, response))
    return 0;
  double square = 0;
  for (unsigned int c = first_component; c < first_component + n_components; ++c)
    for (unsigned int d = first_component; d < first_component + n_components; ++d)
      square += response.by_gradient[c * n + d].norm_square();
  return std::sqrt(square);
}

} // namespace

template <int dim>
SideRatios side_ratios(const Interface<dim> &interface, const MPI_Comm &communicator)
{
  SideRatios result;
  result.face_size = mean_face_size(interface.sides[destination], communicator) /
                     mean_face_size(interface.sides[source], communicator);
  for (const TiedField &field : interface.fields) {
    std::array<double, 2> of_sides;
    for (const unsigned int side : {source, destination})
      of_sides[side] =
          stiffness(*interface.sides[side].domain, field.first_component[side], field.n_components);
    if (of_sides[source] > 0)
      result.stiffness = std::max(result.stiffness, of_sides[destination] / of_sides[source]);
  }
  return result;
}

std::string words_for_stiff_follower(const double stiffness)
{
  std::ostringstream sentence;
  sentence.precision(2);
  sentence
      << "the destination follows the source and is " << stiffness
      << " times as stiff: the flux between them errs by about that ratio times the error of the bodies. "
         "Make the stiffer side the source, or use Type = Nitsche";
  return sentence.str();
}

template SideRatios side_ratios(const Interface<2> &, const MPI_Comm &);
template SideRatios side_ratios(const Interface<3> &, const MPI_Comm &);

} // namespace dovetail
