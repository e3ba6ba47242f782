// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/curved_cube.h>

#include <deal.II/base/geometry_info.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_q.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace dovetail {

namespace {

template <int dim>
const dealii::FE_Q<dim> &quadratic()
{
  static const dealii::FE_Q<dim> element(2);
  return element;
}

/// Of its functions, point by point.
template <int dim>
std::vector<std::vector<dealii::Tensor<1, dim>>> gradients_at(const std::vector<dealii::Point<dim>> &points)
{
  std::vector<std::vector<dealii::Tensor<1, dim>>> gradients;
  for (const auto &xi : points) {
    gradients.emplace_back();
    for (unsigned int a = 0; a < quadratic<dim>().n_dofs_per_cell(); ++a)
      gradients.back().push_back(quadratic<dim>().shape_grad(a, xi));
  }
  return gradients;
}

std::vector<unsigned int> pick(const std::vector<unsigned int> &from, const std::vector<unsigned int> &places)
{
  std::vector<unsigned int> picked;
  for (const unsigned int i : places)
    picked.push_back(from[i]);
  std::sort(picked.begin(), picked.end());
  return picked;
}

/// Between which vertices the nodes of FE_Q(2) stand that are no vertices.
template <int dim>
std::vector<std::vector<unsigned int>> vertices_around_further_nodes()
{
  using Cube = dealii::GeometryInfo<dim>;
  std::vector<std::vector<unsigned int>> result;
  for (unsigned int l = 0; dim > 1 && l < Cube::lines_per_cell; ++l)
    result.push_back({Cube::line_to_cell_vertices(l, 0), Cube::line_to_cell_vertices(l, 1)});
  for (unsigned int f = 0; dim == 3 && f < Cube::faces_per_cell; ++f) {
    result.emplace_back();
    for (unsigned int v = 0; v < Cube::vertices_per_face; ++v)
      result.back().push_back(Cube::face_to_cell_vertices(f, v));
  }
  result.emplace_back(Cube::vertices_per_cell);
  std::iota(result.back().begin(), result.back().end(), 0);
  return result;
}

/// Of a cell, by the vertices around them.
template <int dim>
std::map<std::vector<unsigned int>, dealii::Point<3>> further_nodes_by_vertices(const MeshFile &mesh,
                                                                                const std::size_t cell)
{
  const auto around = vertices_around_further_nodes<dim>();
  const std::vector<unsigned int> vertices(mesh.cells.nodes_of(cell),
                                           mesh.cells.nodes_of(cell) + mesh.cells.n_nodes(cell));
  std::map<std::vector<unsigned int>, dealii::Point<3>> nodes;
  for (unsigned int i = 0; i < around.size(); ++i)
    nodes[pick(vertices, around[i])] = mesh.further_nodes[cell * around.size() + i];
  return nodes;
}

} // namespace

template <int structdim>
std::vector<dealii::Point<3>> further_nodes_of(const MeshFile &mesh, const std::size_t cell,
                                               const std::vector<unsigned int> &part)
{
  const auto of_cell = mesh.cells.n_nodes(cell) == 4 ? further_nodes_by_vertices<2>(mesh, cell)
                                                     : further_nodes_by_vertices<3>(mesh, cell);
  std::vector<dealii::Point<3>> nodes;
  for (const auto &around : vertices_around_further_nodes<structdim>())
    nodes.push_back(of_cell.at(pick(part, around)));
  return nodes;
}

template <int structdim>
CurvedCube<structdim>::CurvedCube(const MeshFile &mesh, const std::size_t cell,
                                  const std::vector<unsigned int> &part)
{
  for (const unsigned int v : part)
    nodes.push_back(mesh.nodes[v]);
  const auto further = further_nodes_of<structdim>(mesh, cell, part);
  nodes.insert(nodes.end(), further.begin(), further.end());
}

template <int structdim>
std::array<dealii::Tensor<1, 3>, structdim>
CurvedCube<structdim>::jacobian(const std::vector<dealii::Tensor<1, structdim>> &gradients) const
{
  std::array<dealii::Tensor<1, 3>, structdim> columns;
  for (unsigned int a = 0; a < nodes.size(); ++a)
    for (unsigned int d = 0; d < structdim; ++d)
      columns[d] += gradients[a][d] * nodes[a];
  return columns;
}

template <int structdim>
double CurvedCube<structdim>::measure() const
{
  static const dealii::QGauss<structdim> gauss(4);
  static const auto gradients = gradients_at(gauss.get_points());
  double result = 0;
  for (unsigned int q = 0; q < gauss.size(); ++q) {
    const auto J = jacobian(gradients[q]);
    double size;
    if constexpr (structdim == 1)
      size = J[0].norm();
    else if constexpr (structdim == 2)
      size = dealii::cross_product_3d(J[0], J[1]).norm();
    else
      size = std::abs(dealii::cross_product_3d(J[0], J[1]) * J[2]);
    result += gauss.weight(q) * size;
  }
  return result;
}

template <int structdim>
bool CurvedCube<structdim>::is_turned_over() const
{
  static const auto gradients = gradients_at(quadratic<structdim>().get_unit_support_points());
  return std::any_of(gradients.begin(), gradients.end(), [this](const auto &gradients_at_node) {
    const auto J = jacobian(gradients_at_node);
    if constexpr (structdim == 2)
      return dealii::cross_product_3d(J[0], J[1])[2] <= 0;
    else
      return dealii::cross_product_3d(J[0], J[1]) * J[2] <= 0;
  });
}

template std::vector<dealii::Point<3>> further_nodes_of<2>(const MeshFile &, std::size_t,
                                                           const std::vector<unsigned int> &);
template std::vector<dealii::Point<3>> further_nodes_of<3>(const MeshFile &, std::size_t,
                                                           const std::vector<unsigned int> &);
template CurvedCube<1>::CurvedCube(const MeshFile &, std::size_t, const std::vector<unsigned int> &);
template double CurvedCube<1>::measure() const;
template class CurvedCube<2>;
template class CurvedCube<3>;

} // namespace dovetail
