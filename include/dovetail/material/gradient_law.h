// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Fluxes down a gradient: Fourier's and Fick's law.

#pragma once

#include <dovetail/material/scalar_law.h>

#include <cmath>
#include <optional>

namespace dovetail {

/// The tensor K(scalars, X, t) of @f[ A = K\,\nabla B. @f] It is a number, a diagonal (dim components) or a
/// full tensor row by row (dim * dim components), which need not be symmetric but must have a positive
/// definite symmetric part.
class ConductivityTensor
{
public:
  /// Reads @p entry.
  ConductivityTensor(const Section &section, const std::string &entry, const std::string &description,
                     const ScalarNames &scalars);

  /// K, or nothing if it is not positive definite or not finite, with the reason left.
  std::optional<dealii::Tensor<2, 3>> value(const ScalarState &state) const;
  dealii::Tensor<2, 3> derivative(const ScalarState &state, unsigned int scalar) const;
  dealii::Tensor<2, 3> second_derivative(const ScalarState &state, unsigned int first,
                                         unsigned int second) const;

  bool depends_on_scalars() const { return K.depends_on_scalars(); }
  bool depends_on_scalar(const unsigned int scalar) const { return K.depends_on_scalar(scalar); }
  bool depends_on_time() const { return K.depends_on_time(); }
  const std::optional<dealii::Tensor<2, 3>> &if_constant() const { return constant; }
  /// One that is not constant counts as symmetric only if the text can give no other.
  bool is_symmetric() const;
  /// Leave the reason why a derivative of A is no number. @return false
  bool refuse_derivative(const ScalarState &state) const;

private:
  template <typename Function>
  dealii::Tensor<2, 3> tensor(const Function &value_of) const;
  dealii::Tensor<2, 3> evaluate(const ScalarState &state) const;
  bool is_positive_definite(const dealii::Tensor<2, 3> &k) const;
  bool is_good_at_some_value(const ScalarState &state) const;
  bool explain(const ScalarState &state) const;
  std::string place(const ScalarState &state) const;

  const Section section; ///< for error messages
  const std::string entry;
  const ScalarNames names;
  const unsigned int dim;
  const Expression K;
  std::optional<dealii::Tensor<2, 3>> constant;
};

/// A = K grad B as a law of the family @p Law, HeatLaw or SpeciesLaw.
template <class Law>
class GradientLaw : public Law
{
public:
  GradientLaw(const Section &section, const std::string &entry, const std::string &description,
              const ScalarNames &scalars)
      : K(section, entry, description, scalars)
  {
  }

  bool evaluate(const ScalarState &state, const bool with_derivatives,
                typename Law::Response &response) const override
  {
    const auto k = K.value(state);
    if (!k)
      return false;
    response.A = *k * state.G;
    if (!with_derivatives)
      return true;
    response.by_gradient = *k;
    for (unsigned int s = 0; s < response.by_scalar.size(); ++s)
      if (K.depends_on_scalar(s)) {
        response.by_scalar[s] = K.derivative(state, s) * state.G;
        if (!std::isfinite(response.by_scalar[s].norm_square()))
          return K.refuse_derivative(state);
      }
    return true;
  }

  void curvature(const ScalarState &state, const dealii::Tensor<1, 3> &w,
                 typename Law::Curvature &result) const override
  {
    const unsigned int n = result.by_gradient_and_scalar.size();
    for (unsigned int i = 0; i < n; ++i)
      if (K.depends_on_scalar(i)) {
        result.by_gradient_and_scalar[i] = w * K.derivative(state, i);
        for (unsigned int j = 0; j < n; ++j)
          if (K.depends_on_scalar(j))
            result.by_scalars[i * n + j] = w * K.second_derivative(state, i, j) * state.G;
      }
  }

  bool is_linear() const override { return !K.depends_on_scalars(); }
  bool is_symmetric() const override { return K.is_symmetric(); }
  bool depends_on_scalar(const unsigned int s) const override { return K.depends_on_scalar(s); }
  bool depends_on_time() const override { return K.depends_on_time(); }
  std::optional<dealii::Tensor<2, 3>> constant_gradient() const override { return K.if_constant(); }

private:
  const ConductivityTensor K;
};

} // namespace dovetail
