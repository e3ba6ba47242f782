// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the laws of both sides say at a point of an interface.

#pragma once

#include <dovetail/interface/side_points.h>

#include <array>
#include <vector>

namespace dovetail {

/// The states of both sides at a point and the responses of their laws there.
///
/// A solid's law may be defined in a cell and not on its face, about which nothing but a tie asks: beside the
/// corner of a bonded rubber the extrapolation of the deformation to the face turns over, or nearly so, and
/// its stress grows without bound. There the gradient at the centre of the cell behind takes the place of
/// that at the point (the values stay those at the point). A constant gradient is the same at both: patch
/// tests stay exact.
template <int dim>
class SideStates : public SidePoints<dim>
{
public:
  /// Choose the points that take the gradient of the centre: those at which a law of a nonlinear vector field
  /// is not defined, or |N.dA/dgrad B| is more than largest_stiffening times that at the centre.
  void begin_step(const Interface<dim> &interface, double t, const ValuesOf &unknowns);

  /// State and response of a side at a point of a group, whose unknowns are given. Where the law is not
  /// defined, the point takes the gradient of the centre from now on, if the state is accepted. @return
  /// whether the law is defined.
  using SidePoints<dim>::evaluate;
  bool evaluate(const Interface<dim> &interface, const typename Pairing<dim>::Group &group, unsigned int side,
                unsigned int q, double t, const std::vector<double> &unknowns, const bool with_derivatives)
  {
    return evaluate(interface, group, side, q, t, unknowns,
                    interface.sides[side].domain->material.asks_for_all(with_derivatives));
  }
  bool evaluate(const Interface<dim> &interface, const typename Pairing<dim>::Group &group, unsigned int side,
                unsigned int q, double t, const std::vector<double> &unknowns,
                const std::vector<Asked> &asked); ///< by field of the side
  /// The state that was evaluated last becomes the solution so far.
  void accept();

  /// Whether a side takes the gradient of the centre, in the state that was evaluated last.
  bool is_central(const unsigned int side, const unsigned int q) const
  {
    return choices[q][side].is_of_trial;
  }
  unsigned int n_central() const; ///< number of points of this rank that do

  /// |N.dA/dgrad B| of a field for the response at hand.
  double normal_stiffness(const Interface<dim> &interface, const TiedField &field, unsigned int side,
                          unsigned int q) const;

private:
  struct Choice ///< of the gradient of the centre: for the solution so far, and for the trial
  {
    bool is_accepted = false, is_of_trial = false;
  };
  static constexpr double largest_stiffening = 4;

  bool stiffens(const Interface<dim> &interface, const typename Pairing<dim>::Group &group, unsigned int side,
                unsigned int q, const std::vector<double> &unknowns);

  std::vector<std::array<Choice, 2>> choices; ///< by point and side
};

/// Whether the field is a vector and a law of one of the sides knows large strain.
template <int dim>
bool has_large_strain(const Interface<dim> &interface, const TiedField &field);
/// Whether any tied field is.
template <int dim>
bool has_large_strain(const Interface<dim> &interface);

} // namespace dovetail
