// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A material: at most one law per field, seen by everybody else as one function from State to Response.

#pragma once

#include <dovetail/material/heat_law.h>
#include <dovetail/material/solid_law.h>

#include <deal.II/lac/full_matrix.h>

#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// An unknown of a domain: `displacement` (dim components) or a scalar such as `temperature`.
struct Field
{
  std::string name;
  unsigned int n_components;
  unsigned int first_component; ///< among the components of all fields of the material
};

/// All fields that a material may have, each with as many components as it may have, for the documentation.
const std::vector<Field> &every_field();

/// What a law sees at a point: position, time, and for each component c the trace B_c and its gradient.
template <int dim>
struct State
{
  explicit State(unsigned int n_components) : value(n_components), gradient(n_components) {}
  dealii::Point<dim> X;
  double t = 0;
  std::vector<double> value;
  std::vector<dealii::Tensor<1, dim>> gradient;
};

/// What it answers: for each component c the flux A_c and, for each pair (c, d) at index c * n + d, the
/// derivatives by_gradient[c * n + d][J][L] = dA_cJ / d(grad B_d)_L and by_value[c * n + d][J] = dA_cJ /
/// dB_d.
template <int dim>
struct Response
{
  explicit Response(unsigned int n_components)
      : flux(n_components), by_gradient(n_components * n_components), by_value(n_components * n_components)
  {
  }
  std::vector<dealii::Tensor<1, dim>> flux;
  std::vector<dealii::Tensor<2, dim>> by_gradient;
  std::vector<dealii::Tensor<1, dim>> by_value;
};

/// The laws of one material, embedded into dim dimensions (2D: plane strain). Fields are ordered
/// displacement, temperature; a law that is absent gives no field.
template <int dim>
class Material
{
public:
  Material(const std::string &name, const Section &section);

  const std::string name;
  const std::vector<Field> &fields() const { return all_fields; }
  const Field *find_field(const std::string &field_name) const; ///< nullptr if it has no such field
  unsigned int n_components() const;

  /// @return false if a law is not defined at this state. Derivatives that vanish identically are zero, and
  /// are known in advance from depends().
  bool evaluate(const State<dim> &state, bool with_derivatives, Response<dim> &response) const;

  /// Second derivatives of sum_c w_c . A_c by all of S = (B_0, grad B_0, B_1, grad B_1, …): a symmetric
  /// matrix of size n (1 + dim), component d at rows d (1 + dim) …; zero blocks are zero. Only the components
  /// of fields in which w is not zero are evaluated.
  void curvature(const State<dim> &state, const std::vector<dealii::Tensor<1, dim>> &w,
                 dealii::FullMatrix<double> &result) const;

  /// sigma = P F^T / J, the force per deformed area (P itself for a linear law, which knows no deformed
  /// area); three-dimensional also in plane strain. NaN where the solid law is not defined. @pre The material
  /// has a displacement.
  dealii::Tensor<2, 3> cauchy_stress(const State<dim> &state) const;

  bool depends(unsigned int field,
               unsigned int on_field) const;   ///< whether A of one field depends on another
  bool is_linear(unsigned int field) const;    ///< affine in all fields, so constant derivatives
  bool has_large_strain() const;               ///< of a vector field whose law is nonlinear
  bool is_symmetric(unsigned int field) const; ///< own block of the tangent is symmetric
  bool depends_on_time() const;

  /// "Fourier, linear"
  std::string description(unsigned int field) const;

  /// How often the laws have been asked at points of this rank.
  struct Evaluations
  {
    unsigned long solid = 0, heat = 0;
  };
  const Evaluations &evaluations() const { return n_evaluations; }

private:
  std::vector<Field> all_fields;
  std::unique_ptr<SolidLaw> solid;
  std::unique_ptr<HeatLaw> heat;
  double expansion_coefficient = 0; ///< alpha [1/K]
  double reference_temperature = 0; ///< T0 [K]
  std::string name_of_solid, name_of_heat;
  mutable Evaluations n_evaluations;
};

} // namespace dovetail
