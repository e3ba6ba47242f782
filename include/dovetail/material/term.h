// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A term: one summand of a domain's balance at a point, from State to Response.

#pragma once

#include <dovetail/material/memory.h>

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>
#include <deal.II/lac/full_matrix.h>

#include <atomic>
#include <limits>
#include <string>
#include <vector>

namespace dovetail {

/// An unknown of a domain: `displacement` (dim components) or a scalar such as `temperature`.
struct Field
{
  std::string name;
  unsigned int n_components;
  unsigned int first_component; ///< among the components of all fields of the material
  std::string law;              ///< what gives a material this field: "solid" for the displacement
  std::string symbol;           ///< of a scalar in formulas: T for the temperature; "" if it has none
  std::string rate = "";        ///< what its rate is called, if a scene may give it: velocity
  int relative_degree = 0;      ///< of its elements against the Degree of the domain: 0 or -1
  bool is_continuous = true;    ///< across faces; if not, its terms have no flux, and it has no trace
  /// Of a constraint on the other fields of the body, as a pressure is of its volume: nothing has to hold it.
  bool is_multiplier = false;

  /// Whether a component of the material is one of its own.
  bool has_component(const unsigned int c) const
  {
    return c >= first_component && c < first_component + n_components;
  }
};

/// What a law sees at a point: position, time, for each component c the trace B_c and its gradient, and what
/// the terms of the material remember there.
template <int dim>
struct State
{
  explicit State(unsigned int n_components) : value(n_components), gradient(n_components) {}
  dealii::Point<dim> X;
  double t = 0;
  std::vector<double> value;
  std::vector<dealii::Tensor<1, dim>> gradient;
  Memory memory; ///< empty if no term remembers anything; of terms one after the other
  /// At this point, the state whose tangent has led here, if derivatives shall have the stress that this
  /// tangent predicts (SolidTerm); its values and gradients alone are known.
  const State *linearised_at = nullptr;

  /// In transient scenes, where a term of the material asks for them, dB_c/dt and d2B_c/dt2 with their
  /// derivatives by B_c, which a time scheme gives. Empty where nobody knows them: on interfaces, in
  /// pictures.
  std::vector<double> rate, second_rate;
  double rate_by_value = 0, second_rate_by_value = 0;
  /// Where a term stores nonlinearly: dB_c/dt = rate_by_value B_c + sum_j past_weight[j] past[j][c] with the
  /// values of the steps before.
  std::vector<double> past_weight;
  std::vector<std::vector<double>> past;
};

/// What it answers: for each component c the flux A_c and the source S_c of the balance
/// @f[ R(\delta) = \int A\cdot\nabla\delta B + S\cdot\delta B - f\cdot\delta B \,dV @f]
/// and, for each pair (c, d) at index c * n + d, their derivatives by_gradient[c * n + d][J][L] = dA_cJ /
/// d(grad B_d)_L, by_value[c * n + d][J] = dA_cJ / dB_d, source_by_gradient[c * n + d][L] = dS_c / d(grad
/// B_d)_L and source_by_value[c * n + d] = dS_c / dB_d. S is what a law takes out of the body: minus a
/// production, the rate of what is stored.
template <int dim>
struct Response
{
  explicit Response(unsigned int n)
      : flux(n), source(n), by_gradient(n * n), by_value(n * n), source_by_gradient(n * n),
        source_by_value(n * n)
  {
  }
  std::vector<dealii::Tensor<1, dim>> flux;
  std::vector<double> source;
  std::vector<dealii::Tensor<2, dim>> by_gradient;
  std::vector<dealii::Tensor<1, dim>> by_value;
  std::vector<dealii::Tensor<1, dim>> source_by_gradient;
  std::vector<double> source_by_value;
};

/// Which derivatives of a pair (c, d) of components do not vanish identically.
struct Coupling
{
  bool flux_by_gradient = false, flux_by_value = false, source_by_gradient = false, source_by_value = false;

  bool in_flux() const { return flux_by_gradient || flux_by_value; }
  bool in_source() const { return source_by_gradient || source_by_value; }
  bool any() const { return in_flux() || in_source(); }
  Coupling &operator|=(const Coupling &other)
  {
    flux_by_gradient = flux_by_gradient || other.flux_by_gradient;
    flux_by_value = flux_by_value || other.flux_by_value;
    source_by_gradient = source_by_gradient || other.source_by_gradient;
    source_by_value = source_by_value || other.source_by_value;
    return *this;
  }
};

/// What a caller asks of the terms of a field at a point.
enum class Asked : unsigned char { nothing, response, derivatives };

/// One summand of the balance of one field: the stress of a solid, the conduction of heat, a reaction. Knows
/// no mesh. A term is asked only where all components of its field are known.
template <int dim>
class Term
{
public:
  explicit Term(const Field &field) : field(field) {}
  virtual ~Term() = default;

  const Field field;                                   ///< whose balance it belongs to
  mutable std::atomic<unsigned long> n_evaluations{0}; ///< points of this rank that add() has served

  virtual bool has_flux() const = 0;
  virtual bool has_source() const = 0;
  /// Of the rates it asks for: 1 for State::rate, 2 for State::second_rate. Such a term is a source that
  /// stores; it is left out where the rates are not known.
  virtual unsigned int order_in_time() const { return 0; }
  virtual bool sees_past() const { return false; } ///< it asks for State::past
  /// Whether what it stores depends on X itself.
  virtual bool stores_by_position() const { return false; }
  /// How component c of its field depends on component d of the material.
  virtual Coupling coupling(unsigned int c, unsigned int d) const = 0;
  virtual bool is_linear() const = 0; ///< affine in all fields, so its derivatives are constant
  /// Whether its flux is D grad B with the same D at every X, t and state, and it has no source: then its
  /// derivatives at one state say all.
  virtual bool is_uniform() const { return false; }
  /// Whether its flux depends on grad B by the same D, whatever else it may be.
  virtual bool has_uniform_stiffness() const { return is_uniform(); }
  virtual bool is_symmetric() const = 0;    ///< its derivatives by its own field are, and not negative
  virtual bool depends_on_time() const = 0; ///< through t itself
  virtual bool has_large_strain() const { return false; } ///< it knows the deformed body
  virtual std::string description() const = 0;
  /// What it remembers at a point, in the order of its part of the state's memory.
  virtual std::vector<InternalVariable> internal_variables() const { return {}; }
  /// Write the trial of what it remembers for a step in which it does not hold, or before the first one: time
  /// and deformation go on without it. Only what depends on time has to.
  virtual void pass(const State<dim> & /*state*/) const {}
  unsigned int first_internal_variable = 0; ///< of its numbers in the memory; set by the material
  /// Whether add_curvature() knows the second derivatives.
  virtual bool has_curvature() const { return true; }

  /// Add to the flux and the source of its field and, if asked for, to the derivatives for which coupling()
  /// says so. @return false if the law is not defined at this state, with the reason left as
  /// scene/undefined.h says.
  virtual bool add(const State<dim> &state, bool with_derivatives, Response<dim> &response) const = 0;

  /// Add the second derivatives of sum_c w_c . A_c, c in its field, to those of the material
  /// (Material::curvature). Asked only if some w_c is not zero, the term is not linear and has a curvature.
  virtual void add_curvature(const State<dim> & /*state*/, const std::vector<dealii::Tensor<1, dim>> & /*w*/,
                             dealii::FullMatrix<double> & /*result*/) const
  {
  }

  /// What it stores per undeformed volume and gives back [J/m^3]; NaN where it is not defined.
  virtual double energy_density(const State<dim> & /*state*/) const { return 0; }
  /// Of a term that stores a scalar: per undeformed volume what it contains above the value zero, and the
  /// share that has melted; NaN where there is none.
  virtual double content(const State<dim> & /*state*/) const
  {
    return std::numeric_limits<double>::quiet_NaN();
  }
  virtual double liquid_fraction(const State<dim> & /*state*/) const
  {
    return std::numeric_limits<double>::quiet_NaN();
  }

protected:
  // Rows of a curvature.
  static unsigned int value_row(const unsigned int c) { return c * (1 + dim); }
  static unsigned int gradient_row(const unsigned int c, const unsigned int J)
  {
    return c * (1 + dim) + 1 + J;
  }
  static void add_symmetric(dealii::FullMatrix<double> &result, const unsigned int row,
                            const unsigned int column, const double value)
  {
    result(row, column) += value;
    result(column, row) += value;
  }
};

} // namespace dovetail
