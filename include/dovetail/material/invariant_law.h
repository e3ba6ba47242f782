// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Isotropic hyperelastic laws by the invariants of the deformation.

#pragma once

#include <dovetail/material/coefficient.h>
#include <dovetail/material/hyperelastic_law.h>

#include <optional>

namespace dovetail {

/// The two invariants without change of volume minus 3, exact where they are small; computed when asked for.
struct IsochoricInvariants
{
  double first_minus_3() const;
  double second_minus_3() const;
  double J() const { return deformation.J; }
  const SolidLaw::Place &place() const { return deformation.place; } ///< for formulas

  const Deformation &deformation;
  const bool with_third = false; ///< whether third derivatives are asked for
};

/// The isochoric part of an energy by the two invariants without change of volume,
/// @f[ \bar I_1 = J^{-2/3} I_1,\quad \bar I_2 = J^{-4/3} I_2,\qquad I_1 = \mathrm{tr}\,C,\quad
///     I_2 = \tfrac12 (I_1^2 - \mathrm{tr}\,C^2). @f]
struct IsochoricEnergy
{
  double W_1 = 0, W_2 = 0;                           ///< dW/dI_1, dW/dI_2 [Pa]
  double W_11 = 0, W_12 = 0, W_22 = 0;               ///< second derivatives
  double W_111 = 0, W_112 = 0, W_122 = 0, W_222 = 0; ///< third derivatives

  /// Of an energy that does not split: its derivatives by J and an invariant. Those by J alone stand in U.
  struct Mixed
  {
    double W_1J = 0, W_2J = 0, W_11J = 0, W_12J = 0, W_22J = 0, W_1JJ = 0, W_2JJ = 0;
  };
  std::optional<Mixed> mixed = std::nullopt;
};

/// The volumetric part U(J).
struct VolumetricEnergy
{
  double U_1 = 0, U_2 = 0, U_3 = 0; ///< U', U'', U''' [Pa]
};

/// A hyperelastic solid with @f[ W_e = W(\bar I_1, \bar I_2) + U(J). @f] A member of the family gives the
/// derivatives of two functions of scalars; this class makes the tensors of them, once for all laws. With
/// C = I + 2E, Q = F^-T and N_k = dI_k/dF each invariant has the derivative
/// @f[ G = J^{-\beta}\,(N - \beta I\,Q),\qquad \beta = \tfrac23, \tfrac43, @f]
/// which is computed so that it vanishes with H = F - I term by term; see doc/theory/laws.md.
class InvariantLaw : public HyperelasticLaw
{
protected:
  virtual IsochoricEnergy isochoric(const IsochoricInvariants &invariants) const = 0;
  virtual VolumetricEnergy volumetric(const IsochoricInvariants &invariants) const; ///< that of volume()

  void elastic_response(const Deformation &deformation, dealii::Tensor<2, 3> &P,
                        dealii::Tensor<4, 3> *D) const final;
  dealii::Tensor<4, 3> elastic_curvature(const Deformation &deformation,
                                         const dealii::Tensor<2, 3> &w) const final;
};

/// kappa times one of the published functions of J, which the entry `Volumetric` selects: U'(1) = 0, U''(1) =
/// kappa.
///
/// | `Volumetric` | U/kappa | source |
/// |---|---|---|
/// | Simo-Taylor | (J^2 - 1 - 2 ln J)/4 | Simo & Taylor (1982) |
/// | quadratic | (J - 1)^2/2 | Simo, Taylor & Pister (1985) |
/// | logarithmic | (ln J)^2/2 | Hencky (1933) |
/// | Miehe | J - ln J - 1 | Miehe (1994) |
/// | Liu | J ln J - J + 1 | Liu, Hofstetter & Mang (1994) |
/// | Ogden | (J^-b - 1 + b ln J)/b^2, b the Volumetric exponent | Ogden (1972) |
class Volumetric
{
public:
  /// Reads `Volumetric`, and `Volumetric exponent`.
  Volumetric(const Section &section, double kappa);
  Volumetric(const Section &section, const VaryingModuli &moduli);
  /// And `Bulk modulus`, which may be a formula.
  Volumetric(SolidLaw &law, const Section &section);
  /// `quadratic`, of a law that has no choice.
  explicit Volumetric(const VaryingModuli &moduli)
      : kappa(moduli.bulk), inverse(moduli.compressibility), is_separate(false), choice(1)
  {
  }
  /// Of metals.
  static Volumetric quadratic(const IsotropicModuli &moduli) { return {moduli, 1}; }
  static Volumetric logarithmic(const IsotropicModuli &moduli) { return {moduli, 2}; }
  /// Zero with `Formulation = mixed`.
  VolumetricEnergy at(const Deformation &deformation) const
  {
    return is_separate ? VolumetricEnergy() : times(kappa.at(deformation.place), deformation.J_minus_1);
  }
  VolumetricEnergy at(const IsochoricInvariants &invariants) const { return at(invariants.deformation); }

  VolumetricEnergy per_bulk_modulus(const double J_minus_1) const { return times(1., J_minus_1); }
  const Coefficient &compressibility() const { return inverse; } ///< 1/kappa [1/Pa]
  /// kappa U(J) where the mean tension kappa U'(J) is @p p; NaN where it is never so large.
  double energy_at(double p, const SolidLaw::Place &place) const;
  /// J - 1 where U'(J)/kappa is @p strain; NaN where it is never so large.
  double change_at(double strain) const;

private:
  Volumetric(const IsotropicModuli &moduli, const unsigned int choice)
      : kappa(moduli.bulk), inverse(1 / moduli.bulk), is_separate(false), choice(choice)
  {
  }
  VolumetricEnergy times(double factor, double J_minus_1) const;

  void read_function(const Section &section);

  Coefficient kappa, inverse = 0;
  bool is_separate;
  unsigned int choice = 0;
  double exponent = 0;
};

/// The entry `Bulk modulus` of laws without a Poisson ratio.
double require_bulk_modulus(const Section &section);

} // namespace dovetail
