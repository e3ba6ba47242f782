// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Which face of a boundary, on whichever rank, is closest to a point.

#pragma once

#include <dovetail/pairing/exchange.h>
#include <dovetail/pairing/face_shape.h>

#include <deal.II/base/mpi.h>
#include <deal.II/fe/mapping.h>
#include <deal.II/grid/tria.h>

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

namespace dovetail {

/// The unit in which distances to a face of a size are counted: about 1e-9 of the size, and a power of two,
/// so that rounding is exact and faces of equal size share it.
double distance_quantum(double face_size);

/// (CellId, number of the face): the same for every partition.
using GlobalKey = std::array<unsigned int, 5>;

/// The locally owned faces of one side of an interface, in the order of the cells.
template <int dim>
class SideFaces
{
public:
  struct Face
  {
    typename dealii::Triangulation<dim>::active_cell_iterator cell;
    unsigned int face_no;
    double size;          ///< diameter of the support points
    double rim_tolerance; ///< how far off sideways a point may be: what curved edges leave open
  };

  /// Tells which boundary faces are meant, by the cell and the boundary id.
  using Selection = std::function<bool(const typename dealii::Triangulation<dim>::active_cell_iterator &cell,
                                       dealii::types::boundary_id id)>;

  /// @p mapping_degree: the degree of @p mapping; @p shift: by which the nodes are moved.
  SideFaces(const dealii::Triangulation<dim> &triangulation, const dealii::Mapping<dim> &mapping,
            unsigned int mapping_degree, const Selection &selection,
            const dealii::Tensor<1, dim> &shift = dealii::Tensor<1, dim>());

  FaceShape<dim> shape;
  std::vector<Face> faces;
  std::vector<GlobalKey> keys;
  dealii::Tensor<1, dim> shift;
  const dealii::Point<dim> *nodes(const unsigned int face) const
  {
    return &all_nodes[face * shape.n_nodes()];
  }

private:
  std::vector<dealii::Point<dim>> all_nodes;
};

/// Finds, for points anywhere on any rank, the closest point on the faces of one side of an interface.
///
/// Each rank keeps an r-tree over the boxes of its own faces, inflated by search_radius times the size of the
/// face (size = the diameter of the face's support points). A point is sent only to the ranks whose few
/// coarse boxes hold it; there the closest point on the true mapped face, clamped to the reference face, is
/// found by Newton's method. The winner is chosen by distance rounded to 1e-9 of the face size, then by the
/// global key (CellId, face number), so the result does not depend on the partition. All lengths are compared
/// relative to face sizes. The cost follows the faces and the points, not the cells.
template <int dim>
class FaceLocator
{
public:
  struct Query
  {
    dealii::Point<dim> X;
    dealii::Tensor<1, dim> N; ///< outward normal of the asking side
    double face_size = 0;     ///< of the asking side

    template <typename Archive>
    void serialize(Archive &archive, const unsigned int)
    {
      archive &X &N &face_size;
    }
  };

  struct Match
  {
    bool found = false;
    /// This and all below: of the winner or, if not found, of the nearest candidate within the boxes (if
    /// there is none, the distance is infinite and the face invalid).
    double distance = std::numeric_limits<double>::infinity();
    double angle = 0; ///< between N and minus the partner's outward normal [rad]
    unsigned int rank = dealii::numbers::invalid_unsigned_int;
    unsigned int face = dealii::numbers::invalid_unsigned_int; ///< index into side().faces of that rank
    dealii::Point<dim> unit_point;                             ///< reference coordinates in the cell
    dealii::Point<dim> X;                                      ///< the closest point
    dealii::Tensor<1, dim> N;                                  ///< the partner's outward normal there
    double face_size = 0, rim_tolerance = 0;

    /// All but found, rank, face and sizes, from a point of a face.
    void set(const FaceShape<dim> &shape, unsigned int face_no, const Query &query,
             const SurfacePoint<dim> &point);

    template <typename Archive>
    void serialize(Archive &archive, const unsigned int)
    {
      archive &found &distance &angle &rank &face &unit_point &X &N &face_size &rim_tolerance;
    }
  };

  /// A face of any rank.
  struct NearbyFace
  {
    unsigned int rank, index; ///< index into side().faces of that rank
    unsigned int face_no;
    double size, rim_tolerance;
    GlobalKey key;
    std::vector<dealii::Point<dim>> nodes;

    template <typename Archive>
    void serialize(Archive &archive, const unsigned int)
    {
      archive &rank &index &face_no &size &rim_tolerance &key &nodes;
    }
  };
  struct NearbyFaces
  {
    std::vector<NearbyFace> faces;
    std::vector<std::vector<unsigned int>>
        faces_in_box; ///< for each box positions in faces, in the order of the keys

    template <typename Archive>
    void serialize(Archive &archive, const unsigned int)
    {
      archive &faces &faces_in_box;
    }
  };

  /// @p search_radius: the largest distance, in units of the larger one of the two face sizes, at which a
  /// point still has a partner; @p least_reach: a distance at which it has one in any case. Collective.
  FaceLocator(SideFaces<dim> side, double search_radius, double least_reach, const MPI_Comm &communicator);
  ~FaceLocator();

  const SideFaces<dim> &side() const;

  /// What it has cost so far; those who ask it add to that.
  InterfaceWork &work() const;

  /// Whether the closest point of a face makes it a partner: it must face the point (angle below 90 degrees),
  /// lie within the search radius and, where the closest point is clamped to the rim of the face, be off
  /// sideways by no more than the largest of 1e-6 of the face size, the normal distance (so a curved side of
  /// coarse facets loses no point, and a side that sticks out over its partner is uncovered there) and a
  /// tenth of the height of its curved edges over their chords (two meshes with the same curved rim).
  bool is_partner(const Query &query, const Match &match) const;

  /// A match per query. Collective.
  std::vector<Match> locate(const std::vector<Query> &queries) const;

  /// The faces within reach of other faces with these boxes and sizes. Only faces that some box of this rank
  /// asks for are received. Collective.
  NearbyFaces faces_near(std::vector<dealii::BoundingBox<dim>> boxes, const std::vector<double> &sizes) const;

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation;
};

} // namespace dovetail
