// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The mapped shape of one cell or face as a polynomial through its mapping's support points.

#pragma once

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>
#include <deal.II/base/tensor_product_polynomials.h>

#include <array>
#include <vector>

namespace dovetail {

/// Values and derivatives of the tensor-product Lagrange basis of a degree on Gauss-Lobatto points, in
/// lexicographic order. One object serves all cells or faces of a domain; structdim is the dimension of the
/// reference cell.
///
/// The mapped position is X(xi) = sum_a basis_a(xi) node_a: exactly deal.II's MappingQ of that degree, whose
/// faces depend on the support points of the face only.
template <int structdim>
class LagrangeBasis
{
public:
  explicit LagrangeBasis(unsigned int degree);

  unsigned int size() const; ///< (degree + 1)^structdim
  const std::vector<dealii::Point<structdim>> &support_points() const;

  /// Fill the arrays that are not empty (each must then have size() entries).
  void evaluate(const dealii::Point<structdim> &xi, std::vector<double> &values,
                std::vector<dealii::Tensor<1, structdim>> &gradients,
                std::vector<dealii::Tensor<2, structdim>> &hessians) const;

private:
  std::vector<dealii::Point<structdim>> points;
  dealii::TensorProductPolynomials<structdim> polynomials;
};

/// The same for triangles and tetrahedra: the Lagrange basis of FE_SimplexP and its support points, of any
/// degree that deal.II has.
template <int structdim>
class SimplexBasis
{
public:
  explicit SimplexBasis(unsigned int degree);

  unsigned int size() const { return points.size(); }
  const std::vector<dealii::Point<structdim>> &support_points() const { return points; }

  /// Fill the arrays that are not empty (each must then have size() entries).
  void evaluate(const dealii::Point<structdim> &xi, std::vector<double> &values,
                std::vector<dealii::Tensor<1, structdim>> &gradients,
                std::vector<dealii::Tensor<2, structdim>> &hessians) const;

private:
  unsigned int degree;
  std::vector<dealii::Point<structdim>> points;
  std::vector<std::array<unsigned int, structdim + 1>> steps; ///< by node: degree times its lambda_d
};

} // namespace dovetail
