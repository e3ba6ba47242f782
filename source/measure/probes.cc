// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/transient.h>
#include <dovetail/measure/extreme_places.h>
#include <dovetail/measure/probes.h>
#include <dovetail/measure/singular_points.h>
#include <dovetail/scene/undefined.h>

#include <dovetail/compatibility.h>

#include <algorithm>

namespace dovetail {

namespace {

const NoteName of_singular_probe("singular probe", "a probe of a stress or flux lies where it is singular");

template <int dim>
const Domain<dim> *find_domain(const std::string &name, const Section &section, const std::string &entry,
                               const Model<dim> &model)
{
  std::vector<std::string> names;
  for (const auto &domain : model.domains) {
    if (domain->name == name)
      return domain.get();
    names.push_back(domain->name);
  }
  section.check(false, entry,
                "names the domain '" + name + "', which is not among Domains (" + comma_separated(names) +
                    "). " + did_you_mean(name, names));
  return nullptr;
}

template <int dim>
Field find_field(const std::string &name, const Section &section, const Domain<dim> *domain)
{
  if (domain == nullptr) // documenting
    return {name, 1, 0, "", ""};
  if (const Field *field = domain->material.find_field(name))
    return *field;
  std::vector<std::string> known;
  for (const Field &field : domain->fields())
    known.push_back(field.name);
  section.check(false, "Field",
                "names '" + name + "', but the domain " + domain->name + " has " + comma_separated(known) +
                    ". " + did_you_mean(name, known));
  return {name, 1, 0, "", ""};
}

/// A field as a quantity.
template <int dim>
class ValueOfField : public Quantity<dim>
{
public:
  ValueOfField(const Field &field, const Domain<dim> &domain)
      : Quantity<dim>(field.name, domain), field(field)
  {
  }

  unsigned int n_components() const override { return field.n_components; }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const auto first = point.state().value.begin() + field.first_component;
    numbers.insert(numbers.end(), first, first + field.n_components);
  }

private:
  const Field field;
};

/// @return one without a creator while documenting.
template <int dim>
typename QuantityCatalogue<dim>::Creator read_quantity(const Section &section, const Domain<dim> *domain,
                                                       const bool is_on_boundary)
{
  const auto name = section.require<std::string>(
      "Quantity", "Instead of a Field: one of those that Output/Fields lists, for instance von Mises [-]");
  if (domain == nullptr)
    return {};
  section.check(domain->material.find_field(name) == nullptr, "Quantity",
                "is '" + name + "', which is a field: set Field = " + name + " instead.");
  const auto &member = QuantityCatalogue<dim>::find(name, section, "Quantity");
  section.check(member.field.empty() || domain->material.find_field(member.field) != nullptr, "Quantity",
                "asks for " + name + " in the domain " + domain->name + ", but its material " +
                    domain->material.name + " has no " + law_of_field(member.field) +
                    ". Choose another quantity or domain.");
  const auto quantity = member.create(name, *domain);
  section.check(!quantity->is_of_nodes(), "Quantity",
                "asks for " + name +
                    ", which only pictures show: they act on nodes. Give Boundary and Field for their sum.");
  section.check(!quantity->is_of_motion() || (is_transient(section) && has_inertia(section)), "Quantity",
                "asks for " + name +
                    ", which only bodies with inertia have: set Inertia = true in the "
                    "subsection Steps of a transient scene.");
  section.check(!quantity->is_stored() || is_transient(section), "Quantity",
                "asks for " + name +
                    ", which only transient scenes have: set Kind = transient in the subsection Steps, or "
                    "leave it out.");
  section.check(is_on_boundary || !quantity->is_of_boundary(), "Quantity",
                "asks for " + name + ", which only boundaries have: give Boundary and Reduce.");
  return member.create;
}

std::optional<Reduce> read_reduce(const Section &section)
{
  if (!section.is_set("Reduce") && !section.documenting())
    return {};
  const auto &names = names_of_reduce();
  std::string alternatives;
  for (const std::string &name : names)
    alternatives += (alternatives.empty() ? "" : "|") + name;
  const auto name = section.require<std::string>(
      "Reduce",
      "What of the whole Domain or Boundary, of each component by itself: of a field minimum and maximum of "
      "the nodes, of a quantity of Gauss points; mean and integral over the undeformed volume or area [-]",
      Patterns::Selection(alternatives));
  return static_cast<Reduce>(std::find(names.begin(), names.end(), name) - names.begin());
}

/// Each number of a quantity at a point: the mean of the cells that have it.
template <int dim>
std::vector<double> value_at(const std::vector<PointInCell<dim>> &places, const Domain<dim> &domain,
                             const Quantity<dim> &quantity, const Vector &solution, const double t)
{
  std::vector<double> sums(quantity.n_numbers() + 1, 0.), numbers; // the last one: of cells
  DomainPoint<dim> point(domain, solution, t);
  for (const auto &[cell, unit_point] : places) {
    dealii::FEValues<dim> values(domain.mapping(), domain.layout().shape_element(),
                                 dealii::Quadrature<dim>(unit_point), DomainPoint<dim>::needed());
    values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
    point.enter(values);
    point.move_to(0);
    numbers.clear();
    quantity.evaluate(point, numbers);
    for (unsigned int i = 0; i < numbers.size(); ++i)
      sums[i] += numbers[i];
    sums.back() += 1;
  }
  dealii::Utilities::MPI::sum(sums, solution.block(0).get_mpi_communicator(), sums);
  const double n_cells = sums.back();
  sums.pop_back();
  for (double &sum : sums)
    sum /= n_cells;
  return sums;
}

} // namespace

template <int dim>
Probes<dim>::Probes(const Section &scene, const Model<dim> &model) : model(model)
{
  if (const std::string words = scene.peek("Units"); !words.empty())
    given_units.emplace(words);
  for (const std::string &name :
       scene.announce("Probes", "Probe", "Names of the numbers that are reported at the end [-]"))
    probes.push_back(read(name, scene.subsection("Probe " + name), model));
}

/// Where.
template <int dim>
void Probes<dim>::read_place(Probe &probe, const Section &section, const Model<dim> &model)
{
  const bool documents = section.documenting();
  const bool has_point = section.is_set("Point"), has_boundary = section.is_set("Boundary");
  section.check(has_point || has_boundary || section.is_set("Reduce"), "",
                "needs a Point (with its Domain), a Boundary, or a Domain with Reduce.");
  section.check(!has_point || !has_boundary, "Boundary",
                "cannot be combined with Point: a probe is one number or vector. Make two probes.");
  section.check(!has_boundary || !section.is_set("Domain"), "Domain",
                "cannot be combined with Boundary, which names its domain itself (domain : boundary ids). "
                "Remove it.");
  if (!has_boundary || documents) {
    const auto domain =
        section.require<std::string>("Domain", "The domain in which the point lies or that is reduced [-]");
    probe.region.domain = find_domain(domain, section, "Domain", model);
  }
  if (has_point || documents) {
    const auto point = section.require_point(
        "Point", "Where the field or quantity is evaluated, in material coordinates [m]");
    probe.X.emplace();
    for (unsigned int d = 0; d < dim; ++d)
      (*probe.X)[d] = point[d];
  }
  if (has_boundary || documents) {
    const auto boundary = section.require_boundary(
        "Boundary",
        "Instead of Domain and Point: where the field's flux is added up, or what is reduced, domain : "
        "boundary ids [-]");
    probe.region.domain = find_domain(boundary.domain, section, "Boundary", model);
    if (!documents)
      for (const unsigned int id : boundary.ids)
        probe.region.domain->check_boundary_id(id, section, "Boundary");
    probe.region.boundary_ids = {boundary.ids.begin(), boundary.ids.end()};
  }
  probe.reduce = read_reduce(section);
  section.check(!has_point || !probe.reduce, "Reduce",
                "cannot be combined with Point: it is of a whole Domain or Boundary.");
}

template <int dim>
typename Probes<dim>::Probe Probes<dim>::read(const std::string &name, const Section &section,
                                              const Model<dim> &model)
{
  Probe probe;
  probe.name = name;
  probe.section = section;
  read_place(probe, section, model);
  const bool has_boundary = !probe.region.boundary_ids.empty();
  const bool has_quantity = section.is_set("Quantity");
  section.check(!has_quantity || !section.is_set("Field"), "Quantity",
                "cannot be combined with Field: a probe is of one of them. Make two probes.");
  section.check(!has_quantity || !has_boundary || probe.reduce, "Quantity",
                "of a Boundary needs a Reduce (" + comma_separated(names_of_reduce()) +
                    "); without one the flux of a Field is added up.");
  if (!has_quantity || section.documenting()) {
    probe.field = find_field(section.require<std::string>(
                                 "Field", "The field, for instance temperature; else give a Quantity [-]"),
                             section, probe.region.domain);
    probe.make_quantity = [field = *probe.field](const Domain<dim> &domain) {
      return std::make_unique<ValueOfField<dim>>(field, domain);
    };
  }
  if (has_quantity || section.documenting())
    probe.make_quantity = [create = read_quantity(section, probe.region.domain, has_boundary),
                           quantity = section.peek("Quantity")](const Domain<dim> &domain) {
      return create(quantity, domain);
    };
  if (has_quantity && !section.documenting())
    probe.field_of_law = probe.region.domain->material.find_field(
        QuantityCatalogue<dim>::find(section.peek("Quantity"), section, "Quantity").field);
  if (probe.region.domain != nullptr)
    probe.quantity = probe.make_quantity(*probe.region.domain);
  if (probe.quantity && (probe.quantity->is_stored() || probe.quantity->is_of_motion()))
    probe.field_of_law = nullptr; // it follows from the field and its rate, which are bounded
  read_tolerance(probe, section, model);
  if (probe.X && !section.documenting())
    probe.places = find_cells(*probe.region.domain, *probe.X, section, model.communicator);
  return probe;
}

namespace {

/// Why the dual problem of a model cannot be solved; empty if it can.
template <int dim>
std::string why_no_dual_problem(const Model<dim> &model)
{
  if (model.order_in_time() > 0)
    return "the scene is transient, and the dual problem would run backwards in time. Remove it, or solve "
           "the "
           "static scene";
  for (const auto &domain : model.domains) {
    if (domain->material.has_memory())
      return "the law of " + domain->material.name +
             " remembers the steps before. Remove it, or take a law without internal variables";
    if (std::any_of(domain->fields().begin(), domain->fields().end(),
                    [](const Field &field) { return field.is_multiplier; }))
      return "the formulation of " + domain->material.name +
             " is mixed. Remove it, or set Formulation = displacement";
    if (domain->has_simplices() && domain->degree + 1 > largest_degree_of_simplices)
      return "elements of one degree more are needed, and the triangles or tetrahedra of " + domain->name +
             " have the largest degree already. Remove it, or set a lower Degree";
  }
  if (model.has_conditions_by_fields())
    return "the toggle of a boundary condition looks at fields, and would be asked anew on each mesh. Remove "
           "it, or take a toggle of t";
  for (const auto &interface : model.interfaces) {
    if (interface->tie().follows_fields())
      return "the toggle of the interface " + interface->name +
             " looks at fields, and would be asked anew on each mesh. Remove it, or take a toggle of t";
    if (!interface->tie().internal_variables().empty())
      return "the joint of the interface " + interface->name +
             " remembers the steps before. Remove it, or set Joint = none there";
  }
  for (const Block &block : model.numbering->blocks())
    if (block.is_of_multipliers && block.end > block.begin)
      return "the multipliers of the interface " + block.name +
             " are unknowns. Set Multiplier space = dual there";
  return "";
}

/// Why a probe has no derivative, or none that is known; empty if it has one.
template <int dim>
std::string why_no_derivative(const typename Probes<dim>::Probe &probe, const Model<dim> &model)
{
  if (probe.reduce == Reduce::minimum || probe.reduce == Reduce::maximum)
    return "a minimum or maximum has no derivative by the solution. Give the Point instead, or Reduce = mean "
           "or integral";
  if (probe.X || probe.reduce)
    return "";
  const Domain<dim> &domain = *probe.region.domain;
  const auto meets = [&](const std::set<dealii::types::boundary_id> &ids) {
    return std::any_of(ids.begin(), ids.end(),
                       [&](const auto id) { return probe.region.boundary_ids.count(id) > 0; });
  };
  for (const auto &condition : domain.conditions())
    if (condition->is_weak() && condition->field.name == probe.field->name && meets(condition->boundary_ids))
      return "the condition " + condition->name + " prescribes values weakly there. Set its Method = strong";
  for (const auto &interface : model.interfaces)
    for (const auto &side : interface->sides)
      if (side.domain == &domain && meets(side.boundary_ids))
        return "the interface " + interface->name +
               " is on this boundary. Take boundaries that conditions hold, or a Point, a mean or an "
               "integral";
  return "";
}

} // namespace

template <int dim>
void Probes<dim>::read_tolerance(Probe &probe, const Section &section, const Model<dim> &model)
{
  probe.tolerance =
      section.read<double>("Tolerance", 0,
                           "Of the estimated error, relative to the value (of a vector: to its length): the "
                           "run refines the meshes "
                           "until it is reached, and reports value and estimate; 0: no estimate [-]",
                           Patterns::Double(0));
  if (probe.tolerance == 0 || section.documenting())
    return;
  for (const std::string &reason : {why_no_dual_problem(model), why_no_derivative<dim>(probe, model)})
    section.check(reason.empty(), "Tolerance", "cannot be kept: " + reason + ".");
}

template <int dim>
bool Probes<dim>::has_tolerance() const
{
  return std::any_of(probes.begin(), probes.end(), [](const Probe &probe) { return probe.tolerance > 0; });
}

template <int dim>
bool Probes<dim>::has_motion() const
{
  return std::any_of(probes.begin(), probes.end(),
                     [](const Probe &probe) { return probe.quantity && probe.quantity->is_of_motion(); });
}

template <int dim>
void Probes<dim>::set_velocity(const Vector *velocity)
{
  for (const Probe &probe : probes)
    if (probe.quantity)
      probe.quantity->set_velocity(velocity);
}

template <int dim>
NoteList Probes<dim>::notes() const
{
  NoteList notes;
  for (const Probe &probe : probes)
    if (probe.field_of_law != nullptr && probe.X)
      if (const std::string why = why_singular(model, *probe.X, *probe.field_of_law, 0.); !why.empty())
        notes.push_back(of_singular_probe("the point of the probe " + probe.name + " lies at " + why +
                                          ", where its quantity grows without bound as the mesh is refined: "
                                          "move the point away from it, or take a mean over a part of it"));
  return notes;
}

template <int dim>
NoteList Probes<dim>::notes_on_extremes(const Vector &solution, const double t) const
{
  NoteList notes;
  const auto why_at = [&](const Probe &probe) {
    for (const auto &vertices : places_of_extremes(probe.region, *probe.quantity, *probe.reduce, solution, t))
      for (const auto &X : vertices)
        if (const std::string why = why_singular(model, X, *probe.field_of_law, t); !why.empty())
          return why + " at " + in_words(X);
    return std::string();
  };
  for (const Probe &probe : probes)
    if (probe.field_of_law != nullptr && (probe.reduce == Reduce::minimum || probe.reduce == Reduce::maximum))
      if (const std::string why = why_at(probe); !why.empty())
        notes.push_back(of_singular_probe(
            "the " + names_of_reduce()[static_cast<unsigned int>(*probe.reduce)] + " of the probe " +
            probe.name + " lies at " + why +
            ", where its quantity grows without bound as the mesh is refined: round the corner off as the "
            "part is, or take a point or a boundary away from it"));
  return notes;
}

template <int dim>
void Probes<dim>::locate_again()
{
  for (Probe &probe : probes)
    if (probe.X)
      probe.places = find_cells(*probe.region.domain, *probe.X, *probe.section, model.communicator);
}

template <int dim>
std::vector<double> Probes<dim>::evaluate(const Probe &probe, const Vector &solution,
                                          const Reactions<dim> &reactions,
                                          std::vector<dealii::Point<dim>> *places)
{
  const Region<dim> &region = probe.region;
  const double t = reactions.forces().t;
  if (probe.X)
    return value_at(probe.places, *region.domain, *probe.quantity, solution, t);
  if (!probe.reduce)
    return reactions.resultant(*region.domain, region.boundary_ids, *probe.field);
  return probe.field ? reduce(region, *probe.field, *probe.reduce, solution, places)
                     : reduce(region, *probe.quantity, *probe.reduce, solution, t, places);
}

template <int dim>
typename Probes<dim>::Values Probes<dim>::evaluate(const Vector &solution,
                                                   const Reactions<dim> &reactions) const
{
  const auto one_or_all = [](const auto &values) {
    return values.size() == 1 ? nlohmann::ordered_json(values[0]) : nlohmann::ordered_json(values);
  };
  Values result = {nlohmann::ordered_json::object(), nlohmann::ordered_json::object()};
  for (const Probe &probe : probes) {
    std::vector<dealii::Point<dim>> places;
    result.numbers[probe.name] = one_or_all(evaluate(probe, solution, reactions, &places));
    std::vector<std::vector<double>> points;
    for (const auto &place : places)
      points.emplace_back(place.begin_raw(), place.end_raw());
    if (!points.empty())
      result.places[probe.name] = one_or_all(points);
  }
  return result;
}

template class Probes<2>;
template class Probes<3>;

} // namespace dovetail
