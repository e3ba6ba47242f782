// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What Nitsche's tie and the ties that put a joint in series with it share.

#pragma once

#include <dovetail/interface/gradient_change.h>
#include <dovetail/interface/interface.h>
#include <dovetail/interface/side_states.h>
#include <dovetail/interface/trace_eigenvalue.h>

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
/// theta = 1 is symmetric, 0 nonsymmetric (delta{A} is never evaluated), -1 skew-symmetric. The tangent is
/// exact: for theta != 0 and a nonlinear law it holds the second derivative of A, contracted with e. Weights
/// and penalty are frozen at the beginning of a step. Where the first update of a step changes the strain by
/// a fifth, the penalty joins the sides alone until updates are small (adapt()). For theta > 0 and a
/// nonlinear law of a vector field, -1 takes the place of theta at points at which the penalty does not bound
/// the tangent: the skew-symmetric form asks for no bound, and every theta is consistent.
template <int dim>
class Nitsche : public Tie<dim>
{
public:
  explicit Nitsche(const Section &section);

  void set_fields(const Section &section, const std::vector<TiedField> &fields) override;
  std::array<bool, 2> integrates_on() const override { return sides_of_integration; }
  bool adds_terms() const override { return true; }
  bool couples_fluxes() const override { return has_joint(); }
  bool is_symmetric() const override { return theta == 1. && !own_sides; }
  bool is_balanced() const override { return !own_sides; }
  bool has_constant_tangent(const Interface<dim> &interface) const override
  {
    return this->is_linear() && has_constant_penalty(interface);
  }
  std::string description() const override;
  std::vector<std::string> left_out(const Interface<dim> &interface) const override;
  void begin_step(const Interface<dim> &interface, double t, const typename Tie<dim>::Unknowns &unknowns,
                  const MPI_Comm &communicator) override;
  bool refreeze(const Interface<dim> &interface, double t, const typename Tie<dim>::Unknowns &unknowns,
                const MPI_Comm &communicator) override;
  bool adapt(const Interface<dim> &interface, double t, const typename Tie<dim>::Unknowns &unknowns,
             const MPI_Comm &communicator) override;
  bool assemble(const Interface<dim> &interface, const typename Pairing<dim>::Group &group, double t,
                const std::vector<double> &unknowns, std::vector<double> &residual,
                dealii::FullMatrix<double> *tangent) override;
  void accept_state() override { sides.accept(); }
  void numerical_flux(const Interface<dim> &interface, const TiedField &field, unsigned int q,
                      const std::array<State<dim>, 2> &state, const std::array<std::vector<double>, 2> &flux,
                      const std::vector<double> &jump, std::vector<double> &result) const override;
  typename Tie<dim>::Penalty penalty() const override { return range; }
  std::vector<std::string> notes() const override { return sentences; }
  typename Tie<dim>::FluxVariations flux_variations() const override { return variations; }

protected:
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  /// What lies between the two sides at a point.
  struct Joint
  {
    double along_normal = infinity;   ///< h of the component along N, and of a scalar
    double along_tangents = infinity; ///< h of the components across it
    double derivative_by_mean = 0;    ///< dh/dB of a scalar, B the mean of both sides' traces
  };
  /// Whether there is one at all; then find_joint() is asked for it at every point.
  virtual bool has_joint() const { return false; }
  /// @return false if it is not defined at this state of the two sides.
  virtual bool find_joint(const TiedField & /*field*/, const std::array<State<dim>, 2> & /*state*/,
                          Joint & /*joint*/) const
  {
    return true;
  }

private:
  enum class Weights { eigenvalue, volume, equal, source, destination };
  enum class PenaltyRule { eigenvalue, volume, value };

  /// w_src, w_dst and gamma of a field at a point.
  struct Parameters
  {
    std::array<double, 2> weight = {{0, 0}};
    double gamma = 0;
    /// The sides' shares in the least penalty at the beginning of a step, and |N.dA/dgrad B| then; 0: not
    /// known.
    std::array<double, 2> bound = {{0, 0}}, stiffness = {{0, 0}};
    bool is_skew = false; ///< -1 takes the place of theta until the end of the step
  };

  /// The tensors a and b: one value along N, another one across it.
  struct Series
  {
    bool is_rigid = true;
    std::array<double, 2> a = {{1, 1}}, b = {{0, 0}};
    double b_by_mean = 0; ///< - db/dB of a scalar
    dealii::Tensor<1, dim> N;
    /// Of component c of the field with d.
    double entry(const std::array<double, 2> &values, unsigned int c, unsigned int d) const
    {
      return (c == d ? values[1] : 0) + (values[0] - values[1]) * N[c] * N[d];
    }
  };

  void freeze(const Interface<dim> &interface, double t, const typename Tie<dim>::Unknowns &unknowns,
              const MPI_Comm &communicator);
  void end_prediction(const Interface<dim> &interface, double t, const typename Tie<dim>::Unknowns &unknowns,
                      const MPI_Comm &communicator);
  static void check_value(const Section &section, double gamma);
  void check_value(const Interface<dim> &interface, double t, const MPI_Comm &communicator) const;
  static std::optional<double> read_multiplier(const Section &section, PenaltyRule rule);
  bool needs_eigenvalues() const;
  bool has_constant_penalty(const Interface<dim> &interface) const;
  void find_eigenvalues(const Interface<dim> &interface, double t,
                        const typename Tie<dim>::Unknowns &unknowns, const MPI_Comm &communicator);
  void evaluate_stiffness(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                          unsigned int q, double t, const std::vector<double> &unknowns);
  double stiffness(const Interface<dim> &interface, const TiedField &field, unsigned int side,
                   const dealii::Tensor<1, dim> &N) const;
  double choose(const Interface<dim> &interface, unsigned int field_index,
                const typename Pairing<dim>::Group &group, unsigned int q, double t,
                Parameters &chosen) const;
  double multiplier_of(const Interface<dim> &interface, const TiedField &field) const;
  void note_central_gradients(const MPI_Comm &communicator);
  bool may_turn_skew(const Interface<dim> &interface, const TiedField &field) const;
  void note_bound(unsigned int field_index, const typename Pairing<dim>::Group &group,
                  Parameters &chosen) const;
  /// By which factor the penalties of a field have grown, and by which they have shrunk.
  struct Change
  {
    double growth = 0, decrease = 0;
  };
  Change change_to(const std::vector<Parameters> &of_solution, const Interface<dim> &interface,
                   unsigned int field_index, const MPI_Comm &communicator) const;
  double theta_at(const Interface<dim> &interface, const TiedField &field, unsigned int q,
                  Parameters &parameters) const;
  void note_margin(unsigned int field_index, const typename Pairing<dim>::Group &group,
                   const Parameters &chosen, double unit);
  void warn_if_not_coercive(const Interface<dim> &interface, const MPI_Comm &communicator);
  void note_large_penalty(const MPI_Comm &communicator);

  bool join(const Interface<dim> &interface, const TiedField &field, unsigned int q, double gamma,
            const std::array<State<dim>, 2> &of_sides, Series &series) const;
  bool evaluate_sides(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                      unsigned int q, double t, const std::vector<double> &unknowns, bool with_derivatives);
  bool add_field(const Interface<dim> &interface, unsigned int field_index, unsigned int q, double t,
                 const std::vector<double> &unknowns, std::vector<double> &residual,
                 dealii::FullMatrix<double> *tangent);
  void keep_own_rows(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                     std::vector<double> &residual, dealii::FullMatrix<double> *tangent) const;
  void linearise_mean_flux(const Interface<dim> &interface, const TiedField &field,
                           const Parameters &parameters, unsigned int q);
  void find_jump_unknowns(const Interface<dim> &interface, const TiedField &field, unsigned int q);
  void add_tangent(const Interface<dim> &interface, const TiedField &field, const Parameters &parameters,
                   const Series &series, unsigned int q, dealii::FullMatrix<double> &tangent);
  void add_variation_rows(const TiedField &field, const Series &series, double weight,
                          dealii::FullMatrix<double> &tangent) const;
  void add_change_of_joint(const Interface<dim> &interface, const TiedField &field,
                           const Parameters &parameters, const Series &series, unsigned int q,
                           dealii::FullMatrix<double> &tangent) const;
  void add_curvature(const Interface<dim> &interface, const TiedField &field, const Parameters &parameters,
                     unsigned int q, dealii::FullMatrix<double> &tangent);

  const double theta;
  std::array<bool, 2> sides_of_integration;
  bool own_sides;
  const Weights weights;
  const PenaltyRule penalty_rule;
  const std::optional<double> given_multiplier;
  const bool is_automatic; ///< the penalty
  const double multiplier;
  const Expression value;

  std::vector<Parameters> parameters; ///< at field * n_points + point
  GradientChange<dim> change;         ///< since the last update
  /// Whether the next update may be found to be large, and since when the penalty joins the sides alone.
  bool may_predict = false, is_predicting = false;
  std::vector<Parameters> before_prediction;
  static constexpr double large_update = 0.2, small_update = 0.1; ///< change of strain, mean
  /// s where a side takes the gradient of the centre, in the last assembly; likewise.
  std::map<std::size_t, std::vector<double>> central_flux;
  std::vector<double> first_gamma; ///< of the first step, likewise
  /// Of a penalty in a step: harmless, too much, too much.
  static constexpr double small_growth = 1.5, largest_growth = 10, largest_mean_growth = 5,
                          largest_decrease = 100;
  static constexpr double central_factor = 10; ///< of the penalty where the flux is that at a cell's centre
  bool has_begun = false, has_warned = false, has_noted_centres = false;
  /// By field, of the cells behind the points; empty if nothing needs them.
  std::vector<TraceEigenvalues> lambda;
  typename Tie<dim>::Penalty range;
  double least_multiplier = 0; ///< with which all points would be coercive
  double excess = 0;           ///< largest gamma in units of that which theta = 1 needs
  std::vector<std::string> sentences;
  typename Tie<dim>::FluxVariations variations;

  // at the current point: states and responses of the two sides, and of the current field what R needs
  SideStates<dim> sides;
  double theta_here = 0;                                      ///< theta or -1
  std::vector<double> jump, mean_flux, transmitted, mismatch; ///< [B], {A}, s and e
  std::vector<double> mean_flux_of;                           ///< d{A}_c / dx_i at c * n_local + i
  std::vector<double> transmitted_of;                         ///< a.d{A}, likewise; unless a = 1
  std::vector<double> variation_of; ///< delta{A}_c for the test function i, likewise
  struct InJump                     ///< an unknown that enters the jump, with signed trial and test value
  {
    unsigned int i, component;
    double trial, test;
  };
  std::vector<InJump> in_jump;
  std::vector<unsigned int> of_field; ///< all unknowns of the field
  std::vector<dealii::Tensor<1, dim>> contraction;
  dealii::FullMatrix<double> second_derivative;
};

} // namespace dovetail
