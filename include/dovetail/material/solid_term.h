// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The stress of a solid in the balance of forces.

#pragma once

#include <dovetail/material/solid_law.h>
#include <dovetail/material/term.h>

#include <memory>
#include <optional>
#include <string>

namespace dovetail {

/// A = P(I + grad u, e), in 2D with H_33 = 0 (which a law in plane stress replaces), where e = alpha (T - T0)
/// is the free thermal strain.
///
/// In axisymmetry the fibres around the axis have the strain H_33 = u_r/r, r = X_1, and their stress is a
/// source of the radial balance, S_r = P_33/r. On the axis, where every weight vanishes, u_r/r has the limit
/// H_11, and the source is left out.
template <int dim>
class SolidTerm : public Term<dim>
{
public:
  struct Expansion
  {
    unsigned int temperature;      ///< its component
    double coefficient, reference; ///< alpha [1/K], T0 [K]
  };

  /// @param name_of_material,name_of_law for messages
  SolidTerm(const Field &field, std::unique_ptr<SolidLaw> law, const std::optional<Expansion> &expansion,
            bool is_axisymmetric, const std::string &name_of_material, const std::string &name_of_law,
            double density);

  const double density; ///< mass per undeformed volume [kg/m^3]; 0: not given

  bool has_flux() const override { return true; }
  bool has_source() const override { return is_axisymmetric; }
  Coupling coupling(unsigned int c, unsigned int d) const override;
  bool is_linear() const override { return law->is_linear(); }
  bool is_uniform() const override { return law->is_uniform() && !expansion && !is_axisymmetric; }
  bool has_uniform_stiffness() const override { return law->is_uniform(); }
  bool is_symmetric() const override { return law->is_symmetric(); }
  bool has_large_strain() const override { return law->has_large_strain(); }
  bool depends_on_time() const override { return law->depends_on_time(); }
  std::string description() const override { return name_of_law; }
  std::vector<InternalVariable> internal_variables() const override { return law->internal_variables(); }
  void pass(const State<dim> &state) const override { law->pass(place(state)); }
  bool has_curvature() const override { return law->has_curvature(); }
  bool is_around_axis() const { return is_axisymmetric; }

  bool add(const State<dim> &state, bool with_derivatives, Response<dim> &response) const override;
  void add_curvature(const State<dim> &state, const std::vector<dealii::Tensor<1, dim>> &w,
                     dealii::FullMatrix<double> &result) const override;

  /// Of a step, per undeformed volume, with its derivatives.
  struct Work
  {
    double value = 0, by_temperature = 0, by_radius = 0; ///< by u_r around an axis
    dealii::Tensor<2, dim> by_gradient;
  };
  bool can_flow() const { return law->shear_of_flow().has_value(); }
  /// What the flow of this step dissipates: P : (eps_p - eps_p,n), or at large strains q (a - a_n) with the
  /// equivalent of the Kirchhoff stress, q = (3/2)^1/2 |dev P F^T|.
  /// @return false where the law is not defined. @pre can_flow()
  bool flow_work(const State<dim> &state, Work &work) const;
  bool has_expansion_work() const { return law->has_expansion_work(); }
  /// SolidLaw::expansion_work() per temperature [J/(m^3 K)], H_n being grad u at the last good step.
  /// @return and @pre likewise
  bool expansion_work(const State<dim> &state, const dealii::Tensor<2, 3> &H_n, Work &work) const;

  double energy_density(const State<dim> &state) const override;
  /// sigma = P F^T / J, the force per deformed area (P itself for a law of small displacements, which knows
  /// no deformed area); three-dimensional also in plane strain. NaN where the law is not defined.
  dealii::Tensor<2, 3> cauchy_stress(const State<dim> &state) const;
  /// grad u, with the part that the law itself finds (plane stress); NaN where it is not defined.
  dealii::Tensor<2, 3> full_displacement_gradient(const State<dim> &state) const;

  /// Likewise without that part.
  dealii::Tensor<2, 3> displacement_gradient(const State<dim> &state) const;

  /// dH_33/du_r and dH_33/dH_11.
  struct Hoop
  {
    double by_value, by_gradient;
  };
  static Hoop hoop(const State<dim> &state) { return state.X[0] > 0 ? Hoop{1 / state.X[0], 0} : Hoop{0, 1}; }

private:
  void add_hoop(const State<dim> &state, bool with_derivatives, const SolidLaw::Response &local,
                Response<dim> &response) const;

  std::optional<dealii::Tensor<2, 3>> predict_stress(const State<dim> &state) const;
  void take_stress(const State<dim> &state, const dealii::Tensor<2, 3> &predicted,
                   SolidLaw::Response &local) const;
  void explain_undefined() const;
  void set_derivatives(const State<dim> &state, double by_strain, const dealii::Tensor<2, 3> &by_F,
                       Work &work) const;
  SolidLaw::Place place(const State<dim> &state) const;
  double thermal_strain(const State<dim> &state) const
  {
    return expansion ? expansion->coefficient * (state.value[expansion->temperature] - expansion->reference)
                     : 0;
  }

  const std::unique_ptr<SolidLaw> law;
  const std::optional<Expansion> expansion;
  const bool is_axisymmetric;
  const std::string name_of_material, name_of_law;
  const unsigned int n_internal_variables; ///< numbers
};

} // namespace dovetail
