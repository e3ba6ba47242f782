// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Species whose diffusivities and reactions depend on each other and on the temperature: fluxes, sources and
// their derivatives against differences, and what depends on what.

#include "law_check.h"

namespace {

const std::string species = "set Species = a, b c\n"
                            "subsection Species a\nset Type = Fick\nset Diffusivity = 1 + b_c^2/(10 + T)\n"
                            "set Reaction = -a*b_c^2 + exp(-T)\nend\n"
                            "subsection Species b c\nset Type = Fick\nset Diffusivity = 2; 3\n"
                            "set Reaction = -0.5*b_c\nend\n";

/// dS_c/dB_d and dS_c/dgrad B_d.
template <int dim>
void check_sources(const Material<dim> &material)
{
  Random random;
  const unsigned int n = material.n_components();
  const double h = 1e-5;
  double error = 0;
  for (unsigned int sample = 0; sample < 5; ++sample) {
    State<dim> state = random.state(material);
    Response<dim> here(n), plus(n), minus(n);
    material.evaluate(state, true, here);
    for (unsigned int s = 0; s < n * (1 + dim); ++s) {
      const double S = entry(state, s);
      entry(state, s) = S + h;
      material.evaluate(state, false, plus);
      entry(state, s) = S - h;
      material.evaluate(state, false, minus);
      entry(state, s) = S;
      for (unsigned int c = 0; c < n; ++c) {
        const unsigned int pair = c * n + s / (1 + dim), i = s % (1 + dim);
        const double exact = i == 0 ? here.source_by_value[pair] : here.source_by_gradient[pair][i - 1];
        error = std::max(error, std::abs(exact - (plus.source[c] - minus.source[c]) / (2 * h)) /
                                    (1 + std::abs(exact)));
      }
    }
  }
  report("sources, " + std::to_string(dim) + "D", error, 1e-8);
}

} // namespace

int main()
{
  const std::string heat = "set Type = Fourier\nset Conductivity = 3 + a/20";
  const Material<2> material = make_material<2>("", heat, species);
  check_differences("species", material);
  check_differences("species", make_material<3>("", heat,
                                                "set Species = a\nsubsection Species a\nset Type = Fick\n"
                                                "set Diffusivity = 2 + a*T\nend\n"));
  check_sources(material);
  for (unsigned int f = 0; f < material.fields().size(); ++f) {
    std::cout << material.fields()[f].name << ": " << material.description(f) << "; linear flux "
              << material.has_linear_flux(f) << ", symmetric " << material.is_symmetric(f) << ", source "
              << material.has_source(f) << ", flux depends on";
    for (unsigned int g = 0; g < material.fields().size(); ++g)
      if (material.flux_depends(f, g))
        std::cout << ' ' << material.fields()[g].name;
    std::cout << std::endl;
  }
}
