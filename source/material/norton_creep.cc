// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Metal that creeps in time (secondary creep), for small displacements. With eps = sym(H), the creep strain
// eps_c (without change of volume), the free thermal strain e and von Mises' stress q = (3/2 dev P : dev
// P)^1/2,
//
//     P = kappa (tr eps - 3 e) I + 2 mu (dev eps - eps_c)
//     d eps_c/dt = r_0 (q/s_0)^n 3/2 dev P/q
//
// Backward Euler from the time t_n of the last good step, which the law remembers: q is the root of q + 3 mu
// (t - t_n) r_0 (q/s_0)^n = q_trial, whose tangent is exact. The error of a step is of first order in its
// size.
//
// Reference: Norton, The Creep of Steel at High Temperatures (1929); Simo & Hughes, Computational
// Inelasticity (1998), section 2.7.
//
//     subsection Solid
//       set Type             = Norton creep
//       set Young modulus    = 160e9    # Pa
//       set Poisson ratio    = 0.3
//       set Reference rate   = 1e-9     # 1/s
//       set Reference stress = 100e6    # Pa
//       set Exponent         = 5
//     end

#include <dovetail/material/isochoric_flow.h>
#include <dovetail/scene/catalogue.h>

#include <cmath>

namespace dovetail {

using dealii::Tensor;

class NortonCreep : public IsochoricFlow
{
public:
  explicit NortonCreep(const Section &section)
      : IsochoricFlow(section),
        rate(section.require<double>(
            "Reference rate", "r_0 in the rate r_0 (q/s_0)^n of uniaxial creep [1/s]", Patterns::Double(0))),
        stress(section.require<double>("Reference stress", "s_0, at which the rate is r_0 [Pa]",
                                       Patterns::Double(1e-300))),
        exponent(section.require<double>("Exponent", "n, at least 1 [-]"))
  {
    section.check(exponent >= 1, "Exponent", "must be at least 1.");
  }

  std::vector<InternalVariable> internal_variables() const override
  {
    return {{"creep strain", 9}, {"equivalent creep strain"}, {"time of the last step"}};
  }

  bool evaluate(const Tensor<2, 3> &H, double e, bool with_derivatives, Response &response) const override
  {
    const double *const h = response.memory.accepted.data();
    double *const now = response.memory.trial.data();
    const double mu = moduli.shear, time = std::max(0., response.t - h[10]);
    const Tensor<2, 3> trial = deviator(H, h);
    const double q_trial = std::sqrt(1.5) * trial.norm(), flow = 3 * mu * time * rate;
    const double q = find_stress(q_trial, flow), ratio = q_trial > 0 ? q / q_trial : 1;
    for (unsigned int i = 0; i < 9; ++i)
      now[i] = h[i] + (1 - ratio) / (2 * mu) * trial[i / 3][i % 3];
    now[9] = h[9] + (q_trial - q) / (3 * mu);
    now[10] = std::max(h[10], response.t);
    if (with_derivatives) {
      const double slope = 1 / (1 + flow * exponent / stress * power(q, exponent - 1)), norm = trial.norm();
      set_derivatives(norm > 0 ? trial / norm : Tensor<2, 3>(), ratio, slope, response);
    }
    return set_stress(ratio * trial, H, e, response);
  }

  void pass(const Place &place) const override
  {
    place.memory.trial[10] = std::max(place.memory.accepted[10], place.t);
  }

  bool depends_on_time() const override { return true; }

private:
  double power(const double q, const double n) const { return std::pow(q / stress, n); }

  /// The root q of the convex function q + flow (q/s_0)^n - q_trial: Newton's method from a value above it
  /// falls until rounding ends that.
  double find_stress(const double q_trial, const double flow) const
  {
    if (!(flow > 0 && q_trial > 0))
      return q_trial;
    double q = std::min(q_trial, stress * std::pow(q_trial / flow, 1 / exponent));
    for (unsigned int i = 0; i < 100; ++i) {
      const double rest = q + flow * power(q, exponent) - q_trial;
      const double next = q - rest / (1 + flow * exponent / stress * power(q, exponent - 1));
      if (!(next < q))
        break;
      q = next;
    }
    return q;
  }

  const double rate, stress, exponent;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<NortonCreep>(
    "Norton creep", "Metal that creeps with a power of the stress, for small displacements.");
}

} // namespace dovetail
