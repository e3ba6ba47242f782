// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The heat that a solid produces while it deforms: what compression gives (Gough and Joule), and a share f of
// the work of plastic flow or creep (Taylor and Quinney 1934),
//
//     q = (T + offset) dP/dT : dF/dt + f P : deps_p/dt
//
// per undeformed volume, at large strains with (3/2)^1/2 |dev P F^T| da/dt in place of P : deps_p/dt,
// with backward differences from the last good step, whatever the scheme of the step is. At the time of that
// step it gives the heat of that step again. Reference: Simo & Miehe, Comput. Methods Appl. Mech. Engrg. 98
// (1992).

#pragma once

#include <dovetail/material/solid_term.h>

namespace dovetail {

template <int dim>
class DeformationHeat : public Term<dim>
{
public:
  /// @param solid the stress of the material, whose field is the displacement
  DeformationHeat(const Field &temperature, const SolidTerm<dim> &solid, bool with_compression, double share,
                  double offset);

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
    gradient_of_step ///< and the displacement gradient at its end, dim x dim numbers
  };
  void remember(const State<dim> &state, double heat) const;
  bool add_compression(const State<dim> &state, double duration, const double *accepted, double &heat,
                       Response<dim> *response) const;
  bool add_flow(const State<dim> &state, double duration, double &heat, Response<dim> *response) const;

  const SolidTerm<dim> &solid;
  const bool with_compression;
  const double share, offset;
};

} // namespace dovetail
