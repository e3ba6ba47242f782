// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/interface_point.h>
#include <dovetail/output/interface_surface.h>

#include <deal.II/base/geometry_info.h>
#include <deal.II/grid/reference_cell.h>

#include <numeric>

namespace dovetail {

namespace {

constexpr unsigned int largest_rule = 64;

template <int dim>
constexpr unsigned int n_vertices = dealii::GeometryInfo<dim - 1>::vertices_per_cell; ///< of a patch

/// A face of the side that is shown.
template <int dim>
struct Face
{
  typename dealii::Triangulation<dim>::active_cell_iterator cell;
  unsigned int face_no;
};

/// The faces behind Pairing::cells of the integrated side, in the same order.
template <int dim>
std::vector<Face<dim>> faces_of(const InterfaceSide<dim> &side)
{
  std::vector<Face<dim>> faces;
  for (const auto &cell : side.domain->mesh().active_cell_iterators())
    if (cell->is_locally_owned() && cell->at_boundary())
      for (const unsigned int face : cell->face_indices())
        if (cell->face(face)->at_boundary() && side.boundary_ids.count(cell->face(face)->boundary_id()) > 0)
          faces.push_back({cell, face});
  return faces;
}

/// The directions of the reference cell along a face.
template <int dim>
std::array<unsigned int, dim - 1> directions_along(const unsigned int face_no)
{
  std::array<unsigned int, dim - 1> result;
  for (unsigned int d = 0, i = 0; d < dim; ++d)
    if (d != face_no / 2)
      result[i++] = d;
  return result;
}

/// The number of points per direction of the Gauss rule to which all these points of faces belong; 0: there
/// is none.
template <int dim>
unsigned int find_gauss_rule(const std::vector<Face<dim>> &faces,
                             const std::vector<unsigned int> &face_of_point,
                             const std::vector<dealii::Point<dim>> &unit_points)
{
  for (unsigned int n = 1; n <= largest_rule; ++n) {
    const auto gauss = dealii::QGauss<1>(n).get_points();
    const auto has = [&gauss](const double x) {
      return std::any_of(gauss.begin(), gauss.end(),
                         [x](const auto &p) { return std::abs(p[0] - x) < 1e-6; });
    };
    bool fits = true;
    for (unsigned int p = 0; p < unit_points.size() && fits; ++p)
      for (const unsigned int d : directions_along<dim>(faces[face_of_point[p]].face_no))
        fits = fits && has(unit_points[p][d]);
    if (fits)
      return n;
  }
  return 0;
}

/// The share [begin, end] that the Gauss point at x has of the unit interval: its weight.
std::array<double, 2> share_of(const double x, const dealii::QGauss<1> &rule)
{
  unsigned int nearest = 0;
  for (unsigned int i = 1; i < rule.size(); ++i)
    if (std::abs(rule.point(i)[0] - x) < std::abs(rule.point(nearest)[0] - x))
      nearest = i;
  const double begin = std::accumulate(rule.get_weights().begin(), rule.get_weights().begin() + nearest, 0.);
  return {{begin, begin + rule.weight(nearest)}};
}

/// An edge or square of this measure, perpendicular to N, around X.
template <int dim>
void set_square(const dealii::Point<dim> &X, const dealii::Tensor<1, dim> &N, const double measure,
                dealii::DataOutBase::Patch<dim - 1, dim> &patch)
{
  const double half = std::pow(measure, 1. / (dim - 1)) / 2;
  if constexpr (dim == 2) {
    const dealii::Tensor<1, dim> tangent = dealii::cross_product_2d(N);
    patch.vertices[0] = X - half * tangent;
    patch.vertices[1] = X + half * tangent;
  } else {
    dealii::Tensor<1, dim> e;
    e[std::abs(N[0]) < 0.5 ? 0 : 1] = 1;
    dealii::Tensor<1, dim> s = dealii::cross_product_3d(N, e);
    s /= s.norm();
    const dealii::Tensor<1, dim> t = dealii::cross_product_3d(N, s);
    for (unsigned int v = 0; v < 4; ++v)
      patch.vertices[v] = X + half * ((v % 2 == 0 ? -1. : 1.) * s + (v / 2 == 0 ? -1. : 1.) * t);
  }
}

/// The part of a face that belongs to a Gauss point: they tile it.
template <int dim>
void set_share_of_face(const dealii::Mapping<dim> &mapping, const Face<dim> &face,
                       const dealii::Point<dim> &unit_point, const unsigned int n_gauss,
                       dealii::DataOutBase::Patch<dim - 1, dim> &patch)
{
  const dealii::QGauss<1> rule(n_gauss);
  const auto along = directions_along<dim>(face.face_no);
  for (unsigned int v = 0; v < n_vertices<dim>; ++v) {
    dealii::Point<dim> corner;
    corner[face.face_no / 2] = face.face_no % 2;
    for (unsigned int i = 0; i < dim - 1; ++i)
      corner[along[i]] = share_of(unit_point[along[i]], rule)[(v >> i) & 1];
    patch.vertices[v] = mapping.transform_unit_to_real_cell(face.cell, corner);
  }
}

} // namespace

template <int dim>
InterfaceSurface<dim>::InterfaceSurface(const Interface<dim> &interface)
    : interface(interface), own(interface.tie().integrates_on()[source] ? source : destination)
{
  const Pairing<dim> &pairing = interface.pairing();
  const InterfaceSide<dim> &side = interface.sides[own];
  const auto faces = faces_of(side);

  // with points on both sides those of the destination come last: their cells follow those of the own faces
  std::vector<unsigned int> face_of_patch;
  std::vector<dealii::Point<dim>> unit_points;
  for (const auto &group : pairing.groups)
    if (const unsigned int face = group.cells[own]; face < faces.size())
      for (unsigned int q = group.begin; q < group.end; ++q) {
        point_of_patch.push_back(q);
        face_of_patch.push_back(face);
        unit_points.push_back(
            side.domain->mapping().transform_real_to_unit_cell(faces[face].cell, pairing.X(own, q)));
      }

  const unsigned int n_gauss = find_gauss_rule(faces, face_of_patch, unit_points);
  const bool has_both = interface.tie().integrates_on()[1 - own]; // each with half the weight
  patches.resize(point_of_patch.size());
  for (unsigned int p = 0; p < patches.size(); ++p) {
    const unsigned int q = point_of_patch[p];
    if (n_gauss > 0)
      set_share_of_face(side.domain->mapping(), faces[face_of_patch[p]], unit_points[p], n_gauss, patches[p]);
    else
      set_square(pairing.X(own, q), pairing.N(own, q), (has_both ? 2 : 1) * pairing.weight(q), patches[p]);
    patches[p].patch_index = p;
    patches[p].reference_cell = dealii::ReferenceCells::get_hypercube<dim - 1>();
    patches[p].n_subdivisions = 1;
  }
}

template <int dim>
void InterfaceSurface<dim>::update(const Vector &solution, const double t)
{
  const Pairing<dim> &pairing = interface.pairing();
  InterfacePoint<dim> point(interface, t);
  std::vector<double> data;
  unsigned int p = 0;
  point.for_each(solution, [&](const unsigned int q) {
    if (p == patches.size() || point_of_patch[p] != q)
      return; // a point of the other side
    data.clear();
    for (const auto &of_field : point.fields) {
      data.insert(data.end(), of_field.jump.begin(), of_field.jump.end());
      data.insert(data.end(), of_field.numerical_flux.begin(), of_field.numerical_flux.end());
    }
    data.push_back(pairing.X(source, q).distance(pairing.X(destination, q)));
    for (unsigned int d = 0; d < dim; ++d)
      data.push_back(pairing.N(own, q)[d]);

    patches[p].data.reinit(data.size(), n_vertices<dim>);
    for (unsigned int i = 0; i < data.size(); ++i)
      for (unsigned int v = 0; v < n_vertices<dim>; ++v)
        patches[p].data(i, v) = data[i];
    ++p;
  });
}

template <int dim>
std::vector<std::string> InterfaceSurface<dim>::get_dataset_names() const
{
  std::vector<std::string> names;
  for (const TiedField &field : interface.fields) {
    names.insert(names.end(), field.n_components, "jump " + field.name);
    names.insert(names.end(), field.n_components, "flux " + field.name);
  }
  names.push_back("gap");
  names.insert(names.end(), dim, "normal");
  return names;
}

template class InterfaceSurface<2>;
template class InterfaceSurface<3>;

} // namespace dovetail
