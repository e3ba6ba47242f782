// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/gaps.h>
#include <dovetail/measure/meeting_bodies.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_overlap("overlap", "the bodies at an interface overlap by more than their facets explain");
const NoteName of_angle("angle", "the sides of a tie meet at more than 45 degrees");

const double steep = 45 * dealii::numbers::PI / 180;
const double least_share_of_sides = 0.01; ///< of the area of a tie

/// The largest of a side, of all ranks. Collective.
template <int dim>
double largest_face_of(const InterfaceSide<dim> &side, const MPI_Comm &communicator)
{
  double size = 0;
  for (const auto &face : side.domain->boundary_faces())
    if (face.cell->is_locally_owned() && side.boundary_ids.count(face.id) > 0)
      size = std::max(size, face.cell->face(face.number)->diameter());
  return dealii::Utilities::MPI::max(size, communicator);
}

struct DoubtfulAreas
{
  double area = 0, overlap = 0, steep = 0;
  double largest_overlap = 0;
};

template <int dim>
double angle_at(const Pairing<dim> &pairing, const unsigned int q)
{
  return std::acos(std::clamp(-(pairing.N(source, q) * pairing.N(destination, q)), -1., 1.));
}

/// Between the normals: of all points, and of those that face each other. Collective.
template <int dim>
std::array<double, 2> largest_angles(const Interface<dim> &interface, const MPI_Comm &communicator)
{
  std::array<double, 2> largest{{0, 0}};
  for (unsigned int q = 0; q < interface.pairing().n_points(); ++q) {
    const double angle = angle_at(interface.pairing(), q);
    largest[0] = std::max(largest[0], angle);
    if (angle <= steep)
      largest[1] = std::max(largest[1], angle);
  }
  return {{dealii::Utilities::MPI::max(largest[0], communicator),
           dealii::Utilities::MPI::max(largest[1], communicator)}};
}

template <int dim>
DoubtfulAreas find_doubtful_areas(const Interface<dim> &interface, const double usual_distance)
{
  const Pairing<dim> &pairing = interface.pairing();
  DoubtfulAreas found;
  for (unsigned int q = 0; q < pairing.n_points(); ++q) {
    const double overlap = -signed_gap(interface, q);
    found.area += pairing.weight(q);
    if (angle_at(pairing, q) > steep)
      found.steep += pairing.weight(q);
    else if (overlap > usual_distance) {
      found.overlap += pairing.weight(q);
      found.largest_overlap = std::max(found.largest_overlap, overlap);
    }
  }
  return found;
}

template <int dim>
void add_notes_on_sides(const Interface<dim> &interface, const MPI_Comm &communicator, NoteList &notes)
{
  const double face_size = std::max(largest_face_of(interface.sides[source], communicator),
                                    largest_face_of(interface.sides[destination], communicator));
  const auto [largest_angle, angle_of_facets] = largest_angles(interface, communicator);
  const DoubtfulAreas own = find_doubtful_areas(interface, distance_of_facets(face_size, angle_of_facets));
  const auto sum = [&](const double value) { return dealii::Utilities::MPI::sum(value, communicator); };
  const double area = sum(own.area), overlapping = sum(own.overlap) / area, turned = sum(own.steep) / area,
               largest_overlap = dealii::Utilities::MPI::max(own.largest_overlap, communicator);
  std::ostringstream words;
  words.precision(3);
  if (overlapping > least_share_of_sides) {
    words << "its sides overlap by up to " << largest_overlap << " on " << 100 * overlapping
          << " % of the tied area, where faces are up to " << face_size
          << " large. They are tied as if they touched. Check Scale and Shift of the meshes, or give the "
             "Interface a Shift or a Jump if an interference is meant";
    notes.push_back(of_overlap(words.str()).of(interface.name));
  }
  if (turned > least_share_of_sides) {
    words.str("");
    words << "on " << 100 * turned << " % of the tied area the sides meet at more than 45 degrees (up to "
          << largest_angle * 180 / dealii::numbers::PI
          << "): they do not face each other, and the flux is that of neither side. Name the boundaries that "
             "face each other in Source and Destination";
    notes.push_back(of_angle(words.str()).of(interface.name));
  }
}

} // namespace

template <int dim>
NoteList notes_on_sides(const Model<dim> &model)
{
  NoteList notes;
  for (const auto &interface : model.interfaces)
    add_notes_on_sides(*interface, model.communicator, notes);
  return notes;
}

template NoteList notes_on_sides(const Model<2> &);
template NoteList notes_on_sides(const Model<3> &);

} // namespace dovetail
