// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Formulas typed by the user: muParser strings in x, y, z, t and, where a law depends on it, the temperature
// T.

#pragma once

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// A list of formulas, one per component ("sin(pi*x); t"), of position, time and temperature.
///
/// Known besides muParser's own: pi, inf, ln and log (natural), log10, if(a,b,c), min, max, abs, sign, floor,
/// ceil,
/// &&, ||, a ? b : c. A component that uses no variable is evaluated once. Copies share nothing that changes.
class Expression
{
public:
  /// Which variables a formula may use: the first @p dim of x, y, z, always t, and T if @p with_temperature.
  struct Variables
  {
    unsigned int dim = 3;
    bool with_temperature = false;
  };

  /// The constant zero with one component.
  Expression();
  /// Zero with @p n_components.
  explicit Expression(unsigned int n_components);
  /// @throw UserError if a component does not parse or uses an unknown name (the text says which and what is
  /// known). The message does not say where; Section adds that.
  Expression(const std::string &text, Variables variables);

  Expression(const Expression &);
  Expression &operator=(const Expression &);
  Expression(Expression &&) noexcept;
  Expression &operator=(Expression &&) noexcept;
  ~Expression();

  unsigned int n_components() const;
  bool depends_on_position() const;
  bool depends_on_time() const;
  bool depends_on_temperature() const;
  bool is_zero() const; ///< every component is the constant 0

  template <int dim>
  double value(const dealii::Point<dim> &X, double t, unsigned int component = 0, double T = 0) const;

  /// Gradient: exact if the formula holds arithmetics and smooth functions only. Else by a five-point central
  /// difference with a step of 1e-3 @p length (a typical length of the body), exact to rounding for
  /// polynomials up to degree 4.
  template <int dim>
  dealii::Tensor<1, dim> gradient(const dealii::Point<dim> &X, double t, unsigned int component,
                                  double length) const;

  /// The same at many points at once, which is faster.
  template <int dim>
  void values(const std::vector<dealii::Point<dim>> &X, double t, unsigned int component,
              std::vector<double> &result) const;
  template <int dim>
  void gradients(const std::vector<dealii::Point<dim>> &X, double t, unsigned int component, double length,
                 std::vector<dealii::Tensor<1, dim>> &result) const;

  /// d/dT and d²/dT² by five-point central differences, step 1e-3 |T| + 1e-4; exactly 0 without T.
  template <int dim>
  std::array<double, 2> temperature_derivatives(const dealii::Point<dim> &X, double t, unsigned int component,
                                                double T) const;

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation;
};

} // namespace dovetail
