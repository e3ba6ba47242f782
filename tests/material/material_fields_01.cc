// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The fields of a material and what its fluxes depend on, for each combination of laws.

#include "law_check.h"

template <int dim>
void describe(const std::string &what, const std::string &solid, const std::string &heat)
{
  const Material<dim> material = make_material<dim>(solid, heat);
  std::cout << what << ", " << dim << "D: " << material.n_components() << " components" << std::endl;
  for (unsigned int f = 0; f < material.fields().size(); ++f) {
    const Field &field = material.fields()[f];
    std::cout << "  " << field.name << ": components " << field.first_component << " + " << field.n_components
              << ", linear " << material.is_linear(f) << ", symmetric " << material.is_symmetric(f)
              << ", depends on";
    for (unsigned int g = 0; g < material.fields().size(); ++g)
      if (material.depends(f, g))
        std::cout << ' ' << material.fields()[g].name;
    std::cout << std::endl;
  }
  report("  finds its own fields only",
         (material.find_field("displacement") != nullptr) == !solid.empty() &&
             (material.find_field("temperature") != nullptr) == !heat.empty() &&
             material.find_field("pressure") == nullptr);
}

int main()
{
  const std::string linear = "set Type = linear elastic\nset Young modulus = 2\nset Poisson ratio = 0.3";
  const std::string rubber = "set Type = neo-Hookean\nset Young modulus = 2\nset Poisson ratio = 0.3";
  const std::string fourier = "set Type = Fourier\nset Conductivity = 2";
  describe<2>("solid", linear, "");
  describe<3>("solid", rubber, "");
  describe<2>("heat", "", fourier);
  describe<3>("heat", "", conducts);
  describe<2>("both", linear, fourier);
  describe<3>("expanding", linear + expansion, fourier);
  describe<2>("expanding", rubber + expansion, conducts);

  // E = 2 and nu = 0.3: uniaxial strain 0.01 gives the stress E (1 - nu) / ((1 + nu) (1 - 2 nu)) 0.01
  const Material<2> material = make_material<2>(linear, "");
  State<2> state(2);
  state.gradient[0][0] = 0.01;
  Response<2> response(2);
  material.evaluate(state, false, response);
  std::cout << "uniaxial strain: " << 100 * response.flux[0][0] << std::endl;

  // While the reference of all entries is written nothing is required.
  const auto documentation = SceneText::for_documentation();
  const Material<3> documented("NAME", SceneText::root(documentation).subsection("Material NAME"));
  report("can be documented", documented.fields().size() == 3);
}
