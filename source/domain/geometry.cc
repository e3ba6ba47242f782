// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The basis of MappingQ: phi_a(xi) = prod_d l_{a_d}(xi_d), with l_i the Lagrange polynomials on Gauss-Lobatto
// points.

#include <dovetail/compatibility.h>
#include <dovetail/domain/geometry.h>

#include <deal.II/base/exceptions.h>
#include <deal.II/base/polynomial.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_simplex_p.h>

#include <array>
#include <map>

namespace dovetail {

using namespace dealii;

template <int structdim>
LagrangeBasis<structdim>::LagrangeBasis(const unsigned int degree)
    : points(Quadrature<structdim>(QGaussLobatto<1>(degree + 1)).get_points()),
      polynomials(Polynomials::generate_complete_Lagrange_basis(QGaussLobatto<1>(degree + 1).get_points()))
{
  AssertThrow(degree > 0, ExcMessage("A mapping has at least degree 1."));
}

template <int structdim>
unsigned int LagrangeBasis<structdim>::size() const
{
  return points.size();
}

template <int structdim>
const std::vector<Point<structdim>> &LagrangeBasis<structdim>::support_points() const
{
  return points;
}

template <int structdim>
void LagrangeBasis<structdim>::evaluate(const Point<structdim> &xi, std::vector<double> &values,
                                        std::vector<Tensor<1, structdim>> &gradients,
                                        std::vector<Tensor<2, structdim>> &hessians) const
{
  // Empty vectors own no memory, so nothing is allocated here.
  std::vector<Tensor<3, structdim>> no_third_derivatives;
  std::vector<Tensor<4, structdim>> no_fourth_derivatives;
  polynomials.evaluate(xi, values, gradients, hessians, no_third_derivatives, no_fourth_derivatives);
}

namespace {

/// To make an element takes a millisecond.
template <int structdim>
const std::vector<Point<structdim>> &nodes_of_simplex(const unsigned int degree)
{
  AssertThrow(degree <= largest_degree_of_simplices, ExcNotImplemented());
  static std::map<unsigned int, std::vector<Point<structdim>>> made;
  auto found = made.find(degree);
  if (found == made.end())
    found = made.emplace(degree, FE_SimplexP<structdim>(degree).get_unit_support_points()).first;
  return found->second;
}

/// lambda_0 falls in all directions, and lambda_(d + 1) is xi_d.
template <int structdim>
double barycentric(const Point<structdim> &xi, const unsigned int d)
{
  if (d > 0)
    return xi[d - 1];
  double rest = 1;
  for (unsigned int e = 0; e < structdim; ++e)
    rest -= xi[e];
  return rest;
}

} // namespace

template <int structdim>
SimplexBasis<structdim>::SimplexBasis(const unsigned int degree)
    : degree(degree), points(nodes_of_simplex<structdim>(degree))
{
  for (const Point<structdim> &node : points) {
    steps.emplace_back();
    for (unsigned int d = 0; d <= structdim; ++d)
      steps.back()[d] = static_cast<unsigned int>(degree * barycentric(node, d) + 0.5);
  }
}

/// phi = prod_d f_n(lambda_d) with f_n(s) = prod_(k < n) (p s - k)/(k + 1) of degree p, for a node that is
/// n/p from zero in lambda_d. (deal.II's polynomials take ten times as long.)
template <int structdim>
void SimplexBasis<structdim>::evaluate(const Point<structdim> &xi, std::vector<double> &values,
                                       std::vector<Tensor<1, structdim>> &gradients,
                                       std::vector<Tensor<2, structdim>> &hessians) const
{
  // of each lambda_d the f_n, and their first and second derivatives
  std::array<std::array<std::array<double, 3>, largest_degree_of_simplices + 1>, structdim + 1> factor;
  for (unsigned int d = 0; d <= structdim; ++d) {
    const double lambda = barycentric(xi, d);
    factor[d][0] = {{1, 0, 0}};
    for (unsigned int k = 0; k < degree; ++k) {
      const double slope = degree / (k + 1.), next = (degree * lambda - k) / (k + 1.);
      const auto &f = factor[d][k];
      factor[d][k + 1] = {{f[0] * next, f[1] * next + f[0] * slope, f[2] * next + 2 * f[1] * slope}};
    }
  }
  for (unsigned int a = 0; a < size(); ++a) {
    const auto derivative = [&](const unsigned int i, const unsigned int j) {
      double product = 1;
      for (unsigned int d = 0; d <= structdim; ++d)
        product *= factor[d][steps[a][d]][(d == i ? 1 : 0) + (d == j ? 1 : 0)];
      return product;
    };
    constexpr unsigned int none = structdim + 1;
    if (!values.empty())
      values[a] = derivative(none, none);
    for (unsigned int i = 1; i <= structdim; ++i) {
      if (!gradients.empty())
        gradients[a][i - 1] = derivative(i, none) - derivative(0, none);
      for (unsigned int j = 1; j <= structdim && !hessians.empty(); ++j)
        hessians[a][i - 1][j - 1] = derivative(i, j) - derivative(i, 0) - derivative(0, j) + derivative(0, 0);
    }
  }
}

template class SimplexBasis<1>;
template class SimplexBasis<2>;
template class SimplexBasis<3>;
template class LagrangeBasis<1>;
template class LagrangeBasis<2>;
template class LagrangeBasis<3>;

} // namespace dovetail
