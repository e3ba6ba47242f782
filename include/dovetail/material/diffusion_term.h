// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The diffusion of a scalar: conduction of heat, diffusion of a species.

#pragma once

#include <dovetail/material/embedding.h>
#include <dovetail/material/scalar_law.h>
#include <dovetail/material/term.h>

#include <memory>
#include <optional>
#include <string>

namespace dovetail {

/// Of the fields of a material those that are scalars, as its laws number them.
class Scalars
{
public:
  explicit Scalars(const std::vector<Field> &fields);

  unsigned int size() const { return components.size(); }
  unsigned int component(const unsigned int scalar) const { return components[scalar]; }
  /// Number of the scalar with this component; size() if there is none.
  unsigned int number(unsigned int component) const;
  /// They are the last components of a material. @pre size() > 0
  template <int dim>
  dealii::ArrayView<const double> values(const State<dim> &state) const
  {
    return {state.value.data() + components.front(), components.size()};
  }
  /// What a law of the scalar @p own sees of a state, but for gradients.
  template <int dim>
  ScalarState state(const State<dim> &state, const unsigned int own) const
  {
    ScalarState result;
    result.X = embed(state.X);
    result.t = state.t;
    result.scalars = values(state);
    result.own = own;
    return result;
  }

private:
  std::vector<unsigned int> components;
};

/// A = A(scalars, grad B), S = 0.
template <int dim>
class DiffusionTerm : public Term<dim>
{
public:
  DiffusionTerm(const Field &field, const std::vector<Field> &all, std::unique_ptr<ScalarLaw> law,
                const std::string &name_of_law);

  bool has_flux() const override { return true; }
  bool has_source() const override { return false; }
  Coupling coupling(unsigned int c, unsigned int d) const override;
  bool is_linear() const override { return law->is_linear(); }
  bool is_uniform() const override { return constant.has_value(); }
  bool is_symmetric() const override { return law->is_symmetric() && !law->depends_on_scalar(own); }
  bool depends_on_time() const override { return law->depends_on_time(); }
  std::string description() const override { return name_of_law; }

  bool add(const State<dim> &state, bool with_derivatives, Response<dim> &response) const override;
  void add_curvature(const State<dim> &state, const std::vector<dealii::Tensor<1, dim>> &w,
                     dealii::FullMatrix<double> &result) const override;

private:
  ScalarState scalar_state(const State<dim> &state) const;

  const Scalars scalars;
  const unsigned int own; ///< number of the scalar
  const std::unique_ptr<ScalarLaw> law;
  const std::optional<dealii::Tensor<2, dim>> constant; ///< ScalarLaw::constant_gradient()
  const std::string name_of_law;
};

} // namespace dovetail
