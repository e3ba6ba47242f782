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
//
//     subsection Interface seam
//       set Type        = contact resistance
//       set Source      = left : 1
//       set Destination = right : 0
//       set Conductance = 2000 + 3*T      # W/(m^2 K)
//     end

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
                                    "inf (tied); required if the displacement is tied [Pa/m]"))
  {
    if (section.documenting())
      read_conductance();
  }

  void set_fields(const Section &section, const std::vector<TiedField> &fields) override;
  bool is_symmetric() const override
  {
    return Nitsche<dim>::is_symmetric() && !conductance.depends_on_scalars();
  }
  bool is_linear() const override { return !conductance.depends_on_scalars(); }
  bool has_constant_tangent(const Interface<dim> &interface) const override
  {
    return Nitsche<dim>::has_constant_tangent(interface) && !conductance.depends_on_time() &&
           !stiffness.depends_on_time();
  }
  std::string description() const override
  {
    return Nitsche<dim>::description() + ", in series with a joint";
  }
  bool holds(const TiedField &field) const override { return !law_of(field).is_zero(); }
  bool surely_holds(const TiedField &field, double t) const override;
  bool allows_jump(const TiedField & /*field*/) const override { return true; }
  void begin_step(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
                  const MPI_Comm &communicator) override;

protected:
  bool has_joint() const override { return true; }
  bool find_joint(const TiedField &field, const std::array<State<dim>, 2> &state,
                  typename Nitsche<dim>::Joint &joint) const override;

private:
  void read_conductance()
  {
    conductance = section.read_expression(
        "Conductance", "", {1},
        "Flux per jump of a scalar field such as the temperature, which may depend on the mean of both sides "
        "by the field's symbol, T for the temperature; from 0 (no contact) to inf (tied); required if such a "
        "field is tied [W/(m^2 K)]",
        {symbol});
  }
  bool explain(const TiedField &field, const dealii::Point<dim> &X, double t, double h,
               std::optional<double> mean = {}) const;
  const Expression &law_of(const TiedField &field) const
  {
    return field.n_components == 1 ? conductance : stiffness;
  }
  static void check_not_negative(const double h, const Section &section, const TiedField &field)
  {
    std::ostringstream message;
    message << "is " << (std::isnan(h) ? "not a number" : "negative") << " on the interface";
    if (!std::isnan(h))
      message << " (" << h << ')';
    section.check(h >= 0, entry_of(field),
                  message.str() + ", but must be from 0 (no contact) to inf (tied).");
  }
  static std::string entry_of(const TiedField &field)
  {
    return field.n_components == 1 ? "Conductance" : "Joint stiffness";
  }

  const Section section;    ///< for error messages
  std::string symbol = "T"; ///< of the scalar that is tied
  Expression conductance;
  const Expression stiffness;
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
  for (const TiedField &field : fields) {
    const Expression &law = law_of(field);
    if (!law.depends_on_position() && !law.depends_on_time() && !law.depends_on_scalars())
      for (unsigned int c = 0; c < law.n_components(); ++c)
        check_not_negative(law.value(dealii::Point<dim>(), 0, c), section, field);
  }
}

/// If the joint is the same everywhere and gives way in no direction.
template <int dim>
bool ContactResistance<dim>::surely_holds(const TiedField &field, const double t) const
{
  const Expression &law = law_of(field);
  if (law.depends_on_position() || law.depends_on_scalars())
    return false;
  for (unsigned int c = 0; c < law.n_components(); ++c)
    if (!(law.value(dealii::Point<dim>(), t, c) > 0))
      return false;
  return true;
}

/// Both sides get the same h: at the middle between the points and at the mean of the traces.
template <int dim>
bool ContactResistance<dim>::find_joint(const TiedField &field, const std::array<State<dim>, 2> &state,
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
    joint.along_normal = joint.along_tangents = conductance.value(X, t, 0, {&mean, 1});
    joint.derivative_by_mean = conductance.derivative(X, t, 0, {&mean, 1}, 0);
  } else {
    joint.along_normal = stiffness.value(X, t, 0);
    joint.along_tangents = stiffness.n_components() == 1 ? joint.along_normal : stiffness.value(X, t, 1);
  }
  if (joint.along_normal >= 0 && joint.along_tangents >= 0)
    return true;
  return explain(field, X, t, joint.along_normal >= 0 ? joint.along_tangents : joint.along_normal,
                 law_of(field).depends_on_scalars() ? std::optional(mean) : std::nullopt);
}

/// Leave the reason why h is no conductance, at the mean of the scalar if it depends on that. @return false
template <int dim>
bool ContactResistance<dim>::explain(const TiedField &field, const dealii::Point<dim> &X, const double t,
                                     const double h, const std::optional<double> mean) const
{
  return undefined(sentence_about(section, entry_of(field),
                                  (std::isnan(h) ? "is not a number" : "is " + in_words(h)) + " at " +
                                      (mean ? symbol + " = " + in_words(*mean) + ", " : "") + in_words(X) +
                                      " and t = " + in_words(t) +
                                      ", but must be from 0 (no contact) to inf (tied)."),
                   !mean);
}

/// What does not depend on the solution must be right from the start; the rest makes a step shorter.
template <int dim>
void ContactResistance<dim>::begin_step(const Interface<dim> &interface, const double t,
                                        const ValuesOf &unknowns, const MPI_Comm &communicator)
{
  for (const TiedField &field : interface.fields) {
    const Expression &law = law_of(field);
    if (law.depends_on_scalars())
      continue;
    double smallest = 0;
    Undefined not_a_number;
    const unsigned int n_points = interface.pairing().n_points();
    for (unsigned int q = 0; q < (law.depends_on_position() ? n_points : std::min(n_points, 1u)); ++q)
      for (unsigned int c = 0; c < law.n_components(); ++c) {
        const double h = law.value(interface.pairing().X(source, q), t, c);
        smallest = std::min(smallest, h);
        if (std::isnan(h) && !not_a_number) {
          explain(field, interface.pairing().X(source, q), t, h);
          not_a_number = last_undefined();
        }
      }
    refuse_undefined(not_a_number, communicator);
    check_not_negative(dealii::Utilities::MPI::min(smallest, communicator), interface.section, field);
  }
  Nitsche<dim>::begin_step(interface, t, unknowns, communicator);
}

const bool registered = add_tie<ContactResistance>(
    "contact resistance", "Nitsche's method through a joint that passes a flux proportional to the jump.");

} // namespace

} // namespace dovetail
