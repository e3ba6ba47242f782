// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/looks.h>
#include <dovetail/interface/make_cover.h>
#include <dovetail/pairing/facing_boundaries.h>
#include <dovetail/system/joined_fields.h>
#include <dovetail/system/model.h>
#include <dovetail/system/rigid_motions.h>

#include <deal.II/base/timer.h>

#include <algorithm>
#include <set>
#include <sstream>

namespace dovetail {

namespace {

std::string to_text(const double t)
{
  std::ostringstream text;
  text << t;
  return text.str();
}

} // namespace

template <int dim>
Model<dim>::Model(const Section &scene, const MPI_Comm &communicator)
    : communicator(communicator), toggles(scene)
{
  std::vector<std::string> material_names;
  for (const std::string &name : scene.announce("Materials", "Material", "Names of the materials [-]")) {
    materials.push_back(std::make_unique<Material<dim>>(name, scene.subsection("Material " + name)));
    material_names.push_back(name);
  }
  scene.check(!materials.empty(), "Materials", "must name at least one material.");

  for (const std::string &name : scene.announce("Domains", "Domain", "Names of the bodies [-]")) {
    const Section section = scene.subsection("Domain " + name);
    const auto material_name = section.require<std::string>("Material", "The material of this body [-]");
    const auto material = std::find(material_names.begin(), material_names.end(), material_name);
    section.check(material != material_names.end(), "Material",
                  "names '" + material_name + "', which is not among Materials (" +
                      comma_separated(material_names) + "). " + did_you_mean(material_name, material_names));
    const unsigned int index =
        scene.documenting() ? 0 : static_cast<unsigned int>(material - material_names.begin());
    domains.push_back(std::make_unique<Domain<dim>>(name, section, *materials[index], toggles, communicator));
  }
  scene.check(!domains.empty(), "Domains", "must name at least one body.");

  if (scene.peek("Interfaces") == "automatic" && !scene.has_subsection("Interface automatic"))
    find_interfaces(scene);
  for (const std::string &name : scene.announce(
           "Interfaces", "Interface",
           "Names of the pairs of boundaries that are tied; automatic: one by Nitsche's method for "
           "each pair of bodies that face each other within 0.2 face sizes and 45 degrees [-]"))
    interfaces.push_back(
        std::make_unique<Interface<dim>>(name, scene.subsection("Interface " + name), domains, toggles));

  if (scene.documenting())
    return;
  tell_other_interfaces();
  for (unsigned int i = 0; i < interfaces.size(); ++i)
    for (unsigned int j = 0; j < i; ++j)
      if (!interfaces[i]->has_toggle() && !interfaces[j]->has_toggle())
        interfaces[i]->check_against(*interfaces[j], "both are always active");
  check_constants();
  number();
}

template <int dim>
Model<dim>::Model(const Model &other, const unsigned int more_degrees)
    : communicator(other.communicator), toggles(other.toggles)
{
  for (const auto &domain : other.domains)
    domains.push_back(
        std::make_unique<Domain<dim>>(*domain, domain->degree + more_degrees, toggles, communicator));
  for (const auto &interface : other.interfaces) {
    const std::string type = interface->tie().type_for_errors();
    const Section section = type.empty() ? interface->section : interface->section.in_copy_of_scene();
    if (!type.empty())
      section.give("", "Type", type, "the estimate of errors");
    interfaces.push_back(std::make_unique<Interface<dim>>(interface->name, section, domains, toggles));
    interfaces.back()->follow(*interface);
  }
  tell_other_interfaces();
  number();
  pair();
}

template <int dim>
void Model<dim>::number()
{
  numbering = std::make_unique<Numbering>(domains, communicator);
  for (const auto &interface : interfaces)
    for (TiedField &field : interface->fields) {
      const Multipliers<dim> *multipliers = interface->tie().parts().multipliers;
      field.n_multipliers =
          multipliers != nullptr ? multipliers->unknowns_with_multiplier(*interface, field).size() : 0;
      field.first_multiplier =
          numbering->add_multipliers(interface->name, field.name, field.n_multipliers, communicator);
    }
}

template <int dim>
void Model<dim>::check_ties(const double t) const
{
  std::ostringstream when;
  when << "both are active at t = " << t;
  for (unsigned int i = 0; i < interfaces.size(); ++i)
    for (unsigned int j = 0; j < i; ++j)
      if (interfaces[i]->is_active(t) && interfaces[j]->is_active(t) &&
          !interfaces[i]->tie().follows_fields() && !interfaces[j]->tie().follows_fields())
        interfaces[i]->check_against(*interfaces[j], when.str());
  check_constants(t);
}

/// Tell each side of each interface what others tie of its domain.
template <int dim>
void Model<dim>::tell_other_interfaces()
{
  for (const auto &interface : interfaces)
    for (InterfaceSide<dim> &side : interface->sides) {
      side.others.clear();
      side.strong_others.clear();
      for (const auto &other : interfaces)
        for (const unsigned int i : {source, destination})
          if (const InterfaceSide<dim> &other_side = other->sides[i];
              &other_side != &side && other_side.domain == side.domain)
            for (const TiedField &field : other->fields) {
              side.others[field.names[i]].push_back(&other_side);
              if (other->tie().parts().elimination != nullptr)
                side.strong_others[field.names[i]].push_back(&other_side);
            }
    }
}

template <int dim>
void Model<dim>::find_interfaces(const Section &scene) const
{
  const std::string reason = "Interfaces = automatic";
  std::vector<std::string> names;
  for (const FacingBoundaries &facing : find_facing_boundaries(domains, 0.2, communicator)) {
    const auto side = [&](const unsigned int i) {
      std::vector<std::string> ids;
      for (const auto id : facing.ids[i])
        ids.push_back(std::to_string(id));
      return domains[facing.domains[i]]->name + " : " + comma_separated(ids);
    };
    names.push_back(domains[facing.domains[0]]->name + "-" + domains[facing.domains[1]]->name);
    const std::string subsection = "Interface " + names.back();
    scene.give(subsection, "Type", "Nitsche", reason);
    scene.give(subsection, "Source", side(0), reason);
    scene.give(subsection, "Destination", side(1), reason);
    // each side is usually larger than what it shares with one other body
    scene.give(subsection, "Uncovered", "allow", reason);
  }
  scene.check(
      !names.empty(), "Interfaces",
      "is automatic, but no two bodies that share a field face each other within 0.2 face sizes and 45 "
      "degrees. Check "
      "Scale and Shift of the meshes, or name the interfaces.");
  scene.give("", "Interfaces", comma_separated(names), reason);
}

template <int dim>
void Model<dim>::pair()
{
  dealii::Timer timer;
  for (const auto &interface : interfaces) {
    interface->pair(communicator);
    search_seconds += interface->pairing().seconds_of_search();
  }
  make_covers();
  pairing_seconds = timer.wall_time();
}

/// Boundary conditions act on what the interfaces leave of their boundary ids.
template <int dim>
void Model<dim>::make_covers()
{
  for (const auto &domain : domains)
    domain->covers.clear();
  for (const auto &interface : interfaces)
    for (const unsigned int side : {source, destination})
      if (interface->has_conditions(side))
        for (const auto &domain : domains)
          if (domain.get() == interface->sides[side].domain)
            domain->covers.push_back(make_cover(*interface, side, communicator));

  for (const auto &domain : domains)
    for (const auto &condition : domain->conditions())
      check_acts_somewhere(*domain, *condition);
}

/// An error if permanent interfaces cover all of a condition's faces or, of a prescribed value, all nodes.
template <int dim>
void Model<dim>::check_acts_somewhere(const Domain<dim> &domain, const Condition<dim> &condition) const
{
  if (condition.point())
    return;
  std::vector<std::string> covering;
  std::map<std::pair<unsigned int, unsigned int>, double> share;
  std::set<std::array<unsigned int, 4>> nodes;
  const unsigned int first = condition.field.first_component, space = domain.layout().space(first);
  const auto &element = domain.layout().element(first);
  for (const Cover<dim> &cover : domain.covers)
    if (cover.is_permanent && cover.fields.count(condition.field.name) > 0) {
      covering.push_back(cover.interface);
      for (const auto &[face, covered] : cover.faces)
        share[face] += covered.share;
      nodes.insert(cover.nodes.begin(), cover.nodes.end());
    }
  unsigned int n_open = 0;
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (cell->is_locally_owned() && condition.boundary_ids.count(id) > 0) {
      if (condition.prescribed_components().empty() || condition.is_weak())
        n_open += share[{cell->active_cell_index(), face}] < 1 - 1e-9 ? 1 : 0;
      else
        for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
          n_open += element.has_support_on_face(a, face) &&
                            nodes.count({{cell->active_cell_index(), face, space, a}}) == 0
                        ? 1
                        : 0;
    }
  condition.section.check(
      covering.empty() || dealii::Utilities::MPI::sum(n_open, communicator) > 0, "Boundary ids",
      "are covered wholly by the " +
          (covering.size() > 1 ? "interfaces " + comma_separated(covering) + ", which tie"
                               : "interface " + comma_separated(covering) + ", which ties") +
          " the same field there: the condition would act nowhere. Remove the condition, or those ids from " +
          (covering.size() > 1 ? "the interfaces." : "the interface."));
}

template <int dim>
Vector Model<dim>::refine(const std::vector<std::vector<bool>> &marked, const Vector &ghosted)
{
  std::vector<dealii::TrilinosWrappers::MPI::Vector> parts;
  for (const auto &domain : domains)
    parts.push_back(domain_vector(*domain, ghosted));
  for (unsigned int d = 0; d < domains.size(); ++d)
    if (domains[d]->can_refine())
      parts[d] = domains[d]->refine(marked[d], parts[d]);

  for (auto &interface : interfaces) { // what a tie has frozen belongs to points that are no more
    auto renewed = std::make_unique<Interface<dim>>(interface->name, interface->section, domains, toggles);
    renewed->follow(*interface);
    interface = std::move(renewed);
  }
  tell_other_interfaces();
  number();
  Vector refined(numbering->split(numbering->owned), communicator); // multipliers begin at zero
  for (unsigned int d = 0; d < domains.size(); ++d)
    for (const auto dof : domains[d]->dof_handler().locally_owned_dofs())
      refined(domains[d]->first_dof() + dof) = parts[d](dof);
  refined.compress(dealii::VectorOperation::insert);
  pair();
  return refined;
}

/// Every group of domains that is tied in a field needs, for each component, a condition that keeps it from
/// drifting.
template <int dim>
void Model<dim>::check_constants(const std::optional<double> t) const
{
  std::map<std::pair<std::string, unsigned int>, std::set<const Domain<dim> *>> held;
  for (const auto &domain : domains)
    for (const Field &field : domain->fields())
      for (unsigned int c = 0; c < field.n_components; ++c) {
        const auto [entry, is_new] = held.try_emplace({field.name, c});
        if (is_new)
          entry->second = held_domains(field.name, c, t);
        if (field.is_multiplier)
          continue;
        const bool is_radial = domain->measure.has_hoop_strain(field) && c == 0; // strained, so held
        if (!is_radial && entry->second.count(domain.get()) == 0)
          domain->section.fail(
              "Boundary conditions",
              "leave the " + field.name + " of this domain free to drift by a constant" +
                  (field.n_components > 1 ? " in " + std::string(1, "xyz"[c]) : "") +
                  (t ? " while toggles switch off what holds it (t = " + to_text(*t) + ")" : "") +
                  ". Give it a condition of Type = value" +
                  std::string(field.n_components > 1 ? "" : " or convection") +
                  " here or on a domain it is tied to.");
      }
}

/// Whether a body stores the component, so that it does not drift without reason; or a source depends on this
/// component itself, and on others only if conditions hold these: a and b that react with each other may
/// drift together.
template <int dim>
bool Model<dim>::is_held_by_source(const Domain<dim> &domain, const unsigned int c,
                                   const std::optional<double> t) const
{
  if (domain.material.order_in_time(c) > 0)
    return true;
  if (!domain.material.coupling(c, c).source_by_value)
    return false;
  for (const Field &other : domain.fields())
    for (unsigned int d = 0; d < other.n_components; ++d)
      if (other.first_component + d != c && domain.material.order_in_time(other.first_component + d) == 0 &&
          domain.material.coupling(c, other.first_component + d).in_source() &&
          held_domains(other.name, d, t, false).count(&domain) == 0)
        return false;
  return true;
}

/// The domains in which a condition or a reaction reaches a component of a field, directly or through
/// interfaces.
template <int dim>
std::set<const Domain<dim> *> Model<dim>::held_domains(const std::string &field, const unsigned int component,
                                                       const std::optional<double> t,
                                                       const bool with_reactions) const
{
  const auto joined = joined_fields<dim>(*this, [&](const auto &interface, const TiedField &tied) {
    return interface.tie().holds(tied) && (!t || interface.is_active(*t));
  });
  std::set<unsigned int> asked, is_held; // of the numbers in joined
  for (unsigned int d = 0; d < domains.size(); ++d)
    for (unsigned int f = 0; f < domains[d]->fields().size(); ++f)
      if (domains[d]->fields()[f].name == field)
        asked.insert(joined[d][f]);
  for (unsigned int d = 0; d < domains.size(); ++d)
    for (unsigned int f = 0; f < domains[d]->fields().size(); ++f) {
      const Field &domain_field = domains[d]->fields()[f];
      if (asked.count(joined[d][f]) == 0 || component >= domain_field.n_components)
        continue;
      const auto &conditions = domains[d]->conditions();
      const bool has_condition =
          std::any_of(conditions.begin(), conditions.end(), [&](const auto &condition) {
            return condition->field.name == domain_field.name && condition->removes_constant(component) &&
                   (!t || condition->is_active(*t));
          });
      if (has_condition ||
          (with_reactions && is_held_by_source(*domains[d], domain_field.first_component + component, t)))
        is_held.insert(joined[d][f]);
    }
  std::set<const Domain<dim> *> held;
  for (unsigned int d = 0; d < domains.size(); ++d)
    for (unsigned int f = 0; f < domains[d]->fields().size(); ++f)
      if (domains[d]->fields()[f].name == field && is_held.count(joined[d][f]) > 0)
        held.insert(domains[d].get());
  return held;
}

namespace {

/// Pairs of a tied scalar and another field on which its tie depends.
template <int dim>
std::set<std::pair<std::string, std::string>> looks_of_ties(const Interface<dim> &interface)
{
  std::set<std::pair<std::string, std::string>> pairs;
  for (const TiedField &tied : interface.fields)
    for (const unsigned int of : {source, destination})
      for (const unsigned int side : {source, destination})
        for (unsigned int g = 0; g < interface.sides[side].domain->fields().size(); ++g)
          if (const std::string &name = interface.sides[side].domain->fields()[g].name;
              tied.n_components == 1 && name != tied.names[of] &&
              looks_at(interface.tie(), *interface.sides[side].domain, g))
            pairs.emplace(tied.names[of], name);
  return pairs;
}

} // namespace

template <int dim>
std::vector<std::vector<std::string>> Model<dim>::field_groups() const
{
  std::vector<std::string> open;
  std::map<std::string, std::set<std::string>> depends_on;
  for (const auto &domain : domains)
    for (unsigned int f = 0; f < domain->fields().size(); ++f) {
      const std::string &name = domain->fields()[f].name;
      if (std::find(open.begin(), open.end(), name) == open.end())
        open.push_back(name);
      for (unsigned int g = 0; g < domain->fields().size(); ++g)
        if (g != f && domain->material.depends(f, g))
          depends_on[name].insert(domain->fields()[g].name);
    }
  for (const auto &interface : interfaces)
    for (const TiedField &tied : interface->fields)
      for (const unsigned int side : {source, destination})
        if (tied.names[side] != tied.names[1 - side])
          depends_on[tied.names[side]].insert(tied.names[1 - side]);
  for (const auto &interface : interfaces)
    for (const auto &[field, other] : looks_of_ties(*interface))
      depends_on[field].insert(other);

  // what a field needs, directly or by way of others
  for (std::size_t round = 0; round < open.size(); ++round)
    for (auto &[name, needed] : depends_on)
      for (const std::string &other : std::set<std::string>(needed))
        needed.insert(depends_on[other].begin(), depends_on[other].end());

  std::vector<std::vector<std::string>> groups;
  std::set<std::string> done;
  while (!open.empty()) {
    // the first field that needs, besides those that are done, only fields that need it in turn
    const auto next = std::find_if(open.begin(), open.end(), [&](const std::string &name) {
      return std::all_of(depends_on[name].begin(), depends_on[name].end(), [&](const std::string &other) {
        return done.count(other) > 0 || other == name || depends_on[other].count(name) > 0;
      });
    });
    std::vector<std::string> group;
    for (const std::string &name : open)
      if (name == *next || (depends_on[*next].count(name) > 0 && depends_on[name].count(*next) > 0))
        group.push_back(name);
    for (const std::string &name : group) {
      done.insert(name);
      open.erase(std::find(open.begin(), open.end(), name));
    }
    groups.push_back(group);
  }
  return groups;
}

template <int dim>
std::vector<unsigned int> Model<dim>::stages() const
{
  std::vector<unsigned int> result;
  std::vector<std::string> fields; // of the last stage
  for (const auto &group : field_groups()) {
    const bool is_driven = std::any_of(group.begin(), group.end(), [&](const std::string &field) {
      return std::any_of(fields.begin(), fields.end(),
                         [&](const std::string &other) { return depends(field, other); });
    });
    const bool follows = is_driven && is_linear(group) && !is_linear();
    if (follows)
      fields.clear();
    result.push_back(result.empty() ? 0 : result.back() + (follows ? 1 : 0));
    fields.insert(fields.end(), group.begin(), group.end());
  }
  return result;
}

template <int dim>
std::map<std::string, unsigned int> Model<dim>::stages_of_fields() const
{
  const auto groups = field_groups();
  const std::vector<unsigned int> of_groups = stages();
  std::map<std::string, unsigned int> result;
  for (unsigned int g = 0; g < groups.size(); ++g)
    for (const std::string &field : groups[g])
      result[field] = of_groups[g];
  return result;
}

template <int dim>
unsigned int Model<dim>::order_in_time() const
{
  unsigned int order = 0;
  for (const auto &domain : domains)
    order = std::max(order, domain->material.order_in_time());
  return order;
}

template <int dim>
bool Model<dim>::sees_past() const
{
  return std::any_of(domains.begin(), domains.end(),
                     [](const auto &domain) { return domain->material.sees_past(); });
}

template <int dim>
bool Model<dim>::has_large_strain() const
{
  return std::any_of(domains.begin(), domains.end(),
                     [](const auto &domain) { return domain->material.has_large_strain(); });
}

/// Of the fields, by name, for which @p is_asked.
template <int dim>
template <typename IsAsked>
bool Model<dim>::is_linear_in(const IsAsked &is_asked) const
{
  for (const auto &domain : domains) {
    for (unsigned int f = 0; f < domain->fields().size(); ++f)
      if (is_asked(domain->fields()[f].name) && !domain->material.is_linear(f))
        return false;
    for (const auto &condition : domain->conditions())
      if (is_asked(condition->field.name) && !condition->is_linear())
        return false;
  }
  for (const auto &interface : interfaces)
    for (const TiedField &tied : interface->fields)
      if ((is_asked(tied.names[source]) || is_asked(tied.names[destination])) &&
          !interface->tie().is_linear())
        return false;
  return true;
}

template <int dim>
bool Model<dim>::is_linear() const
{
  return is_linear_in([](const std::string &) { return true; });
}

template <int dim>
bool Model<dim>::is_linear(const std::vector<std::string> &fields) const
{
  return is_linear_in([&fields](const std::string &field) {
    return std::find(fields.begin(), fields.end(), field) != fields.end();
  });
}

template <int dim>
bool Model<dim>::depends(const std::string &field, const std::string &on_field) const
{
  for (const auto &domain : domains) {
    const auto &fields = domain->fields();
    for (unsigned int f = 0; f < fields.size(); ++f)
      for (unsigned int g = 0; g < fields.size(); ++g)
        if (fields[f].name == field && fields[g].name == on_field && domain->material.depends(f, g))
          return true;
  }
  for (const auto &interface : interfaces)
    for (const TiedField &tied : interface->fields)
      for (const unsigned int side : {source, destination})
        if (tied.names[side] == field && tied.names[1 - side] == on_field && field != on_field)
          return true;
  return std::any_of(interfaces.begin(), interfaces.end(), [&](const auto &interface) {
    return looks_of_ties(*interface).count({field, on_field}) > 0;
  });
}

template <int dim>
bool Model<dim>::has_constant_tangent() const
{
  if (!is_linear())
    return false;
  for (const auto &domain : domains) {
    if (domain->material.depends_on_time())
      return false;
    for (const auto &condition : domain->conditions())
      if (!condition->has_constant_tangent() || (condition->follows_fields() && condition->has_tangent()))
        return false;
  }
  return std::all_of(interfaces.begin(), interfaces.end(),
                     [](const auto &interface) { return interface->tie().has_constant_tangent(*interface); });
}

template <int dim>
std::vector<bool> Model<dim>::active_toggles(const double t) const
{
  std::vector<bool> active;
  for (const auto &domain : domains)
    for (const auto &condition : domain->conditions())
      active.push_back(condition->is_active(t));
  for (const auto &interface : interfaces)
    active.push_back(interface->is_active(t));
  return active;
}

template <int dim>
bool Model<dim>::has_conditions_by_fields() const
{
  return std::any_of(domains.begin(), domains.end(),
                     [](const auto &domain) { return domain->has_conditions_by_fields(); });
}

template <int dim>
bool Model<dim>::is_symmetric(const std::string &field) const
{
  for (const auto &domain : domains) {
    for (unsigned int f = 0; f < domain->fields().size(); ++f)
      if (domain->fields()[f].name == field && !domain->material.is_symmetric(f))
        return false;
    for (const auto &condition : domain->conditions())
      if (condition->field.name == field && !condition->is_symmetric())
        return false;
  }
  for (const auto &interface : interfaces)
    for (const auto &tied : interface->fields)
      if (tied.ties(field) && (!interface->is_symmetric() || tied.has_partition()))
        return false;
  return true;
}

template <int dim>
bool Model<dim>::allows_jumps(const std::string &field) const
{
  for (const auto &interface : interfaces)
    for (const auto &tied : interface->fields)
      if (tied.ties(field) && (interface->tie().allows_jump(tied) || tied.has_partition()))
        return true;
  return false;
}

template <int dim>
unsigned int Model<dim>::degree() const
{
  unsigned int largest = 1;
  for (const auto &domain : domains)
    largest = std::max(largest, domain->degree);
  return largest;
}

template <int dim>
std::vector<std::vector<double>> Model<dim>::near_null_space(const Block &block, const bool about_one_point,
                                                             const std::vector<unsigned int> *unknowns,
                                                             const Vector *displacements) const
{
  const Domain<dim> &domain = *domains[block.domain_index];
  const Domain<dim> &reference = about_one_point ? *domains[0] : domain;
  return rigid_motions(domain, block, reference.centre(), reference.typical_length(), unknowns,
                       domain.material.has_large_strain() ? displacements : nullptr);
}

template <int dim>
std::string names_of(const std::vector<const Domain<dim> *> &bodies)
{
  std::vector<std::string> names;
  for (const Domain<dim> *body : bodies)
    names.push_back(body->name);
  return comma_separated(names);
}

template class Model<2>;
template class Model<3>;
template std::string names_of(const std::vector<const Domain<2> *> &);
template std::string names_of(const std::vector<const Domain<3> *> &);

} // namespace dovetail
