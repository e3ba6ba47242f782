// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/gradient_law.h>
#include <dovetail/scene/undefined.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

using dealii::Point;
using dealii::Tensor;

ConductivityTensor::ConductivityTensor(const Section &section, const std::string &entry,
                                       const std::string &description, const ScalarNames &scalars)
    : section(section), entry(entry), names(scalars), dim(section.dimension()),
      K(section.require_expression(entry, {1, dim, dim * dim}, description, scalars))
{
  if (K.depends_on_position() || K.depends_on_time() || K.depends_on_scalars())
    return;
  constant = evaluate(ScalarState());
  section.check(is_positive_definite(*constant), entry,
                K.n_components() == 1 ? "must be positive." : "must be positive definite.");
}

std::optional<Tensor<2, 3>> ConductivityTensor::value(const ScalarState &state) const
{
  if (constant)
    return constant;
  const Tensor<2, 3> k = evaluate(state);
  if (!is_positive_definite(k)) {
    explain(state);
    return {};
  }
  return k;
}

bool ConductivityTensor::is_symmetric() const
{
  return K.n_components() <= dim || (constant && (*constant - transpose(*constant)).norm() == 0);
}

std::string ConductivityTensor::place(const ScalarState &state) const
{
  std::string words;
  for (unsigned int s = 0; s < names.size(); ++s)
    if (K.depends_on_scalar(s))
      words += names[s] + " = " + in_words(state.scalars[s]) + ", ";
  return words;
}

bool ConductivityTensor::refuse_derivative(const ScalarState &state) const
{
  const std::string scalars = place(state);
  std::string by;
  for (unsigned int s = 0; s < names.size(); ++s)
    if (K.depends_on_scalar(s))
      by += (by.empty() ? "" : " or ") + names[s];
  return undefined(sentence_about(section, entry,
                                  "or its derivative by " + by + " is not finite at " +
                                      scalars.substr(0, scalars.size() - 2)));
}

/// Perhaps there is none at any value: then no step, however small, leads to a solution. @return false
bool ConductivityTensor::explain(const ScalarState &state) const
{
  const Tensor<2, 3> k = evaluate(state);
  const auto &X = state.X;
  std::string words =
      "is " + (K.n_components() == 1 ? in_words(k[0][0]) : "not positive definite") + " at " + place(state);
  words += (dim == 2 ? in_words(Point<2>(X[0], X[1])) : in_words(X)) + " and t = " + in_words(state.t);
  if (K.n_components() == 1)
    words += ", but must be positive";
  const bool is_never_good = !is_good_at_some_value(state);
  if (K.depends_on_scalars() && is_never_good)
    words += names == ScalarNames{"T"} ? ", and is so at no temperature"
                                       : ", and is so at no value of the scalars";
  return undefined(sentence_about(section, entry, words + "."), is_never_good);
}

/// With one scalar after the other at values of all sizes.
bool ConductivityTensor::is_good_at_some_value(const ScalarState &state) const
{
  std::vector<double> scalars(state.scalars.begin(), state.scalars.end());
  ScalarState other = state;
  other.scalars = dealii::ArrayView<const double>(scalars.data(), scalars.size());
  for (unsigned int s = 0; s < scalars.size(); ++s) {
    if (!K.depends_on_scalar(s))
      continue;
    for (double size = 1e-3; size < 1e7; size *= 1.5)
      for (const double value : {size, -size}) {
        scalars[s] = value;
        if (is_positive_definite(evaluate(other)))
          return true;
      }
    scalars[s] = state.scalars[s];
  }
  return false;
}

/// The components of the expression, each turned into a number by @p value_of, at their places in K.
template <typename Function>
Tensor<2, 3> ConductivityTensor::tensor(const Function &value_of) const
{
  Tensor<2, 3> result;
  const unsigned int n = K.n_components();
  if (n == 1) {
    const double value = value_of(0);
    for (unsigned int i = 0; i < dim; ++i)
      result[i][i] = value;
  } else if (n == dim)
    for (unsigned int i = 0; i < dim; ++i)
      result[i][i] = value_of(i);
  else
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        result[i][j] = value_of(i * dim + j);
  return result;
}

Tensor<2, 3> ConductivityTensor::evaluate(const ScalarState &state) const
{
  return tensor([&](unsigned int c) { return K.value(state.X, state.t, c, state.scalars); });
}

Tensor<2, 3> ConductivityTensor::derivative(const ScalarState &state, const unsigned int scalar) const
{
  return tensor([&](unsigned int c) { return K.derivative(state.X, state.t, c, state.scalars, scalar); });
}

Tensor<2, 3> ConductivityTensor::second_derivative(const ScalarState &state, const unsigned int first,
                                                   const unsigned int second) const
{
  return tensor(
      [&](unsigned int c) { return K.second_derivative(state.X, state.t, c, state.scalars, first, second); });
}

/// All leading minors of the symmetric part are positive (Sylvester), and it is finite.
bool ConductivityTensor::is_positive_definite(const Tensor<2, 3> &k) const
{
  Tensor<2, 3> s = 0.5 * (k + transpose(k));
  if (dim == 2)
    s[2][2] = 1;
  return std::isfinite(k.norm_square()) && s[0][0] > 0 && s[0][0] * s[1][1] - s[0][1] * s[1][0] > 0 &&
         determinant(s) > 0;
}

} // namespace dovetail
