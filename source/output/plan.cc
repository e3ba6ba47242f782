// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/plan.h>

#include <algorithm>
#include <sstream>

namespace dovetail {

namespace {

/// Domains of which the same is said come together, in the order of the scene.
class DomainNames
{
public:
  void add(const std::string &before, const std::string &after, const std::string &domain)
  {
    const auto found = std::find_if(all.begin(), all.end(), [&](const Entry &entry) {
      return entry.before == before && entry.after == after;
    });
    if (found != all.end())
      found->domains.push_back(domain);
    else
      all.push_back({before, after, {domain}});
  }

  /// Without their names where all are meant.
  void append_to(std::vector<std::string> &sentences, const unsigned int n_domains) const
  {
    for (const Entry &entry : all)
      sentences.push_back(entry.before +
                          (entry.domains.size() == n_domains ? "" : " of " + comma_separated(entry.domains)) +
                          ": " + entry.after);
  }

private:
  struct Entry
  {
    std::string before, after;
    std::vector<std::string> domains;
  };
  std::vector<Entry> all;
};

/// What is not as usual.
template <int dim>
void plan_geometry(const Model<dim> &model, Plan &plan)
{
  const Measure<dim> &measure = model.domains[0]->measure;
  if (measure.thickness() != 1) {
    std::ostringstream thickness;
    thickness << measure.thickness();
    plan.needed.push_back("thickness of all bodies: " + thickness.str());
  }
  if (!measure.is_axisymmetric())
    return;
  plan.needed.push_back("axisymmetric: x is the radius, y the axis; integrals are over the whole circle");
  DomainNames held;
  for (const auto &domain : model.domains)
    for (const Field &field : domain->fields())
      if (domain->reaches_axis() && measure.has_hoop_strain(field))
        held.add(field.name + " on the axis", "0 along x", domain->name);
  held.append_to(plan.needed, model.domains.size());
}

template <int dim>
void plan_fields(const Model<dim> &model, Plan &plan)
{
  DomainNames laws, absent, uncoupled;
  const auto stage = model.stages_of_fields();
  for (const auto &group : model.field_groups())
    for (const std::string &name : group)
      for (const auto &domain : model.domains)
        for (unsigned int f = 0; f < domain->fields().size(); ++f)
          if (domain->fields()[f].name == name)
            laws.add(name, domain->material.description(f), domain->name);
  for (const auto &[field, law] : {std::pair("displacement", "solid"), std::pair("temperature", "heat")})
    for (const auto &domain : model.domains)
      if (domain->material.find_field(field) == nullptr)
        absent.add(field, std::string("no ") + law + " law", domain->name);
  for (const auto &domain : model.domains)
    for (unsigned int f = 0; f < domain->fields().size(); ++f)
      for (unsigned int g = 0; g < domain->fields().size(); ++g)
        if (const std::string &field = domain->fields()[f].name, &by = domain->fields()[g].name;
            !domain->material.depends(f, g))
          uncoupled.add("block " + field + " by " + by, "not coupled", domain->name);
        else if (model.solves_stages_apart() && stage.at(field) != stage.at(by))
          uncoupled.add("block " + field + " by " + by, by + " is solved first", domain->name);
  laws.append_to(plan.needed, model.domains.size());
  absent.append_to(plan.left_out, model.domains.size());
  uncoupled.append_to(plan.left_out, model.domains.size());
}

template <int dim>
bool has_toggles(const Model<dim> &model)
{
  for (const auto &domain : model.domains)
    for (const auto &condition : domain->conditions())
      if (!condition->toggle_name().empty())
        return true;
  return std::any_of(model.interfaces.begin(), model.interfaces.end(),
                     [](const auto &interface) { return interface->has_toggle(); });
}

template <int dim>
void plan_steps(const Model<dim> &model, const unsigned int n_steps, Plan &plan)
{
  if (n_steps == 0)
    return;
  const std::string steps = n_steps == 1 ? "one step" : std::to_string(n_steps) + " steps";
  if (!model.is_linear())
    plan.needed.push_back(steps + ": nonlinear, Newton's method");
  else if (n_steps == 1)
    plan.needed.push_back(steps + ": linear, one tangent and one solve");
  else if (!model.has_constant_tangent())
    plan.needed.push_back(steps + ": linear, a tangent for each, because it depends on t");
  else {
    const std::string exception = has_toggles(model) ? ", and anew where a toggle switches" : "";
    plan.needed.push_back(steps + ": linear, one tangent and one factorisation for all" + exception);
    plan.left_out.push_back("tangent and factorisation of later steps: linear, and they do not depend on t" +
                            std::string(exception.empty() ? "" : " between toggles"));
  }
}

template <int dim>
void plan_interfaces(const Model<dim> &model, Plan &plan)
{
  const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(model.communicator);
  if (model.interfaces.empty())
    plan.left_out.push_back("pairing: no interfaces");
  std::vector<std::pair<std::string, std::vector<std::string>>> ties; // with the interfaces that have them
  std::vector<std::string> exchanges;
  for (const auto &interface : model.interfaces) {
    std::vector<std::string> tied;
    for (const TiedField &field : interface->fields)
      tied.push_back(field.label());
    const std::string sentence = comma_separated(tied) + " by " + interface->description();
    const auto same =
        std::find_if(ties.begin(), ties.end(), [&](const auto &other) { return other.first == sentence; });
    if (same == ties.end())
      ties.push_back({sentence, {interface->name}});
    else
      same->second.push_back(interface->name);
    const std::string exchange = "exchange between ranks for " + interface->name;
    if (dealii::Utilities::MPI::sum(interface->work().messages, model.communicator) > 0)
      exchanges.push_back(
          exchange + ": " +
          std::to_string(dealii::Utilities::MPI::sum(interface->work().faces, model.communicator)) +
          " faces");
    else if (n_ranks > 1)
      plan.left_out.push_back(exchange + ": facing points live on one rank");
    for (const std::string &without : interface->tie().left_out(*interface))
      plan.left_out.push_back(without);
  }
  for (const auto &[sentence, names] : ties)
    plan.needed.push_back(comma_separated(names) + ": " + sentence);
  plan.needed.insert(plan.needed.end(), exchanges.begin(), exchanges.end());
}

template <int dim>
void plan_loads(const Model<dim> &model, Plan &plan)
{
  bool has_flux = false, has_source = false;
  for (const auto &domain : model.domains) {
    has_source = has_source || !domain->source().expressions.empty() || domain->body_force().is_given();
    for (const auto &condition : domain->conditions())
      has_flux = has_flux || condition->adds_flux() || condition->is_weak();
  }
  if (!has_source)
    plan.left_out.push_back("source terms: none given");
  if (!has_flux)
    plan.left_out.push_back("boundary terms: no condition gives a flux");
}

} // namespace

template <int dim>
Plan make_plan(const Model<dim> &model, const unsigned int n_steps, const std::vector<std::string> &solvers)
{
  Plan plan;
  plan_geometry(model, plan);
  plan_fields(model, plan);
  plan_interfaces(model, plan);
  plan_steps(model, n_steps, plan);
  for (const std::string &solver : solvers)
    plan.needed.push_back("solver of " + solver);
  plan_loads(model, plan);
  return plan;
}

template Plan make_plan(const Model<2> &, unsigned int, const std::vector<std::string> &);
template Plan make_plan(const Model<3> &, unsigned int, const std::vector<std::string> &);

} // namespace dovetail
