// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The basis of MappingQ: phi_a(xi) = prod_d l_{a_d}(xi_d), with l_i the Lagrange polynomials on Gauss-Lobatto
// points.

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

/// To make them takes a millisecond.
template <int structdim>
struct SimplexElement
{
  const std::vector<Point<structdim>> points;
  const BarycentricPolynomials<structdim> polynomials;

  static const SimplexElement &of(const unsigned int degree)
  {
    static std::map<unsigned int, SimplexElement> made;
    auto found = made.find(degree);
    if (found == made.end())
      found = made.emplace(degree, SimplexElement{FE_SimplexP<structdim>(degree).get_unit_support_points(),
                                                  BarycentricPolynomials<structdim>::get_fe_p_basis(degree)})
                  .first;
    return found->second;
  }
};

} // namespace

template <int structdim>
SimplexBasis<structdim>::SimplexBasis(const unsigned int degree)
    : points(SimplexElement<structdim>::of(degree).points),
      polynomials(SimplexElement<structdim>::of(degree).polynomials)
{
}

namespace {

/// phi = prod_d f_n(lambda_d) with f_n(s) = prod_(k < n) (p s - k)/(n - k) of degree p, for a node that is
/// n/p from zero in lambda_d. lambda_0 falls in all directions, and lambda_(d + 1) is xi_d. For each d, f and
/// its first and second derivative.
template <int structdim>
std::array<std::array<double, 3>, structdim + 1>
factors(const unsigned int degree, const Point<structdim> &node, const Point<structdim> &xi)
{
  std::array<std::array<double, 3>, structdim + 1> result;
  for (unsigned int d = 0; d <= structdim; ++d) {
    double lambda = d == 0 ? 1 : xi[d - 1], at_node = d == 0 ? 1 : node[d - 1];
    for (unsigned int e = 0; e < structdim && d == 0; ++e) {
      lambda -= xi[e];
      at_node -= node[e];
    }
    const auto n = static_cast<unsigned int>(degree * at_node + 0.5);
    auto &f = result[d];
    f = {{1, 0, 0}};
    for (unsigned int k = 0; k < n; ++k) {
      const double slope = degree / (1. * n - k), factor = slope * lambda - k / (1. * n - k);
      f = {{f[0] * factor, f[1] * factor + f[0] * slope, f[2] * factor + 2 * f[1] * slope}};
    }
  }
  return result;
}

} // namespace

/// Cells and faces have degree 1 or 2, for which deal.II's polynomials take ten times as long.
template <int structdim>
void SimplexBasis<structdim>::evaluate(const Point<structdim> &xi, std::vector<double> &values,
                                       std::vector<Tensor<1, structdim>> &gradients,
                                       std::vector<Tensor<2, structdim>> &hessians) const
{
  if (size() <= (structdim + 1) * (structdim + 2) / 2) {
    for (unsigned int a = 0; a < size(); ++a) {
      const auto f = factors(size() == structdim + 1 ? 1U : 2U, points[a], xi);
      const auto derivative = [&](const unsigned int i, const unsigned int j) {
        double product = 1;
        for (unsigned int d = 0; d <= structdim; ++d)
          product *= f[d][(d == i ? 1 : 0) + (d == j ? 1 : 0)];
        return product;
      };
      constexpr unsigned int none = structdim + 1;
      if (!values.empty())
        values[a] = derivative(none, none);
      for (unsigned int i = 1; i <= structdim; ++i) {
        if (!gradients.empty())
          gradients[a][i - 1] = derivative(i, none) - derivative(0, none);
        for (unsigned int j = 1; j <= structdim && !hessians.empty(); ++j)
          hessians[a][i - 1][j - 1] =
              derivative(i, j) - derivative(i, 0) - derivative(0, j) + derivative(0, 0);
      }
    }
    return;
  }
  for (unsigned int a = 0; a < values.size(); ++a)
    values[a] = polynomials.compute_value(a, xi);
  for (unsigned int a = 0; a < gradients.size(); ++a)
    gradients[a] = polynomials.compute_grad(a, xi);
  for (unsigned int a = 0; a < hessians.size(); ++a)
    hessians[a] = polynomials.compute_grad_grad(a, xi);
}

template class SimplexBasis<1>;
template class SimplexBasis<2>;
template class SimplexBasis<3>;
template class LagrangeBasis<1>;
template class LagrangeBasis<2>;
template class LagrangeBasis<3>;

} // namespace dovetail
