// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/surface_exchange.h>
#include <dovetail/measure/domain_point.h>
#include <dovetail/measure/reduction.h>
#include <dovetail/measure/used_ranges.h>
#include <dovetail/scene/undefined.h>

#include <deal.II/base/mpi.h>

#include <algorithm>

namespace dovetail {

namespace {

const NoteName of_table("table range", "a field leaves the range of a table in which it is looked up");

const double allowed_share = 0.01; ///< of the width of a table, beyond it

/// The part of a domain for which an entry in the section @p path holds; no domain if there is none.
template <int dim>
Region<dim> region_of(const Domain<dim> &domain, const std::string &path)
{
  const auto is_in = [&](const std::string &section) {
    return path == section || path.compare(0, section.size() + 1, section + "/") == 0;
  };
  for (const auto &condition : domain.conditions())
    if (path == condition->section.path())
      return {condition->point() ? nullptr : &domain, condition->boundary_ids};
  return {is_in("Material " + domain.material.name) || is_in(domain.section.path()) ? &domain : nullptr, {}};
}

/// "Young modulus (table from 293 to 900)" for each that the values of a field leave.
std::string tables_left(const FormulaWithTables &entry, const unsigned int scalar, const double smallest,
                        const double largest)
{
  for (const auto &lookup : lookups_in(entry, scalar, smallest, largest)) {
    const double allowed = allowed_share * (lookup.last - lookup.first);
    if (lookup.smallest < lookup.first - allowed || lookup.largest > lookup.last + allowed)
      return entry.entry + " of " + entry.path + " (a table from " + in_words(lookup.first) + " to " +
             in_words(lookup.last) + ")";
  }
  return "";
}

/// Of a condition whose film coefficient is no constant; else nullptr.
template <int dim>
const ExchangeCoefficient<dim> *varying_coefficient(const Condition<dim> &condition)
{
  const auto *exchange = dynamic_cast<const ExchangeCoefficient<dim> *>(&condition);
  return exchange != nullptr && exchange->varies() ? exchange : nullptr;
}

} // namespace

template <int dim>
bool UsedRanges<dim>::has_any() const
{
  return !text.formulas_with_tables().empty() ||
         std::any_of(model.domains.begin(), model.domains.end(), [](const auto &domain) {
           const auto &conditions = domain->conditions();
           return std::any_of(conditions.begin(), conditions.end(), [](const auto &condition) {
             return varying_coefficient(*condition) != nullptr;
           });
         });
}

template <int dim>
void UsedRanges<dim>::add(const Vector &solution, const double t)
{
  add_tables(solution);
  add_coefficients(solution, t);
}

template <int dim>
void UsedRanges<dim>::add_tables(const Vector &solution)
{
  for (const auto &domain : model.domains)
    for (const Field &field : domain->fields())
      for (const FormulaWithTables &entry : text.formulas_with_tables()) {
        const auto scalar = std::find(entry.scalars.begin(), entry.scalars.end(), field.symbol);
        const Region<dim> region = region_of(*domain, entry.path);
        if (field.n_components > 1 || scalar == entry.scalars.end() || region.domain == nullptr)
          continue;
        const double smallest = reduce(region, field, Reduce::minimum, solution)[0],
                     largest = reduce(region, field, Reduce::maximum, solution)[0];
        auto &known = ranges[{domain.get(), field.name}];
        const auto found = std::find_if(known.begin(), known.end(),
                                        [&entry](const Range &range) { return range.entry == &entry; });
        if (found == known.end())
          known.push_back(
              {&entry, static_cast<unsigned int>(scalar - entry.scalars.begin()), smallest, largest});
        else {
          found->smallest = std::min(found->smallest, smallest);
          found->largest = std::max(found->largest, largest);
        }
      }
}

template <int dim>
NoteList UsedRanges<dim>::explain_tables() const
{
  NoteList notes;
  for (const auto &domain : model.domains)
    for (const Field &field : domain->fields()) {
      const auto found = ranges.find({domain.get(), field.name});
      if (found == ranges.end())
        continue;
      std::vector<std::string> left;
      double lowest = 0, highest = 0;
      for (const Range &range : found->second) {
        const std::string words = tables_left(*range.entry, range.scalar, range.smallest, range.largest);
        if (words.empty())
          continue;
        lowest = left.empty() ? range.smallest : std::min(lowest, range.smallest);
        highest = left.empty() ? range.largest : std::max(highest, range.largest);
        left.push_back(words);
      }
      if (!left.empty())
        notes.push_back(
            of_table(domain->name + ": the " + field.name + " runs from " + in_words(lowest) + " to " +
                     in_words(highest) + ", beyond what is given for " + comma_separated(left) +
                     ". Outside of a table its last value holds. " +
                     (field.symbol == "T"
                          ? "Tables and reference temperatures of the library are in kelvin; else extend"
                          : "Extend") +
                     " the tables to where they are used"));
    }
  return notes;
}

/// Of this rank. A coefficient of no field is asked at earlier times, too.
template <int dim>
void UsedRanges<dim>::add_coefficients(const Vector &solution, const double t)
{
  for (const auto &domain : model.domains)
    for (const auto &condition : domain->conditions()) {
      const auto *exchange = varying_coefficient(*condition);
      if (exchange == nullptr)
        continue;
      LeastCoefficient &least = coefficients[condition.get()];
      const unsigned int n_times = exchange->follows_state() ? 0 : 8; // before t
      visit_points<dim>({domain.get(), condition->boundary_ids}, solution, t,
                        [&](DomainPoint<dim> &point, double) {
                          State<dim> state = point.state();
                          for (unsigned int i = 0; i <= n_times; ++i) {
                            state.t = n_times == 0 ? t : t * i / n_times;
                            const double coefficient = exchange->exchange_coefficient(state);
                            if (coefficient < least.smallest && condition->is_active(state.t))
                              least = {coefficient, state.t, state.X};
                          }
                        });
    }
}

/// Zero of one that has not been asked.
template <int dim>
typename UsedRanges<dim>::LeastCoefficient
UsedRanges<dim>::least_of_all_ranks(const Condition<dim> &condition) const
{
  const auto own = coefficients.find(&condition);
  LeastCoefficient worst;
  if (own == coefficients.end())
    return worst;
  for (const auto &of_rank : dealii::Utilities::MPI::all_gather(model.communicator, own->second))
    if (of_rank.smallest < worst.smallest)
      worst = of_rank;
  return worst;
}

template <int dim>
nlohmann::ordered_json UsedRanges<dim>::save() const
{
  nlohmann::ordered_json saved = {{"tables", nlohmann::ordered_json::array()},
                                  {"coefficients", nlohmann::ordered_json::object()}};
  for (const auto &domain : model.domains) {
    for (const Field &field : domain->fields())
      if (const auto found = ranges.find({domain.get(), field.name}); found != ranges.end())
        for (const Range &range : found->second)
          saved["tables"].push_back({{"domain", domain->name},
                                     {"field", field.name},
                                     {"path", range.entry->path},
                                     {"entry", range.entry->entry},
                                     {"scalar", range.entry->scalars[range.scalar]},
                                     {"range", {range.smallest, range.largest}}});
    for (const auto &condition : domain->conditions())
      if (const LeastCoefficient least = least_of_all_ranks(*condition); least.smallest < 0)
        saved["coefficients"][condition->section.path()] = {
            {"smallest", least.smallest},
            {"t", least.t},
            {"place", std::vector<double>(least.X.begin_raw(), least.X.end_raw())}};
  }
  return saved;
}

template <int dim>
void UsedRanges<dim>::restore(const nlohmann::ordered_json &saved)
{
  for (const auto &domain : model.domains) {
    for (const auto &table : saved["tables"])
      for (const FormulaWithTables &entry : text.formulas_with_tables())
        if (domain->name == table["domain"] && entry.path == table["path"] && entry.entry == table["entry"]) {
          const auto scalar =
              std::find_if(entry.scalars.begin(), entry.scalars.end(),
                           [&table](const std::string &name) { return name == table["scalar"]; });
          if (scalar != entry.scalars.end()) // checkpoints of earlier versions have a number here
            ranges[{domain.get(), table["field"]}].push_back(
                {&entry, static_cast<unsigned int>(scalar - entry.scalars.begin()), table["range"][0],
                 table["range"][1]});
        }
    for (const auto &condition : domain->conditions())
      if (const auto found = saved["coefficients"].find(condition->section.path());
          found != saved["coefficients"].end()) {
        LeastCoefficient &least = coefficients[condition.get()];
        least.smallest = (*found)["smallest"];
        least.t = (*found)["t"];
        for (unsigned int d = 0; d < dim; ++d)
          least.X[d] = (*found)["place"][d];
      }
  }
}

template <int dim>
NoteList UsedRanges<dim>::explain() const
{
  NoteList notes = explain_tables();
  for (const auto &domain : model.domains)
    for (const auto &condition : domain->conditions()) {
      const LeastCoefficient worst = least_of_all_ranks(*condition);
      if (worst.smallest < 0)
        notes.push_back(
            of_negative_coefficient("Coefficient is " + in_words(worst.smallest) + " at " +
                                    in_words(worst.X) + ", t = " + in_words(worst.t) +
                                    ": what is warmer than its surroundings is heated by them there. "
                                    "Change its sign, if it was meant for a flux that points outwards")
                .of(condition->section.path()));
    }
  return notes;
}

template class UsedRanges<2>;
template class UsedRanges<3>;

} // namespace dovetail
