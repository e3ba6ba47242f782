// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What Nitsche's tie and the ties that put a joint in series with it share.

#pragma once

#include <dovetail/tie/gradient_change.h>
#include <dovetail/tie/joint_law.h>
#include <dovetail/tie/penalty.h>
#include <dovetail/tie/point_toggle.h>

#include <limits>
#include <map>
#include <optional>

namespace dovetail {

/// Nitsche's method for any conjugate pair of flux A and trace B, in series with a joint that passes the flux
/// h [B] (h: its conductance, flux per jump; infinite unless a derived class says otherwise). With the
/// penalty gamma, b = 1/(h + gamma) and a = h b,
/// @f[ R(\delta) = \int_\Gamma - s\cdot\delta[B] - \theta\, \delta\{A\}\cdot e \,d\Gamma, \quad
///     s = a (\{A\} - \gamma [B]), \quad e = a [B] + b \{A\} @f]
/// with the signs of pairing.h. In the letters of Juntunen and Stenberg (2009), who did this for a boundary,
/// a = gamma_eff/gamma and b = (gamma_eff/gamma)/h with 1/gamma_eff = 1/h + 1/gamma. The exact flux {A} = -h
/// [B] makes e vanish and s = {A}, for every h from 0 (two bodies) to infinity (a = 1, b = 0: the tie alone).
///
/// A joint with a law of its own, traction t over opening w = -[B] (joint_law.h), is in series likewise:
/// t(w) + gamma w = {A} - gamma [B] gives w at each point, and then s = t(w), e = [B] + w. With D = dt/dw the
/// derivatives are those above with h = D, a tensor. gamma grows by what t falls at most, so that w is
/// unique.
///
/// theta = 1 is symmetric, 0 nonsymmetric (delta{A} is never evaluated), -1 skew-symmetric. The tangent is
/// exact: for theta != 0 and a nonlinear law it holds the second derivative of A, contracted with e; with
/// `Variation = frozen`, for laws that have none, delta{A} is that at the beginning of the step. Weights
/// and penalty are frozen at the beginning of a step. Where the first update of a step changes the strain by
/// a fifth, the penalty joins the sides alone until updates are small (adapt()). For theta > 0 and a
/// nonlinear law of a vector field, -1 takes the place of theta at points at which the penalty does not bound
/// the tangent: the skew-symmetric form asks for no bound, and every theta is consistent.
template <int dim>
class Nitsche : public Tie<dim>, public PointTerms<dim>
{
public:
  explicit Nitsche(const Section &section);

  TieParts<dim> parts() override { return {this}; }
  void set_fields(const Section &section, const std::vector<TiedField> &fields) override;
  std::array<bool, 2> integrates_on() const override { return sides_of_integration; }
  bool couples_fluxes() const override { return has_joint(); }
  bool couples_insides(const Interface<dim> &interface) const override; ///< by second derivatives of the flux
  bool is_symmetric() const override
  {
    return theta == 1. && !own_sides && !has_frozen_variation && !penalty_at_points.is_skew_somewhere();
  }
  bool is_balanced() const override { return !own_sides; }
  bool has_constant_tangent(const Interface<dim> &interface) const override
  {
    return this->is_linear() && penalty_at_points.is_constant(interface) && !toggle.is_given();
  }
  std::string description() const override;
  bool allows_partition() const override { return true; }
  bool follows_fields() const override { return toggle.is_given(); }
  bool has_switched() const override { return toggle.has_switched(); }
  bool allows_jump(const TiedField & /*field*/) const override { return toggle.is_given(); }
  std::vector<std::string> left_out(const Interface<dim> &interface) const override;
  void begin_step(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
                  const MPI_Comm &communicator) override;
  bool update_penalties(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
                        const MPI_Comm &communicator) override;
  std::vector<double> pack_points(const Interface<dim> &interface) const override;
  void unpack_points(const Interface<dim> &interface, const std::vector<double> &numbers) override;
  bool adapt(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
             const MPI_Comm &communicator) override;
  bool assemble(const Interface<dim> &interface, const typename Pairing<dim>::Group &group, double t,
                const std::vector<double> &unknowns, std::vector<double> &residual,
                dealii::FullMatrix<double> *tangent) override;
  const LeadingUnknowns *leading_unknowns(const Interface<dim> &interface,
                                          const typename Pairing<dim>::Group &group) const override;
  bool assemble_leading(const Interface<dim> &interface, const typename Pairing<dim>::Group &group, double t,
                        const std::vector<double> &unknowns, std::vector<double> &residual,
                        dealii::FullMatrix<double> *tangent) override;
  void ask_for(const std::vector<Asked> &of_fields) override { asked = of_fields; }
  void accept_state() override { sides.accept(); }
  bool evaluate_memory(Interface<dim> &interface, double t, const ValuesOf &unknowns) override;
  void numerical_flux(const Interface<dim> &interface, const TiedField &field, unsigned int q,
                      const std::array<State<dim>, 2> &state, const std::array<std::vector<double>, 2> &flux,
                      const std::vector<double> &jump, std::vector<double> &result) const override;
  std::optional<double> energy(const Interface<dim> &interface, const TiedField &field, unsigned int q,
                               const std::vector<double> &numerical_flux,
                               const std::vector<double> &jump) const override;
  PenaltyRange penalty() const override { return penalty_at_points.range(); }
  NoteList notes() const override;
  FluxVariations flux_variations() const override { return variations; }

protected:
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  bool has_toggle_at_points() const { return toggle.is_given(); }

  /// What lies between the two sides at a point.
  struct Joint
  {
    double along_normal = infinity;   ///< h of the component along N, and of a scalar
    double along_tangents = infinity; ///< h of the components across it
    /// Of h of a scalar by the state of a side: dh = sum_d by_value dB_d + by_gradient . d(grad B_d).
    struct Derivative
    {
      double by_value = 0;
      dealii::Tensor<1, dim> by_gradient;
    };
    std::array<std::vector<Derivative>, 2> by_state; ///< by component of the side; empty: not at all
    const JointLaw *law = nullptr;                   ///< in place of h
    JointPlace place;                                ///< for the law
    dealii::Tensor<1, dim> normal;                   ///< that of the law, from the source to the destination
  };
  /// Whether there is one at all; then find_joint() is asked for it at every point.
  virtual bool has_joint() const { return false; }
  /// Of a field at a point. @return false if it is not defined at this state of the two sides.
  virtual bool find_joint(const Interface<dim> & /*interface*/, const TiedField & /*field*/,
                          unsigned int /*q*/, const std::array<State<dim>, 2> & /*state*/,
                          Joint & /*joint*/) const
  {
    return true;
  }

private:
  using AtPoint = typename Penalty<dim>::AtPoint;

  /// Tie and joint in series at a point: a, b, s and e; only the first entries of a scalar.
  struct Series
  {
    bool is_rigid = true; ///< a = 1, b = 0
    dealii::Tensor<2, dim> a, b;
    std::array<std::vector<typename Joint::Derivative>, 2> h_by_state; ///< of a scalar; empty: not at all
    std::array<double, dim> transmitted{}, mismatch{};
  };

  void freeze_variation(const Interface<dim> &interface, double t, const ValuesOf &unknowns);
  void find_pressures(const Interface<dim> &interface);
  void freeze(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
              const MPI_Comm &communicator);
  void end_prediction(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
                      const MPI_Comm &communicator);
  void note_central_gradients(const MPI_Comm &communicator);

  bool is_central(const AtPoint &parameters, unsigned int q) const;
  AtPoint parameters_at(const Interface<dim> &interface, const TiedField &field, unsigned int q) const;
  void find_mean_flux(const Interface<dim> &interface, const TiedField &field, const AtPoint &parameters,
                      unsigned int q);
  bool join(const Interface<dim> &interface, const TiedField &field, unsigned int q,
            const std::array<State<dim>, 2> &side_states, const std::vector<double> &mean_flux,
            const std::vector<double> &jump, AtPoint &parameters, Series &series) const;
  bool join_by_law(const Joint &joint, const std::vector<double> &mean_flux, const std::vector<double> &jump,
                   AtPoint &parameters, Series &series) const;
  void join_linearly(const Interface<dim> &interface, const TiedField &field, unsigned int q,
                     const Joint &joint, const std::vector<double> &mean_flux,
                     const std::vector<double> &jump, double gamma, Series &series) const;
  bool remember_joint(Interface<dim> &interface, unsigned int q, double t,
                      const std::vector<double> &unknowns);
  bool evaluate_sides(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                      unsigned int q, double t, const std::vector<double> &unknowns);
  Asked what_is_asked(const TiedField &field) const
  {
    return asked.empty() ? Asked::derivatives : asked[field.index];
  }
  void ask_sides(const Interface<dim> &interface, bool with_tangent);
  bool add_field(const Interface<dim> &interface, unsigned int field_index, unsigned int q, double t,
                 const std::vector<double> &unknowns, std::vector<double> &residual,
                 dealii::FullMatrix<double> *tangent);
  void keep_own_rows(const typename Pairing<dim>::Group &group, std::vector<double> &residual,
                     dealii::FullMatrix<double> *tangent) const;
  void linearise_mean_flux(const Interface<dim> &interface, const TiedField &field, const AtPoint &parameters,
                           unsigned int q);
  void find_jump_unknowns(const Interface<dim> &interface, const TiedField &field, unsigned int q);
  void add_tangent(const Interface<dim> &interface, const TiedField &field, const AtPoint &parameters,
                   const Series &series, unsigned int q, dealii::FullMatrix<double> &tangent);
  bool varies_as_mean() const;
  void add_variation_rows(const TiedField &field, const Series &series, double weight,
                          dealii::FullMatrix<double> &tangent) const;
  void add_change_of_joint(const Interface<dim> &interface, const AtPoint &parameters, const Series &series,
                           unsigned int q, dealii::FullMatrix<double> &tangent) const;
  void add_curvature(const Interface<dim> &interface, const TiedField &field, const AtPoint &parameters,
                     const Series &series, unsigned int q, dealii::FullMatrix<double> &tangent);
  void add_curvature_rows(const Interface<dim> &interface, const TiedField &field, unsigned int side,
                          unsigned int q, unsigned int component, double share,
                          dealii::FullMatrix<double> &tangent) const;

  const double theta;
  Penalty<dim> penalty_at_points;
  std::array<bool, 2> sides_of_integration;
  bool own_sides;
  const unsigned int variation_rule; ///< automatic, current, frozen
  bool has_frozen_variation = false; ///< delta{A} is that at the beginning of the step
  /// By tied field: the components of the sides' pressures (pressure_of_flux.h). Empty: not yet found.
  std::vector<std::array<std::optional<unsigned int>, 2>> pressures;
  bool varies = false; ///< some delta{A} counts: theta is not 0, or there is a pressure

  PointToggle<dim> toggle;
  GradientChange<dim> change; ///< since the last update
  /// Whether the next update may be found to be large, and since when the penalty joins the sides alone.
  bool may_predict = false, is_predicting = false;
  static constexpr double large_update = 0.2, small_update = 0.1; ///< change of strain, mean
  /// s where a side takes the gradient of the centre, in the last assembly; at field * n_points + point.
  std::map<std::size_t, std::vector<double>> central_flux;
  /// By side: of N.A_c by B_d at the beginning of the step, at (point * n + c) * n + d.
  struct FrozenDerivatives
  {
    dealii::Tensor<1, dim> by_gradient;
    double by_value = 0;
  };
  std::array<std::vector<FrozenDerivatives>, 2> frozen;
  static constexpr double central_factor = 10; ///< of the penalty where the flux is that at a cell's centre
  bool has_begun = false;
  NoteList note_on_centres; ///< at most one
  FluxVariations variations;

  std::vector<Asked> asked;                        ///< by tied field; empty: all
  std::array<std::vector<Asked>, 2> asked_of_side; ///< by field of each side, of the current group

  // of the current group: its unknowns, here those that lead; and residual and tangent of them
  const LeadingUnknowns *leading = nullptr;
  std::vector<double> residual_of_leading;
  dealii::FullMatrix<double> tangent_of_leading;
  /// int d{A}.delta[B] of the points at which delta{A} is d{A}: with its transpose it is both terms.
  dealii::FullMatrix<double> flux_by_jump;
  bool has_flux_by_jump = false;

  // at the current point: states and responses of the two sides, and of the current field what R needs
  SideStates<dim> sides;
  double theta_here = 0;               ///< theta or -1
  std::vector<double> jump, mean_flux; ///< [B] and {A}
  std::vector<double> mean_flux_of;    ///< d{A}_c / dx_i at c * n_local + i
  std::vector<double> transmitted_of;  ///< a.d{A}, likewise; unless a = 1
  std::vector<double> variation_of;    ///< theta delta{A}_c for the test function i, likewise
  struct InJump                        ///< an unknown that enters the jump, with signed trial and test value
  {
    unsigned int i, component;
    double trial, test;
  };
  std::vector<InJump> in_jump;
  std::vector<unsigned int> field_unknowns; ///< all unknowns of the field
  std::vector<dealii::Tensor<1, dim>> contraction;
  dealii::FullMatrix<double> second_derivative;
};

} // namespace dovetail
