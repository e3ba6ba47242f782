// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Two grey, parallel faces that see only each other through a gap exchange heat by radiation (Stefan 1879;
// Christiansen 1883 for the effective emissivity). With absolute temperatures theta = T + offset,
//
//     A_src.N = - A_dst.N = - c (theta_src^4 - theta_dst^4),   c = e_eff times 5.670374e-8 W/(m^2 K^4)
//     R(delta) = int_Gamma c (theta_src^4 - theta_dst^4) (delta_src - delta_dst) dGamma
//
// with 1/e_eff = 1/e_src + 1/e_dst - 1 for parallel faces. What one side loses the other one gains. The area
// is that of the source, so c belongs to it; between a shaft of radius a and a tube of radius b the source is
// the shaft, with 1/e_eff = 1/e_src + (a/b) (1/e_dst - 1). For iterates below the absolute zero, theta^4
// continues as theta |theta|^3. The traces are those at the faces: nothing is extended over the gap.
//
//     subsection Interface vacuum
//       set Type          = gap radiation
//       set Source        = shaft : 1
//       set Destination   = tube : 0
//       set Coefficient   = 0.8*5.670374e-8
//       set Offset        = 273.15             # the fields are in degrees Celsius
//       set Search radius = 3                  # of the face size: the gap is wide
//     end

#include <dovetail/interface/interface.h>
#include <dovetail/tie/point_toggle.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace dovetail {

namespace {

template <int dim>
class GapRadiation : public Tie<dim>, public PointTerms<dim>
{
public:
  explicit GapRadiation(const Section &section)
      : toggle(section), section(section),
        coefficient(section.require_expression(
            "Coefficient", {1},
            "Effective emissivity of the two faces times the Stefan-Boltzmann constant 5.670374e-8, per area "
            "of the source [W/(m^2 K^4)]")),
        offset(section.read<double>(
            "Offset", 0,
            "Added to the fields it gives absolute temperatures; 273.15 for degrees Celsius [K]"))
  {
  }

  TieParts<dim> parts() override { return {this}; }
  std::array<bool, 2> integrates_on() const override { return {{true, false}}; }
  bool bridges_gaps() const override { return false; }
  void set_fields(const Section &section, const std::vector<TiedField> &fields) override;
  void begin_step(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
                  const MPI_Comm &communicator) override;

  bool follows_fields() const override { return toggle.is_given(); }
  bool has_switched() const override { return toggle.has_switched(); }
  std::vector<double> pack_points(const Interface<dim> &interface) const override
  {
    return toggle.pack(interface.pairing().n_points(), {});
  }
  void unpack_points(const Interface<dim> &interface, const std::vector<double> &numbers) override
  {
    toggle.unpack(interface.pairing().n_points(), numbers);
  }

  bool is_symmetric() const override { return false; }
  bool is_linear() const override { return false; }
  bool holds(const TiedField & /*field*/) const override { return !coefficient.is_zero(); }
  bool allows_jump(const TiedField & /*field*/) const override { return true; }
  bool couples_fluxes() const override { return false; }
  bool couples_insides(const Interface<dim> & /*interface*/) const override { return false; }

  bool assemble(const Interface<dim> &interface, const typename Pairing<dim>::Group &group, double t,
                const std::vector<double> &unknowns, std::vector<double> &residual,
                dealii::FullMatrix<double> *tangent) override;
  void numerical_flux(const Interface<dim> &interface, const TiedField &field, unsigned int q,
                      const std::array<State<dim>, 2> &state, const std::array<std::vector<double>, 2> &flux,
                      const std::vector<double> &jump, std::vector<double> &result) const override;

private:
  double emitted(const double T) const
  {
    const double theta = T + offset;
    return theta * std::pow(std::abs(theta), 3);
  }
  double slope(const double T) const { return 4 * std::pow(std::abs(T + offset), 3); }
  void check_coefficient(double c) const;

  PointToggle<dim> toggle;
  const Section section; ///< for error messages
  const Expression coefficient;
  const double offset;
};

template <int dim>
void GapRadiation<dim>::set_fields(const Section &, const std::vector<TiedField> &fields)
{
  for (const TiedField &field : fields)
    section.check(field.n_components == 1, "Type",
                  "is gap radiation, which transmits heat, but the interface ties the " + field.name +
                      ". Set Fields to the temperature.");
  section.check(fields.size() < 2, "Type",
                "is gap radiation, which transmits heat, but the interface ties several fields. Set Fields "
                "to the temperature.");
  section.check(!section.is_set("Jump"), "Jump",
                "has no meaning for gap radiation, by which both sides may have any temperature. Remove it.");
  if (!coefficient.depends_on_position() && !coefficient.depends_on_time())
    check_coefficient(coefficient.value(dealii::Point<dim>(), 0));
}

template <int dim>
void GapRadiation<dim>::check_coefficient(const double c) const
{
  std::ostringstream number;
  number << c;
  section.check(c >= 0 && std::isfinite(c), "Coefficient",
                "is " + number.str() + " on the interface, but must be finite and not negative.");
}

template <int dim>
void GapRadiation<dim>::begin_step(const Interface<dim> &interface, const double t, const ValuesOf &unknowns,
                                   const MPI_Comm &communicator)
{
  toggle.look(interface, t, unknowns, communicator);
  if (!coefficient.depends_on_position() && !coefficient.depends_on_time())
    return;
  std::array<double, 2> range = {{0, 0}};
  for (unsigned int q = 0; q < interface.pairing().n_points(); ++q) {
    double c = coefficient.value(interface.pairing().X(source, q), t);
    c = std::isnan(c) ? std::numeric_limits<double>::infinity() : c;
    range = {{std::min(range[0], c), std::max(range[1], c)}};
  }
  const double smallest = dealii::Utilities::MPI::min(range[0], communicator),
               largest = dealii::Utilities::MPI::max(range[1], communicator);
  check_coefficient(smallest < 0 ? smallest : largest);
}

template <int dim>
bool GapRadiation<dim>::assemble(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                                 const double t, const std::vector<double> &unknowns,
                                 std::vector<double> &residual, dealii::FullMatrix<double> *tangent)
{
  const Pairing<dim> &pairing = interface.pairing();
  const TiedField &field = interface.fields[0];
  std::array<unsigned int, 2> first;
  for (const unsigned int side : {source, destination})
    first[side] = interface.first_unknown(side, field.first_component[side]);
  for (unsigned int q = group.begin; q < group.end; ++q) {
    if (!toggle.is_on(q))
      continue;
    const double c = pairing.weight(q) * coefficient.value(pairing.X(source, q), t);
    const std::array<const double *, 2> shapes = {
        {pairing.values(source, q) + field.first_shape[source],
         pairing.values(destination, q) + field.first_shape[destination]}};
    std::array<double, 2> T = {{0, 0}};
    for (const unsigned int side : {source, destination})
      for (unsigned int a = 0; a < field.n_nodes[side]; ++a)
        T[side] += shapes[side][a] * unknowns[first[side] + a];
    const double heat = c * (emitted(T[source]) - emitted(T[destination]));
    for (const unsigned int side : {source, destination})
      for (unsigned int a = 0; a < field.n_nodes[side]; ++a) {
        const double test = (side == source ? 1 : -1) * shapes[side][a];
        residual[first[side] + a] += heat * test;
        if (tangent != nullptr)
          for (const unsigned int other : {source, destination})
            for (unsigned int b = 0; b < field.n_nodes[other]; ++b)
              (*tangent)(first[side] + a, first[other] + b) +=
                  c * test * (other == source ? 1 : -1) * slope(T[other]) * shapes[other][b];
      }
  }
  return true;
}

template <int dim>
void GapRadiation<dim>::numerical_flux(const Interface<dim> &interface, const TiedField &field,
                                       const unsigned int q, const std::array<State<dim>, 2> &state,
                                       const std::array<std::vector<double>, 2> & /*flux*/,
                                       const std::vector<double> & /*jump*/,
                                       std::vector<double> &result) const
{
  const double c = toggle.is_on(q) ? coefficient.value(interface.pairing().X(source, q), state[source].t) : 0;
  result[0] = -c * (emitted(state[source].value[field.first_component[source]]) -
                    emitted(state[destination].value[field.first_component[destination]]));
}

const bool registered = add_tie<GapRadiation>(
    "gap radiation", "Radiation between two faces across a gap, Coefficient (T_source^4 - T_destination^4).");

} // namespace

} // namespace dovetail
