// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Formulas typed by the user: strings in muParser's syntax in x, y, z, t and, where a law depends on them,
// scalars such as the temperature T.

#pragma once

#include <deal.II/base/array_view.h>
#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace dovetail {

/// A list of formulas, one per component ("sin(pi*x); t"), of position, time and scalars.
///
/// A formula means what muParser says, which parses and checks it; its values and exact derivatives come from
/// a tape of elementary operations (tape.h), which muParser does not give. Both values must agree.
///
/// Known besides muParser's own: pi, inf, ln and log (natural), log10, if(a,b,c), min, max, abs, sign, floor,
/// ceil,
/// &&, ||, a ? b : c, and table(argument, x_1, y_1, x_2, y_2, …), the monotone cubic through the pairs,
/// constant outside; all of them in functions(). Derivatives are exact. A component that uses no variable is
/// evaluated once. Copies share nothing that changes.
class Expression
{
public:
  /// Which variables a formula may use: the first @p dim of x, y, z, always t, and the scalars by these
  /// names.
  struct Variables
  {
    unsigned int dim = 3;
    std::vector<std::string> scalars;
  };
  using Scalars = dealii::ArrayView<const double>; ///< their values, in this order

  /// The functions and operators that a formula may use, each with its meaning.
  static const std::vector<std::pair<std::string, std::string>> &functions();
  /// Their names as the evaluator knows them, without operators.
  static std::vector<std::string> names_of_functions();

  /// The constant zero with one component.
  Expression();
  /// Zero with @p n_components.
  explicit Expression(unsigned int n_components);
  /// @throw UserError if a component does not parse or uses an unknown name (the text says which and what is
  /// known). The message does not say where; Section adds that.
  Expression(const std::string &text, const Variables &variables);

  Expression(const Expression &);
  Expression &operator=(const Expression &);
  Expression(Expression &&) noexcept;
  Expression &operator=(Expression &&) noexcept;
  ~Expression();

  unsigned int n_components() const;
  bool depends_on_position() const;
  bool depends_on_time() const;
  bool depends_on_scalars() const;
  bool depends_on_scalar(unsigned int scalar) const;
  bool is_affine_in_scalars() const; ///< whether its derivatives by the scalars depend on none of them
  bool is_zero() const;              ///< every component is the constant 0
  bool is_zero(unsigned int component) const;

  /// @p scalars may be missing if it does not depend on them.
  template <int dim>
  double value(const dealii::Point<dim> &X, double t, unsigned int component = 0, Scalars scalars = {}) const;

  /// Gradient; where that is not finite (the edge of a root) a five-point central difference with a step of
  /// 1e-3 @p length, a typical length of the body.
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

  /// By one of the scalars, and by two, which may be the same.
  template <int dim>
  double derivative(const dealii::Point<dim> &X, double t, unsigned int component, Scalars scalars,
                    unsigned int scalar) const;
  template <int dim>
  double second_derivative(const dealii::Point<dim> &X, double t, unsigned int component, Scalars scalars,
                           unsigned int first, unsigned int second) const;
  /// By the scalars of these numbers, one after the other: of any order.
  template <int dim>
  double derivative(const dealii::Point<dim> &X, double t, unsigned int component, Scalars scalars,
                    const std::vector<unsigned int> &by_scalars) const;

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation;
};

} // namespace dovetail
