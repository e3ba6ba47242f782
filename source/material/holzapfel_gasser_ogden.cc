// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Soft tissue or rubber with one or two families of fibres, which carry only tension: with the directions a
// of the fibres, their square stretch I_a = |F a|^2 and the first invariant of the deformation without change
// of volume,
//
//     W_e = mu/2 (I_1 - 3) + kappa U(J) + sum_a k_1/(2 k_2) (exp(k_2 (I_a - 1)^2) - 1)     (of the fibres
//     with I_a > 1)
//
// The fibres see the whole stretch, not the one without change of volume: else a body that is pulled on all
// sides would keep its fibres at rest (Nolan et al. 2014). For nearly incompressible bodies both are the
// same.
//
// Reference: Holzapfel, Gasser & Ogden, J. Elasticity 61 (2000) 1-48; Nolan, Gower, Destrade, Ogden &
// McGarry, J. Mech. Behav. Biomed. Mater. 39 (2014) 48-60.
//
//     subsection Solid
//       set Type           = Holzapfel-Gasser-Ogden
//       set Shear modulus  = 3e3       # Pa
//       set Bulk modulus   = 300e3     # Pa
//       set Fibre modulus  = 2.4e3     # k_1, Pa
//       set Fibre exponent = 0.84      # k_2
//       set First fibre    = cos(0.5); sin(0.5); 0
//       set Second fibre   = cos(0.5); -sin(0.5); 0
//     end

#include <dovetail/material/invariant_law.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/undefined.h>

#include <cmath>
#include <vector>

namespace dovetail {

using dealii::Tensor;

namespace {

/// What is between the fibres.
class GroundMatrix : public InvariantLaw
{
public:
  /// The formulas belong to @p owner.
  GroundMatrix(SolidLaw &owner, const Section &section) : moduli(owner, section), U(section, moduli) {}

  const Volumetric *volume() const override { return &U; }

  using InvariantLaw::elastic_curvature;
  using InvariantLaw::elastic_response;

protected:
  IsochoricEnergy isochoric(const IsochoricInvariants &invariants) const override
  {
    IsochoricEnergy W;
    W.W_1 = moduli.shear.at(invariants.place()) / 2;
    return W;
  }

private:
  const VaryingModuli moduli;
  const Volumetric U;
};

} // namespace

class HolzapfelGasserOgden : public HyperelasticLaw
{
public:
  explicit HolzapfelGasserOgden(const Section &section)
      : matrix(*this, section), k_1(*this, section, "Fibre modulus", "k_1 [Pa]", Coefficient::not_negative()),
        k_2(section.require<double>("Fibre exponent", "k_2 [-]", Patterns::Double(1e-300)))
  {
    fibres.push_back(section.require_expression("First fibre", {section.dimension(), 3},
                                                "Direction of any length; a formula of x, y, z, t [-]"));
    const Expression second = section.read_expression("Second fibre", "", {section.dimension(), 3},
                                                      "That of the second family, if there is one [-]");
    if (!section.peek("Second fibre").empty())
      fibres.push_back(second);
    if (section.documenting())
      return;
    for (const Expression &fibre : fibres)
      section.check(fibre.depends_on_position() || fibre.depends_on_time() ||
                        std::isfinite(direction(fibre, {}).norm_square()),
                    &fibre == &fibres.front() ? "First fibre" : "Second fibre",
                    "is zero, which is no direction.");
  }

  /// The stiffness of a fibre begins with a jump where it is stretched.
  bool has_curvature() const override { return false; }

  const Volumetric *volume() const override { return matrix.volume(); }

  bool depends_on_time() const override
  {
    return HyperelasticLaw::depends_on_time() || fibres.front().depends_on_time() ||
           fibres.back().depends_on_time();
  }

protected:
  bool is_defined(const Deformation &deformation) const override
  {
    for (const Expression &fibre : fibres)
      if (!std::isfinite(direction(fibre, deformation.place).norm_square()))
        return undefined(
            "the direction of a fibre at " + in_words(deformation.place.X) + " is zero or no number", true);
    return true;
  }

  // P = 2 W_1 F a x a,  D = 4 W_2 F a x a x F a x a + 2 W_1 I x a x a
  void elastic_response(const Deformation &deformation, Tensor<2, 3> &P, Tensor<4, 3> *D) const override
  {
    matrix.elastic_response(deformation, P, D);
    for (const Expression &fibre : fibres) {
      const Tensor<1, 3> a = direction(fibre, deformation.place), Fa = deformation.F * a;
      const Slopes W(*this, deformation, a);
      P += 2 * W.first * outer_product(Fa, a);
      if (D != nullptr)
        add(4 * W.second * outer_product(Fa, Fa) + 2 * W.first * identity(), a, *D);
    }
  }

  // with s = w a . F a:  8 W_3 s F a x F a + 4 W_2 (w a x F a + F a x w a + s I), each with a x a
  Tensor<4, 3> elastic_curvature(const Deformation &deformation, const Tensor<2, 3> &w) const override
  {
    Tensor<4, 3> result = matrix.elastic_curvature(deformation, w);
    for (const Expression &fibre : fibres) {
      const Tensor<1, 3> a = direction(fibre, deformation.place), Fa = deformation.F * a, wa = w * a;
      const Slopes W(*this, deformation, a);
      const double s = wa * Fa;
      add(8 * W.third * s * outer_product(Fa, Fa) +
              4 * W.second * (outer_product(wa, Fa) + outer_product(Fa, wa) + s * identity()),
          a, result);
    }
    return result;
  }

private:
  /// W_1, W_2, W_3: derivatives of the energy of a fibre by I_a.
  struct Slopes
  {
    Slopes(const HolzapfelGasserOgden &law, const Deformation &deformation, const Tensor<1, 3> &a)
    {
      const double E = 2 * (a * (deformation.green_strain() * a)), k = law.k_2; // I_a - 1
      if (E <= 0)
        return;
      const double grown = law.k_1.at(deformation.place) * std::exp(k * E * E);
      first = grown * E;
      second = grown * (1 + 2 * k * E * E);
      third = grown * 2 * k * E * (3 + 2 * k * E * E);
    }
    double first = 0, second = 0, third = 0;
  };

  static Tensor<2, 3> identity() { return dealii::unit_symmetric_tensor<3>(); }

  static Tensor<1, 3> direction(const Expression &fibre, const SolidLaw::Place &place)
  {
    Tensor<1, 3> a;
    for (unsigned int i = 0; i < fibre.n_components(); ++i)
      a[i] = fibre.value(place.X, place.t, i);
    return a / a.norm();
  }

  /// D_iJkL += A_ik a_J a_L
  static void add(const Tensor<2, 3> &A, const Tensor<1, 3> &a, Tensor<4, 3> &D)
  {
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int J = 0; J < 3; ++J)
        for (unsigned int k = 0; k < 3; ++k)
          D[i][J][k] += A[i][k] * a[J] * a;
  }

  const GroundMatrix matrix;
  const Coefficient k_1;
  const double k_2;
  std::vector<Expression> fibres;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<HolzapfelGasserOgden>(
    "Holzapfel-Gasser-Ogden",
    "Soft tissue: a neo-Hookean solid with two families of fibres, which carry tension.");
}

} // namespace dovetail
