// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/quadrature.h>
#include <dovetail/pairing/pairing.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/timer.h>

#include <algorithm>
#include <numeric>

namespace dovetail {

namespace {

using dealii::Utilities::MPI::max;
using dealii::Utilities::MPI::sum;

/// Of the faces of this rank: their area in the plane of the mesh, and with the measure.
template <int dim>
std::array<double, 2> areas_of(const SideFaces<dim> &side, const Measure<dim> &measure)
{
  const auto rule =
      gauss_rule<dim - 1>(side.shape.is_triangle() ? dealii::ReferenceCells::Triangle
                                                   : dealii::ReferenceCells::get_hypercube<dim - 1>(),
                          side.shape.degree() + 1);
  std::array<double, 2> areas{};
  for (unsigned int face = 0; face < side.faces.size(); ++face)
    for (unsigned int q = 0; q < rule.size(); ++q) {
      const SurfacePoint<dim> point = side.shape.evaluate(side.nodes(face), rule.point(q));
      const double JxW = rule.weight(q) * side.shape.normal(side.faces[face].face_no, point).norm();
      areas[0] += JxW;
      areas[1] += JxW * measure(point.X - side.shift);
    }
  return areas;
}

/// The cells of the points' own faces, as fetch_shapes gives those of the partner.
template <int dim>
PartnerShapes<dim> own_shapes(const Domain<dim> &domain, const FacePoints<dim> &points,
                              const SideFaces<dim> &faces, const unsigned int this_rank,
                              const bool with_nodes)
{
  PartnerShapes<dim> result;
  result.inverse_jacobians.resize(points.size());
  ShapeEvaluator<dim> shapes(domain);
  unsigned int current = dealii::numbers::invalid_unsigned_int;
  for (unsigned int q = 0; q < points.size(); ++q) {
    if (points.face[q] != current) {
      current = points.face[q];
      result.cells.push_back(cell_behind(domain, faces, current, this_rank, with_nodes, shapes));
    }
    result.cell_of_point.push_back(result.cells.size() - 1);
    if (points.matches[q].found)
      result.inverse_jacobians[q] = shapes.inverse_jacobian(points.unit_points[q]);
  }
  return result;
}

} // namespace

template <int dim>
bool InterfaceSide<dim>::overlaps(const InterfaceSide &other) const
{
  const auto share = [](const auto &one, const auto &two) {
    return std::any_of(one.begin(), one.end(), [&](const auto id) { return two.count(id) > 0; });
  };
  return domain == other.domain && share(boundary_ids, other.boundary_ids) &&
         (material_ids.empty() || other.material_ids.empty() || share(material_ids, other.material_ids));
}

template <int dim>
SideFaces<dim> faces_of(const InterfaceSide<dim> &side)
{
  const Domain<dim> &domain = *side.domain;
  return {domain.mesh(), domain.mapping(), domain.mapping_degree(),
          [&](const auto &cell, const auto id) { return side.belongs(cell, id); }, side.shift};
}

template <int dim>
std::vector<typename dealii::Triangulation<dim>::active_cell_iterator>
cells_behind(const InterfaceSide<dim> &side)
{
  std::vector<typename dealii::Triangulation<dim>::active_cell_iterator> cells;
  for (const auto &[cell, face, id] : side.domain->boundary_faces())
    if (cell->is_locally_owned() && side.belongs(cell, id))
      cells.push_back(cell);
  return cells;
}

template <int dim>
Pairing<dim>::Pairing(const std::array<InterfaceSide<dim>, 2> &sides, const Options &options,
                      const std::array<bool, 2> &with_cover, const MPI_Comm &communicator)
    : extension(options.gap_extension), shift(sides[source].shift - sides[destination].shift),
      n_shapes{{sides[source].domain->layout().n_shapes(), sides[destination].domain->layout().n_shapes()}}
{
  for (const unsigned int side : {source, destination})
    present_shapes.emplace_back(*sides[side].domain);
  for (const unsigned int side : {source, destination}) {
    const SideFaces<dim> faces = faces_of(sides[side]);
    const auto areas = areas_of(faces, sides[side].domain->measure);
    account.area[side] = sum(areas[1], communicator);
    const double n_faces = sum(static_cast<double>(faces.faces.size()), communicator);
    face_size[side] = std::pow(sum(areas[0], communicator) / std::max(n_faces, 1.), 1. / (dim - 1));
  }

  const double factor = options.integrate_on[source] && options.integrate_on[destination] ? 0.5 : 1;
  for (const unsigned int own : {source, destination})
    if (options.integrate_on[own])
      integrate(sides, own, options, factor, communicator);
  account.n_points = sum(static_cast<unsigned long>(weights.size()), communicator);

  // how much of a side without points is covered: all of it if its share of the partner's points says so
  for (const unsigned int own : {source, destination}) {
    if (options.integrate_on[own])
      continue;
    if (!with_cover[own] && account.is_complete(own))
      account.covered[own] = account.area[own];
    else {
      const SideFaces<dim> faces = faces_of(sides[own]);
      const FaceLocator<dim> locator(faces_of(sides[1 - own]), options.search_radius, options.least_reach,
                                     communicator);
      count(find_points(sides, own, options, faces, locator), faces, own, communicator);
      all_work += locator.work();
    }
  }
  account.n_uncovered = sum(static_cast<unsigned long>(uncovered.size()), communicator);
}

template <int dim>
FacePoints<dim> Pairing<dim>::find_points(const std::array<InterfaceSide<dim>, 2> &sides,
                                          const unsigned int own, const Options &options,
                                          const SideFaces<dim> &own_faces,
                                          const FaceLocator<dim> &locator) const
{
  FacePoints<dim> result = find_flat_points(sides, own, options, own_faces, locator);
  for (unsigned int q = 0; q < result.size(); ++q)
    result.JxW[q] *= sides[own].domain->measure(result.queries[q].X - own_faces.shift);
  return result;
}

/// With their weights in the plane of the mesh.
template <int dim>
FacePoints<dim> Pairing<dim>::find_flat_points(const std::array<InterfaceSide<dim>, 2> &sides,
                                               const unsigned int own, const Options &options,
                                               const SideFaces<dim> &own_faces,
                                               const FaceLocator<dim> &locator) const
{
  const unsigned int partner = 1 - own;
  if (options.quadrature == FaceQuadrature::segments)
    return segments(own_faces, locator, sides[own].domain->degree, sides[partner].domain->degree);
  unsigned int n = options.points_per_direction;
  if (n == 0) {
    // a coarse face needs so many points that the partner's faces, too, hold their share of them
    const unsigned int degree = std::max(sides[source].domain->degree, sides[destination].domain->degree);
    const double ratio = std::max(1., face_size[own] / face_size[partner]);
    n = static_cast<unsigned int>(std::ceil((degree + 1) * ratio - 1e-6)) + 1;
  }
  return mapped_points(own_faces, locator, n);
}

template <int dim>
void Pairing<dim>::count(const FacePoints<dim> &points, const SideFaces<dim> &faces, const unsigned int own,
                         const MPI_Comm &communicator)
{
  double open = 0;
  for (unsigned int q = 0; q < points.size(); ++q) {
    const auto &match = points.matches[q];
    if (!match.found) {
      open += points.JxW[q];
      uncovered.push_back({own, points.queries[q].X - faces.shift, match.distance, match.angle});
    }
  }
  account.covered[own] = account.area[own] - sum(open, communicator);

  for (unsigned int q = 0, end; q < points.size(); q = end) {
    typename Cover<dim>::Face face;
    double area = 0, covered_area = 0;
    for (end = q; end < points.size() && points.face[end] == points.face[q]; ++end) {
      area += points.JxW[end];
      if (points.matches[end].found) {
        covered_area += points.JxW[end];
        face.unit_points.push_back(points.unit_points[end]);
        face.N.push_back(points.queries[end].N);
        face.JxW.push_back(points.JxW[end]);
      }
    }
    if (covered_area == 0)
      continue;
    face.share = covered_area / area;
    if (face.share == 1)
      face = {1., {}, {}, {}};
    const auto &found_face = faces.faces[points.face[q]];
    cover[own].emplace(std::make_pair(found_face.cell->active_cell_index(), found_face.face_no),
                       std::move(face));
  }
}

template <int dim>
void Pairing<dim>::integrate(const std::array<InterfaceSide<dim>, 2> &sides, const unsigned int own,
                             const Options &options, const double factor, const MPI_Comm &communicator)
{
  const unsigned int partner = 1 - own;
  dealii::Timer timer;
  const SideFaces<dim> faces = faces_of(sides[own]);
  const FaceLocator<dim> locator(faces_of(sides[partner]), options.search_radius, options.least_reach,
                                 communicator);
  const FacePoints<dim> face_points = find_points(sides, own, options, faces, locator);
  search_seconds += timer.wall_time();
  std::array<PartnerShapes<dim>, 2> shapes;
  shapes[own] = own_shapes(*sides[own].domain, face_points, faces,
                           dealii::Utilities::MPI::this_mpi_process(communicator), options.with_bridges);
  shapes[partner] =
      fetch_shapes(*sides[partner].domain, locator, face_points.matches, options.with_bridges, communicator);
  all_work += locator.work();
  count(face_points, faces, own, communicator);

  // the points with a partner, sorted by the two cells behind them
  std::vector<unsigned int> order;
  double covered_partner = 0, gap = 0, angle = 0;
  for (unsigned int q = 0; q < face_points.size(); ++q)
    if (const auto &match = face_points.matches[q]; match.found) {
      order.push_back(q);
      covered_partner += face_points.JxW[q] / std::abs(face_points.queries[q].N * match.N);
      gap = std::max(gap, match.distance);
      angle = std::max(angle, match.angle);
    }
  const auto cells_behind = [&](const unsigned int q) {
    return std::make_pair(shapes[own].cell_of_point[q], shapes[partner].cell_of_point[q]);
  };
  std::stable_sort(order.begin(), order.end(), [&](const unsigned int p, const unsigned int q) {
    return cells_behind(p) < cells_behind(q);
  });
  account.n_segments += sum(face_points.n_segments, communicator);
  account.largest_gap = std::max(account.largest_gap, max(gap, communicator));
  account.largest_angle = std::max(account.largest_angle, max(angle, communicator));
  if (!options.integrate_on[partner]) // up to the angle and what counts twice where that is large
    account.covered[partner] = std::min(account.area[partner], sum(covered_partner, communicator));

  append(sides, own, factor, face_points, shapes, order);
}

/// The points of @p order with what is known of them, as they lie one behind the other, and their groups.
template <int dim>
void Pairing<dim>::append(const std::array<InterfaceSide<dim>, 2> &sides, const unsigned int own,
                          const double factor, const FacePoints<dim> &face_points,
                          const std::array<PartnerShapes<dim>, 2> &shapes,
                          const std::vector<unsigned int> &order)
{
  const unsigned int partner = 1 - own;
  const unsigned int first_point = weights.size();
  const std::array<unsigned int, 2> first_cell = {{static_cast<unsigned int>(cells[source].size()),
                                                   static_cast<unsigned int>(cells[destination].size())}};
  for (const unsigned int side : {source, destination})
    cells[side].insert(cells[side].end(), shapes[side].cells.begin(), shapes[side].cells.end());
  std::vector<unsigned int> position(face_points.size(), dealii::numbers::invalid_unsigned_int);
  for (const unsigned int q : order) {
    const auto &query = face_points.queries[q];
    const auto &match = face_points.matches[q];
    position[q] = weights.size();
    weights.push_back(factor * face_points.JxW[q]);
    points[own].push_back(query.X - sides[own].shift);
    points[partner].push_back(match.X - sides[partner].shift);
    normals[own].push_back(query.N);
    normals[partner].push_back(match.N);
    offsets.push_back(query.X - match.X);
    unit_points[own].push_back(face_points.unit_points[q]);
    unit_points[partner].push_back(match.unit_point);
    for (const unsigned int side : {source, destination})
      inverse_jacobians[side].push_back(shapes[side].inverse_jacobians[q]);
  }
  for (unsigned int i = 0; i < order.size(); ++i) {
    std::array<unsigned int, 2> behind;
    for (const unsigned int side : {source, destination})
      behind[side] = first_cell[side] + shapes[side].cell_of_point[order[i]];
    if (i == 0 || groups.back().cells != behind)
      groups.push_back({first_point + i, first_point + i, behind, own});
    ++groups.back().end;
  }
  for (Piece piece : face_points.pieces)
    if (const unsigned int begin = position[piece.begin]; begin != dealii::numbers::invalid_unsigned_int) {
      piece.end = begin + (piece.end - piece.begin);
      piece.begin = begin;
      for (unsigned int v = 0; v < piece.n_vertices; ++v)
        piece.vertices[v] -= sides[own].shift;
      pieces.push_back(piece);
    }
}

/// Fields with the same shares have the same values.
template <int dim>
void Pairing<dim>::extend(const std::vector<OwnShare> &share_of_field)
{
  own_shares.clear();
  extension_of_field.clear();
  const bool is_extended = extension != GapExtension::none && has_gap();
  for (unsigned int f = 0; is_extended && f < share_of_field.size(); ++f) {
    std::vector<double> shares(n_points());
    for (const Group &group : groups)
      for (unsigned int q = group.begin; q < group.end; ++q)
        shares[q] = share_of_field[f](group.side, q);
    const auto known = std::find(own_shares.begin(), own_shares.end(), shares);
    extension_of_field.push_back(known - own_shares.begin());
    if (known == own_shares.end())
      own_shares.push_back(std::move(shares));
  }
  for (Shapes &shapes : present_shapes)
    shapes.end = 0; // the extended values are others
}

template <int dim>
const typename Pairing<dim>::Group &Pairing<dim>::group_of(const unsigned int q) const
{
  return *std::upper_bound(groups.begin(), groups.end(), q,
                           [](const unsigned int p, const Group &group) { return p < group.end; });
}

template <int dim>
void Pairing<dim>::evaluate_shapes(const unsigned int side, const unsigned int q) const
{
  const Group &group = group_of(q);
  Shapes &shapes = present_shapes[side];
  shapes.begin = group.begin;
  shapes.end = group.end;
  const unsigned int n = n_shapes[side], n_values = (shapes.end - shapes.begin) * n;
  shapes.values.resize(n_values);
  shapes.gradients.resize(n_values);
  for (unsigned int p = shapes.begin, first = 0; p < shapes.end; ++p, first += n)
    shapes.unit_shapes.evaluate(unit_points[side][p], inverse_jacobians[side][p], &shapes.values[first],
                                &shapes.gradients[first]);
  shapes.extended_values.assign(own_shares.size(), shapes.values);
  for (unsigned int k = 0; k < own_shares.size(); ++k)
    for (unsigned int p = shapes.begin, i = 0; p < shapes.end; ++p) {
      const double share = side == group.side ? -own_shares[k][p] : 1 - own_shares[k][p];
      for (const unsigned int end = i + n; i < end; ++i)
        if (share != 0)
          shapes.extended_values[k][i] += share * (shapes.gradients[i] * offsets[p]);
    }
}

namespace {

/// Of a cell's face, the geometric mean of its lengths along it. @param jacobian dX/dxi
template <int dim>
double width(const dealii::Tensor<2, dim> &jacobian, const unsigned int face_no)
{
  double product = 1;
  for (unsigned int d = 0; d < dim; ++d)
    if (d != face_no / 2) {
      dealii::Tensor<1, dim> along;
      for (unsigned int i = 0; i < dim; ++i)
        along[i] = jacobian[i][d];
      product *= along.norm();
    }
  return std::pow(product, 1. / (dim - 1));
}

} // namespace

template <int dim>
std::optional<typename Pairing<dim>::Bridge>
Pairing<dim>::bridge(const unsigned int side, const unsigned int q, const dealii::FiniteElement<dim> &element,
                     const unsigned int first_shape) const
{
  const double small = 0.02; // of the cell
  const CellBehind<dim> &cell = cells[side][group_of(q).cells[side]];
  const dealii::Tensor<1, dim> gap = points[destination][q] - points[source][q] - shift;
  if (cell.nodes.empty() || element.degree < 2 || !element.has_support_points())
    return {};
  const dealii::Tensor<2, dim> jacobian(invert(inverse_jacobians[side][q]));
  const double depth_of_cell = cell.cell_measure / cell.face_measure,
               flatness = std::max(1., width<dim>(jacobian, cell.face_no) / depth_of_cell);
  if (gap.norm() > small * depth_of_cell * std::pow(flatness, element.degree))
    return {};
  const dealii::Point<dim> &X = points[side][q];
  const dealii::Tensor<1, dim> into_cell =
      -jacobian * dealii::GeometryInfo<dim>::unit_normal_vector[cell.face_no];
  const dealii::Tensor<1, dim> *by_X = gradients(side, q) + first_shape;
  Bridge result;
  dealii::Tensor<1, dim> d;
  for (unsigned int k = 0; k < element.n_dofs_per_cell(); ++k) {
    const double coordinate = element.unit_support_point(k)[cell.face_no / 2],
                 depth = cell.face_no % 2 == 0 ? coordinate : 1 - coordinate;
    result.weights.push_back(depth == 0 ? 0 : (1 - depth) * (by_X[k] * into_cell));
    d += result.weights[k] * (cell.nodes[first_shape + k] - X);
  }
  const double factor = (gap * normals[source][q]) / (d * normals[source][q]);
  for (double &weight : result.weights) {
    weight *= factor;
    result.share += weight;
  }
  result.along_face = gap - factor * d;
  return result;
}

/// Up to rounding.
template <int dim>
bool Pairing<dim>::has_gap() const
{
  return account.largest_gap > 1e-13 * std::min(face_size[source], face_size[destination]);
}

template SideFaces<2> faces_of(const InterfaceSide<2> &);
template SideFaces<3> faces_of(const InterfaceSide<3> &);
template std::vector<dealii::Triangulation<2>::active_cell_iterator> cells_behind(const InterfaceSide<2> &);
template std::vector<dealii::Triangulation<3>::active_cell_iterator> cells_behind(const InterfaceSide<3> &);
template struct InterfaceSide<2>;
template struct InterfaceSide<3>;
template class Pairing<2>;
template class Pairing<3>;

} // namespace dovetail
