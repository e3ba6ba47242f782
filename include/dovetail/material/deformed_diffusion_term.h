// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Conduction in the deformed body.

#pragma once

#include <dovetail/material/diffusion_term.h>
#include <dovetail/scene/section.h>

#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// A = J F^-1 a(scalars, g), S = 0, with the gradient g = F^-T grad B in the deformed body and the flux a of
/// the law there, per deformed area: for a conductivity k the tensor J F^-1 k F^-T (Nanson's formula;
/// Holzapfel, Nonlinear Solid Mechanics 2000, section 7.2). In axisymmetry F_33 = 1 + u_r/r.
template <int dim>
class DeformedDiffusionTerm : public Term<dim>
{
public:
  /// @param section of the law, for messages @pre One of the fields is a displacement of the material.
  DeformedDiffusionTerm(const Field &field, const std::vector<Field> &all, const Section &section,
                        std::unique_ptr<ScalarLaw> law, const std::string &name_of_law);

  bool has_flux() const override { return true; }
  bool has_source() const override { return false; }
  Coupling coupling(unsigned int c, unsigned int d) const override;
  bool is_linear() const override { return false; }
  bool is_symmetric() const override { return law->is_symmetric() && !law->depends_on_scalar(own); }
  bool depends_on_time() const override { return law->depends_on_time(); }
  bool has_curvature() const override { return false; }
  std::string description() const override { return name_of_law + " in the deformed body"; }

  bool add(const State<dim> &state, bool with_derivatives, Response<dim> &response) const override;

private:
  dealii::Tensor<2, 3> deformation_gradient(const State<dim> &state) const;
  double radius(const State<dim> &state) const { return state.X[0]; }

  const Scalars scalars;
  const unsigned int own; ///< number of the scalar
  unsigned int u = 0;     ///< first component of the displacement
  const Section section;
  const bool is_axisymmetric;
  const std::unique_ptr<ScalarLaw> law;
  const std::string name_of_law;
};

} // namespace dovetail
