// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Thin sheets: a solid law without stress across the plane.

#pragma once

#include <dovetail/material/solid_law.h>

#include <memory>
#include <optional>

namespace dovetail {

/// A solid law in plane stress: H_33 = z(H, e) is what makes @f$ P_{33}(H, e) = 0, @f$ found by Newton's
/// method, and the derivatives are those of P(H + z e_3 e_3, e):
/// @f[ \frac{\mathrm dP}{\mathrm dF} = D - \frac{D_{\cdot33}\,D_{33\cdot}}{D_{3333}} @f]
/// and likewise by e. The second derivatives of w:P are those at the same H with w_33 = -(w:D_.33)/D_3333,
/// along the change of z. With a law that remembers, z is an internal variable, too: the search begins at
/// that of the last good step, so that the law sees no strain that the body never had.
class PlaneStress : public SolidLaw
{
public:
  explicit PlaneStress(std::unique_ptr<SolidLaw> law);

  bool evaluate(const dealii::Tensor<2, 3> &H, double e, bool with_derivatives,
                Response &response) const override;
  Curvature curvature(const dealii::Tensor<2, 3> &H, double e, const dealii::Tensor<2, 3> &w,
                      const Place &place) const override;
  bool is_linear() const override { return law->is_linear(); }
  bool is_uniform() const override { return law->is_uniform(); }
  std::optional<dealii::Tensor<2, 3>> full_gradient(const dealii::Tensor<2, 3> &H, double e,
                                                    const Place &place) const override;
  double energy(const dealii::Tensor<2, 3> &H, double e, const Place &place) const override;
  std::vector<InternalVariable> internal_variables() const override;
  void pass(const Place &place) const override;
  bool has_curvature() const override { return law->has_curvature(); }
  bool is_symmetric() const override { return law->is_symmetric(); }
  bool has_large_strain() const override { return law->has_large_strain(); }
  bool depends_on_time() const override { return law->depends_on_time(); }

private:
  /// @p H with the strain across, and the response of the law there with derivatives.
  bool find_thickness(dealii::Tensor<2, 3> &H, double e, Response &response) const;
  /// Where the search begins: @p H and the response there.
  bool begin(dealii::Tensor<2, 3> &H, double e, double last_strain, Response &response) const;
  bool search(dealii::Tensor<2, 3> &H, double e, Response &response) const;

  const std::unique_ptr<SolidLaw> law;
  unsigned int n_of_law = 0; ///< numbers that it remembers
};

} // namespace dovetail
