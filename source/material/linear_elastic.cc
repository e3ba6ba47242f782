// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Hooke's law for small displacements: with eps = sym(H), H = grad u, and the free thermal strain e,
//
//     W = lambda/2 (tr eps)^2 + mu eps:eps - 3 kappa e tr eps
//     P = lambda tr(eps) I + 2 mu eps - 3 kappa e I
//
// Reference: Hughes, The Finite Element Method (2000), section 2.7; Boley & Weiner, Theory of Thermal
// Stresses (1960), section 1.12 for the thermal term.
//
//     subsection Solid
//       set Type          = linear elastic
//       set Young modulus = 210e9    # Pa
//       set Poisson ratio = 0.3
//     end

#include <dovetail/material/invariant_law.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/undefined.h>

#include <cmath>

namespace dovetail {

using dealii::Tensor;

class LinearElastic : public SolidLaw
{
public:
  explicit LinearElastic(const Section &section) : moduli(*this, section), U(moduli) {}

  bool evaluate(const Tensor<2, 3> &H, double e, bool with_derivatives, Response &response) const override
  {
    const IsotropicModuli m = moduli.at(response);
    const double pressure = m.lame() * trace(H) - 3 * m.bulk_of_stress() * e;
    for (unsigned int i = 0; i < 3; ++i) {
      for (unsigned int J = 0; J < 3; ++J)
        response.P[i][J] = m.shear * (H[i][J] + H[J][i]);
      response.P[i][i] += pressure;
    }
    if (with_derivatives) {
      set_derivatives(m, response);
    }
    return std::isfinite(response.P.norm_square()) || undefined("the stress is not a finite number");
  }

  Curvature curvature(const Tensor<2, 3> &, double, const Tensor<2, 3> &, const Place &) const override
  {
    return {};
  }

  const Volumetric *volume() const override { return &U; }
  bool is_linear() const override { return true; }
  bool is_uniform() const override { return moduli.shear.is_constant() && moduli.bulk.is_constant(); }

private:
  static void set_derivatives(const IsotropicModuli &m, Response &response)
  {
    response.dP_dF = 0;
    response.dP_de = 0;
    for (unsigned int i = 0; i < 3; ++i) {
      for (unsigned int J = 0; J < 3; ++J) {
        response.dP_dF[i][J][i][J] += m.shear;
        response.dP_dF[i][J][J][i] += m.shear;
        response.dP_dF[i][i][J][J] += m.lame();
      }
      response.dP_de[i][i] = -3 * m.bulk_of_stress();
    }
  }

  const VaryingModuli moduli;
  const Volumetric U;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<LinearElastic>(
    "linear elastic", "Isotropic Hooke's law for small displacements, with thermal expansion.");
}

} // namespace dovetail
