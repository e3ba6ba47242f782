// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Fourier's law of heat conduction: the heat into the body through its outward normal N is A.N with
//
//     A = K(T, X, t) grad T
//
// K is a number, a diagonal (dim components) or a full tensor row by row (dim * dim components), which need
// not be symmetric but must have a positive definite symmetric part.
//
// Reference: Carslaw & Jaeger, Conduction of Heat in Solids (1959), sections 1.3 and 1.17.
//
//     subsection Heat
//       set Type         = Fourier
//       set Conductivity = 15 * (1 + 0.001 * T)    # W/(m K)
//     end

#include <dovetail/material/heat_law.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/undefined.h>

#include <cmath>

namespace dovetail {

using dealii::Point;
using dealii::Tensor;

class Fourier : public HeatLaw
{
public:
  explicit Fourier(const Section &section)
      : section(section), dim(section.dimension()),
        K(section.require_expression(
            "Conductivity", {1, dim, dim * dim},
            "Thermal conductivity, which may depend on x, y, z, t and the temperature T: one "
            "number, the diagonal, or the full tensor row by row [W/(m K)]",
            true)),
        is_constant(!K.depends_on_position() && !K.depends_on_time() && !K.depends_on_temperature())
  {
    if (!is_constant)
      return;
    constant = conductivity(Point<3>(), 0, 0);
    section.check(is_positive_definite(constant), "Conductivity",
                  K.n_components() == 1 ? "must be positive." : "must be positive definite.");
  }

  bool evaluate(const Point<3> &X, double t, double T, const Tensor<1, 3> &G, bool with_derivatives,
                Response &response) const override
  {
    const Tensor<2, 3> k = is_constant ? constant : conductivity(X, t, T);
    response.A = k * G;
    if (with_derivatives) {
      response.dA_dG = k;
      response.dA_dT = K.depends_on_temperature() ? temperature_derivative(X, t, T, 1) * G : Tensor<1, 3>();
    }
    if (is_constant)
      return true;
    if (!is_positive_definite(k))
      return explain(X, t, T);
    return std::isfinite(response.A.norm_square() + response.dA_dT.norm_square()) ||
           undefined(sentence_about(section, "Conductivity",
                                    "or its derivative by T is not finite at T = " + in_words(T)));
  }

  Curvature curvature(const Point<3> &X, double t, double T, const Tensor<1, 3> &G,
                      const Tensor<1, 3> &w) const override
  {
    Curvature result;
    if (K.depends_on_temperature()) {
      result.GT = w * temperature_derivative(X, t, T, 1);
      result.TT = w * temperature_derivative(X, t, T, 2) * G;
    }
    return result;
  }

  bool is_linear() const override { return !K.depends_on_temperature(); }
  bool depends_on_time() const override { return K.depends_on_time(); }

  // A tensor that is not constant counts as symmetric only if the text can give no other.
  bool is_symmetric() const override
  {
    if (K.depends_on_temperature())
      return false;
    return K.n_components() <= dim || (is_constant && (constant - transpose(constant)).norm() == 0);
  }

private:
  /// Perhaps there is none at any temperature: then no step, however small, leads to a solution. @return
  /// false
  bool explain(const Point<3> &X, double t, double T) const
  {
    const Tensor<2, 3> k = conductivity(X, t, T);
    std::string words =
        "is " + (K.n_components() == 1 ? in_words(k[0][0]) : "not positive definite") + " at ";
    if (K.depends_on_temperature())
      words += "T = " + in_words(T) + ", ";
    words += (dim == 2 ? in_words(Point<2>(X[0], X[1])) : in_words(X)) + " and t = " + in_words(t);
    if (K.n_components() == 1)
      words += ", but must be positive";
    const bool is_never_good = !is_good_at_some_temperature(X, t);
    if (K.depends_on_temperature() && is_never_good)
      words += ", and is so at no temperature";
    return undefined(sentence_about(section, "Conductivity", words + "."), is_never_good);
  }

  bool is_good_at_some_temperature(const Point<3> &X, double t) const
  {
    if (!K.depends_on_temperature())
      return false;
    for (double size = 1e-3; size < 1e7; size *= 1.5)
      for (const double T : {size, -size})
        if (is_positive_definite(conductivity(X, t, T)))
          return true;
    return false;
  }

  /// The components of the expression, each turned into a number by @p value_of, at their places in K.
  template <typename Function>
  Tensor<2, 3> tensor(const Function &value_of) const
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

  Tensor<2, 3> conductivity(const Point<3> &X, double t, double T) const
  {
    return tensor([&](unsigned int component) { return K.value(X, t, component, T); });
  }

  Tensor<2, 3> temperature_derivative(const Point<3> &X, double t, double T, unsigned int order) const
  {
    return tensor(
        [&](unsigned int component) { return K.temperature_derivatives(X, t, component, T)[order - 1]; });
  }

  /// All leading minors of the symmetric part are positive (Sylvester), and it is finite.
  bool is_positive_definite(const Tensor<2, 3> &k) const
  {
    Tensor<2, 3> s = 0.5 * (k + transpose(k));
    if (dim == 2)
      s[2][2] = 1;
    return std::isfinite(k.norm_square()) && s[0][0] > 0 && s[0][0] * s[1][1] - s[0][1] * s[1][0] > 0 &&
           determinant(s) > 0;
  }

  const Section section; ///< for error messages
  const unsigned int dim;
  const Expression K;
  const bool is_constant;
  Tensor<2, 3> constant;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<HeatLaw>::add<Fourier>(
    "Fourier", "Heat flows down the gradient of the temperature; isotropic or anisotropic.");
}

} // namespace dovetail
