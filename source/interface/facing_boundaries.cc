// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/face_points.h>
#include <dovetail/interface/facing_boundaries.h>

#include <deal.II/base/mpi.h>

namespace dovetail {

namespace {

template <int dim>
SideFaces<dim> faces_of(const Domain<dim> &domain, const std::set<dealii::types::boundary_id> &ids)
{
  return {domain.mesh(), domain.mapping(), domain.mapping_degree(), ids};
}

/// Whether some part of the faces of one side has a partner on the other.
template <int dim>
bool faces(const SideFaces<dim> &own, const SideFaces<dim> &other, const double search_radius,
           const MPI_Comm &communicator)
{
  const auto points = segments(own, FaceLocator<dim>(other, search_radius, communicator), 1, 1);
  const bool is_found = std::any_of(points.matches.begin(), points.matches.end(),
                                    [](const auto &match) { return match.found; });
  return dealii::Utilities::MPI::max(is_found ? 1 : 0, communicator) > 0;
}

template <int dim>
bool share_a_field(const Domain<dim> &one, const Domain<dim> &other)
{
  return std::any_of(one.fields().begin(), one.fields().end(),
                     [&](const Field &field) { return other.material.find_field(field.name) != nullptr; });
}

} // namespace

template <int dim>
std::vector<FacingBoundaries> find_facing_boundaries(const std::vector<std::unique_ptr<Domain<dim>>> &domains,
                                                     const double search_radius, const MPI_Comm &communicator)
{
  std::vector<FacingBoundaries> result;
  for (unsigned int i = 0; i < domains.size(); ++i)
    for (unsigned int j = i + 1; j < domains.size(); ++j) {
      const Domain<dim> &one = *domains[i], &other = *domains[j];
      const double reach = (1 + search_radius) * (one.typical_length() + other.typical_length()) / 2;
      if (!share_a_field(one, other) || one.centre().distance(other.centre()) > reach)
        continue;
      FacingBoundaries facing{{{i, j}}, {}};
      for (const auto id : one.boundary_ids())
        for (const auto other_id : other.boundary_ids()) {
          const auto of_one = faces_of(one, {id}), of_other = faces_of(other, {other_id});
          if (faces(of_one, of_other, search_radius, communicator) ||
              faces(of_other, of_one, search_radius, communicator)) {
            facing.ids[0].insert(id);
            facing.ids[1].insert(other_id);
          }
        }
      if (!facing.ids[0].empty())
        result.push_back(facing);
    }
  return result;
}

template std::vector<FacingBoundaries> find_facing_boundaries(const std::vector<std::unique_ptr<Domain<2>>> &,
                                                              double, const MPI_Comm &);
template std::vector<FacingBoundaries> find_facing_boundaries(const std::vector<std::unique_ptr<Domain<3>>> &,
                                                              double, const MPI_Comm &);

} // namespace dovetail
