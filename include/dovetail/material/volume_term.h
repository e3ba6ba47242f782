// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A solid whose pressure is a field of its own, so that its volume may be kept.

#pragma once

#include <dovetail/material/invariant_law.h>
#include <dovetail/material/solid_term.h>
#include <dovetail/material/thermal_law.h>

#include <memory>
#include <optional>

namespace dovetail {

/// The stress of a mean tension p [Pa], which a SolidTerm hands over in the place of the thermal strain:
/// @f[ P = p\,\mathrm{cof} F, @f] whose Cauchy stress is p I; of small displacements P = p I.
class PressureStress : public SolidLaw
{
public:
  explicit PressureStress(const bool is_of_large_strain) : is_large(is_of_large_strain) {}

  bool evaluate(const dealii::Tensor<2, 3> &H, double p, bool with_derivatives,
                Response &response) const override;
  Curvature curvature(const dealii::Tensor<2, 3> &H, double p, const dealii::Tensor<2, 3> &w,
                      const Place &place) const override;
  bool is_linear() const override { return !is_large; }
  /// That of the volume stands in VolumeTerm.
  double energy(const dealii::Tensor<2, 3> &, double, const Place &) const override { return 0; }

private:
  const bool is_large;
};

/// The equation of the pressure, @f[ S = J - J_p, \qquad J_p = (1 + e)^3 J_e, \quad U'(J_e) = p/\kappa, @f]
/// with the volume J_p that has the pressure, and S = tr H - 3 e - p/kappa of small displacements. 1/kappa =
/// 0 keeps the volume. Since P:dF = p dJ, stress and volume follow from one energy, and the work of the
/// pressure is what it stores.
///
/// Reference: Simo, Taylor & Pister (1985); Boffi, Brezzi & Fortin (2013), section 8.12 for the elements.
template <int dim>
class VolumeTerm : public Term<dim>
{
public:
  /// @param solid the stress without the pressure, which lives as long
  /// @param temperature its component, if e or kappa depend on it
  VolumeTerm(const Field &field, const SolidTerm<dim> &solid, const Volumetric &U,
             const std::optional<unsigned int> &temperature, const ThermalStrain &strain,
             bool is_axisymmetric);

  bool has_flux() const override { return false; }
  bool has_source() const override { return true; }
  Coupling coupling(unsigned int c, unsigned int d) const override;
  bool is_linear() const override
  {
    return !solid.has_large_strain() && strain.constant_coefficient() &&
           !U.compressibility().depends_on_temperature();
  }
  bool is_symmetric() const override { return false; } ///< it is not positive
  bool depends_on_time() const override { return solid.depends_on_time(); }
  std::string description() const override { return "volume"; }
  bool add(const State<dim> &state, bool with_derivatives, Response<dim> &response) const override;
  /// That of the volume which has the pressure p: J itself is only near it, and kappa large.
  double energy_density(const State<dim> &state) const override;

  /// What the volume adds to SolidTerm::expansion_work(): with s = 1 + e, and J the volume that has the
  /// pressure p,
  /// @f[ \frac{\partial p}{\partial T}\Big|_J (J - J_n) = - \Bigl( \frac{(1/\kappa)'}{1/\kappa} p
  ///     + \frac{3 e'}{s} \kappa J_e U''(J_e) \Bigr) (J - J_n), \qquad J = s^3 J_e,\quad U'(J_e) = p/\kappa.
  ///     @f]
  /// At small displacements J - 1 is 3 e + p/kappa, J_e U'' and s are 1.
  struct ExpansionWork
  {
    double value = 0, by_pressure = 0, by_temperature = 0; ///< [J/(m^3 K)]
  };
  /// @param volume_n J_n - 1
  /// @return false where it is not defined
  bool expansion_work(const State<dim> &state, double volume_n, ExpansionWork &work) const;
  /// J - 1: of the pressure, or of the displacement where that is not in equilibrium with it.
  double volume_of_pressure(const State<dim> &state) const;
  double volume_of_displacement(const State<dim> &state) const;
  /// Whether the bulk modulus is finite.
  bool is_compressible() const
  {
    return !(U.compressibility().is_constant() && U.compressibility().at({}) == 0);
  }
  bool expands() const { return !strain.is_zero(); } ///< with the temperature

private:
  SolidLaw::Place place(const State<dim> &state, unsigned int derivative) const;
  /// J - 1, or tr H.
  struct Volume
  {
    double change = 0;
    dealii::Tensor<2, 3> by_F;
  };
  /// Likewise, and J_e - 1.
  struct VolumeOfPressure
  {
    double change, by_pressure, by_temperature, elastic_change;
  };
  bool find_volume(const State<dim> &state, Volume &volume) const;
  VolumeOfPressure find_volume_of_pressure(const State<dim> &state) const;

  const SolidTerm<dim> &solid;
  const Volumetric U;
  const std::optional<unsigned int> temperature;
  const ThermalStrain strain;
  const bool is_axisymmetric;
};

} // namespace dovetail
