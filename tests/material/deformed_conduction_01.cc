// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Conduction in the deformed body, J F^-1 k(T, x) F^-T grad T with a full tensor k: value, and derivatives by
// all traces and gradients against differences, in plane strain, axisymmetry and 3D.

#include "law_check.h"

namespace {

template <int dim>
void check(const std::string &geometry, const std::string &conductivity)
{
  const Material<dim> material = make_material<dim>(
      "set Type = neo-Hookean\nset Young modulus = 2\nset Poisson ratio = 0.3",
      "set Type = Fourier\nset Conductivity = " + conductivity + "\nset Configuration = deformed", "",
      geometry);
  Random random;
  const unsigned int n = material.n_components(), T = material.find_field("temperature")->first_component;
  const double h = 1e-6;
  double error = 0;
  Response<dim> here(n), plus(n), minus(n);
  for (unsigned int sample = 0; sample < 5; ++sample) {
    State<dim> state = random.state(material);
    state.X[0] = 2 + state.X[0];
    if (!material.evaluate(state, true, here))
      std::cout << "not defined" << std::endl;
    const auto compare = [&](double &number, const auto &derivative) {
      const double kept = number;
      number = kept + h;
      material.evaluate(state, false, plus);
      number = kept - h;
      material.evaluate(state, false, minus);
      number = kept;
      error = std::max(error, ((plus.flux[T] - minus.flux[T]) / (2 * h) - derivative).norm());
    };
    for (unsigned int d = 0; d < n; ++d) {
      if (material.coupling(T, d).flux_by_value)
        compare(state.value[d], here.by_value[T * n + d]);
      for (unsigned int L = 0; L < dim; ++L) {
        Tensor<1, dim> column;
        for (unsigned int K = 0; K < dim; ++K)
          column[K] = here.by_gradient[T * n + d][K][L];
        compare(state.gradient[d][L], column);
      }
    }
  }
  report("derivatives" + (geometry.empty() ? ", " + std::to_string(dim) + "D" : ", axisymmetric"), error,
         1e-7);
  State<dim> state = random.state(material);
  state.X[0] = 2;
  for (unsigned int d = 0; d < dim; ++d)
    state.gradient[material.find_field("displacement")->first_component + d] = 0;
  state.gradient[material.find_field("displacement")->first_component][0] = -1.5;
  report("refused where a cell turns over", !material.evaluate(state, true, here));
}

} // namespace

int main()
{
  check<2>("", "4 + x*T; 0.3 + T^2/20; 0.1; 5 + y");
  check<2>("set Geometry = axisymmetric\n", "3 + T^2/9");
  check<3>("", "4 + x*T; 0.3; T/10; 0.1; 5 + y; 0; 0.2; 0; 3");
}
