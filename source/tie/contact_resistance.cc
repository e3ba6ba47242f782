// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Two bodies that touch imperfectly: the flux through the interface is proportional to the jump, A_src.N = -h
// [B]. For heat, h is the conductance of the contact, for solids the stiffness of a linear elastic joint per
// area. Consistent and stable for every h >= 0 (Juntunen and Stenberg, Math. Comp. 78, 2009, moved to an
// interface), with 1/gamma_eff = 1/h + 1/gamma:
//
//     R(delta) = int_Gamma  - (gamma_eff/gamma) {A}.delta[B]  + gamma_eff [B].delta[B]
//                           - theta (gamma_eff/gamma) delta{A}.([B] + {A}/h)  dGamma
//
// This is Nitsche's tie with a joint in series (nitsche.h). h = 0 separates the bodies, h = inf ties them.
// Solids may be joined by a law of its own, such as that of a cohesive joint (joint_law.h); its normal is the
// mean of both sides' at the last good step, and found anew if the solution has turned it.
//
//     subsection Interface seam
//       set Type        = contact resistance
//       set Source      = left : 1
//       set Destination = right : 0
//       set Conductance = 2000 + 3*T      # W/(m^2 K)
//     end
//
// The conductance may also depend on how the solids press each other and on the gap between them: with the
// deformed normals n and the shares w_s of the sides that have a displacement,
//
//     p = - sum_s w_s n_s . P_s N_s,     g = - sum_s n_s . u_s
//
// at the state at hand. Their derivatives are in the tangent.

#include <dovetail/material/embedding.h>
#include <dovetail/scene/undefined.h>
#include <dovetail/tie/nitsche.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

namespace dovetail {

namespace {

template <int dim>
class ContactResistance : public Nitsche<dim>
{
public:
  explicit ContactResistance(const Section &section)
      : Nitsche<dim>(section), section(section),
        stiffness(
            section.read_expression("Joint stiffness", "", {1, 2},
                                    "Force per area and jump of the displacement: one number for all "
                                    "directions, or two numbers, normal; tangential; from 0 (no contact) to "
                                    "inf (tied); required if the displacement is tied [Pa/m]")),
        law(JointCatalogue::create_by("Joint", section, "none",
                                      "A law by which the joint between solids gives way; none: Joint "
                                      "stiffness alone [-]"))
  {
    if (section.documenting())
      read_conductance();
  }

  void set_fields(const Section &section, const std::vector<TiedField> &fields) override;
  bool is_symmetric() const override
  {
    return Nitsche<dim>::is_symmetric() && !conductance.depends_on_scalars() &&
           (!law || law->is_symmetric(stiffness.n_components() == 1));
  }
  bool is_linear() const override { return !conductance.depends_on_scalars() && !law; }
  bool looks_at(const Field &field) const override { return sees_solids() && field.n_components > 1; }
  bool has_constant_tangent(const Interface<dim> &interface) const override
  {
    return Nitsche<dim>::has_constant_tangent(interface) && !conductance.depends_on_time() &&
           !stiffness.depends_on_time() && !sees_solids();
  }
  std::string description() const override
  {
    return Nitsche<dim>::description() + ", in series with a " + (law ? section.peek("Joint") + ' ' : "") +
           "joint";
  }
  bool holds(const TiedField &field) const override { return !law_of(field).is_zero(); }
  bool surely_holds(const TiedField &field, double t) const override;
  bool allows_jump(const TiedField & /*field*/) const override { return true; }
  void begin_step(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
                  const MPI_Comm &communicator) override;
  bool update_penalties(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
                        const MPI_Comm &communicator) override;
  std::vector<InternalVariable> internal_variables() const override
  {
    return law ? law->internal_variables() : std::vector<InternalVariable>();
  }

protected:
  bool has_joint() const override { return true; }
  bool find_joint(const Interface<dim> &interface, const TiedField &field, unsigned int q,
                  const std::array<State<dim>, 2> &state, typename Nitsche<dim>::Joint &joint) const override;

private:
  void read_conductance()
  {
    conductance = section.read_expression(
        "Conductance", "", {1},
        "Flux per jump of a scalar field such as the temperature, which may depend on the mean of both sides "
        "by the field's symbol, T for the temperature, and on how the solids meet, pressure [Pa] and gap "
        "[m]; "
        "from 0 (no contact) to inf (tied); required if such a field is tied [W/(m^2 K)]",
        {symbol, "p", "gap"});
  }
  /// The scalars of the formula: the mean of the traces, how hard the solids press each other per undeformed
  /// area, and how far they are apart.
  enum Scalar { of_mean, of_pressure, of_gap };
  using Scalars = std::array<double, 3>;
  bool depends_on(const Scalar scalar) const
  {
    return conductance.depends_on_scalars() && conductance.depends_on_scalar(scalar);
  }
  bool sees_solids() const { return depends_on(of_pressure) || depends_on(of_gap); }
  /// How the solids meet at a point.
  struct Meeting
  {
    double pressure = 0, gap = 0;
    using Derivatives = std::vector<typename Nitsche<dim>::Joint::Derivative>; ///< by component of a side
    std::array<Derivatives, 2> of_pressure, of_gap;
  };
  bool find_meeting(const Interface<dim> &interface, unsigned int q, const std::array<State<dim>, 2> &state,
                    Meeting &meeting) const;
  /// One side as a solid that has turned.
  struct Turned
  {
    unsigned int first = 0; ///< component of the displacement
    dealii::Tensor<1, dim> u, N, m, n;
    dealii::Tensor<2, dim> inverse; ///< F^-1; zero at small strain
    dealii::Tensor<1, dim>
    by_normal(const dealii::Tensor<1, dim> &a) const ///< a.dn = - by_normal(a)_L m_k dF_kL
    {
      return inverse * (a - (n * a) * n) / m.norm();
    }
  };
  void find_gap(const Interface<dim> &interface, unsigned int q,
                const std::array<std::optional<Turned>, 2> &sides, Meeting &meeting) const;
  bool explain(const TiedField &field, const dealii::Point<dim> &X, double t, double h,
               std::optional<double> mean = {}) const;
  const Expression &law_of(const TiedField &field) const
  {
    return field.n_components == 1 ? conductance : stiffness;
  }
  bool has_law(const TiedField &field) const { return law && field.n_components > 1; }
  bool is_admissible(const TiedField &field, const double h) const
  {
    return has_law(field) ? h > 0 && std::isfinite(h) : h >= 0;
  }
  std::string admissible(const TiedField &field) const
  {
    return has_law(field) ? "must be positive and finite with a Joint."
                          : "must be from 0 (no contact) to inf (tied).";
  }
  void check_admissible(const double h, const Section &section, const TiedField &field) const
  {
    std::ostringstream message;
    message << "is "
            << (std::isnan(h) ? "not a number"
                : h < 0       ? "negative"
                              : "no stiffness of a whole joint")
            << " on the interface";
    if (!std::isnan(h))
      message << " (" << h << ')';
    section.check(is_admissible(field, h), entry_of(field), message.str() + ", but " + admissible(field));
  }
  std::vector<dealii::Tensor<1, dim>> find_normals(const Interface<dim> &interface, double t,
                                                   const ValuesOf &unknowns) const;
  static std::string entry_of(const TiedField &field)
  {
    return field.n_components == 1 ? "Conductance" : "Joint stiffness";
  }

  const Section section;    ///< for error messages
  std::string symbol = "T"; ///< of the scalar that is tied
  Expression conductance;
  const Expression stiffness;
  const std::unique_ptr<const JointLaw> law;   ///< of solids; empty: linear
  std::vector<dealii::Tensor<1, dim>> normals; ///< of the law, at the points
  mutable std::vector<double> trial_memory;    ///< of the law, at the point evaluated last
  static constexpr double small_turn = 1e-3;   ///< of the normal in a step
};

template <int dim>
void ContactResistance<dim>::set_fields(const Section &section, const std::vector<TiedField> &fields)
{
  Nitsche<dim>::set_fields(section, fields);
  const auto is_scalar = [](const TiedField &field) { return field.n_components == 1; };
  section.check(
      std::count_if(fields.begin(), fields.end(), is_scalar) < 2, "Conductance",
      "is one number, but the interface ties several scalars, whose conductances have different units. Set "
      "Fields to one of them, and tie the others by interfaces of their own.");
  if (const auto scalar = std::find_if(fields.begin(), fields.end(), is_scalar); scalar != fields.end())
    symbol = scalar->symbol;
  section.check(symbol != "p" && symbol != "gap", "Fields",
                "has the species " + symbol +
                    ", a word which stands for the solids in the formula of Conductance. Rename it.");
  read_conductance();
  for (const std::string entry : {"Conductance", "Joint stiffness"}) {
    const TiedField *tied = nullptr, *other = nullptr;
    for (const TiedField &field : fields)
      (entry_of(field) == entry ? tied : other) = &field;
    const std::string unit = entry == "Conductance" ? "W/(m^2 K)" : "Pa/m";
    section.check(tied == nullptr || section.is_set(entry), "Type",
                  "is contact resistance, and the interface ties the " + (tied ? tied->name : "") + ": set " +
                      entry + " [" + unit + "]" +
                      (other ? ", or set Fields = " + other->name + " if only that is to be tied." : "."));
    section.check(
        tied != nullptr || !section.is_set(entry), entry,
        std::string("belongs to ") +
            (entry == "Conductance" ? "scalar fields such as the temperature" : "the displacement") +
            ", which this interface does not tie. Remove it, or change Fields.");
  }
  section.check(
      !law || std::any_of(fields.begin(), fields.end(),
                          [this](const TiedField &field) { return has_law(field); }),
      "Joint",
      "belongs to the displacement, which this interface does not tie. Remove it, or change Fields.");
  for (const TiedField &field : fields) {
    const Expression &law = law_of(field);
    if (!law.depends_on_position() && !law.depends_on_time() && !law.depends_on_scalars())
      for (unsigned int c = 0; c < law.n_components(); ++c)
        check_admissible(law.value(dealii::Point<dim>(), 0, c), section, field);
  }
}

/// If the joint is the same everywhere and gives way in no direction.
template <int dim>
bool ContactResistance<dim>::surely_holds(const TiedField &field, const double t) const
{
  const Expression &h = law_of(field);
  if (h.depends_on_position() || h.depends_on_scalars() || has_law(field) || this->has_toggle_at_points())
    return false;
  for (unsigned int c = 0; c < h.n_components(); ++c)
    if (!(h.value(dealii::Point<dim>(), t, c) > 0))
      return false;
  return true;
}

/// Both sides get the same h: at the middle between the points and at the mean of the traces.
template <int dim>
bool ContactResistance<dim>::find_joint(const Interface<dim> &interface, const TiedField &field,
                                        const unsigned int q, const std::array<State<dim>, 2> &state,
                                        typename Nitsche<dim>::Joint &joint) const
{
  const dealii::Point<dim> X =
      (state[source].X + static_cast<const dealii::Tensor<1, dim> &>(state[destination].X)) / 2.;
  const double t = state[source].t;
  double mean = 0;
  if (field.n_components == 1) {
    mean = (state[source].value[field.first_component[source]] +
            state[destination].value[field.first_component[destination]]) /
           2;
    Scalars scalars = {{mean, 0, 0}};
    Meeting meeting;
    if (sees_solids()) {
      if (!find_meeting(interface, q, state, meeting))
        return false;
      scalars = {{mean, meeting.pressure, meeting.gap}};
    }
    const Expression::Scalars view(scalars.data(), scalars.size());
    joint.along_normal = joint.along_tangents = conductance.value(X, t, 0, view);
    for (const Scalar scalar : {of_mean, of_pressure, of_gap}) {
      const double slope = depends_on(scalar) ? conductance.derivative(X, t, 0, view, scalar) : 0;
      if (slope == 0 || !std::isfinite(slope)) // a power below 1 has none where nothing presses
        continue;
      for (const unsigned int side : {source, destination}) {
        auto &sum = joint.by_state[side];
        sum.resize(state[side].value.size());
        if (scalar == of_mean) {
          sum[field.first_component[side]].by_value += slope / 2;
          continue;
        }
        const auto &derivatives = scalar == of_pressure ? meeting.of_pressure[side] : meeting.of_gap[side];
        for (unsigned int d = 0; d < derivatives.size(); ++d) {
          sum[d].by_value += slope * derivatives[d].by_value;
          sum[d].by_gradient += slope * derivatives[d].by_gradient;
        }
      }
    }
  } else {
    joint.along_normal = stiffness.value(X, t, 0);
    joint.along_tangents = stiffness.n_components() == 1 ? joint.along_normal : stiffness.value(X, t, 1);
  }
  for (const double h : {joint.along_normal, joint.along_tangents})
    if (!is_admissible(field, h))
      return explain(field, X, t, h, law_of(field).depends_on_scalars() ? std::optional(mean) : std::nullopt);
  if (!has_law(field))
    return true;
  const auto accepted = interface.memory.accepted(InterfaceMemory<dim>::joint, q);
  trial_memory.assign(accepted.begin(), accepted.end());
  joint.law = law.get();
  joint.normal = normals[q];
  joint.place = {embed(X),
                 t,
                 {{joint.along_normal, joint.along_tangents}},
                 {accepted, {trial_memory.data(), trial_memory.size()}}};
  return true;
}

namespace {

/// F^-1, where a displacement begins with component @p first; nothing where det F is not positive.
template <int dim>
std::optional<dealii::Tensor<2, dim>> inverse_deformation(const State<dim> &state, const unsigned int first)
{
  dealii::Tensor<2, dim> F = dealii::unit_symmetric_tensor<dim>();
  for (unsigned int d = 0; d < dim; ++d)
    F[d] += state.gradient[first + d];
  if (!(determinant(F) > 0))
    return {};
  return invert(F);
}

/// The displacement of a side, if it has one.
template <int dim>
std::optional<Field> solid_of(const InterfaceSide<dim> &side)
{
  for (const Field &field : side.domain->fields())
    if (field.n_components > 1)
      return field;
  return {};
}

} // namespace

/// The mean of the normals of both sides, N F^-1, from the source to the destination; as in the undeformed
/// state where a side has turned over, and for small strain.
template <int dim>
std::vector<dealii::Tensor<1, dim>> ContactResistance<dim>::find_normals(const Interface<dim> &interface,
                                                                         const double t,
                                                                         const ValuesOf &values_of) const
{
  const Pairing<dim> &pairing = interface.pairing();
  std::vector<dealii::Tensor<1, dim>> result;
  for (unsigned int q = 0; q < pairing.n_points(); ++q) {
    const dealii::Tensor<1, dim> N = pairing.N(source, q) - pairing.N(destination, q);
    result.push_back(N / N.norm());
  }
  const auto field = std::find_if(interface.fields.begin(), interface.fields.end(),
                                  [&](const TiedField &one) { return has_large_strain(interface, one); });
  if (field == interface.fields.end())
    return result;
  SidePoints<dim> points(interface, t);
  for_each_group(interface, values_of, [&](const auto &group, const std::vector<double> &unknowns) {
    for (unsigned int q = group.begin; q < group.end; ++q) {
      dealii::Tensor<1, dim> sum;
      for (const unsigned int side : {source, destination}) {
        points.reinit(side, q, unknowns);
        const auto inverse = inverse_deformation(points.state[side], field->first_component[side]);
        if (!inverse)
          continue;
        const dealii::Tensor<1, dim> n = pairing.N(side, q) * *inverse;
        sum += (side == source ? 1 : -1) * (n / n.norm());
      }
      if (sum.norm() > 0)
        result[q] = sum / sum.norm();
    }
  });
  return result;
}

/// g = n.(x_dst - x_src) - N.(X_dst - X_src), with the means n and N of the normals of the solids, so that
/// motions of both bodies as one do not change it: dg = n.(du_dst - du_src) + (d - n (n.d)).ds/|s| with d =
/// x_dst - x_src and n = s/|s|.
template <int dim>
void ContactResistance<dim>::find_gap(const Interface<dim> &interface, const unsigned int q,
                                      const std::array<std::optional<Turned>, 2> &sides,
                                      Meeting &meeting) const
{
  const Pairing<dim> &pairing = interface.pairing();
  const dealii::Tensor<1, dim> at_rest = pairing.X(destination, q) - pairing.X(source, q) +
                                         interface.sides[destination].shift - interface.sides[source].shift;
  dealii::Tensor<1, dim> d = at_rest, N, s;
  for (const unsigned int side : {source, destination})
    if (sides[side]) {
      const double sign = side == source ? 1 : -1;
      d -= sign * sides[side]->u;
      N += sign * sides[side]->N;
      s += sign * sides[side]->n;
    }
  const dealii::Tensor<1, dim> n = s / s.norm(), across = (d - (n * d) * n) / s.norm();
  meeting.gap = n * d - N * at_rest / N.norm();
  for (const unsigned int side : {source, destination})
    if (sides[side]) {
      const double sign = side == source ? 1 : -1;
      const dealii::Tensor<1, dim> turned = sides[side]->by_normal(sign * across);
      for (unsigned int k = 0; k < dim; ++k) {
        auto &derivative = meeting.of_gap[side][sides[side]->first + k];
        derivative.by_value -= sign * n[k];
        derivative.by_gradient -= sides[side]->m[k] * turned;
      }
    }
}

/// With m = N F^-1 and n = m/|m|, dm_L = - m_k dF_kL (F^-1)_L and a.dn = (a - n (n.a)) . dm/|m|.
/// @return false where a law is not defined
template <int dim>
bool ContactResistance<dim>::find_meeting(const Interface<dim> &interface, const unsigned int q,
                                          const std::array<State<dim>, 2> &state, Meeting &meeting) const
{
  const std::array<std::optional<Field>, 2> solids{
      {solid_of(interface.sides[source]), solid_of(interface.sides[destination])}};
  const double share = solids[source] && solids[destination] ? 0.5 : 1;
  std::array<std::optional<Turned>, 2> sides;
  for (const unsigned int side : {source, destination}) {
    if (!solids[side])
      continue;
    const Material<dim> &material = interface.sides[side].domain->material;
    const unsigned int n_c = state[side].value.size(), first = solids[side]->first_component;
    Response<dim> response(n_c);
    if (!respond(interface, side, state[side], response))
      return false;
    Turned turned;
    turned.first = first;
    turned.m = turned.N = interface.pairing().N(side, q);
    dealii::Tensor<1, dim> traction;
    for (unsigned int d = 0; d < dim; ++d) {
      turned.u[d] = state[side].value[first + d];
      traction[d] = response.flux[first + d] * turned.N;
    }
    if (material.has_large_strain()) {
      const auto found = inverse_deformation(state[side], first);
      if (!found)
        return undefined("the body has turned over at an interface");
      turned.inverse = *found;
      turned.m = turned.N * turned.inverse;
    }
    const dealii::Tensor<1, dim> n = turned.n = turned.m / turned.m.norm();
    meeting.pressure -= share * (n * traction);
    auto &of_pressure = meeting.of_pressure[side];
    of_pressure.resize(n_c);
    meeting.of_gap[side].resize(n_c);
    for (unsigned int d = 0; d < n_c; ++d)
      for (unsigned int i = 0; i < dim; ++i) {
        const unsigned int pair = (first + i) * n_c + d;
        of_pressure[d].by_value -= share * n[i] * (response.by_value[pair] * turned.N);
        of_pressure[d].by_gradient -= share * n[i] * (turned.N * response.by_gradient[pair]);
      }
    const dealii::Tensor<1, dim> by_normal = turned.by_normal(traction);
    for (unsigned int k = 0; k < dim; ++k)
      of_pressure[first + k].by_gradient += share * turned.m[k] * by_normal;
    sides[side] = turned;
  }
  find_gap(interface, q, sides, meeting);
  return true;
}

/// Leave the reason why h is no conductance, at the mean of the scalar if it depends on that. @return false
template <int dim>
bool ContactResistance<dim>::explain(const TiedField &field, const dealii::Point<dim> &X, const double t,
                                     const double h, const std::optional<double> mean) const
{
  return undefined(sentence_about(section, entry_of(field),
                                  (std::isnan(h) ? "is not a number" : "is " + in_words(h)) + " at " +
                                      (mean ? symbol + " = " + in_words(*mean) + ", " : "") + in_words(X) +
                                      " and t = " + in_words(t) + ", but " + admissible(field)),
                   !mean);
}

/// What does not depend on the solution must be right from the start; the rest makes a step shorter.
template <int dim>
void ContactResistance<dim>::begin_step(const Interface<dim> &interface, const double t,
                                        const ValuesOf &unknowns, const MPI_Comm &communicator)
{
  if (law)
    normals = find_normals(interface, t, unknowns);
  section.check(!sees_solids() || solid_of(interface.sides[source]) || solid_of(interface.sides[destination]),
                "Conductance",
                "depends on the pressure or the gap of solids, but neither side has a displacement.");
  for (const TiedField &field : interface.fields) {
    const Expression &law = law_of(field);
    if (law.depends_on_scalars())
      continue;
    double smallest = std::numeric_limits<double>::infinity(), largest = 0;
    Undefined not_a_number;
    const unsigned int n_points = interface.pairing().n_points();
    for (unsigned int q = 0; q < (law.depends_on_position() ? n_points : std::min(n_points, 1u)); ++q)
      for (unsigned int c = 0; c < law.n_components(); ++c) {
        const double h = law.value(interface.pairing().X(source, q), t, c);
        smallest = std::min(smallest, h);
        largest = std::max(largest, h);
        if (std::isnan(h) && !not_a_number) {
          explain(field, interface.pairing().X(source, q), t, h);
          not_a_number = last_undefined();
        }
      }
    refuse_undefined(not_a_number, communicator);
    smallest = dealii::Utilities::MPI::min(smallest, communicator);
    largest = dealii::Utilities::MPI::max(largest, communicator);
    if (smallest <= largest) // there are points
      for (const double h : {smallest, largest})
        check_admissible(h, interface.section, field);
  }
  Nitsche<dim>::begin_step(interface, t, unknowns, communicator);
}

template <int dim>
bool ContactResistance<dim>::update_penalties(const Interface<dim> &interface, const double t,
                                              const ValuesOf &unknowns, const MPI_Comm &communicator)
{
  const bool is_new = Nitsche<dim>::update_penalties(interface, t, unknowns, communicator);
  if (!law)
    return is_new;
  const auto now = find_normals(interface, t, unknowns);
  double largest = 0;
  for (unsigned int q = 0; q < now.size(); ++q)
    largest = std::max(largest, (now[q] - normals[q]).norm());
  if (dealii::Utilities::MPI::max(largest, communicator) < small_turn)
    return is_new;
  normals = now;
  return true;
}

const bool registered = add_tie<ContactResistance>(
    "contact resistance", "Nitsche's method through a joint that passes a flux proportional to the jump.");

} // namespace

} // namespace dovetail
