// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What is stored, rho c(T, a, x, t) dT/dt, C(T, a) da/dt and rho d2u/dt2: derivatives against differences,
// with rates that follow from the values by numbers of a time scheme; terms without known rates are left out,
// and static materials have none.

#include "law_check.h"

namespace {

const std::string transient = "subsection Steps\nset Kind = transient\nset Inertia = true\nend\n",
                  solid = "set Type = neo-Hookean\nset Young modulus = 2\nset Poisson ratio = 0.3\nset "
                          "Density = 1.5",
                  heat = "set Type = Fourier\nset Conductivity = 3\nset Density = 2\n"
                         "set Heat capacity = 4 + x*T + a^2 + t",
                  species = "set Species = a\nsubsection Species a\nset Type = Fick\nset Diffusivity = 1\n"
                            "set Capacity = 1 + T^2/4\nset Reaction = -T*a\nend\n";

/// B' = 7 B - 9 p + 2 q, B'' = 11 B + rest with the values p and q of two steps before
template <int dim>
void set_rates(State<dim> &state)
{
  const unsigned int n = state.value.size();
  state.rate.resize(n);
  state.second_rate.resize(n);
  state.rate_by_value = 7;
  state.second_rate_by_value = 11;
  state.past_weight = {-9, 2};
  state.past = {std::vector<double>(n), std::vector<double>(n)};
  for (unsigned int c = 0; c < n; ++c) {
    state.past[0][c] = 0.2 + 0.1 * c;
    state.past[1][c] = 0.4 - 0.2 * c;
    state.rate[c] = 7 * state.value[c] - 9 * state.past[0][c] + 2 * state.past[1][c];
    state.second_rate[c] = 11 * state.value[c] + 2 * c;
  }
}

template <int dim>
void check()
{
  const Material<dim> material = make_material<dim>(solid, heat, species, transient);
  Random random;
  const unsigned int n = material.n_components();
  const double h = 1e-5;
  double error = 0, value_error = 0, storage_error = 0;
  for (unsigned int sample = 0; sample < 5; ++sample) {
    State<dim> state = random.state(material);
    set_rates(state);
    Response<dim> here(n), plus(n), minus(n), stored(n);
    material.evaluate(state, true, here);
    material.evaluate_storage(state, stored);
    const double T = state.value[dim], a = state.value[dim + 1];
    const auto rate_of = [&](const unsigned int c, const auto &content) {
      return 7 * content(state.value[c]) - 9 * content(state.past[0][c]) + 2 * content(state.past[1][c]);
    };
    const auto H = [&](const double b) { return (4 + a * a + state.t) * b + state.X[0] * b * b / 2; };
    const auto amount = [&](const double b) { return (1 + T * T / 4) * b; };
    value_error = std::max({value_error, std::abs(here.source[0] - 1.5 * state.second_rate[0]),
                            std::abs(here.source[dim] - 2 * rate_of(dim, H)),
                            std::abs(here.source[dim + 1] - rate_of(dim + 1, amount) - T * a)});
    storage_error = std::max({storage_error, std::abs(here.source[0] - stored.source[0]),
                              std::abs(here.source[dim + 1] - stored.source[dim + 1] - T * a)});
    for (unsigned int d = 0; d < n; ++d) {
      const double B = state.value[d];
      state.value[d] = B + h;
      set_rates(state);
      material.evaluate(state, false, plus);
      state.value[d] = B - h;
      set_rates(state);
      material.evaluate(state, false, minus);
      state.value[d] = B;
      set_rates(state);
      for (unsigned int c = 0; c < n; ++c)
        error = std::max(
            error, std::abs(here.source_by_value[c * n + d] - (plus.source[c] - minus.source[c]) / (2 * h)) /
                       (1 + std::abs(here.source_by_value[c * n + d])));
    }
  }
  const std::string of_dim = ", " + std::to_string(dim) + "D";
  report("sources" + of_dim, value_error, 1e-12);
  report("derivatives" + of_dim, error, 1e-8);
  report("storage alone" + of_dim, storage_error, 1e-12);

  State<dim> state = random.state(material);
  Response<dim> here(n);
  report("without rates" + of_dim,
         material.evaluate(state, true, here) && here.source[dim] == 0 &&
             std::abs(here.source[dim + 1] - state.value[dim] * state.value[dim + 1]) < 1e-14);
}

} // namespace

int main()
{
  check<2>();
  check<3>();
  const Material<2> material = make_material<2>(solid, heat, species, transient);
  for (unsigned int f = 0; f < material.fields().size(); ++f)
    std::cout << material.fields()[f].name << ": " << material.description(f) << "; order "
              << material.order_in_time(material.fields()[f].first_component) << ", symmetric "
              << material.is_symmetric(f) << ", source " << material.has_source(f) << ", load "
              << material.has_load(f) << std::endl;
  const Material<2> constant =
      make_material<2>("",
                       "set Type = Fourier\nset Conductivity = 3\nset Density = 2\nset "
                       "Heat capacity = 4",
                       "", transient);
  std::cout << "constant capacity: linear " << constant.is_linear(0) << ", symmetric "
            << constant.is_symmetric(0) << std::endl;
  const Material<2> quasi_static =
                        make_material<2>(solid, "", "", "subsection Steps\nset Kind = transient\nend\n"),
                    statics = make_material<2>(solid, heat, species);
  std::cout << "orders without inertia " << quasi_static.order_in_time() << ", in statics "
            << statics.order_in_time() << std::endl;
}
