// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Weights of the mean flux and the penalty of the jump, at the points of an interface.

#pragma once

#include <dovetail/interface/interface.h>
#include <dovetail/interface/trace_eigenvalue.h>
#include <dovetail/tie/side_states.h>

#include <optional>

namespace dovetail {

/// L1 L2/(L1 + L2), the penalty of two cells by their trace eigenvalues with multiplier 1; zero if both are.
double eigenvalue_penalty(double one, double other);

/// w_src, w_dst and gamma of a consistent tie with this theta (doc/theory/nitsche.md), frozen at the
/// beginning of a step: by the trace eigenvalues L of the cells, by volumes and stiffnesses (Annavarapu et
/// al. 2012), or given. It knows for which gamma the form is coercive, gamma > (1 + theta)^2/4 (w_src^2 L_src
/// + w_dst^2 L_dst), and where it is not any more as the tangents of the laws grow.
template <int dim>
class Penalty
{
public:
  /// Reads `Weights`, `Penalty`, `Multiplier` and `Value`.
  Penalty(const Section &section, double theta);

  /// @throw UserError if one given value would act on several fields, or is wrong everywhere
  void set_fields(const Section &section, const std::vector<TiedField> &fields) const;

  bool is_automatic() const { return has_automatic_multiplier; }
  bool needs_eigenvalues() const; ///< for weights, penalty or the margin of coercivity
  bool is_constant(const Interface<dim> &interface) const; ///< the same in all steps
  std::string description() const;

  /// At the states that @p unknowns give. Where no good one is found the last one stays. Collective.
  void freeze(const Interface<dim> &interface, double t, const ValuesOf &unknowns, SideStates<dim> &sides,
              const MPI_Comm &communicator);
  /// After a step has converged: freeze anew if what was frozen does not fit the solution any more. The range
  /// is that of what was used, with the eigenvalues of the solution. Collective. @return whether it did.
  bool update(const Interface<dim> &interface, double t, const ValuesOf &unknowns, SideStates<dim> &sides,
              const MPI_Comm &communicator);
  /// Fields of large strain are joined by gamma alone, until end_prediction().
  void begin_prediction(const Interface<dim> &interface);
  void end_prediction() { points = before_prediction; }

  /// Of a field at a point.
  struct AtPoint
  {
    std::array<double, 2> weight = {{0, 0}};
    double gamma = 0;
    /// The sides' shares in the least penalty at the beginning of a step, and |N.dA/dgrad B| then; 0: not
    /// known.
    std::array<double, 2> bound = {{0, 0}}, stiffness = {{0, 0}};
    bool is_skew = false; ///< -1 takes the place of theta until the end of the step
  };
  bool empty() const { return points.empty(); } ///< nothing has been frozen yet
  /// What is frozen now and was frozen first, the same number of numbers at each of @p n_points points.
  std::vector<double> pack(unsigned int n_points) const;
  void unpack(unsigned int n_points, const std::vector<double> &numbers);
  bool is_skew_somewhere() const; ///< theta_at() is not theta at a point of this rank
  const AtPoint &operator[](const unsigned int i) const
  {
    return points[i];
  } ///< i = field * n_points + point
  /// theta, or -1 at a point i at which the penalty does not bound the tangent at hand any more: a
  /// conductivity is positive in every state, the tangent of a solid at large strain is not.
  double theta_at(const Interface<dim> &interface, const TiedField &field, unsigned int q,
                  const SideStates<dim> &sides, unsigned int i);

  const PenaltyRange &range() const { return present_range; }
  /// Note a penalty that locks the sides to each other. Collective.
  void note_if_large(const MPI_Comm &communicator);
  const NoteList &notes() const { return all_notes; }

private:
  enum class Weights { eigenvalue, volume, equal, source, destination };
  enum class Rule { eigenvalue, volume, value };

  static std::optional<double> read_multiplier(const Section &section, Rule rule);
  static void check_value(const Section &section, double gamma);
  void check_value(const Interface<dim> &interface, double t, const MPI_Comm &communicator) const;
  void find_eigenvalues(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
                        const MPI_Comm &communicator);
  void evaluate_stiffness(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                          unsigned int q, double t, const std::vector<double> &unknowns,
                          SideStates<dim> &sides) const;
  double stiffness(const Interface<dim> &interface, const TiedField &field, unsigned int side,
                   const dealii::Tensor<1, dim> &N, const SideStates<dim> &sides) const;
  double choose(const Interface<dim> &interface, unsigned int field_index,
                const typename Pairing<dim>::Group &group, unsigned int q, double t,
                const SideStates<dim> &sides, AtPoint &chosen) const;
  double multiplier_of(const Interface<dim> &interface, const TiedField &field) const;
  bool may_turn_skew(const Interface<dim> &interface, const TiedField &field) const;
  void note_bound(unsigned int field_index, const typename Pairing<dim>::Group &group, AtPoint &chosen) const;
  void note_margin(unsigned int field_index, const typename Pairing<dim>::Group &group, const AtPoint &chosen,
                   double unit);
  void note_if_not_coercive(const Interface<dim> &interface, const MPI_Comm &communicator);
  /// By which factor the penalties of a field have grown, and by which they have shrunk.
  struct Change
  {
    double growth = 0, decrease = 0;
  };
  Change change_to(const std::vector<AtPoint> &solution_points, const Interface<dim> &interface,
                   unsigned int field_index, const MPI_Comm &communicator) const;

  double theta;
  Weights weights;
  Rule rule;
  std::optional<double> given_multiplier;
  bool has_automatic_multiplier;
  double multiplier;
  Expression value;

  std::vector<AtPoint> points, before_prediction;
  std::vector<double> first_gamma; ///< of the first step
  /// Of a penalty in a step: harmless, too much, too much.
  static constexpr double small_growth = 1.5, largest_growth = 10, largest_mean_growth = 5,
                          largest_decrease = 100;
  /// By field, of the cells behind the points; empty if nothing needs them.
  std::vector<TraceEigenvalues> lambda;
  PenaltyRange present_range;
  double least_multiplier = 0; ///< with which all points would be coercive
  double excess = 0;           ///< largest gamma in units of that which theta = 1 needs
  bool has_warned = false;
  NoteList all_notes;
};

} // namespace dovetail
