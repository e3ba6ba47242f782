// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A cohesive joint that breaks: linear up to the strength, then linearly down to zero, in any mixture of
// opening and sliding. With the opening w = (n, s), the stiffnesses K_n and K_t, n+ = max(n, 0), and the
// damage d from 0 to 1,
//
//     t = (1 - d) (K_n n+, K_t s) + (K_n min(n, 0), 0)
//     Y = (K_n n+^2 + K_t |s|^2)/2,   B = K_t |s|^2/(2 Y)                  energy of the whole joint, mode
//     Y_0(B) = Y_n + (Y_t - Y_n) B^eta,   Y_n = f_n^2/(2 K_n),   Y_t = f_t^2/(2 K_t)        onset
//     G(B)   = G_n + (G_t - G_n) B^eta                                      (Benzeggagh and Kenane 1996)
//     d = largest so far of  r_f (r - r_0)/(r (r_f - r_0)),   r = Y^(1/2), r_0 = Y_0^(1/2), r_f = G/r_0
//
// with the strengths f and the fracture energies G. Opened along a straight line the joint dissipates exactly
// G(B). It unloads along the secant, and stays stiff in compression (Camanho, Davila and de Moura 2003;
// Turon, Camanho, Costa and Davila 2006; here with two stiffnesses). Where the strength is 0 it is broken
// from the start.
//
//     subsection Interface glue
//       set Type            = contact resistance
//       set Joint           = bilinear
//       set Joint stiffness = 1e15               # Pa/m
//       set Strength        = 30e6; 50e6         # Pa
//       set Fracture energy = 300; 900           # J/m^2
//     end

#include <dovetail/scene/undefined.h>
#include <dovetail/tie/joint_law.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

using dealii::Tensor;

class BilinearJoint : public JointLaw
{
public:
  explicit BilinearJoint(const Section &section)
      : section(section),
        strength(section.require_expression("Strength", {1, 2},
                                            "f, the largest traction of the intact joint: one number, or two "
                                            "for opening; sliding; 0: broken from the start [Pa]")),
        fracture_energy(section.require_expression(
            "Fracture energy", {1, 2},
            "G, the energy per area that breaks the joint: one number, or two for opening; sliding [J/m^2]")),
        exponent(section.read<double>("Mixed mode exponent", 2.,
                                      "eta of the share of sliding in the energy, by which strength and "
                                      "fracture energy go over from opening to sliding; at least 1 [-]",
                                      Patterns::Double(1)))
  {
  }

  std::vector<InternalVariable> internal_variables() const override
  {
    return {{"damage"}, {"dissipated energy"}}; // [-], [J/m^2]
  }
  bool evaluate(const JointPlace &place, const Tensor<1, 3> &opening, JointResponse &response) const override;
  double softening(const JointPlace &place) const override;
  bool is_symmetric(const bool has_one_stiffness) const override // if Y_0 and G do not depend on B
  {
    return has_one_stiffness && strength.n_components() == 1 && fracture_energy.n_components() == 1;
  }

private:
  /// Energies per area of the two modes.
  struct Modes
  {
    std::array<double, 2> onset, fracture;
    double at(const std::array<double, 2> &energies, const double share) const
    {
      return energies[0] + (energies[1] - energies[0]) * share;
    }
  };
  /// r_0, r_f and their derivatives by the share B of sliding.
  struct Radii
  {
    double onset, end, onset_by_B, end_by_B;
    double damage(const double r) const { return end * (r - onset) / (r * (end - onset)); }
    double radius(const double damage) const { return onset * end / (end - damage * (end - onset)); }
    /// What is dissipated along a straight line, from one radius to a larger one.
    double dissipated(const double from, const double to) const
    {
      return onset * end / (end - onset) * (to - from);
    }
  };

  bool find_modes(const JointPlace &place, Modes &modes) const;
  Radii radii(const Modes &modes, double B) const;

  const Section section; ///< for messages
  const Expression strength, fracture_energy;
  const double exponent;
};

bool BilinearJoint::find_modes(const JointPlace &place, Modes &modes) const
{
  for (const unsigned int mode : {0, 1}) {
    const double f = strength.value(place.X, place.t, std::min(mode, strength.n_components() - 1));
    const double G =
        fracture_energy.value(place.X, place.t, std::min(mode, fracture_energy.n_components() - 1));
    modes.onset[mode] = f * f / (2 * place.stiffness[mode]);
    modes.fracture[mode] = G;
    const auto where = " at " + in_words(place.X) + " and t = " + in_words(place.t);
    if (!(f >= 0 && std::isfinite(f)))
      return undefined(sentence_about(section, "Strength",
                                      "is " + in_words(f) + where + ", but must be finite and not negative."),
                       true);
    if (!(G > modes.onset[mode] && std::isfinite(G)))
      return undefined(
          sentence_about(section, "Fracture energy",
                         "is " + in_words(G) + where + ", but must be more than " +
                             in_words(modes.onset[mode]) +
                             ", which the joint stores when its traction reaches the Strength. Raise Joint "
                             "stiffness, or the fracture energy."),
          true);
  }
  if (modes.onset[0] == 0 || modes.onset[1] == 0)
    modes.onset = {{0, 0}};
  return true;
}

BilinearJoint::Radii BilinearJoint::radii(const Modes &modes, const double B) const
{
  const double share = std::pow(B, exponent),
               share_by_B = exponent == 1 ? 1 : exponent * std::pow(B, exponent - 1);
  Radii result{};
  result.onset = std::sqrt(modes.at(modes.onset, share));
  if (result.onset == 0)
    return result;
  const double G = modes.at(modes.fracture, share);
  result.end = G / result.onset;
  result.onset_by_B = (modes.onset[1] - modes.onset[0]) * share_by_B / (2 * result.onset);
  result.end_by_B =
      ((modes.fracture[1] - modes.fracture[0]) * share_by_B - result.end * result.onset_by_B) / result.onset;
  return result;
}

bool BilinearJoint::evaluate(const JointPlace &place, const Tensor<1, 3> &opening,
                             JointResponse &response) const
{
  Modes modes{};
  if (!find_modes(place, modes))
    return false;
  const auto &[K_n, K_t] = place.stiffness;
  Tensor<1, 3> whole; // traction of the whole joint, without compression: dY/dw
  whole[0] = K_n * std::max(opening[0], 0.);
  for (const unsigned int i : {1, 2})
    whole[i] = K_t * opening[i];
  const double last = place.memory.accepted[0];
  double damage = modes.onset[0] == 0 ? 1 : last, dissipated = place.memory.accepted[1];
  Tensor<1, 3> damage_by_opening;

  const double of_sliding = (whole[1] * whole[1] + whole[2] * whole[2]) / (2 * K_t);
  const double Y = whole[0] * whole[0] / (2 * K_n) + of_sliding;
  if (Y > 0) {
    const double B = of_sliding / Y, r = std::sqrt(Y);
    const Radii at = radii(modes, B);
    if (at.onset == 0 || r >= at.end)
      damage = 1;
    else if (const double now = at.damage(r); now > last) {
      damage = now;
      const double span = at.end - at.onset;
      Tensor<1, 3> B_by_opening = -B / Y * whole;
      for (const unsigned int i : {1, 2})
        B_by_opening[i] += whole[i] / Y;
      damage_by_opening = at.end * at.onset / (span * r * r) / (2 * r) * whole +
                          (at.end * (r - at.end) * at.onset_by_B - at.onset * (r - at.onset) * at.end_by_B) /
                              (r * span * span) * B_by_opening;
    }
    if (damage > last && at.onset > 0)
      dissipated += at.dissipated(at.radius(last), at.radius(damage));
  }

  response.traction = (1 - damage) * whole;
  response.by_opening = -outer_product(whole, damage_by_opening);
  // at rest a broken joint is taken to open: one that is taken to be closed opens cell by cell
  response.by_opening[0][0] += opening[0] < 0 ? K_n : (1 - damage) * K_n;
  for (const unsigned int i : {1, 2})
    response.by_opening[i][i] += (1 - damage) * K_t;
  response.traction[0] += K_n * std::min(opening[0], 0.);
  place.memory.trial[0] = damage;
  place.memory.trial[1] = dissipated;
  return true;
}

/// K r_0/(r_f - r_0), the larger one of the two modes.
double BilinearJoint::softening(const JointPlace &place) const
{
  Modes modes{};
  if (!find_modes(place, modes))
    return 0;
  double steepest = 0;
  for (const unsigned int mode : {0, 1})
    steepest = std::max(steepest, modes.onset[mode] / (modes.fracture[mode] - modes.onset[mode]));
  return steepest * std::max(place.stiffness[0], place.stiffness[1]);
}

[[maybe_unused]] const bool registered = JointCatalogue::add<BilinearJoint>(
    "bilinear", "A joint that softens linearly beyond its strength until it has broken.");

} // namespace

} // namespace dovetail
