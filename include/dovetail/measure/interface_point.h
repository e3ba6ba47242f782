// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What happens at one point of an interface.

#pragma once

#include <dovetail/interface/side_points.h>
#include <dovetail/system/vector.h>

#include <array>
#include <functional>
#include <vector>

namespace dovetail {

/// Jumps and fluxes of all tied fields at one point after another; component by component.
template <int dim>
class InterfacePoint
{
public:
  InterfacePoint(const Interface<dim> &interface, double t);

  struct FieldAtPoint
  {
    std::vector<double> jump;                 ///< [B]
    std::array<std::vector<double>, 2> trace; ///< B of each side at its own point
    std::array<std::vector<double>, 2>
        flux;                        ///< A.N of each side through its own normal; NaN: law not defined
    std::array<double, 2> flux_size; ///< |A| of each side, along the interface too; 0 if it is but rounding
    std::vector<double> numerical_flux; ///< the tie's, into the source; zero while the interface is inactive
  };
  std::vector<FieldAtPoint> fields; ///< as in Interface::fields, at the point visited last

  /// Of a point, and of the side on whose faces it lies.
  using Visitor = std::function<void(unsigned int q, unsigned int side)>;
  /// Visit all points of this rank, in order.
  void for_each(const Vector &ghosted_solution, const Visitor &visit);

  /// Whether the domain of some side has an exact solution of the field and of all that its flux depends on.
  bool has_exact_flux(unsigned int field) const;
  /// The exact influx into the source at the point visited last: A.N of the exact solution of the source, or
  /// that of the destination if only it is known or if it is much softer. Rounding in grad B grows with the
  /// modulus: 1e-13 |B| dA/dgrad B over the length of the body.
  std::vector<double> exact_flux(unsigned int field, unsigned int q);
  /// The numerical flux there without the parts of pressures.
  std::vector<double> flux_without_pressure(const TiedField &field, unsigned int q) const;

private:
  void evaluate(unsigned int q, const std::vector<double> &unknowns);
  /// Of the response at the state of a side, which is evaluated.
  std::vector<double> normal_flux(const TiedField &field, unsigned int side, unsigned int q);
  bool has_exact_flux(unsigned int field, unsigned int side) const;
  std::vector<double> exact_flux(unsigned int field, unsigned int side, unsigned int q);
  /// Size of dA/dgrad B of a field in the last response.
  double modulus(const TiedField &field, unsigned int side) const;

  const Interface<dim> &interface;
  const double t;
  SidePoints<dim> points;
};

} // namespace dovetail
