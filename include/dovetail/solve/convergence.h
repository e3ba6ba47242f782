// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// When a state of a nonlinear system is its solution: doc/theory/convergence.md. Knows numbers by part only;
// a part is one field of one domain, or the multipliers of an interface for a field. The unknowns of a
// constraint follow from the others: their updates are not measured.

#pragma once

#include <utility>
#include <vector>

namespace dovetail {

/// What is at work in the equations of each part at one state, as Euclidean norms.
struct WorkingForces
{
  std::vector<double> residuals; ///< ||R_p||
  std::vector<double> forces;    ///< F_p: internal, given, transmitted and reaction forces, cell by cell
  std::vector<double> rounding;  ///< N_p: what rounding can leave of those that cancel
};

/// The last update of each part.
struct WorkingUpdate
{
  std::vector<double> largest;                       ///< max |dx_i|, of free unknowns
  std::vector<double> smallest_value, largest_value; ///< of x + dx and of x at the beginning of the step
  std::vector<double> energies; ///< |dx . R_before|, likewise: dx K dx if no prescribed values moved with it
  std::vector<double> n_unknowns;
};

/// A part is solved if
/// @f[ \|R_p\| \le \max( N_p, \text{absolute}, \text{relative}\, \min(F_p, 100\, F_f^0) ) @f]
/// with the forces F_f^0 of its field at the first state of the step, and the update that led there was small
/// in the range of the field and in the energy norm of the tangent it was made with.
class Convergence
{
public:
  Convergence(std::vector<unsigned int> field_of_part, std::vector<bool> is_constraint,
              double relative_tolerance, double absolute_tolerance);

  void begin_step();
  /// From now on only these parts are measured.
  void restrict_to(std::vector<bool> parts) { is_measured = std::move(parts); }
  /// The largest of ||R_p|| over its reference, 0 for a part whose residual is rounding; NaN if one is not
  /// finite.
  double residual(const WorkingForces &now);
  /// Whether rounding alone let the last residual() be small: a load may be hidden in it.
  bool is_hidden() const { return hides_any; }
  bool is_small(const WorkingUpdate &update) const;

  /// The part with the largest relative residual of the last residual(); that with the largest rounding if
  /// none has one.
  unsigned int worst_part() const { return worst; }
  double tolerance() const { return relative_tolerance; }

  static constexpr double largest_growth = 100;  ///< of forces since the first state
  static constexpr double largest_update = 1e-3; ///< of an accepted state, in the range of its field
  static constexpr double smallest_range = 1e-6; ///< of a field, in its largest value

private:
  std::vector<unsigned int> field_of_part;
  std::vector<bool> is_constraint, is_measured;
  double relative_tolerance, absolute_tolerance;
  std::vector<double> first_forces; ///< by field
  std::vector<double> last_forces;
  unsigned int worst = 0;
  bool hides_any = false;
};

} // namespace dovetail
