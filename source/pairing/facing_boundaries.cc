// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/pairing/facing_boundaries.h>
#include <dovetail/pairing/pairing.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <map>

namespace dovetail {

namespace {

/// Between the normals of what is tied. Walls beside an interface differ by more; coarse facets of a round
/// side by less.
constexpr double largest_angle = 45 * dealii::numbers::PI / 180;

/// Whether some part of the faces of one side has a partner on the other with no third body between them.
template <int dim>
bool faces(const SideFaces<dim> &own, const SideFaces<dim> &other,
           const std::vector<const Domain<dim> *> &third, const double search_radius,
           const MPI_Comm &communicator)
{
  const auto points = segments(own, FaceLocator<dim>(other, search_radius, 0., communicator), 1, 1);
  std::vector<typename FaceLocator<dim>::Query> across_gap;
  std::vector<double> gap;
  bool touches = false;
  for (unsigned int q = 0; q < points.size(); ++q)
    if (points.matches[q].found && points.matches[q].angle <= largest_angle) {
      if (points.matches[q].distance < 1e-6 * points.queries[q].face_size)
        touches = true;
      else {
        across_gap.push_back(points.queries[q]);
        gap.push_back(points.matches[q].distance);
      }
    }
  if (dealii::Utilities::MPI::max(touches ? 1 : 0, communicator) > 0)
    return true;
  if (dealii::Utilities::MPI::max(gap.empty() ? 0 : 1, communicator) == 0)
    return false;
  std::vector<bool> is_open(gap.size(), true);
  for (const Domain<dim> *domain : third) {
    const FaceLocator<dim> locator(faces_of<dim>({domain, domain->boundary_ids()}), search_radius, 0.,
                                   communicator);
    const auto matches = locator.locate(across_gap);
    for (unsigned int q = 0; q < gap.size(); ++q)
      if (matches[q].found && matches[q].distance < (1 - 1e-6) * gap[q])
        is_open[q] = false;
  }
  const bool is_any_open = std::find(is_open.begin(), is_open.end(), true) != is_open.end();
  return dealii::Utilities::MPI::max(is_any_open ? 1 : 0, communicator) > 0;
}

/// For each domain those whose surrounding spheres its own meets, in increasing order.
template <int dim>
std::vector<std::vector<unsigned int>> near_domains(const std::vector<std::unique_ptr<Domain<dim>>> &domains,
                                                    const double search_radius)
{
  std::vector<std::vector<unsigned int>> result(domains.size());
  for (unsigned int i = 0; i < domains.size(); ++i)
    for (unsigned int j = 0; j < domains.size(); ++j)
      if (i != j &&
          domains[i]->centre().distance(domains[j]->centre()) <=
              (1 + search_radius) * (domains[i]->typical_length() + domains[j]->typical_length()) / 2)
        result[i].push_back(j);
  return result;
}

} // namespace

template <int dim>
bool share_a_field(const Domain<dim> &one, const Domain<dim> &other)
{
  return std::any_of(one.fields().begin(), one.fields().end(),
                     [&](const Field &field) { return other.material.find_field(field.name) != nullptr; });
}

template <int dim>
std::vector<FacingBoundaries> find_facing_boundaries(const std::vector<std::unique_ptr<Domain<dim>>> &domains,
                                                     const double search_radius, const MPI_Comm &communicator)
{
  const auto neighbours = near_domains(domains, search_radius);
  std::vector<FacingBoundaries> result;
  for (unsigned int i = 0; i < domains.size(); ++i)
    for (const unsigned int j : neighbours[i]) {
      const Domain<dim> &one = *domains[i], &other = *domains[j];
      if (j < i || !share_a_field(one, other))
        continue;
      std::vector<const Domain<dim> *> third; // a body between two is near both
      for (const unsigned int k : neighbours[i])
        if (std::binary_search(neighbours[j].begin(), neighbours[j].end(), k))
          third.push_back(domains[k].get());
      std::map<dealii::types::boundary_id, SideFaces<dim>> other_faces;
      for (const auto id : other.boundary_ids())
        other_faces.emplace(id, faces_of<dim>({&other, {id}}));
      FacingBoundaries facing{{{i, j}}, {}};
      for (const auto id : one.boundary_ids()) {
        const auto own_faces = faces_of<dim>({&one, {id}});
        for (const auto &[other_id, faces_of_id] : other_faces)
          if (faces(own_faces, faces_of_id, third, search_radius, communicator) ||
              faces(faces_of_id, own_faces, third, search_radius, communicator)) {
            facing.ids[0].insert(id);
            facing.ids[1].insert(other_id);
          }
      }
      if (!facing.ids[0].empty())
        result.push_back(facing);
    }
  return result;
}

template bool share_a_field(const Domain<2> &, const Domain<2> &);
template bool share_a_field(const Domain<3> &, const Domain<3> &);
template std::vector<FacingBoundaries> find_facing_boundaries(const std::vector<std::unique_ptr<Domain<2>>> &,
                                                              double, const MPI_Comm &);
template std::vector<FacingBoundaries> find_facing_boundaries(const std::vector<std::unique_ptr<Domain<3>>> &,
                                                              double, const MPI_Comm &);

} // namespace dovetail
