// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// SimplexBasis with its first and second derivatives against deal.II's polynomials on lines, triangles and
// tetrahedra, inside, on an edge and outside.

#include <dovetail/domain/geometry.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/polynomials_barycentric.h>

#include <algorithm>
#include <iostream>

using namespace dealii;

template <int structdim>
void check(const unsigned int degree)
{
  const dovetail::SimplexBasis<structdim> basis(degree);
  const auto polynomials = BarycentricPolynomials<structdim>::get_fe_p_basis(degree);
  std::vector<double> values(basis.size());
  std::vector<Tensor<1, structdim>> gradients(basis.size());
  std::vector<Tensor<2, structdim>> hessians(basis.size());
  double error = 0;
  for (const double first : {0.11, 0., -0.3}) {
    Point<structdim> xi;
    for (unsigned int d = 0; d < structdim; ++d)
      xi[d] = first + 0.17 * d;
    basis.evaluate(xi, values, gradients, hessians);
    for (unsigned int a = 0; a < basis.size(); ++a)
      error = std::max({error, std::abs(values[a] - polynomials.compute_value(a, xi)),
                        (gradients[a] - polynomials.compute_grad(a, xi)).norm(),
                        (hessians[a] - polynomials.compute_grad_grad(a, xi)).norm()});
  }
  std::cout << structdim << " coordinates, degree " << degree << ": size " << basis.size() << ", equal "
            << (error < 1e-14) << std::endl;
}

int main(int argc, char *argv[])
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const unsigned int degree : {1, 2}) {
    check<1>(degree);
    check<2>(degree);
    check<3>(degree);
  }
}
