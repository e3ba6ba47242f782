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

template <int structdim>
void SimplexBasis<structdim>::evaluate(const Point<structdim> &xi, std::vector<double> &values,
                                       std::vector<Tensor<1, structdim>> &gradients,
                                       std::vector<Tensor<2, structdim>> &hessians) const
{
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
