// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Nitsche's method for any conjugate pair of flux A and trace B (Nitsche 1971; Burman and Zunino 2006 for the
// weights; Annavarapu, Hautefeuille and Dolbow, CMAME 225-228, 2012, for the penalty `volume`):
//
//     R(delta) = int_Gamma  - {A}.delta[B]  - theta delta{A}.[B]  + gamma [B].delta[B]  dGamma
//
// with the signs of pairing.h; nitsche.h has the form with a joint in series. Where A has a part of a
// pressure p, delta{A} has another term for it, without theta: - {delta p N}.[B]. Then the volume that the
// equation of p sees and the work of p belong to each other, whatever theta is: with delta B = B and delta p
// = -p both terms cancel.
//
// Own sides: each side's test functions are integrated on its own faces, so a constant flux becomes exactly
// its consistent nodal forces also with mapped points. The price is a matrix that is not symmetric.
//
//     subsection Interface seam
//       set Type        = Nitsche
//       set Source      = left : 1
//       set Destination = right : 0
//       set Theta       = 1
//     end

#include <dovetail/domain/pressure_of_flux.h>
#include <dovetail/interface/trace_eigenvalue.h>
#include <dovetail/tie/nitsche.h>
#include <dovetail/widest_vectors.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/symmetric_tensor.h>
#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_centres("turned cells", "a law is not defined at points of an interface");

/// A unit normal and, across it, other unit vectors: of no matter which direction, but always the same.
template <int dim>
std::array<dealii::Tensor<1, dim>, dim> axes_with(const dealii::Tensor<1, dim> &N)
{
  std::array<dealii::Tensor<1, dim>, dim> axes;
  axes[0] = N;
  if constexpr (dim == 2)
    axes[1] = dealii::Point<2>(-N[1], N[0]);
  else {
    unsigned int least = 0;
    for (unsigned int d = 1; d < dim; ++d)
      if (std::abs(N[d]) < std::abs(N[least]))
        least = d;
    axes[1][least] = 1;
    axes[1] -= N[least] * N;
    axes[1] /= axes[1].norm();
    axes[2] = dealii::cross_product_3d(N, axes[1]);
  }
  return axes;
}

/// The component of a side's pressure, if the flux of a tied field has a part of it.
template <int dim>
std::optional<unsigned int> pressure_on(const unsigned int side, const Interface<dim> &interface,
                                        const TiedField &field)
{
  return pressure_of_flux(*interface.sides[side].domain, field.field[side]);
}

template <int dim>
bool has_pressure(const Interface<dim> &interface)
{
  return std::any_of(interface.fields.begin(), interface.fields.end(), [&](const TiedField &field) {
    return pressure_on(source, interface, field) || pressure_on(destination, interface, field);
  });
}

} // namespace

template <int dim>
Nitsche<dim>::Nitsche(const Section &section)
    : theta(section.read<double>("Theta", 1.,
                                 "1 symmetric, 0 nonsymmetric, -1 skew-symmetric; any number [-]")),
      penalty_at_points(section, theta),
      variation_rule(section.choose(
          "Variation", {"automatic", "current", "frozen"}, 0,
          "The variation of the mean flux, for Theta other than 0: current: at the present state, which "
          "takes second derivatives of the laws; frozen: at the beginning of the step, consistent but not "
          "symmetric; automatic: frozen only for laws without second derivatives [-]")),
      toggle(section)
{
  const unsigned int integrate_on = section.choose(
      "Integrate on", {"source", "destination", "both", "own sides"}, 0,
      "Whose faces hold the points; both: with half the weight each; own sides: the test functions of each "
      "side on its own faces, patch-exact also with mapped points, but not symmetric [-]");
  sides_of_integration = {{integrate_on != 1, integrate_on != 0}};
  own_sides = integrate_on == 3;
}

template <int dim>
void Nitsche<dim>::set_fields(const Section &section, const std::vector<TiedField> &fields)
{
  const auto without =
      std::find_if(fields.begin(), fields.end(), [](const TiedField &field) { return !field.has_curvature; });
  section.check(without == fields.end() || theta == 0 || variation_rule != 1, "Variation",
                "is current, but a law of the " + (without == fields.end() ? "" : without->name) +
                    " has no second derivatives. Remove the entry, or set Theta = 0.");
  penalty_at_points.set_fields(section, fields);
  has_frozen_variation = variation_rule == 2 || without != fields.end();
}

template <int dim>
std::string Nitsche<dim>::description() const
{
  std::ostringstream words;
  words << "Theta = " << theta << ", " << penalty_at_points.description()
        << (own_sides ? ", each side's test functions on it" : "");
  return words.str();
}

template <int dim>
std::vector<std::string> Nitsche<dim>::left_out(const Interface<dim> &interface) const
{
  std::vector<std::string> sentences;
  if (theta == 0 && !has_pressure(interface))
    sentences.push_back("derivative of the mean flux on " + interface.name + ": Theta = 0");
  else if (interface.is_linear())
    sentences.push_back("second derivatives of the laws on " + interface.name + ": they are linear");
  else if (has_frozen_variation)
    sentences.push_back("second derivatives of the laws on " + interface.name + ": Variation = frozen");
  if (!penalty_at_points.needs_eigenvalues())
    sentences.push_back("trace eigenvalues on " + interface.name +
                        ": neither weights nor penalty ask for them, and Theta = -1 has no bound");
  return sentences;
}

template <int dim>
NoteList Nitsche<dim>::notes() const
{
  NoteList all = note_on_centres;
  all.insert(all.end(), penalty_at_points.notes().begin(), penalty_at_points.notes().end());
  return all;
}

template <int dim>
void Nitsche<dim>::note_central_gradients(const MPI_Comm &communicator)
{
  if (!note_on_centres.empty())
    return;
  const unsigned int n = dealii::Utilities::MPI::sum(sides.n_central(), communicator);
  if (n == 0)
    return;
  note_on_centres.push_back(
      of_centres("at " + std::to_string(n) +
                 " of its points a law is not defined on the face or soon will not be, as beside corners "
                 "where cells turn over: the flux at the centre of the cell takes its place there, and "
                 "ten times the penalty. Refine the mesh there, and see what changes."));
}

template <int dim>
void Nitsche<dim>::begin_step(const Interface<dim> &interface, const double t, const ValuesOf &values_of,
                              const MPI_Comm &communicator)
{
  toggle.look(interface, t, values_of, communicator);
  if (pressures.empty())
    find_pressures(interface);
  freeze(interface, t, values_of, communicator);
  if (has_frozen_variation)
    freeze_variation(interface, t, values_of);
  may_predict = penalty_at_points.is_automatic() && has_large_strain(interface);
  is_predicting = false;
  if (may_predict)
    change.start(interface, values_of);
}

template <int dim>
bool Nitsche<dim>::couples_insides(const Interface<dim> &interface) const
{
  return (theta != 0 || has_pressure(interface)) && !interface.is_linear();
}

template <int dim>
void Nitsche<dim>::find_pressures(const Interface<dim> &interface)
{
  varies = theta != 0 || has_pressure(interface);
  for (const TiedField &field : interface.fields)
    pressures.push_back(
        {{pressure_on(source, interface, field), pressure_on(destination, interface, field)}});
  has_frozen_variation = has_frozen_variation && varies;
}

/// Zero where a law is not defined.
template <int dim>
void Nitsche<dim>::freeze_variation(const Interface<dim> &interface, const double t,
                                    const ValuesOf &values_of)
{
  for (const unsigned int side : {source, destination})
    frozen[side].assign(interface.pairing().n_points() *
                            dealii::Utilities::fixed_power<2>(interface.sides[side].domain->n_components()),
                        FrozenDerivatives());
  for_each_group(interface, values_of, [&](const auto &group, const std::vector<double> &unknowns) {
    for (unsigned int q = group.begin; q < group.end; ++q)
      for (const unsigned int side : {source, destination})
        if (sides.evaluate(interface, group, side, q, t, unknowns, true)) {
          const auto &[N, response] = std::tie(interface.pairing().N(side, q), sides.response[side]);
          const unsigned int n_pairs = response.by_gradient.size();
          for (unsigned int pair = 0; pair < n_pairs; ++pair)
            frozen[side][q * n_pairs + pair] = {N * response.by_gradient[pair], N * response.by_value[pair]};
        }
  });
}

template <int dim>
bool Nitsche<dim>::evaluate_memory(Interface<dim> &interface, const double t, const ValuesOf &values_of)
{
  bool is_defined = true;
  for_each_group(interface, values_of, [&](const auto &group, const std::vector<double> &unknowns) {
    for (unsigned int q = group.begin; q < group.end; ++q)
      for (const unsigned int side : {source, destination}) {
        is_defined = sides.evaluate(interface, group, side, q, t, unknowns, false) && is_defined;
        interface.memory.set_trial(side, q, sides.state[side].memory.trial);
        if (side == destination && interface.memory.has_joint() && !toggle.is_on(q))
          interface.memory.keep_joint(q);
        else if (side == destination && interface.memory.has_joint())
          is_defined = remember_joint(interface, q, t, unknowns) && is_defined;
      }
  });
  return is_defined;
}

/// After both sides have been evaluated.
template <int dim>
bool Nitsche<dim>::remember_joint(Interface<dim> &interface, const unsigned int q, const double t,
                                  const std::vector<double> &unknowns)
{
  bool is_defined = true;
  for (const TiedField &field : interface.fields) {
    if (field.n_components == 1)
      continue;
    AtPoint p = parameters_at(interface, field, q);
    find_mean_flux(interface, field, p, q);
    interface.jump(field, q, t, unknowns, jump);
    Joint joint;
    is_defined = find_joint(interface, field, q, sides.state, joint) && is_defined;
    Series series;
    is_defined = is_defined && join_by_law(joint, mean_flux, jump, p, series);
    interface.memory.set_trial(InterfaceMemory<dim>::joint, q, joint.place.memory.trial);
  }
  return is_defined;
}

/// The first update of a step moves the bodies along straight lines. If it moves them far, the fluxes there
/// say little and the frozen penalty does not bound their tangents. Until the updates are small the penalty
/// joins the sides alone: its form is positive in every state, and asks no law at the interface.
template <int dim>
bool Nitsche<dim>::adapt(const Interface<dim> &interface, const double t, const ValuesOf &values_of,
                         const MPI_Comm &communicator)
{
  if (!may_predict && !is_predicting)
    return false;
  const double update = change.advance(interface, values_of, communicator);
  if (is_predicting) {
    if (update < small_update)
      end_prediction(interface, t, values_of, communicator);
    return !is_predicting;
  }
  may_predict = false;
  is_predicting = update > large_update;
  if (!is_predicting)
    return false;
  penalty_at_points.begin_prediction(interface);
  return true;
}

template <int dim>
void Nitsche<dim>::end_prediction(const Interface<dim> &interface, const double t, const ValuesOf &values_of,
                                  const MPI_Comm &communicator)
{
  is_predicting = false;
  penalty_at_points.end_prediction(); // what was frozen stays where nothing better is found
  freeze(interface, t, values_of, communicator);
}

template <int dim>
void Nitsche<dim>::freeze(const Interface<dim> &interface, const double t, const ValuesOf &values_of,
                          const MPI_Comm &communicator)
{
  if (has_begun && penalty_at_points.is_constant(interface))
    return;
  has_begun = true;
  sides.begin_step(interface, t, values_of);
  note_central_gradients(communicator);
  penalty_at_points.freeze(interface, t, values_of, sides, communicator);
  if (!has_joint())
    penalty_at_points.note_if_large(communicator);
}

template <int dim>
bool Nitsche<dim>::update_penalties(const Interface<dim> &interface, const double t,
                                    const ValuesOf &values_of, const MPI_Comm &communicator)
{
  if (penalty_at_points.is_constant(interface))
    return false;
  if (is_predicting) {
    end_prediction(interface, t, values_of, communicator);
    return true;
  }
  const SideStates<dim> used_sides = sides;
  sides.begin_step(interface, t, values_of);
  note_central_gradients(communicator);
  const bool is_new = penalty_at_points.update(interface, t, values_of, sides, communicator);
  if (!has_joint())
    penalty_at_points.note_if_large(communicator);
  if (!is_new)
    sides = used_sides;
  return is_new;
}

/// Nothing if they follow from the scene alone.
template <int dim>
std::vector<double> Nitsche<dim>::pack_points(const Interface<dim> &interface) const
{
  const unsigned int n_points = interface.pairing().n_points();
  const bool follows = penalty_at_points.is_constant(interface) || penalty_at_points.empty();
  return toggle.pack(n_points, follows ? std::vector<double>() : penalty_at_points.pack(n_points));
}

template <int dim>
void Nitsche<dim>::unpack_points(const Interface<dim> &interface, const std::vector<double> &numbers)
{
  const unsigned int n_points = interface.pairing().n_points();
  if (const auto penalties = toggle.unpack(n_points, numbers);
      !penalties.empty() || !toggle.is_given() || !penalty_at_points.is_constant(interface))
    penalty_at_points.unpack(n_points, penalties);
}

/// Whether a side whose flux counts takes the gradient of the centre.
template <int dim>
bool Nitsche<dim>::is_central(const AtPoint &p, const unsigned int q) const
{
  return (p.weight[source] != 0 && sides.is_central(source, q)) ||
         (p.weight[destination] != 0 && sides.is_central(destination, q));
}

/// With the penalty in force.
template <int dim>
typename Nitsche<dim>::AtPoint Nitsche<dim>::parameters_at(const Interface<dim> &interface,
                                                           const TiedField &field, const unsigned int q) const
{
  AtPoint p = penalty_at_points[field.index * interface.pairing().n_points() + q];
  if (is_central(p, q) && has_large_strain(interface, field))
    p.gamma *= central_factor;
  return p;
}

template <int dim>
void Nitsche<dim>::find_mean_flux(const Interface<dim> &interface, const TiedField &field, const AtPoint &p,
                                  const unsigned int q)
{
  mean_flux.assign(field.n_components, 0.);
  for (const unsigned int side : {source, destination})
    if (p.weight[side] != 0)
      for (unsigned int c = 0; c < field.n_components; ++c)
        mean_flux[c] +=
            (side == source ? 1 : -1) * p.weight[side] *
            (sides.response[side].flux[field.first_component[side] + c] * interface.pairing().N(side, q));
}

/// The series at a point; adds to the penalty what the law of a joint asks for.
template <int dim>
bool Nitsche<dim>::join(const Interface<dim> &interface, const TiedField &field, const unsigned int q,
                        const std::array<State<dim>, 2> &side_states, const std::vector<double> &mean_flux,
                        const std::vector<double> &jump, AtPoint &p, Series &series) const
{
  if (has_joint()) {
    Joint joint;
    if (!find_joint(interface, field, q, side_states, joint))
      return false;
    if (joint.law != nullptr)
      return join_by_law(joint, mean_flux, jump, p, series);
    join_linearly(interface, field, q, joint, mean_flux, jump, p.gamma, series);
    return true;
  }
  for (unsigned int c = 0; c < field.n_components; ++c) {
    series.transmitted[c] = mean_flux[c] - p.gamma * jump[c];
    series.mismatch[c] = jump[c];
  }
  return true;
}

/// a and b have one value along the normal, another one across it.
template <int dim>
void Nitsche<dim>::join_linearly(const Interface<dim> &interface, const TiedField &field,
                                 const unsigned int q, const Joint &joint,
                                 const std::vector<double> &mean_flux, const std::vector<double> &jump,
                                 const double gamma, Series &series) const
{
  series.is_rigid = false;
  const std::array<double, 2> h = {{joint.along_normal, joint.along_tangents}};
  std::array<double, 2> a, b;
  for (const unsigned int i : {0, 1}) {
    b[i] = h[i] + gamma > 0 ? 1 / (h[i] + gamma) : 0;
    a[i] = std::isfinite(h[i]) ? h[i] * b[i] : 1;
  }
  if (field.n_components == 1) {
    series.a[0][0] = a[0];
    series.b[0][0] = b[0];
    if (std::isfinite(h[0]))
      series.h_by_state = joint.by_state;
  } else {
    dealii::Tensor<1, dim> N = interface.pairing().N(source, q) - interface.pairing().N(destination, q);
    N /= N.norm();
    for (unsigned int c = 0; c < dim; ++c)
      for (unsigned int d = 0; d < dim; ++d) {
        series.a[c][d] = (c == d ? a[1] : 0) + (a[0] - a[1]) * N[c] * N[d];
        series.b[c][d] = (c == d ? b[1] : 0) + (b[0] - b[1]) * N[c] * N[d];
      }
  }
  for (unsigned int c = 0; c < field.n_components; ++c)
    for (unsigned int d = 0; d < field.n_components; ++d) {
      series.transmitted[c] += series.a[c][d] * (mean_flux[d] - gamma * jump[d]);
      series.mismatch[c] += series.a[c][d] * jump[d] + series.b[c][d] * mean_flux[d];
    }
}

/// The opening in the axes of the joint: its normal, and across it any two (2D: one).
template <int dim>
bool Nitsche<dim>::join_by_law(const Joint &joint, const std::vector<double> &mean_flux,
                               const std::vector<double> &jump, AtPoint &p, Series &series) const
{
  series.is_rigid = false;
  p.gamma += joint.law->softening(joint.place);
  const std::array<dealii::Tensor<1, dim>, dim> axes = axes_with(joint.normal);
  dealii::Tensor<1, 3> r, opening;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int c = 0; c < dim; ++c)
      r[i] += axes[i][c] * (mean_flux[c] - p.gamma * jump[c]);
  JointResponse response;
  if (!find_opening(*joint.law, joint.place, p.gamma, r, opening, response))
    return false;
  const dealii::Tensor<2, 3> b =
      invert(response.by_opening + p.gamma * dealii::Tensor<2, 3>(dealii::unit_symmetric_tensor<3>()));
  const dealii::Tensor<2, 3> a = response.by_opening * b;
  for (unsigned int c = 0; c < dim; ++c) {
    series.mismatch[c] = jump[c];
    for (unsigned int i = 0; i < dim; ++i) {
      series.transmitted[c] += axes[i][c] * response.traction[i];
      series.mismatch[c] += axes[i][c] * opening[i];
      for (unsigned int d = 0; d < dim; ++d)
        for (unsigned int j = 0; j < dim; ++j) {
          series.a[c][d] += axes[i][c] * a[i][j] * axes[j][d];
          series.b[c][d] += axes[i][c] * b[i][j] * axes[j][d];
        }
    }
  }
  return true;
}

/// s, what the source gets from the destination.
template <int dim>
void Nitsche<dim>::numerical_flux(const Interface<dim> &interface, const TiedField &field,
                                  const unsigned int q, const std::array<State<dim>, 2> &side_states,
                                  const std::array<std::vector<double>, 2> &flux,
                                  const std::vector<double> &jump, std::vector<double> &result) const
{
  if (!toggle.is_on(q)) {
    std::fill(result.begin(), result.end(), 0.);
    return;
  }
  if (penalty_at_points.empty()) // the tie has not been active yet
    return Tie<dim>::numerical_flux(interface, field, q, side_states, flux, jump, result);
  const unsigned int i_at = field.index * interface.pairing().n_points() + q;
  const AtPoint &p = penalty_at_points[i_at];
  for (const unsigned int side : {source, destination})
    if (const auto known = central_flux.find(i_at);
        p.weight[side] != 0 && sides.is_central(side, q) && known != central_flux.end()) {
      result = known->second; // that of the last assembly
      return;
    }
  AtPoint in_force = p;
  std::vector<double> mean(field.n_components);
  for (unsigned int c = 0; c < field.n_components; ++c)
    mean[c] = p.weight[source] * flux[source][c] - p.weight[destination] * flux[destination][c];
  Series series;
  const bool is_defined = join(interface, field, q, side_states, mean, jump, in_force, series);
  for (unsigned int c = 0; c < field.n_components; ++c)
    result[c] = is_defined ? series.transmitted[c] : std::numeric_limits<double>::quiet_NaN();
}

/// -{A}.[B] + gamma/2 |[B]|^2 with {A} = s + gamma [B].
template <int dim>
std::optional<double> Nitsche<dim>::energy(const Interface<dim> &interface, const TiedField &field,
                                           const unsigned int q, const std::vector<double> &s,
                                           const std::vector<double> &jump) const
{
  if (!toggle.is_on(q) || penalty_at_points.empty())
    return 0.;
  const AtPoint &p = penalty_at_points[field.index * interface.pairing().n_points() + q];
  if (!is_symmetric() || has_joint() || (is_central(p, q) && has_pressure(interface)))
    return {};
  const double gamma = p.gamma;
  double energy = 0;
  for (unsigned int c = 0; c < field.n_components; ++c)
    energy -= s[c] * jump[c] + gamma / 2 * jump[c] * jump[c];
  return energy;
}

/// A joint sees all that the two sides do, and where strains are large a side's flux may be that at the
/// centre of the cell, which all its laws choose together.
template <int dim>
void Nitsche<dim>::ask_sides(const Interface<dim> &interface, const bool with_tangent)
{
  const bool needs_all = asked.empty() || has_joint() || has_large_strain(interface);
  for (const unsigned int side : {source, destination}) {
    std::vector<Asked> &of_side = asked_of_side[side];
    const Material<dim> &material = interface.sides[side].domain->material;
    of_side = material.asks_for_all(with_tangent || varies);
    if (needs_all)
      continue;
    std::fill(of_side.begin(), of_side.end(), Asked::nothing);
    for (const TiedField &field : interface.fields)
      if (what_is_asked(field) != Asked::nothing)
        of_side[field.field[side]] = varies || (with_tangent && what_is_asked(field) == Asked::derivatives)
                                         ? Asked::derivatives
                                         : Asked::response;
  }
}

/// @return false where a law is not defined, or no penalty was found at the beginning of the step.
template <int dim>
bool Nitsche<dim>::evaluate_sides(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                                  const unsigned int q, const double t, const std::vector<double> &unknowns)
{
  for (const unsigned int side : {source, destination}) {
    bool is_weighted = false;
    for (unsigned int f = 0; f < interface.fields.size(); ++f) {
      const AtPoint &p = penalty_at_points[f * interface.pairing().n_points() + q];
      if (std::isnan(p.gamma))
        return false;
      is_weighted = is_weighted || p.weight[side] != 0;
    }
    if (is_weighted) {
      if (!sides.evaluate(interface, group, side, q, t, unknowns, asked_of_side[side]))
        return false;
    } else if (has_joint()) {
      sides.state[side].t = t;
      sides.reinit(side, q, unknowns);
    }
  }
  return true;
}

template <int dim>
bool Nitsche<dim>::assemble(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                            const double t, const std::vector<double> &unknowns,
                            std::vector<double> &residual, dealii::FullMatrix<double> *tangent)
{
  const LeadingUnknowns &of_group = *leading_unknowns(interface, group);
  if (of_group.is_complete())
    return assemble_leading(interface, group, t, unknowns, residual, tangent);
  const unsigned int n = of_group.size();
  residual_of_leading.assign(n, 0.);
  if (tangent != nullptr)
    tangent_of_leading.reinit(n, n);
  if (!assemble_leading(interface, group, t, unknowns, residual_of_leading,
                        tangent == nullptr ? nullptr : &tangent_of_leading))
    return false;
  of_group.expand(residual_of_leading, residual);
  if (tangent != nullptr)
    of_group.expand(tangent_of_leading, *tangent);
  return true;
}

/// All where a flux may be that at the centre of a cell.
template <int dim>
const LeadingUnknowns *Nitsche<dim>::leading_unknowns(const Interface<dim> &interface,
                                                      const typename Pairing<dim>::Group &group) const
{
  return has_large_strain(interface) ? &interface.all_unknowns() : &interface.leading_unknowns(group);
}

template <int dim>
bool Nitsche<dim>::assemble_leading(const Interface<dim> &interface,
                                    const typename Pairing<dim>::Group &group, const double t,
                                    const std::vector<double> &unknowns, std::vector<double> &residual,
                                    dealii::FullMatrix<double> *tangent)
{
  leading = leading_unknowns(interface, group);
  has_flux_by_jump = false;
  ask_sides(interface, tangent != nullptr);
  for (unsigned int q = group.begin; q < group.end; ++q) {
    if (!toggle.is_on(q))
      continue;
    if (!evaluate_sides(interface, group, q, t, unknowns))
      return false;
    for (const TiedField &field : interface.fields)
      if (const Asked what = what_is_asked(field);
          what != Asked::nothing && !add_field(interface, field.index, q, t, unknowns, residual,
                                               what == Asked::derivatives ? tangent : nullptr))
        return false;
  }
  if (has_flux_by_jump) {
    tangent->add(1., flux_by_jump);
    tangent->Tadd(1., flux_by_jump);
  }
  if (own_sides)
    keep_own_rows(group, residual, tangent);
  return true;
}

/// The test functions of the side on whose faces the points lie, with the whole weight.
template <int dim>
void Nitsche<dim>::keep_own_rows(const typename Pairing<dim>::Group &group, std::vector<double> &residual,
                                 dealii::FullMatrix<double> *tangent) const
{
  for (unsigned int i = 0; i < residual.size(); ++i) {
    const double factor = (i < leading->n_of_side[source]) == (group.side == source) ? 2 : 0;
    residual[i] *= factor;
    if (tangent != nullptr)
      for (unsigned int j = 0; j < residual.size(); ++j)
        (*tangent)(i, j) *= factor;
  }
}

template <int dim>
bool Nitsche<dim>::add_field(const Interface<dim> &interface, const unsigned int field_index,
                             const unsigned int q, const double t, const std::vector<double> &unknowns,
                             std::vector<double> &residual, dealii::FullMatrix<double> *tangent)
{
  const Pairing<dim> &pairing = interface.pairing();
  const TiedField &field = interface.fields[field_index];
  const unsigned int i_at = field_index * pairing.n_points() + q;
  const unsigned int n_c = field.n_components, n_local = residual.size();
  theta_here = penalty_at_points.theta_at(interface, field, q, sides, i_at);
  AtPoint p = parameters_at(interface, field, q);
  interface.jump(field, q, t, unknowns, jump);
  if (!std::all_of(jump.begin(), jump.end(), [](const double value) { return std::isfinite(value); }))
    return false;
  find_mean_flux(interface, field, p, q);
  Series series;
  if (!join(interface, field, q, sides.state, mean_flux, jump, p, series))
    return false;
  if (is_central(p, q))
    central_flux[i_at].assign(series.transmitted.begin(), series.transmitted.begin() + n_c);
  if (tangent != nullptr || varies)
    linearise_mean_flux(interface, field, p, q);

  find_jump_unknowns(interface, field, q);
  for (const InJump &row : in_jump)
    residual[row.i] -= pairing.weight(q) * row.test * series.transmitted[row.component];
  if (varies)
    for (const unsigned int i : field_unknowns)
      for (unsigned int c = 0; c < n_c; ++c)
        residual[i] -= pairing.weight(q) * variation_of[c * n_local + i] * series.mismatch[c];
  if (tangent == nullptr)
    return true;
  add_tangent(interface, field, p, series, q, *tangent);
  if (varies && !interface.is_linear() && !has_frozen_variation)
    add_curvature(interface, field, p, series, q, *tangent);
  return true;
}

/// d{A}_c/dx_i = +-w N.(dA_c/dgrad B_d . grad phi_a + dA_c/dB_d phi_a) for the unknown i = (side, d, a), and
/// theta delta{A}. A test function of a scalar varies the flux through its gradient only, so that a constant
/// one does not and the fluxes of both sides balance also for k(T); that of a vector by its value, too, which
/// is the strain around an axis, and that of a pressure by its value alone and without theta.
template <int dim>
void Nitsche<dim>::linearise_mean_flux(const Interface<dim> &interface, const TiedField &field,
                                       const AtPoint &p, const unsigned int q)
{
  const Pairing<dim> &pairing = interface.pairing();
  const unsigned int n_c = field.n_components, n_local = leading->size();
  mean_flux_of.assign(n_c * n_local, 0.);
  if (varies) {
    variation_of.assign(n_c * n_local, 0.);
    ++variations.first;
  }
  for (const unsigned int side : {source, destination}) {
    const Domain<dim> &domain = *interface.sides[side].domain;
    const unsigned int n = domain.n_components();
    const double factor = (side == source ? 1 : -1) * p.weight[side];
    unsigned int i = side == source ? 0 : leading->n_of_side[source];
    for (unsigned int k = 0; factor != 0 && k < interface.components[side].size(); ++k) {
      const unsigned int d = interface.components[side][k];
      const std::vector<unsigned int> &nodes = leading->nodes[side][k];
      const unsigned int n_nodes = nodes.size();
      const dealii::Tensor<1, dim> *gradients = sides.shape_gradients[side] + domain.layout().first_shape(d);
      const double *values = pairing.values(side, q) + domain.layout().first_shape(d);
      const bool is_multiplier = pressures[field.index][side] == d,
                 varies_by_value = field.varies_by_value(side, d) || is_multiplier,
                 is_of_field = d - field.first_component[side] < field.n_components; // wraps below the first
      const double share = is_multiplier ? 1 : is_of_field ? theta_here : 0;         // of delta{A}
      for (unsigned int c = 0; c < n_c; ++c) {
        const unsigned int pair = (field.first_component[side] + c) * n + d;
        const dealii::Tensor<1, dim> by_gradient =
            factor * (pairing.N(side, q) * sides.response[side].by_gradient[pair]);
        const double by_value = factor * (pairing.N(side, q) * sides.response[side].by_value[pair]);
        double *mean = &mean_flux_of[c * n_local + i];
        double *variation = varies ? &variation_of[c * n_local + i] : nullptr;
        const auto vary_as_mean = [&](const bool is_now) {
          for (unsigned int a = 0; is_now && a < n_nodes; ++a)
            variation[a] = share * mean[a];
        };
        for (unsigned int a = 0; a < n_nodes; ++a)
          mean[a] = by_gradient * gradients[nodes[a]];
        if (has_frozen_variation)
          for (unsigned int a = 0; a < n_nodes; ++a)
            variation[a] =
                share * factor *
                (frozen[side][q * n * n + pair].by_gradient * gradients[nodes[a]] +
                 (varies_by_value ? frozen[side][q * n * n + pair].by_value * values[nodes[a]] : 0.));
        vary_as_mean(varies && !varies_by_value && !has_frozen_variation);
        if (by_value != 0)
          for (unsigned int a = 0; a < n_nodes; ++a)
            mean[a] += by_value * values[nodes[a]];
        vary_as_mean(varies && varies_by_value && !has_frozen_variation);
      }
      i += n_nodes;
    }
  }
  if (theta != 0 && field.has_partition()) // the flux varies by K times the destination's trace
    for (unsigned int c = 0; c < n_c; ++c)
      for (unsigned int j = leading->n_of_side[source]; j < n_local; ++j)
        variation_of[c * n_local + j] /= field.partition;
}

template <int dim>
void Nitsche<dim>::find_jump_unknowns(const Interface<dim> &interface, const TiedField &field,
                                      const unsigned int q)
{
  in_jump.clear();
  field_unknowns.clear();
  unsigned int i = 0;
  for (const unsigned int side : {source, destination}) {
    const double sign = side == source ? 1 : -1;
    const double *trial = interface.pairing().trial(side, q, field.index) + field.first_shape[side],
                 *test = interface.pairing().test(side, q, field.index) + field.first_shape[side];
    for (unsigned int k = 0; k < interface.components[side].size(); ++k) {
      const unsigned int c =
          interface.components[side][k] - field.first_component[side]; // wraps if not of this field
      for (const unsigned int a : leading->nodes[side][k]) {
        if (c < field.n_components) {
          field_unknowns.push_back(i);
          if (std::abs(trial[a]) > interface.least_in_jump || std::abs(test[a]) > interface.least_in_jump)
            in_jump.push_back({i, c, sign * field.in_jump(side) * trial[a], sign * test[a]});
        } else if (pressures[field.index][side] == interface.components[side][k])
          field_unknowns.push_back(i);
        ++i;
      }
    }
  }
}

namespace {

/// y -= a x
DOVETAIL_WIDEST_VECTORS void subtract(const std::size_t n, const double a, const double *const x,
                                      double *const __restrict__ y)
{
  for (std::size_t i = 0; i < n; ++i)
    y[i] -= a * x[i];
}

} // namespace

/// - ds.delta[B] - theta delta{A}.de
template <int dim>
void Nitsche<dim>::add_tangent(const Interface<dim> &interface, const TiedField &field, const AtPoint &p,
                               const Series &series, const unsigned int q,
                               dealii::FullMatrix<double> &tangent)
{
  const double w = interface.pairing().weight(q);
  const unsigned int n_local = tangent.n(), n_c = field.n_components;
  if (!series.is_rigid) {
    transmitted_of.assign(n_c * n_local, 0.);
    for (unsigned int c = 0; c < n_c; ++c)
      for (unsigned int d = 0; d < n_c; ++d) {
        const double a = series.a[c][d];
        for (unsigned int j = 0; j < n_local; ++j)
          transmitted_of[c * n_local + j] += a * mean_flux_of[d * n_local + j];
      }
  }
  const bool is_mirrored = series.is_rigid && varies_as_mean();
  if (is_mirrored && !has_flux_by_jump)
    flux_by_jump.reinit(n_local, n_local);
  has_flux_by_jump = has_flux_by_jump || is_mirrored;
  for (const InJump &row : in_jump) {
    const double test = w * row.test;
    const double *row_flux = &(series.is_rigid ? mean_flux_of : transmitted_of)[row.component * n_local];
    double *entries = &tangent(row.i, 0), *with_flux = is_mirrored ? &flux_by_jump(row.i, 0) : entries;
    subtract(n_local, test, row_flux, with_flux);
    const double penalty = p.gamma * test;
    if (series.is_rigid) {
      for (const InJump &column : in_jump)
        if (column.component == row.component)
          entries[column.i] += penalty * column.trial;
    } else
      for (const InJump &column : in_jump)
        entries[column.i] += series.a[row.component][column.component] * penalty * column.trial;
  }
  if (varies && !is_mirrored)
    add_variation_rows(field, series, w, tangent);
  if (!series.h_by_state[source].empty() || !series.h_by_state[destination].empty())
    add_change_of_joint(interface, p, series, q, tangent);
}

/// Whether - delta{A}.d[B] is the transpose of - d{A}.delta[B].
template <int dim>
bool Nitsche<dim>::varies_as_mean() const
{
  return theta_here == 1 && variation_of == mean_flux_of &&
         std::all_of(in_jump.begin(), in_jump.end(), [](const InJump &row) { return row.trial == row.test; });
}

/// - theta delta{A}.(a.d[B] + b.d{A})
template <int dim>
void Nitsche<dim>::add_variation_rows(const TiedField &field, const Series &series, const double weight,
                                      dealii::FullMatrix<double> &tangent) const
{
  const unsigned int n_local = tangent.n(), n_c = field.n_components;
  for (const unsigned int row : field_unknowns) {
    std::array<double, dim> variation, jump_factor;
    for (unsigned int c = 0; c < n_c; ++c)
      variation[c] = jump_factor[c] = weight * variation_of[c * n_local + row];
    double *entries = &tangent(row, 0);
    if (!series.is_rigid)
      for (unsigned int c = 0; c < n_c; ++c) {
        double flux_factor = 0;
        jump_factor[c] = 0;
        for (unsigned int d = 0; d < n_c; ++d) {
          jump_factor[c] += variation[d] * series.a[d][c];
          flux_factor += variation[d] * series.b[d][c];
        }
        subtract(n_local, flux_factor, &mean_flux_of[c * n_local], entries);
      }
    for (const InJump *column = in_jump.data(), *end = column + in_jump.size(); column != end;) {
      const unsigned int c = column->component;
      const double factor = jump_factor[c];
      for (; column != end && column->component == c; ++column)
        entries[column->i] -= factor * column->trial;
    }
  }
}

/// Of a scalar: b^2 (gamma [B] - {A}) (gamma delta[B] - theta delta{A}) dh. h may depend on all that the two
/// sides see.
template <int dim>
void Nitsche<dim>::add_change_of_joint(const Interface<dim> &interface, const AtPoint &p,
                                       const Series &series, const unsigned int q,
                                       dealii::FullMatrix<double> &tangent) const
{
  const Pairing<dim> &pairing = interface.pairing();
  const double b = series.b[0][0], factor = pairing.weight(q) * b * b * (p.gamma * jump[0] - mean_flux[0]);
  std::vector<double> change(leading->size()); // factor dh/dx_j
  for (const unsigned int side : {source, destination})
    for (unsigned int k = 0; k < interface.components[side].size() && !series.h_by_state[side].empty(); ++k) {
      const unsigned int d = interface.components[side][k], first = leading->first[side][k];
      const auto &layout = interface.sides[side].domain->layout();
      const std::vector<unsigned int> &nodes = leading->nodes[side][k];
      const double *values = pairing.values(side, q) + layout.first_shape(d);
      const dealii::Tensor<1, dim> *gradients = sides.shape_gradients[side] + layout.first_shape(d);
      const double by_value = factor * series.h_by_state[side][d].by_value;
      const dealii::Tensor<1, dim> by_gradient = factor * series.h_by_state[side][d].by_gradient;
      for (unsigned int a = 0; a < nodes.size(); ++a)
        change[first + a] = by_value * values[nodes[a]] + by_gradient * gradients[nodes[a]];
    }
  const auto add_row = [&](const unsigned int row, const double test) {
    for (unsigned int j = 0; j < change.size(); ++j)
      tangent(row, j) += test * change[j];
  };
  for (const InJump &row : in_jump)
    add_row(row.i, p.gamma * row.test);
  if (theta != 0)
    for (const unsigned int row : field_unknowns)
      add_row(row, -variation_of[row]);
}

/// - theta e_c d2{A}_c(delta, d): the second derivative of the flux contracted with e; without theta for the
/// test function of a pressure.
template <int dim>
void Nitsche<dim>::add_curvature(const Interface<dim> &interface, const TiedField &field, const AtPoint &p,
                                 const Series &series, const unsigned int q,
                                 dealii::FullMatrix<double> &tangent)
{
  const Pairing<dim> &pairing = interface.pairing();
  for (const unsigned int side : {source, destination}) {
    const Domain<dim> &domain = *interface.sides[side].domain;
    if (p.weight[side] != 0 && !domain.material.has_linear_flux(field.field[side])) {
      ++variations.second;
      contraction.assign(domain.n_components(), dealii::Tensor<1, dim>());
      for (unsigned int c = 0; c < field.n_components; ++c)
        contraction[field.first_component[side] + c] = -(side == source ? 1. : -1.) * p.weight[side] /
                                                       field.in_jump(side) * pairing.weight(q) *
                                                       series.mismatch[c] * pairing.N(side, q);
      sides.curvature(side, contraction, second_derivative);

      // delta{A} varies the tied field and its pressure only
      for (unsigned int c = 0; c < field.n_components && theta_here != 0; ++c)
        add_curvature_rows(interface, field, side, q, field.first_component[side] + c, theta_here, tangent);
      if (const auto pressure = pressures[field.index][side])
        add_curvature_rows(interface, field, side, q, *pressure, 1, tangent);
    }
  }
}

/// The same in the rows of a component, which have a share of it.
template <int dim>
void Nitsche<dim>::add_curvature_rows(const Interface<dim> &interface, const TiedField &field,
                                      const unsigned int side, const unsigned int q, const unsigned int c,
                                      const double share, dealii::FullMatrix<double> &tangent) const
{
  const Pairing<dim> &pairing = interface.pairing();
  const auto &layout = interface.sides[side].domain->layout();
  const auto &components = interface.components[side];
  const dealii::FullMatrix<double> &H = second_derivative;
  const double *values = pairing.values(side, q) + layout.first_shape(c);
  const dealii::Tensor<1, dim> *gradients = sides.shape_gradients[side] + layout.first_shape(c);
  const bool varies_by_value = field.varies_by_value(side, c) || pressures[field.index][side] == c;
  const unsigned int position = interface.position(side, c), first_row = leading->first[side][position];
  const std::vector<unsigned int> &rows = leading->nodes[side][position];
  for (unsigned int k = 0; k < components.size(); ++k) {
    const unsigned int d = components[k], first_column = leading->first[side][k];
    const double *values_of_d = pairing.values(side, q) + layout.first_shape(d);
    const dealii::Tensor<1, dim> *gradients_of_d = sides.shape_gradients[side] + layout.first_shape(d);
    const std::vector<unsigned int> &columns = leading->nodes[side][k];
    for (unsigned int i = 0; i < rows.size(); ++i) {
      const unsigned int a = rows[i];
      const unsigned int row = c * (1 + dim), column = d * (1 + dim);
      dealii::Tensor<1, dim> g; // grad phi_a (and phi_a) times H, by gradient and by value of the column
      double v = varies_by_value ? values[a] * H(row, column) : 0;
      for (unsigned int L = 0; varies_by_value && L < dim; ++L)
        g[L] = values[a] * H(row, column + 1 + L);
      for (unsigned int J = 0; J < dim; ++J) {
        v += gradients[a][J] * H(row + 1 + J, column);
        for (unsigned int L = 0; L < dim; ++L)
          g[L] += gradients[a][J] * H(row + 1 + J, column + 1 + L);
      }
      v *= share;
      g *= share;
      double *entries = &tangent(first_row + i, first_column);
      for (unsigned int b = 0; b < columns.size(); ++b)
        entries[b] += g * gradients_of_d[columns[b]];
      for (unsigned int b = 0; v != 0 && b < columns.size(); ++b)
        entries[b] += v * values_of_d[columns[b]];
    }
  }
}

template class Nitsche<2>;
template class Nitsche<3>;

namespace {

const bool registered =
    add_tie<Nitsche>("Nitsche", "Weak continuity by consistent flux terms and a penalty.");

} // namespace

} // namespace dovetail
