// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/jumps.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_jump("jump", "the sides of a tie differ by more than 1 % of the range of a field");
const NoteName of_oscillation("flux oscillation", "the flux of a tie differs from the fluxes in both bodies");
const NoteName of_imbalance("flux imbalance", "the sides of an interface receive different resultants");

using nlohmann::ordered_json;

constexpr double worth_a_note = 0.01;
constexpr double flux_worth_a_note = 0.9, least_in_bodies = 0.05;
constexpr double rounding_of_range = 1e-10; ///< range of a constant field, relative to its size

/// NaN if the field is constant.
template <int dim>
double range(const Interface<dim> &interface, const TiedField &field, const ordered_json &domains)
{
  double largest = -std::numeric_limits<double>::max(), smallest = -largest;
  for (const unsigned int side : {source, destination}) {
    const ordered_json &domain_numbers = domains.at(interface.sides[side].domain->name);
    const double K = field.in_jump(side);
    largest = std::max(largest, K * domain_numbers.at("maximum").at(field.names[side]).get<double>());
    smallest = std::min(smallest, K * domain_numbers.at("minimum").at(field.names[side]).get<double>());
  }
  return largest - smallest > rounding_of_range * std::max(std::abs(largest), std::abs(smallest))
             ? largest - smallest
             : std::numeric_limits<double>::quiet_NaN();
}

/// Collective.
template <int dim>
std::string explain(const Interface<dim> &interface, const std::vector<std::pair<std::string, double>> &jumps,
                    const MPI_Comm &communicator)
{
  const PointTerms<dim> *terms = interface.tie().parts().point_terms;
  const double penalty =
      dealii::Utilities::MPI::max(terms != nullptr ? terms->penalty().largest : 0., communicator);
  std::ostringstream sentence;
  sentence.precision(2);
  sentence << interface.name << ":";
  for (const auto &[field, jump] : jumps)
    sentence << (&field == &jumps.front().first ? " its two sides differ in the " : " and in the ") << field
             << " by " << 100 * jump << " % of the range in the two bodies";
  sentence << " (root mean square). Refine the coarser side at it";
  if (penalty > 0)
    sentence << ", or take a larger Multiplier, which costs accuracy of the flux, or a mortar";
  sentence << '.';
  return sentence.str();
}

/// Where the flux that is transmitted is far from those of both bodies, as when a penalty or multipliers
/// oscillate.
std::string words_for_flux_gap(const std::string &interface, const std::string &field, const double gap)
{
  std::ostringstream sentence;
  sentence
      << interface << ": the flux of the " << field << " between its sides differs by "
      << std::round(100 * gap)
      << " % from that in either body (root mean square): it oscillates, and only its resultant is to be "
         "trusted. Refine the bodies at it, or compare with another tie.";
  return sentence.str();
}

std::string words_for_imbalance(const std::string &interface, const std::string &field, const double share)
{
  std::ostringstream sentence;
  sentence.precision(2);
  sentence
      << interface << ": its two sides get resultants of the " << field << " that differ by " << 100 * share
      << " %: that is how much the flux errs at its points. Use Quadrature = segments, or another side in "
         "Integrate on.";
  return sentence.str();
}

/// NaN if the report does not know it.
double number(const ordered_json &numbers, const std::string &key, const std::string &field)
{
  const auto field_numbers = numbers.find(key);
  if (field_numbers == numbers.end() || !field_numbers->contains(field) ||
      !field_numbers->at(field).is_number())
    return std::numeric_limits<double>::quiet_NaN();
  return field_numbers->at(field).get<double>();
}

/// Of ties that give each side the flux at the points of its own faces: what one side gets and the other one
/// does not give.
double imbalance(const ordered_json &numbers, const std::string &field)
{
  const ordered_json &source_resultant = numbers.at("resultant source").at(field),
                     &destination_resultant = numbers.at("resultant destination").at(field);
  double square = 0;
  if (!source_resultant.is_array())
    return std::abs(source_resultant.get<double>() + destination_resultant.get<double>());
  for (unsigned int c = 0; c < source_resultant.size(); ++c)
    square += std::pow(source_resultant[c].get<double>() + destination_resultant[c].get<double>(), 2);
  return std::sqrt(square);
}

/// What flows in and out of the two bodies, the largest number of a component; 0 if the report does not know
/// it.
template <int dim>
double largest_flow(const Interface<dim> &interface, const TiedField &field, const ordered_json &balance)
{
  double largest = 0;
  const auto take = [&](const ordered_json &flow) {
    largest = flow.is_number() ? std::max(largest, std::abs(flow.get<double>())) : largest;
  };
  for (const unsigned int side : {source, destination})
    for (const char *const flow : {"in", "out"})
      if (const auto path = nlohmann::ordered_json::json_pointer() / interface.sides[side].domain->name /
                            field.names[side] / flow;
          balance.contains(path)) {
        const ordered_json &flows = balance.at(path);
        if (flows.is_array())
          std::for_each(flows.begin(), flows.end(), take);
        else
          take(flows);
      }
  return largest;
}

/// Where the flux through the interface is small beside that along it or beside what flows through the bodies
/// elsewhere, or rounding, there is nothing to tell.
template <int dim>
void explain_fluxes(const Interface<dim> &interface, const double area, const ordered_json &balance,
                    ordered_json &numbers, NoteList &notes)
{
  const PointTerms<dim> *terms = interface.tie().parts().point_terms;
  for (const TiedField &field : interface.fields) {
    const double gap = number(numbers, "flux gap L2", field.name),
                 flux = number(numbers, "numerical flux L2", field.name),
                 in_bodies = number(numbers, "flux in bodies L2", field.name);
    if (!(flux > least_in_bodies * in_bodies) || !(in_bodies > 0))
      continue;
    if (std::isfinite(gap))
      numbers["relative flux gap"][field.name] = gap / flux;
    if (gap > flux_worth_a_note * flux &&
        flux * std::sqrt(area) > worth_a_note * largest_flow(interface, field, balance))
      notes.push_back(of_oscillation(words_for_flux_gap(interface.name, field.name, gap / flux)));
    if (terms == nullptr || terms->is_balanced())
      continue;
    const double share = imbalance(numbers, field.name) / (flux * std::sqrt(area));
    if (share > worth_a_note)
      notes.push_back(of_imbalance(words_for_imbalance(interface.name, field.name, share)));
  }
}

} // namespace

template <int dim>
NoteList explain_jumps(const Model<dim> &model, const double t, const ordered_json &domains,
                       const ordered_json &balance, ordered_json &interfaces)
{
  NoteList notes;
  for (const auto &interface : model.interfaces) {
    ordered_json &numbers = interfaces.at(interface->name);
    const double area = interface->pairing().coverage().covered[source];
    std::vector<std::pair<std::string, double>> large;
    if (!interface->is_active(t) || !(area > 0))
      continue;
    for (const TiedField &field : interface->fields) {
      if (interface->tie().allows_jump(field) || numbers.at("jump L2").at(field.name).is_null())
        continue;
      const double jump = numbers["jump L2"][field.name].template get<double>() / std::sqrt(area) /
                          range(*interface, field, domains);
      if (std::isfinite(jump))
        numbers["relative jump"][field.name] = jump;
      if (jump > worth_a_note)
        large.emplace_back(field.name, jump);
    }
    if (!large.empty())
      notes.push_back(of_jump(explain(*interface, large, model.communicator)));
    explain_fluxes(*interface, area, balance, numbers, notes);
  }
  return notes;
}

template NoteList explain_jumps(const Model<2> &, double, const ordered_json &, const ordered_json &,
                                ordered_json &);
template NoteList explain_jumps(const Model<3> &, double, const ordered_json &, const ordered_json &,
                                ordered_json &);

} // namespace dovetail
