// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Fourier's law with a number, a diagonal and a full tensor, constant and not: derivatives against
// differences and, for one known state each, the flux by hand.

#include "law_check.h"

template <int dim>
void check(const std::string &conductivity)
{
  const Material<dim> material =
      make_material<dim>("", "set Type = Fourier\nset Conductivity = " + conductivity);
  check_differences(conductivity, material);

  // grad T = (1, 2, 3), T = 2, X = (0.5, 0.25, …), t = 0.1
  State<dim> state(1);
  state.X[0] = 0.5;
  state.X[1] = 0.25;
  state.t = 0.1;
  state.value[0] = 2;
  for (unsigned int i = 0; i < dim; ++i)
    state.gradient[0][i] = i + 1;
  Response<dim> response(1);
  material.evaluate(state, false, response);
  std::cout << "flux " << response.flux[0] << ", linear " << material.is_linear(0) << ", symmetric "
            << material.is_symmetric(0) << ", depends on time " << material.depends_on_time() << std::endl;
  state.gradient[0] = 0;
  material.evaluate(state, false, response);
  report("no flux at rest", response.flux[0].norm(), 1e-14);
}

int main()
{
  check<2>("1.5");
  check<3>("1.5");
  check<2>("1; 2");
  check<3>("1; 2; 3");
  check<2>("2; 0.5; 0.5; 1");
  check<2>("2; 0.5; -0.5; 1");
  check<3>("2; 0.5; 0; 0.5; 1; 0.25; 0; 0.25; 3");
  check<2>("20 + x + 10*t");
  check<3>("1 + 0.5*T + 0.125*T^2");
  check<2>("1 + T; 6 + y*T");
  check<3>("4 + T; 1; 0; -1; 4 + T; 0; 0; T; 8");

  // k <= 0 is a flux that is not defined, not a crash
  const Material<2> material = make_material<2>("", "set Type = Fourier\nset Conductivity = 3 - T");
  State<2> state(1);
  Response<2> response(1);
  for (const double T : {2., 3., 4.}) {
    state.value[0] = T;
    std::cout << "3 - T at T = " << T << " is defined: " << material.evaluate(state, true, response)
              << std::endl;
  }
}
