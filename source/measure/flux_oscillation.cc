// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/flux_oscillation.h>

#include <deal.II/base/mpi.h>

#include <boost/serialization/map.hpp>
#include <boost/serialization/utility.hpp>
#include <boost/serialization/vector.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

template <int dim>
FluxOscillation<dim>::FluxOscillation(const Interface<dim> &interface)
    : interface(interface), group_of_point(interface.pairing().n_points()), first({1})
{
  const auto &groups = interface.pairing().groups;
  for (unsigned int g = 0; g < groups.size(); ++g)
    std::fill(group_of_point.begin() + groups[g].begin, group_of_point.begin() + groups[g].end, g);
  for (const TiedField &field : interface.fields)
    first.push_back(first.back() + field.n_components);
}

template <int dim>
void FluxOscillation<dim>::add(const unsigned int field, const unsigned int q,
                               const std::vector<double> &error)
{
  const Pairing<dim> &pairing = interface.pairing();
  for (const unsigned int side : {source, destination}) {
    const CellBehind<dim> &behind = pairing.cells[side][pairing.groups[group_of_point[q]].cells[side]];
    Sums &face_sums = sums[side][{behind.rank, behind.face}];
    face_sums.resize(first.back());
    if (field == 0)
      face_sums[0] += pairing.weight(q);
    for (unsigned int c = 0; c < error.size(); ++c)
      face_sums[first[field] + c] += error[c] * pairing.weight(q);
  }
}

template <int dim>
typename FluxOscillation<dim>::Faces FluxOscillation<dim>::gather(const unsigned int side,
                                                                  const MPI_Comm &communicator) const
{
  const SideFaces<dim> own = faces_of(interface.sides[side]);
  const unsigned int n_edges = own.shape.n_corners();
  std::vector<std::vector<dealii::Point<dim>>> own_edges(own.faces.size());
  for (unsigned int face = 0; face < own.faces.size(); ++face)
    for (unsigned int i = 0; i < n_edges; ++i) {
      const auto begin = own.shape.corner(own.nodes(face), i);
      const auto end = dim == 2 ? begin : own.shape.corner(own.nodes(face), (i + 1) % n_edges);
      own_edges[face].push_back(begin + (end - begin) / 2);
    }
  const auto all_edges = dealii::Utilities::MPI::gather(communicator, own_edges);

  std::map<Key, Sums> merged;
  for (const auto &rank_sums : dealii::Utilities::MPI::gather(communicator, sums[side]))
    for (const auto &[key, face_sums] : rank_sums) {
      Sums &sum = merged[key];
      sum.resize(face_sums.size());
      for (unsigned int i = 0; i < face_sums.size(); ++i)
        sum[i] += face_sums[i];
    }
  Faces faces;
  for (const auto &[key, face_sums] : merged) {
    faces.sums.push_back(face_sums);
    faces.edges.push_back(all_edges[key.first][key.second]);
  }
  return faces;
}

/// Edges are the same if their middles are, up to a thousandth of the smallest face: one mesh knows no others
/// as near as that.
template <int dim>
std::vector<std::vector<unsigned int>> FluxOscillation<dim>::neighbours(const Faces &faces)
{
  double smallest = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, std::pair<unsigned int, dealii::Point<dim>>>> sorted;
  for (unsigned int f = 0; f < faces.edges.size(); ++f)
    for (unsigned int i = 0; i < faces.edges[f].size(); ++i) {
      const dealii::Point<dim> &X = faces.edges[f][i];
      for (unsigned int j = 0; j < i; ++j)
        smallest = std::min(smallest, X.distance(faces.edges[f][j]));
      double position = 0; // along a direction in which hardly any two edges coincide
      for (unsigned int d = 0; d < dim; ++d)
        position += X[d] * std::sqrt(d == 0 ? 0.2 : d == 1 ? 0.3 : 0.5);
      sorted.push_back({position, {f, X}});
    }
  std::sort(sorted.begin(), sorted.end(), [](const auto &a, const auto &b) { return a.first < b.first; });
  const double tolerance = 1e-3 * smallest;
  std::vector<std::vector<unsigned int>> result(faces.sums.size());
  for (unsigned int i = 0; i < sorted.size(); ++i)
    for (unsigned int j = i + 1; j < sorted.size() && sorted[j].first - sorted[i].first <= tolerance; ++j) {
      const auto &[f, X] = sorted[i].second;
      const auto &[g, Y] = sorted[j].second;
      if (f != g && X.distance(Y) <= tolerance) {
        result[f].push_back(g);
        result[g].push_back(f);
      }
    }
  return result;
}

template <int dim>
std::vector<double> FluxOscillation<dim>::oscillations(const Faces &faces) const
{
  std::vector<double> squares(first.size() - 1, 0.);
  const auto face_sums = neighbours(faces);
  for (unsigned int f = 0; f < face_sums.size(); ++f) {
    double area = 0; // of the neighbours
    for (const unsigned int g : face_sums[f])
      area += faces.sums[g][0];
    if (!(area > 0) || !(faces.sums[f][0] > 0))
      continue;
    for (unsigned int field = 0; field < squares.size(); ++field)
      for (unsigned int i = first[field]; i < first[field + 1]; ++i) {
        double around = 0;
        for (const unsigned int g : face_sums[f])
          around += faces.sums[g][i];
        const double difference = faces.sums[f][i] / faces.sums[f][0] - around / area;
        squares[field] += faces.sums[f][0] * difference * difference / 4;
      }
  }
  for (double &square : squares)
    square = std::sqrt(square);
  return squares;
}

template <int dim>
std::vector<double> FluxOscillation<dim>::evaluate(const MPI_Comm &communicator) const
{
  const Faces source_faces = gather(source, communicator),
              destination_faces = gather(destination, communicator);
  std::vector<double> result(first.size() - 1);
  if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
    result = oscillations(source_faces.sums.size() >= destination_faces.sums.size() ? source_faces
                                                                                    : destination_faces);
  return dealii::Utilities::MPI::broadcast(communicator, result);
}

template class FluxOscillation<2>;
template class FluxOscillation<3>;

} // namespace dovetail
