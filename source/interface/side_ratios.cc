// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_points.h>
#include <dovetail/interface/side_ratios.h>

#include <deal.II/base/mpi.h>

#include <sstream>

namespace dovetail {

namespace {

const NoteName of_stiff_destination("stiff destination", "a tie makes a stiff body follow a soft one");
const NoteName of_soft_source("soft source", "a source is softer and finer than its destination by mortar");

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

/// |dA/dgrad B| of a field in the undeformed state, 0 if the law is not defined.
template <int dim>
double stiffness(const Domain<dim> &domain, const unsigned int first_component,
                 const unsigned int n_components, const dealii::Point<dim> &X)
{
  const unsigned int n = domain.n_components();
  CellPoints<dim> point(domain, 0);
  point.state.X = X;
  for (const Field &field : domain.fields()) // a displacement that is given first does not stiffen the body
    if (const Expression *initial = domain.initial().find(field.name);
        initial != nullptr && field.n_components == 1)
      point.state.value[field.first_component] = initial->value(X, 0., 0);
  if (!point.evaluate(true))
    return 0;
  double square = 0;
  for (unsigned int c = first_component; c < first_component + n_components; ++c)
    for (unsigned int d = first_component; d < first_component + n_components; ++d)
      square += point.response.by_gradient[c * n + d].norm_square();
  return std::sqrt(square);
}

/// Integrals over the interface by field, where the laws of both sides are defined.
template <int dim>
std::vector<std::array<double, 2>> stiffnesses(const Interface<dim> &interface, const MPI_Comm &communicator)
{
  std::vector<double> sums(2 * interface.fields.size(), 0.);
  for (unsigned int q = 0; q < interface.pairing().n_points(); ++q)
    for (unsigned int f = 0; f < interface.fields.size(); ++f) {
      const TiedField &field = interface.fields[f];
      std::array<double, 2> k;
      for (const unsigned int side : {source, destination})
        k[side] = stiffness(*interface.sides[side].domain, field.first_component[side], field.n_components,
                            interface.pairing().X(side, q));
      for (const unsigned int side : {source, destination})
        if (k[source] > 0 && k[destination] > 0)
          sums[2 * f + side] += interface.pairing().weight(q) * k[side];
    }
  dealii::Utilities::MPI::sum(sums, communicator, sums);
  std::vector<std::array<double, 2>> result;
  for (unsigned int f = 0; f < interface.fields.size(); ++f)
    result.push_back({{sums[2 * f], sums[2 * f + 1]}});
  return result;
}

} // namespace

template <int dim>
SideRatios side_ratios(const Interface<dim> &interface, const MPI_Comm &communicator)
{
  SideRatios result;
  result.face_size = mean_face_size(interface.sides[destination], communicator) /
                     mean_face_size(interface.sides[source], communicator);
  for (const auto &pair : stiffnesses(interface, communicator))
    if (pair[source] > 0)
      result.stiffness = std::max(result.stiffness, pair[destination] / pair[source]);
  return result;
}

template <int dim>
double own_share_of_gap(const Interface<dim> &interface, const TiedField &field, const unsigned int own,
                        const std::array<dealii::Point<dim>, 2> &X)
{
  if (interface.sides[source].domain == interface.sides[destination].domain)
    return 0;
  std::array<double, 2> k;
  for (const unsigned int side : {source, destination})
    k[side] =
        stiffness(*interface.sides[side].domain, field.first_component[side], field.n_components, X[side]);
  return k[1 - own] > 0 && k[own] > k[1 - own] ? 1 - k[1 - own] / k[own] : 0;
}

Note note_on_stiff_destination(const double stiffness)
{
  std::ostringstream sentence;
  sentence.precision(2);
  sentence
      << "the destination follows the source and is " << stiffness
      << " times as stiff: the flux between them errs by about that ratio times the error of the bodies. "
         "Make the stiffer side the source, or use Type = Nitsche";
  return of_stiff_destination(sentence.str());
}

Note note_on_fine_soft_source(const SideRatios &ratios)
{
  std::ostringstream sentence;
  sentence.precision(2);
  sentence
      << "the destination is " << ratios.stiffness << " times as stiff as the source and its faces are "
      << ratios.face_size
      << " times as large: the softer, finer source is tied in the mean over these faces only and slips "
         "between them, which at large strain makes the answer wrong. Swap Source and Destination, or use "
         "Type = Nitsche";
  return of_soft_source(sentence.str());
}

template SideRatios side_ratios(const Interface<2> &, const MPI_Comm &);
template SideRatios side_ratios(const Interface<3> &, const MPI_Comm &);
template double own_share_of_gap(const Interface<2> &, const TiedField &, unsigned int,
                                 const std::array<dealii::Point<2>, 2> &);
template double own_share_of_gap(const Interface<3> &, const TiedField &, unsigned int,
                                 const std::array<dealii::Point<3>, 2> &);

} // namespace dovetail
