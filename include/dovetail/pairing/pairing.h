// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The geometry of an interface: which point of one side faces which point of the other.
//
// Signs, once for all: N is the outward normal of each side, the jump is [B] = B_src - map(B_dst), the mean
// flux is {A} = w_src A_src.N_src - w_dst A_dst.N_dst.

#pragma once

#include <dovetail/pairing/face_points.h>
#include <dovetail/pairing/partner_shapes.h>

#include <array>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <vector>

namespace dovetail {

/// The two sides of an interface, as array indices.
inline constexpr unsigned int source = 0, destination = 1;

template <int dim>
struct InterfaceSide
{
  const Domain<dim> *domain = nullptr;
  std::set<dealii::types::boundary_id> boundary_ids = {};
  std::set<dealii::types::material_id> material_ids = {}; ///< of the cells behind its faces; empty: all
  /// Partners are sought at X + shift (the faces of faces_of() and the queries to a FaceLocator); all else
  /// has the true X.
  dealii::Tensor<1, dim> shift = {};
  /// For each field, the other sides that tie it on the same domain, the one of the same interface, too.
  std::map<std::string, std::vector<const InterfaceSide *>> others = {};
  std::map<std::string, std::vector<const InterfaceSide *>> strong_others = {}; ///< those that take unknowns

  /// Whether a boundary face of the domain, of a cell and with an id, is part of the side.
  bool belongs(const typename dealii::Triangulation<dim>::active_cell_iterator &cell,
               const dealii::types::boundary_id id) const
  {
    return boundary_ids.count(id) > 0 &&
           (material_ids.empty() || material_ids.count(cell->material_id()) > 0);
  }
  /// Whether two sides may have a face in common, judged by their ids.
  bool overlaps(const InterfaceSide &other) const;
};

/// The faces of a side that this rank owns, moved by its shift.
template <int dim>
SideFaces<dim> faces_of(const InterfaceSide<dim> &side);

/// The cells behind these faces, in their order.
template <int dim>
std::vector<typename dealii::Triangulation<dim>::active_cell_iterator>
cells_behind(const InterfaceSide<dim> &side);

/// What a jump does with the gap between facing points X (own) and X' (partner): with the share s of extend()
/// both fields are extended affinely to the point between them, B(X) + s grad B(X).(X' - X) and B(X') + (1 -
/// s) grad B(X').(X - X'), for solution and test functions, for the solution only, or not at all.
enum class GapExtension { symmetric, trial, none };

/// Where the points of an interface lie: on the common refinement of the faces of both sides, or at the Gauss
/// points of a face (face_points.h).
enum class FaceQuadrature { segments, mapped_points };

/// How much of the two sides faces the other one.
struct Coverage
{
  std::array<double, 2> area = {{0, 0}};
  std::array<double, 2> covered = {{0, 0}};
  unsigned long n_points = 0;
  unsigned long n_segments = 0;
  unsigned long n_uncovered = 0; ///< points without partner of the sides that were looked at
  double largest_gap = 0;
  double largest_angle = 0; ///< between the normals [rad]
  /// Up to what coordinates in mesh files, with six or seven digits, leave uncovered at the rim.
  bool is_complete(const unsigned int side) const { return covered[side] >= (1. - 1e-5) * area[side]; }
};

/// Quadrature points of one or both sides, and for both sides of each point the cell behind it and the shape
/// functions there. Computed once per mesh in material coordinates; a rank holds the points whose own face it
/// owns.
///
/// Points whose two cells are the same form a group, so that their terms are summed before they are
/// scattered.
template <int dim>
class Pairing
{
public:
  struct Options
  {
    FaceQuadrature quadrature = FaceQuadrature::segments;
    std::array<bool, 2> integrate_on = {{true, false}}; ///< sides; both: half the weight each
    unsigned int points_per_direction = 0;              ///< of mapped points; 0: automatic
    double search_radius = 0.2;                         ///< in units of the larger face size
    double least_reach = 0;                             ///< a gap that is tied in any case
    GapExtension gap_extension = GapExtension::symmetric;
    bool with_bridges = false; ///< of small gaps: see Bridge
  };

  struct Group
  {
    unsigned int begin, end;           ///< points
    std::array<unsigned int, 2> cells; ///< indices into cells[side]
    unsigned int side;                 ///< on whose faces the points lie
  };

  using Piece = typename FacePoints<dim>::Piece;

  /// A point without partner.
  struct Uncovered
  {
    unsigned int side;
    dealii::Point<dim> X;
    double distance; ///< to the nearest face within reach; infinity: there is none
    double angle;    ///< [rad]
  };

  /// @p with_cover: the sides of which covered_faces() is needed. Collective.
  Pairing(const std::array<InterfaceSide<dim>, 2> &sides, const Options &options,
          const std::array<bool, 2> &with_cover, const MPI_Comm &communicator);

  /// For each tied field, the share of a gap that the field of the side on whose face the point lies bridges,
  /// 0 to 1; the partner's bridges the rest. Without a gap nobody is asked.
  using OwnShare = std::function<double(unsigned int own, unsigned int q)>;
  void extend(const std::vector<OwnShare> &share_of_field);

  std::array<std::vector<CellBehind<dim>>, 2> cells;
  std::vector<Group> groups;
  std::vector<Piece> pieces; ///< of the sides on which points lie, to be shown
  std::vector<Uncovered> uncovered;

  const typename Cover<dim>::Faces &covered_faces(const unsigned int side) const { return cover[side]; }

  unsigned int n_points() const { return weights.size(); }
  double weight(const unsigned int q) const { return weights[q]; } ///< dA, with the measure
  double gap(const unsigned int q) const                           ///< |X_src + shift - X_dst|
  {
    return (points[source][q] - points[destination][q] + shift).norm();
  }
  /// From the partner of a point to it, with shift.
  const dealii::Tensor<1, dim> &offset(const unsigned int q) const { return offsets[q]; }
  /// Material coordinates, without shift.
  const dealii::Point<dim> &X(const unsigned int side, const unsigned int q) const { return points[side][q]; }
  const dealii::Tensor<1, dim> &N(const unsigned int side, const unsigned int q) const
  {
    return normals[side][q];
  }
  /// Shape functions of all spaces of a side (CellLayout). They are evaluated group by group: the array is
  /// there until those of another group are asked for.
  const double *values(const unsigned int side, const unsigned int q) const
  {
    const Shapes &shapes = shapes_at(side, q);
    return shapes.values.data() + (q - shapes.begin) * n_shapes[side];
  }
  const dealii::Tensor<1, dim> *gradients(const unsigned int side, const unsigned int q) const
  {
    const Shapes &shapes = shapes_at(side, q);
    return shapes.gradients.data() + (q - shapes.begin) * n_shapes[side];
  }
  /// Values with which solution and test functions of a tied field enter the jump; of all spaces, too, and as
  /// long there as these.
  const double *trial(const unsigned int side, const unsigned int q, const unsigned int field) const
  {
    if (own_shares.empty())
      return values(side, q);
    const Shapes &shapes = shapes_at(side, q);
    return shapes.extended_values[extension_of_field[field]].data() + (q - shapes.begin) * n_shapes[side];
  }
  bool is_bridged() const { return !own_shares.empty(); } ///< there is a gap, and fields are extended over it
  /// The share of the gap that the field of the side on whose face the point lies bridges.
  double own_share(const unsigned int q, const unsigned int field) const
  {
    return own_shares.empty() ? 0. : own_shares[extension_of_field[field]][q];
  }
  /// What a field adds to the source's trace B(X') over the whole gap, by a derivative into the cell of a
  /// side in which B(X') stands for the nodes on the face, without those on the opposite face: sum_k
  /// weights_k B_k - share B(X') + along_face.grad B(X') with weights_k ~ (1 - depth_k) dphi_k/dn, where 1 -
  /// depth_k makes the derivative of degree p that of degree p - 1. Unknowns of the destination's face, which
  /// follow the source, ask each other for nothing then. Exact for affine fields.
  struct Bridge
  {
    std::vector<double> weights; ///< by node of the cell
    double share = 0;            ///< their sum
    dealii::Tensor<1, dim> along_face;
  };
  /// For the functions of a space. Nothing if the gap is not small beside the cell, as an error of the
  /// geometry is, if the degree is 1 or the cell is a simplex, or without Options::with_bridges.
  std::optional<Bridge> bridge(unsigned int side, unsigned int q, const dealii::FiniteElement<dim> &element,
                               unsigned int first_shape) const;
  const double *test(const unsigned int side, const unsigned int q, const unsigned int field) const
  {
    return extension == GapExtension::symmetric ? trial(side, q, field) : values(side, q);
  }

  const Coverage &coverage() const { return account; }
  double seconds_of_search() const { return search_seconds; } ///< locating partners, this rank
  const InterfaceWork &work() const { return all_work; }      ///< for the pairing itself

private:
  const Group &group_of(unsigned int q) const;
  bool has_gap() const;
  void integrate(const std::array<InterfaceSide<dim>, 2> &sides, unsigned int own, const Options &options,
                 double factor, const MPI_Comm &communicator);
  FacePoints<dim> find_points(const std::array<InterfaceSide<dim>, 2> &sides, unsigned int own,
                              const Options &options, const SideFaces<dim> &own_faces,
                              const FaceLocator<dim> &locator) const;
  FacePoints<dim> find_flat_points(const std::array<InterfaceSide<dim>, 2> &sides, unsigned int own,
                                   const Options &options, const SideFaces<dim> &own_faces,
                                   const FaceLocator<dim> &locator) const;
  void append(const std::array<InterfaceSide<dim>, 2> &sides, unsigned int own, double factor,
              const FacePoints<dim> &face_points, const std::array<PartnerShapes<dim>, 2> &shapes,
              const std::vector<unsigned int> &order);
  void count(const FacePoints<dim> &points, const SideFaces<dim> &faces, unsigned int own,
             const MPI_Comm &communicator);

  /// Of the points of a group on one side, one after the other.
  struct Shapes
  {
    explicit Shapes(const Domain<dim> &domain) : unit_shapes(domain) {}

    UnitShapes<dim> unit_shapes;
    unsigned int begin = 0, end = 0;
    std::vector<double> values;
    std::vector<dealii::Tensor<1, dim>> gradients;
    std::vector<std::vector<double>> extended_values; ///< by the index in own_shares
  };
  const Shapes &shapes_at(const unsigned int side, const unsigned int q) const
  {
    const Shapes &shapes = present_shapes[side];
    if (q < shapes.begin || q >= shapes.end)
      evaluate_shapes(side, q);
    return shapes;
  }
  void evaluate_shapes(unsigned int side, unsigned int q) const;

  GapExtension extension;
  dealii::Tensor<1, dim> shift;         ///< of the source against the destination
  std::array<unsigned int, 2> n_shapes; ///< at a point
  std::vector<double> weights;
  std::array<std::vector<dealii::Point<dim>>, 2> points;
  std::array<std::vector<dealii::Tensor<1, dim>>, 2> normals;
  std::vector<dealii::Tensor<1, dim>> offsets;
  std::array<std::vector<dealii::Point<dim>>, 2> unit_points; ///< in the cell behind a point
  std::array<std::vector<dealii::Tensor<2, dim>>, 2> inverse_jacobians;
  mutable std::vector<Shapes> present_shapes;   ///< by side
  std::vector<std::vector<double>> own_shares;  ///< by point; empty: nothing is extended
  std::vector<unsigned int> extension_of_field; ///< index of its own shares
  std::array<typename Cover<dim>::Faces, 2> cover;
  std::array<double, 2> face_size; ///< of the sides, mean
  Coverage account;
  double search_seconds = 0;
  InterfaceWork all_work;
};

} // namespace dovetail
