// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Free vibrations of tied solids about a state.

#pragma once

#include <dovetail/output/results.h>
#include <dovetail/run/nonlinear_step.h>
#include <dovetail/solve/eigenpairs.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace dovetail {

/// `Kind = eigenmodes`: the modes v and circular frequencies w of small vibrations about a static state x,
/// K(x) v = w^2 M v, with the tangent K and the consistent mass M of all bodies on the constraints of their
/// ties. Both come from the equations of a step: with a second rate c v they have the tangent K + c M.
template <int dim>
class Eigenmodes
{
public:
  /// Reads entries of `subsection Steps`; the others are kept by reference.
  /// @throw UserError if the matrix will not be symmetric or the fields are not those of solids.
  Eigenmodes(const Section &scene, const Model<dim> &model, NonlinearStep<dim> &step, Results<dim> &results,
             Phases &phases, Notes &notes, Log &log);

  void add_to(Plan &plan) const;
  /// About the solution @p x of time @p t, for which the step has begun; of a linear scene any @p x will do.
  /// Pictures, the table of the log and the numbers of the report. @return whether all were found.
  /// Collective.
  bool run(double t, const Vector &x);

private:
  using Column = EigenProblem::Column;

  void check_scene(const Section &scene) const;
  void check_symmetry() const;
  void find_free_unknowns();
  Column gather(const Vector &x) const;
  Vector scatter(const Column &column) const;
  Column product(const BlockMatrix &matrix, double factor, const Column &x) const;
  void make_guides();
  void assemble(double second_rate);
  void choose_shift();
  void prepare_inverse(double shift);
  Column solve(const Column &b, double enough = 0);
  Column rest(const Column &b, const Column &x);
  Column inverse(const Column &b);
  Column forces(double factor, const Column &x);
  Column stiffness_product(const Column &x);
  double rounding(const Column &x, double size) const;
  void look_for_rounding();
  void note_rounding(const EigenPairs &pairs);
  double product(const Column &x, const Column &y) const;
  bool is_symmetric() const;
  void count(const EigenPairs &pairs);
  bool has_counted(double shift, unsigned long &n);
  std::vector<unsigned int> nearest(const EigenPairs &pairs) const;
  void write(const EigenPairs &pairs);
  double frequency(double value) const;

  const Model<dim> &model;
  NonlinearStep<dim> &step;
  Results<dim> &results;
  Phases &phases;
  Notes &notes;
  Log &log;
  const Section section;
  unsigned int n_modes;
  double given_frequency; ///< next to which modes are wanted [Hz]
  unsigned int group = 0; ///< of the fields that have a mass

  // of a run
  Vector state;
  bool is_held = false;
  BlockMatrix stiffness, mass;
  bool asks_laws = false; ///< for K x, since products with the matrix are not exact enough
  Column forces_at_rest;  ///< at the state, if so
  std::vector<std::pair<unsigned int, unsigned int>>
      free; ///< block and own entry of each own entry of a column
  std::map<unsigned int, std::vector<unsigned int>> constrained; ///< own rows of other unknowns, by block
  EigenProblem problem;
  double shift_of_inverse = 0;
  std::string why_not_counted;
};

} // namespace dovetail
