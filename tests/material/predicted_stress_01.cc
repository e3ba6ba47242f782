// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Derivatives with the stress that the last tangent predicts: of the Saint Venant-Kirchhoff solid against
// S* = C : (E(F0) + sym(F0^T dF)) in closed form, in 3D, in plane strain and around an axis. For all laws,
// what they change is of second order in dF. The flux stays. So it is where a body flows plastically, and
// what its law remembers on trial is that of the present state.

#include "path_check.h"

namespace {

template <int dim>
Tensor<2, 3> deformation(const Material<dim> &material, const State<dim> &state)
{
  Tensor<2, 3> F = dealii::unit_symmetric_tensor<3>();
  return F + material.displacement_gradient(state);
}

/// Of the moduli of law_check.h.
Tensor<2, 3> stress_of(const Tensor<2, 3> &E)
{
  const double mu = 1.3, lambda = 2.7 - 2. / 3. * mu;
  return lambda * trace(E) * Tensor<2, 3>(dealii::unit_symmetric_tensor<3>()) + 2 * mu * E;
}

/// Of the derivatives by gradients: the largest deviation of what the prediction adds from I x @p more.
template <int dim>
double deviation(const Response<dim> &with, const Response<dim> &without, const unsigned int n,
                 const Tensor<2, 3> &more)
{
  double largest = 0;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int k = 0; k < dim; ++k)
      for (unsigned int J = 0; J < dim; ++J)
        for (unsigned int L = 0; L < dim; ++L)
          largest =
              std::max(largest, std::abs(with.by_gradient[i * n + k][J][L] -
                                         without.by_gradient[i * n + k][J][L] - (i == k ? more[J][L] : 0)));
  return largest;
}

template <int dim>
State<dim> between(const State<dim> &first, const State<dim> &last, const double share)
{
  State<dim> state = first;
  for (unsigned int c = 0; c < state.value.size(); ++c) {
    state.value[c] += share * (last.value[c] - first.value[c]);
    state.gradient[c] += share * (last.gradient[c] - first.gradient[c]);
  }
  return state;
}

template <int dim>
void check_closed_form(const std::string &name, const std::string &geometry)
{
  const Material<dim> material =
      make_material<dim>("set Type = Saint Venant-Kirchhoff" + moduli, "", "", geometry);
  Random random;
  State<dim> before = random.state(material), state = random.state(material);
  before.X = state.X = dealii::Point<dim>(); // the axis, if there is one
  state.X[0] = before.X[0] = 0.7;
  Response<dim> with(dim), without(dim);
  material.evaluate(state, true, without);
  state.linearised_at = &before;
  material.evaluate(state, true, with);
  const Tensor<2, 3> F_0 = deformation(material, before), F = deformation(material, state),
                     I = dealii::unit_symmetric_tensor<3>(), linear = transpose(F_0) * (F - F_0);
  const Tensor<2, 3> S = stress_of((transpose(F) * F - I) / 2),
                     predicted = stress_of((transpose(F_0) * F_0 - I) / 2 + (linear + transpose(linear)) / 2);
  report(name + ", derivatives", deviation(with, without, dim, predicted - S), 1e-11);
  report(name + ", flux", with.flux == without.flux);
}

void check_order(const std::string &type)
{
  const Material<3> material = make_material<3>("set Type = " + type, "");
  Random random;
  const State<3> first = random.state(material), last = random.state(material);
  double size[2];
  for (const unsigned int k : {0, 1}) {
    State<3> state = between(first, last, k == 0 ? 1e-3 : 5e-4);
    Response<3> with(3), without(3);
    material.evaluate(state, true, without);
    state.linearised_at = &first;
    material.evaluate(state, true, with);
    size[k] = deviation(with, without, 3, Tensor<2, 3>());
  }
  report(type.substr(0, type.find('\n')) + ", order", size[0] > 0 && std::abs(size[0] / size[1] - 4) < 0.1);
}

void check_memory()
{
  Path<3> path("set Type = finite J2 plasticity" + moduli + "\nset Yield stress = 0.1" +
               "\nset Isotropic hardening modulus = 0.2");
  Random random;
  const State<3> first = random.state(path.material), last = random.state(path.material);
  double size[2];
  bool is_kept = true, flows = true;
  for (const unsigned int k : {0, 1}) {
    State<3> state = between(first, last, k == 0 ? 1e-3 : 5e-4), before = first;
    state.memory = before.memory = path.state.memory;
    Response<3> with(3), without(3);
    path.material.evaluate(state, true, without);
    const std::vector<double> trial = path.trial;
    state.linearised_at = &before;
    path.material.evaluate(state, true, with);
    is_kept = is_kept && path.trial == trial;
    flows = flows && path.trial != path.accepted;
    size[k] = deviation(with, without, 3, Tensor<2, 3>());
  }
  report("finite J2 plasticity, order", size[0] > 0 && std::abs(size[0] / size[1] - 4) < 0.1);
  report("finite J2 plasticity flows", flows);
  report("finite J2 plasticity, what is on trial", is_kept);
}

} // namespace

int main()
{
  check_closed_form<3>("3D", "");
  check_closed_form<2>("plane strain", "");
  check_closed_form<2>("around an axis", "set Geometry = axisymmetric\n");
  for (const std::string type : {"Saint Venant-Kirchhoff", "neo-Hookean"})
    check_order(type + moduli);
  check_memory();
}
