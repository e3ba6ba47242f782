// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/jumps.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace dovetail {

namespace {

using nlohmann::ordered_json;

constexpr double worth_a_note = 0.01;
constexpr double rounding = 1e-10; ///< range of a constant field, relative to its size

/// NaN if the field is constant.
template <int dim>
double range(const Interface<dim> &interface, const std::string &field, const ordered_json &domains)
{
  double largest = -std::numeric_limits<double>::max(), smallest = -largest;
  for (const auto &side : interface.sides) {
    const ordered_json &of_domain = domains.at(side.domain->name);
    largest = std::max(largest, of_domain.at("maximum").at(field).get<double>());
    smallest = std::min(smallest, of_domain.at("minimum").at(field).get<double>());
  }
  return largest - smallest > rounding * std::max(std::abs(largest), std::abs(smallest))
             ? largest - smallest
             : std::numeric_limits<double>::quiet_NaN();
}

/// Collective.
template <int dim>
std::string explain(const Interface<dim> &interface, const std::vector<std::pair<std::string, double>> &jumps,
                    const MPI_Comm &communicator)
{
  const double penalty = dealii::Utilities::MPI::max(interface.tie().penalty().largest, communicator);
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

} // namespace

template <int dim>
std::vector<std::string> explain_jumps(const Model<dim> &model, const double t, const ordered_json &domains,
                                       ordered_json &interfaces)
{
  std::vector<std::string> sentences;
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
                          range(*interface, field.name, domains);
      if (std::isfinite(jump))
        numbers["relative jump"][field.name] = jump;
      if (jump > worth_a_note)
        large.emplace_back(field.name, jump);
    }
    if (!large.empty())
      sentences.push_back(explain(*interface, large, model.communicator));
  }
  return sentences;
}

template std::vector<std::string> explain_jumps(const Model<2> &, double, const ordered_json &,
                                                ordered_json &);
template std::vector<std::string> explain_jumps(const Model<3> &, double, const ordered_json &,
                                                ordered_json &);

} // namespace dovetail
