// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The heat that a solid produces while it deforms: what compression gives (Gough and Joule), and a share f of
// the work of plastic flow or creep (Taylor and Quinney 1934),
//
//     q = (T + offset) d(dW/dT)/dt|_T + f P : deps_p/dt
//
// per undeformed volume, where W is the free energy, so that the first summand is (T + offset) dP/dT : dF/dt
// without flow; at large strains with (3/2)^1/2 |dev P F^T| da/dt in place of P : deps_p/dt, with backward
// differences from the last good step, whatever the scheme of the step is. At the time of that step it gives
// the heat of that step again. Reference: Simo & Miehe, Comput. Methods Appl. Mech. Engrg. 98 (1992).

#pragma once

#include <dovetail/material/volume_term.h>

namespace dovetail {

template <int dim>
class DeformationHeat : public Term<dim>
{
public:
  /// @param solid the stress of the material, whose field is the displacement
  /// @param volume of the mixed formulation, else nullptr
  DeformationHeat(const Field &temperature, const SolidTerm<dim> &solid, const VolumeTerm<dim> *volume,
                  bool with_compression, double share, double offset);

  bool has_flux() const override { return false; }
  bool has_source() const override { return true; }
  Coupling coupling(unsigned int c, unsigned int d) const override;
  bool is_linear() const override { return false; }
  bool is_symmetric() const override { return false; }
  bool depends_on_time() const override { return true; } // through the size of the step
  std::string description() const override { return "heat of deformation"; }
  std::vector<InternalVariable> internal_variables() const override;

  bool add(const State<dim> &state, bool with_derivatives, Response<dim> &response) const override;
  void pass(const State<dim> &state) const override;

private:
  enum Variable {
    heat_of_step, ///< q of the last good step
    time_of_step,
    gradient_of_step ///< and the displacement gradient at its end, dim x dim numbers, that along the hoop
                     ///< around an axis, and J - 1 in the mixed formulation
  };
  unsigned int hoop_of_step() const { return gradient_of_step + dim * dim; }
  unsigned int volume_of_step() const { return hoop_of_step() + (solid.is_around_axis() ? 1 : 0); }
  void remember(const State<dim> &state, double heat, bool is_in_equilibrium) const;
  bool add_compression(const State<dim> &state, double duration, const double *accepted, double &heat,
                       Response<dim> *response) const;
  bool add_flow(const State<dim> &state, double duration, double &heat, Response<dim> *response) const;
  void add_derivatives(const State<dim> &state, double factor, const typename SolidTerm<dim>::Work &work,
                       Response<dim> &response) const;

  const SolidTerm<dim> &solid;
  const VolumeTerm<dim> *const volume;
  const bool with_compression;
  const double share, offset;
};

} // namespace dovetail
