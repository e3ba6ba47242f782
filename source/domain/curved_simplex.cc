// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/curved_simplex.h>
#include <dovetail/domain/quadrature.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

using dealii::Tensor;

CurvedSimplex::CurvedSimplex(const MeshFile &mesh, const std::size_t cell,
                             const std::vector<unsigned int> &part)
{
  for (const unsigned int node : part)
    vertices.push_back(mesh.nodes[node]);
  if (mesh.further_nodes.empty())
    return;

  const unsigned int n = mesh.cells.n_nodes(cell);
  std::map<std::pair<unsigned int, unsigned int>, Tensor<1, 3>> node_on_edge;
  for (unsigned int i = 0, e = cell * n * (n - 1) / 2; i < n; ++i)
    for (unsigned int j = i + 1; j < n; ++j)
      node_on_edge[std::minmax(mesh.cells.nodes_of(cell)[i], mesh.cells.nodes_of(cell)[j])] =
          mesh.further_nodes[e++];
  for (unsigned int i = 0; i < part.size(); ++i)
    for (unsigned int j = i + 1; j < part.size(); ++j)
      bulges.push_back(node_on_edge.at(std::minmax(part[i], part[j])) - 0.5 * (vertices[i] + vertices[j]));
}

std::vector<Tensor<1, 3>> CurvedSimplex::jacobian(const std::vector<double> &l) const
{
  const unsigned int n = vertices.size();
  std::vector<Tensor<1, 3>> by_coordinate = vertices; // dX/dl_i
  for (unsigned int i = 0, e = 0; i < n && !bulges.empty(); ++i)
    for (unsigned int j = i + 1; j < n; ++j, ++e) {
      by_coordinate[i] += 4 * l[j] * bulges[e];
      by_coordinate[j] += 4 * l[i] * bulges[e];
    }
  for (unsigned int d = n - 1; d > 0; --d)
    by_coordinate[d] -= by_coordinate[0];
  by_coordinate.erase(by_coordinate.begin());
  return by_coordinate;
}

double CurvedSimplex::determinant(const std::vector<double> &l) const
{
  const auto J = jacobian(l);
  return J.size() == 2 ? dealii::cross_product_3d(J[0], J[1])[2]
                       : dealii::cross_product_3d(J[0], J[1]) * J[2];
}

bool CurvedSimplex::is_turned_over() const
{
  const unsigned int n = vertices.size();
  if (determinant(std::vector<double>(n, 1. / n)) <= 0)
    return true;
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int j = i; j < n; ++j) {
      std::vector<double> l(n);
      l[i] += 0.5;
      l[j] += 0.5;
      if (determinant(l) <= 0)
        return true;
    }
  return false;
}

template <int dim>
double CurvedSimplex::integrate() const
{
  static const auto one_point = gauss_rule<dim>(dealii::ReferenceCells::get_simplex<dim>(), 1);
  static const auto several = gauss_rule<dim>(dealii::ReferenceCells::get_simplex<dim>(), 4);
  const auto &gauss = bulges.empty() ? one_point : several;
  double result = 0;
  for (unsigned int q = 0; q < gauss.size(); ++q) {
    std::vector<double> l = {1};
    for (unsigned int d = 0; d < dim; ++d) {
      l.push_back(gauss.point(q)[d]);
      l[0] -= gauss.point(q)[d];
    }
    const auto J = jacobian(l);
    if constexpr (dim == 1)
      result += gauss.weight(q) * J[0].norm();
    else if constexpr (dim == 2)
      result += gauss.weight(q) * dealii::cross_product_3d(J[0], J[1]).norm();
    else
      result += gauss.weight(q) * std::abs(dealii::cross_product_3d(J[0], J[1]) * J[2]);
  }
  return result;
}

double CurvedSimplex::measure() const
{
  return vertices.size() == 2 ? integrate<1>() : vertices.size() == 3 ? integrate<2>() : integrate<3>();
}

} // namespace dovetail
