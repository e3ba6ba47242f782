// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Metal that yields, for small displacements: von Mises' yield condition with the associated flow rule. With
// eps = sym(H), the plastic strain eps_p (without change of volume), the free thermal strain e, the
// equivalent plastic strain a and the back stress beta,
//
//     P   = kappa (tr eps - 3 e) I + 2 mu (dev eps - eps_p)
//     f   = |xi| - (2/3)^1/2 Y(a) <= 0,      xi = dev P - beta
//     Y   = Y_0 + K a + (Y_inf - Y_0) (1 - exp(-r a))
//     d eps_p = d gamma n,  n = xi/|xi|,     d a = (2/3)^1/2 d gamma,     d beta = 2/3 K_b d eps_p
//
// One backward Euler step from the last good state: the radial return, of which d gamma is the root of a
// convex function of one variable, and its exact ("consistent") tangent
//
//     D = kappa I x I + 2 mu c dev - 2 mu (c - 1 + 1/(1 + (Y' + K_b)/(3 mu))) n x n,   c = 1 - 2 mu d
//     gamma/|xi_trial|
//
// In uniaxial tension the stress grows with the plastic strain by Y' + K_b. Without K, K_b and Y_inf the
// plasticity is perfect: then no state exists beyond the limit load of the body. A discrete body may find one
// all the same, with a plastic strain of any size, because its cells resist a flow that they cannot follow
// without change of volume (Nagtegaal, Parks & Rice 1974); the law is therefore not defined beyond the
// largest plastic strain.
//
// Reference: Wilkins (1964); Simo & Taylor, Comput. Methods Appl. Mech. Engrg. 48 (1985) 101-118; Voce
// (1955); Prager (1956); Simo & Hughes, Computational Inelasticity (1998), section 3.3.
//
//     subsection Solid
//       set Type                        = J2 plasticity
//       set Young modulus               = 210e9    # Pa
//       set Poisson ratio               = 0.3
//       set Yield stress                = 250e6    # Pa
//       set Isotropic hardening modulus = 1e9      # Pa
//     end

#include <dovetail/material/hardening.h>
#include <dovetail/material/isochoric_flow.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/undefined.h>

#include <algorithm>

namespace dovetail {

using dealii::Tensor;

class J2Plasticity : public IsochoricFlow
{
public:
  explicit J2Plasticity(const Section &section)
      : IsochoricFlow(section), hardening(section),
        kinematic(section.read<double>("Kinematic hardening modulus", 0,
                                       "K_b, by which the back stress grows in uniaxial tension [Pa]",
                                       Patterns::Double(0))),
        largest(section.read<double>("Largest plastic strain", 1,
                                     "Beyond this equivalent plastic strain the law is not defined, as small "
                                     "displacements are no longer a good description [-]",
                                     Patterns::Double(1e-300)))
  {
  }

  std::vector<InternalVariable> internal_variables() const override
  {
    std::vector<InternalVariable> result = {{"plastic strain", 9}, {"equivalent plastic strain"}};
    if (kinematic > 0)
      result.push_back({"back stress", 9});
    return result;
  }

  bool evaluate(const Tensor<2, 3> &H, double e, bool with_derivatives, Response &response) const override
  {
    const double *const h = response.memory.accepted.data();
    Tensor<2, 3> stress = deviator(H, h), xi = stress; // xi: what yields of it
    if (kinematic > 0)
      for (unsigned int i = 0; i < 9; ++i)
        xi[i / 3][i % 3] -= h[10 + i];
    const double norm = xi.norm(),
                 trial = norm - IsotropicHardening::root_of_two_thirds * hardening.strength(h[9]);
    // an accepted state is on the yield surface up to rounding, and must stay as it is
    if (trial > rounding * (norm + 2 * moduli.shear * H.norm())) {
      yield(xi, norm, trial, with_derivatives, stress, response);
      if (!(response.memory.trial[9] <= largest))
        return undefined("the equivalent plastic strain is " + in_words(response.memory.trial[9]) +
                         ", but the Largest plastic strain is " + in_words(largest) +
                         "; a body without hardening flows without end beyond its limit load");
    } else {
      std::copy(response.memory.accepted.begin(), response.memory.accepted.end(),
                response.memory.trial.begin());
      if (with_derivatives)
        set_derivatives({}, 1, 1, response);
    }
    return set_stress(stress, H, e, response);
  }

private:
  static constexpr double rounding = 1e-13;

  /// Return the trial state to the yield surface. @param xi, norm, trial of the trial state
  void yield(const Tensor<2, 3> &xi, const double norm, const double trial, const bool with_derivatives,
             Tensor<2, 3> &stress, Response &response) const
  {
    const double *const h = response.memory.accepted.data();
    double *const now = response.memory.trial.data();
    const double mu = moduli.shear, flow = hardening.find_flow(trial, h[9], 2 * mu + 2. / 3. * kinematic);
    const Tensor<2, 3> n = xi / norm;
    now[9] = h[9] + IsotropicHardening::root_of_two_thirds * flow;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j) {
        now[3 * i + j] = h[3 * i + j] + flow * n[i][j];
        if (kinematic > 0)
          now[10 + 3 * i + j] = h[10 + 3 * i + j] + 2. / 3. * kinematic * flow * n[i][j];
      }
    stress -= 2 * mu * flow * n;
    if (with_derivatives)
      set_derivatives(n, 1 - 2 * mu * flow / norm,
                      1 - 1 / (1 + (hardening.slope(now[9]) + kinematic) / (3 * mu)), response);
  }

  const IsotropicHardening hardening;
  const double kinematic, largest;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<J2Plasticity>(
    "J2 plasticity", "Metal that yields by von Mises' condition, for small displacements, with isotropic and "
                     "kinematic hardening.");
}

} // namespace dovetail
