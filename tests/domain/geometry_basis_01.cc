// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// LagrangeBasis through the support points of a cell and of its faces against MappingQ of the same degree, on
// the curved cells of a ball; derivatives against central differences.

#include <dovetail/domain/geometry.h>

#include <deal.II/base/mpi.h>
#include <deal.II/fe/mapping_q.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/tria.h>

#include <cmath>
#include <iostream>

using namespace dealii;

/// Where the coordinates of a cell (codimension 0) or of its last face (codimension 1) are in the cell.
template <int dim, int structdim>
Point<dim> in_cell(const Point<structdim> &xi)
{
  Point<dim> result;
  for (unsigned int d = 0; d < dim; ++d)
    result[d] = d < structdim ? xi[d] : 1.;
  return result;
}

template <int dim, int structdim>
Point<dim> position(const dovetail::LagrangeBasis<structdim> &basis, const std::vector<Point<dim>> &nodes,
                    const Point<structdim> &xi)
{
  std::vector<double> values(basis.size());
  std::vector<Tensor<1, structdim>> gradients;
  std::vector<Tensor<2, structdim>> hessians;
  basis.evaluate(xi, values, gradients, hessians);
  Point<dim> result;
  for (unsigned int i = 0; i < nodes.size(); ++i)
    result += values[i] * nodes[i];
  return result;
}

template <int structdim>
double derivative_error(const dovetail::LagrangeBasis<structdim> &basis, const Point<structdim> &xi)
{
  const unsigned int n = basis.size();
  const double h = 1e-5;
  std::vector<double> values(n), up(n), down(n);
  std::vector<Tensor<1, structdim>> gradients(n), gradients_up(n), gradients_down(n);
  std::vector<Tensor<2, structdim>> hessians(n), none;
  basis.evaluate(xi, values, gradients, hessians);
  double error = 0;
  for (unsigned int d = 0; d < structdim; ++d) {
    basis.evaluate(xi + h * Point<structdim>::unit_vector(d), up, gradients_up, none);
    basis.evaluate(xi + -h * Point<structdim>::unit_vector(d), down, gradients_down, none);
    for (unsigned int i = 0; i < n; ++i) {
      error = std::max(error, std::abs((up[i] - down[i]) / (2 * h) - gradients[i][d]));
      error = std::max(error, ((gradients_up[i] - gradients_down[i]) / (2 * h) - hessians[i][d]).norm());
    }
  }
  return error;
}

template <int dim, int structdim>
void check(const unsigned int degree)
{
  Triangulation<dim> triangulation;
  GridGenerator::hyper_ball(triangulation);
  triangulation.refine_global(1);
  const MappingQ<dim> mapping(degree);
  const dovetail::LagrangeBasis<structdim> basis(degree);

  double error = 0, error_of_derivatives = 0;
  for (const auto &cell : triangulation.active_cell_iterators()) {
    std::vector<Point<dim>> nodes;
    for (const auto &xi : basis.support_points())
      nodes.push_back(mapping.transform_unit_to_real_cell(cell, in_cell<dim>(xi)));
    for (unsigned int i = 0; i < 5; ++i) {
      Point<structdim> xi;
      for (unsigned int d = 0; d < structdim; ++d)
        xi[d] = std::fmod(0.13 + 0.37 * i + 0.23 * d, 1.);
      error = std::max(error,
                       position(basis, nodes, xi)
                           .distance(mapping.transform_unit_to_real_cell(cell, in_cell<dim, structdim>(xi))));
      error_of_derivatives = std::max(error_of_derivatives, derivative_error(basis, xi));
    }
  }
  std::cout << dim << "D, coordinates " << structdim << ", degree " << degree << ": size " << basis.size()
            << ", same position " << (error < 1e-14) << ", derivatives " << (error_of_derivatives < 1e-7)
            << std::endl;
}

int main(int argc, char *argv[])
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const unsigned int degree : {1, 2, 3, 4}) {
    check<2, 1>(degree);
    check<2, 2>(degree);
    check<3, 2>(degree);
    check<3, 3>(degree);
  }
}
