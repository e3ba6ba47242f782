// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The pressure p of a fluid, which pushes in where it is positive. At large strain it follows the deformed
// boundary (Follower = true): P N = -p J F^-T N per undeformed area, with the derivative
//
//     (cof F N)_i = (F_j x F_k).N,   F_i: row i of F,   i, j, k cyclic
//
// In 2D F_33 = 1; around an axis F_33 = 1 + u_r / r. For a law of small strain there is no deformed area, and
// P N = -p N, as with Follower = false.
//
//     subsection Boundary condition gas
//       set Type         = pressure
//       set Boundary ids = 2
//       set Expression   = 2e6*t
//     end

#include <dovetail/domain/condition.h>
#include <dovetail/material/embedding.h>
#include <dovetail/scene/undefined.h>

#include <array>

namespace dovetail {

namespace {

using dealii::Tensor;

template <int dim>
class Pressure : public Condition<dim>
{
public:
  Pressure(const Section &section, const Material<dim> &material, const Toggles &toggles)
      : Condition<dim>(section, material, toggles, {Scope::vectors, Scope::boundary}),
        expression(
            section.require_expression("Expression", {1}, "The pressure, positive if it pushes in [Pa]")),
        follows(section.read<bool>("Follower", true,
                                   "At large strain the pressure acts on the deformed boundary, along its "
                                   "normal; false: on the undeformed one [-]") &&
                material.has_large_strain()),
        is_axisymmetric(dim == 2 && section.top().peek("Geometry") == "axisymmetric")
  {
    section.check(!follows || dim == 3 || section.top().peek("Geometry") != "plane stress", "Follower",
                  "is true, but the thickness of a sheet in plane stress is not known to the condition. "
                  "Set Follower = false, or Geometry = plane strain.");
  }

  bool adds_flux() const override { return true; }
  bool sees_gradients() const override { return follows; }
  bool is_linear() const override { return !follows; }
  bool is_symmetric() const override { return !follows; }
  bool has_constant_tangent() const override { return !follows; }
  bool depends_on_time() const override { return expression.depends_on_time(); }

  void influx(const State<dim> &state, const Tensor<1, dim> &N, Influx<dim> &influx) const override
  {
    const double p =
        finite(expression.value(state.X, state.t), this->section, "Expression", state.X, state.t);
    if (!follows)
      for (unsigned int i = 0; i < dim; ++i)
        influx.value[i] = -p * N[i];
    else
      add_follower(p, state, embed(N), influx);
  }

private:
  void add_follower(double p, const State<dim> &state, const Tensor<1, 3> &N, Influx<dim> &influx) const;

  const Expression expression;
  const bool follows, is_axisymmetric;
};

template <int dim>
void Pressure<dim>::add_follower(const double p, const State<dim> &state, const Tensor<1, 3> &N,
                                 Influx<dim> &influx) const
{
  const unsigned int first = this->field.first_component;
  std::array<Tensor<1, 3>, 3> F; // rows
  for (unsigned int i = 0; i < 3; ++i)
    F[i][i] = 1;
  for (unsigned int i = 0; i < dim; ++i)
    F[i] += embed(state.gradient[first + i]);
  const double by_r = is_axisymmetric && state.X[0] > 0 ? 1 / state.X[0] : 0; // the axis has no area
  F[2][2] += by_r * state.value[first];
  for (unsigned int i = 0; i < dim; ++i) {
    const unsigned int j = (i + 1) % 3, k = (i + 2) % 3;
    influx.value[i] = -p * (dealii::cross_product_3d(F[j], F[k]) * N);
    for (const auto &[row, derivative] : {std::make_pair(j, dealii::cross_product_3d(F[k], N)),
                                          std::make_pair(k, dealii::cross_product_3d(N, F[j]))})
      if (row < dim)
        influx.by_gradient(i, first + row) = -p * restrict_to<dim>(derivative);
      else
        influx.by_value(i, first) = -p * derivative[2] * by_r;
  }
}

const bool registered =
    add_condition<Pressure>("pressure", "A pressure, which at large strain follows the deformed boundary.");

} // namespace

} // namespace dovetail
