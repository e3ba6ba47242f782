// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A material that gives way to another one where a toggle is off: the solid and the melt of a metal.
//
//     subsection Material steel
//       set Toggle    = solid      # Active while = temperature < 1700
//       set Otherwise = melt
//     end
//
// The toggle is asked at the last good step, at each point for itself: with the last good time t_n and the
// state x_n of that time, the material of the step from t_n to t is chosen by x_n, while the state at t_n
// still belongs to the material of the step before. Three internal variables tell both apart, so that a
// choice lives through checkpoints and refined meshes. Reference: Simo & Hughes, Computational Inelasticity
// (1998), for laws that remember.

#pragma once

#include <dovetail/material/term.h>
#include <dovetail/scene/section.h>

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace dovetail {

/// Which of several materials a point belongs to: the first one whose toggle is on, or the last one.
template <int dim>
class PhaseChoice
{
public:
  /// A phase, where a toggle is not a number.
  static constexpr unsigned int not_known = std::numeric_limits<unsigned int>::max();

  explicit PhaseChoice(const Section &material); ///< reads Toggle and Otherwise, also of the others

  /// The sections of the materials, the own one first; that alone if there is nothing to choose.
  const std::vector<Section> &materials() const { return sections; }
  bool is_given() const { return sections.size() > 1; }

  void set_fields(const std::vector<Field> &fields); ///< of the material
  std::vector<InternalVariable> internal_variables() const;
  bool sees(unsigned int component) const; ///< a toggle looks at it

  /// The number of the material at a state, whose memory begins with the variables of this choice.
  unsigned int at(const State<dim> &state) const;
  /// Whether the point has not been asked before the first step.
  bool is_new(const State<dim> &state) const { return state.memory.accepted[in_step] < 0; }
  /// Write the trial of its variables.
  void remember(const State<dim> &state) const;

private:
  enum Variable {
    in_step,    ///< the material of the last good step
    after_step, ///< and that of the next one
    time_of_step
  };
  unsigned int find(const State<dim> &state) const;

  std::vector<Section> sections;
  std::vector<Expression> toggles;                     ///< of all materials but the last one
  std::vector<std::optional<unsigned int>> components; ///< of the names in toggles, if the material has them
};

} // namespace dovetail
