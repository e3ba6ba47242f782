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

#include <deal.II/physics/elasticity/standard_tensors.h>

#include <cmath>

namespace dovetail {

using dealii::Tensor;

class LinearElastic : public SolidLaw
{
public:
  explicit LinearElastic(const Section &section) : moduli(section), U(moduli.bulk)
  {
    const auto I = dealii::unit_symmetric_tensor<3>();
    tangent = moduli.lame() * outer_product(I, I) + 2 * moduli.shear * dealii::identity_tensor<3>();
    thermal = -3 * moduli.bulk_of_stress() * I;
  }

  bool evaluate(const Tensor<2, 3> &H, double e, bool with_derivatives, Response &response) const override
  {
    const double mu = moduli.shear;
    response.P = mu * (H + transpose(H));
    const double pressure = moduli.lame() * trace(H) - 3 * moduli.bulk_of_stress() * e;
    for (unsigned int i = 0; i < 3; ++i)
      response.P[i][i] += pressure;
    if (with_derivatives) {
      response.dP_dF = tangent;
      response.dP_de = thermal;
    }
    return std::isfinite(response.P.norm_square()) || undefined("the stress is not a finite number");
  }

  Curvature curvature(const Tensor<2, 3> &, double, const Tensor<2, 3> &, const Place &) const override
  {
    return {};
  }

  const Volumetric *volume() const override { return &U; }
  bool is_linear() const override { return true; }

private:
  const IsotropicModuli moduli;
  const Volumetric U;
  Tensor<4, 3> tangent;
  Tensor<2, 3> thermal;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<LinearElastic>(
    "linear elastic", "Isotropic Hooke's law for small displacements, with thermal expansion.");
}

} // namespace dovetail
