// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/pressure_of_flux.h>
#include <dovetail/interface/interface.h>
#include <dovetail/interface/looks.h>
#include <dovetail/interface/side_ratios.h>
#include <dovetail/scene/field_toggle.h>
#include <dovetail/scene/undefined.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

namespace {

const NoteName of_coverage("coverage", "both sides of an interface have parts that face nothing");

std::vector<unsigned int> read_material_ids(const Section &section, const std::string &entry)
{
  return section.read<std::vector<unsigned int>>(
      entry + " material ids", {},
      "Restricts the " + std::string(entry == "Source" ? "source" : "destination") +
          " to faces of cells with one of these material ids of the mesh; if empty, all faces are used [-]");
}

/// An error if no face with the boundary ids of a side belongs to a cell with one of its material ids.
template <int dim>
void check_material_ids(const InterfaceSide<dim> &side, const Section &section, const std::string &entry)
{
  if (side.material_ids.empty())
    return;
  std::set<unsigned int> own_ids, present;
  for (const auto &[cell, face, id] : side.domain->boundary_faces())
    if (cell->is_locally_owned() && side.boundary_ids.count(id) > 0)
      own_ids.insert(cell->material_id());
  for (const auto &ids : dealii::Utilities::MPI::all_gather(
           side.domain->mesh().get_communicator(), std::vector<unsigned int>(own_ids.begin(), own_ids.end())))
    present.insert(ids.begin(), ids.end());
  std::vector<std::string> known;
  for (const unsigned int id : present)
    known.push_back(std::to_string(id));
  for (const unsigned int id : side.material_ids)
    section.check(present.count(id) > 0, entry + " material ids",
                  "has " + std::to_string(id) + ", but the cells behind these faces of " + side.domain->name +
                      " have the material ids " + comma_separated(known) + " only.");
}

template <int dim>
InterfaceSide<dim> find_side(const Section &section, const std::string &entry,
                             const std::vector<std::unique_ptr<Domain<dim>>> &domains)
{
  const auto reference = section.require_boundary(
      entry, "One side of the interface, domain : boundary ids, for instance left : 1 [-]");
  std::vector<std::string> names;
  for (const auto &domain : domains) {
    if (domain->name == reference.domain) {
      for (const unsigned int id : reference.ids)
        domain->check_boundary_id(id, section, entry);
      InterfaceSide<dim> side;
      side.domain = domain.get();
      side.boundary_ids = {reference.ids.begin(), reference.ids.end()};
      const auto ids = read_material_ids(section, entry);
      side.material_ids = {ids.begin(), ids.end()};
      check_material_ids(side, section, entry);
      return side;
    }
    names.push_back(domain->name);
  }
  section.check(false, entry,
                "names the domain '" + reference.domain + "', which is not among Domains (" +
                    comma_separated(names) + "). " + did_you_mean(reference.domain, names));
  return {};
}

unsigned int read_points_per_face(const Section &section)
{
  const auto text =
      section.read<std::string>("Points per face", "automatic",
                                "Number of Gauss points in each direction of a face, for mapped points; "
                                "automatic: computed from the degrees and the ratio of the face sizes [-]");
  if (text == "automatic" || section.documenting())
    return 0;
  const bool is_number = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
  section.check(is_number && text.size() < 4 && std::stoi(text) > 0, "Points per face",
                "is '" + text + "', but must be automatic or a whole number from 1 to 999.");
  return std::stoi(text);
}

std::vector<std::string> read_tied_names(const Section &section)
{
  return section.read<std::vector<std::string>>(
      "Fields", {},
      "The fields that are tied; if empty, all fields that both domains have; none: the Co-fields alone [-]");
}

/// "carbon : carbon monoxide, a : b": a field of the source and that of the destination to which it is tied.
std::vector<std::array<std::string, 2>> read_co_fields(const Section &section)
{
  std::vector<std::array<std::string, 2>> pairs;
  for (const std::string &text :
       section.read<std::vector<std::string>>("Co-fields", {},
                                              "Fields of different names that are tied, source's field : "
                                              "destination's field, for instance carbon "
                                              ": carbon monoxide [-]")) {
    const auto parts = dealii::Utilities::split_string_list(text, ':');
    const bool is_good = parts.size() == 2 && !parts[0].empty() && !parts[1].empty();
    section.check(
        is_good, "Co-fields",
        "has '" + text +
            "', but must be a list of 'field of the source : field of the destination', for instance "
            "carbon : carbon monoxide.");
    if (is_good)
      pairs.push_back({{parts[0], parts[1]}});
  }
  return pairs;
}

} // namespace

template <int dim>
Interface<dim>::Interface(const std::string &name, const Section &section,
                          const std::vector<std::unique_ptr<Domain<dim>>> &domains, const Toggles &toggles)
    : name(name), section(section), sides{{find_side(section, "Source", domains),
                                           find_side(section, "Destination", domains)}},
      toggles(&toggles), toggle(toggles.read_reference(section)),
      method(TieCatalogue<dim>::create(section, "", "The method that ties the two sides [-]"))
{
  options.quadrature = static_cast<FaceQuadrature>(
      section.choose("Quadrature", {"segments", "mapped points"}, 0,
                     "segments: exact integration on the common refinement of the faces of both sides; "
                     "mapped points: Gauss points of the faces, each mapped to the closest point of the "
                     "other side, with an error of O(1/n^2) for n points per direction [-]"));
  options.points_per_direction = read_points_per_face(section);
  section.check(
      options.quadrature == FaceQuadrature::mapped_points || options.points_per_direction == 0,
      "Points per face",
      "belongs to Quadrature = mapped points; segments know how many points they need. Remove it, or "
      "set Quadrature = mapped points.");
  options.search_radius = section.read<double>(
      "Search radius", 0.2, "Largest gap that is tied, as a multiple of the larger of the two face sizes [-]",
      Patterns::Double(1e-300));
  options.gap_extension = static_cast<GapExtension>(section.choose(
      "Gap extension", {"symmetric", "trial", "none"}, 0,
      "Extend the partner's field affinely over the gap: solution and test functions, only the "
      "solution, or not at all [-]"));
  if (!section.documenting() && !method->bridges_gaps()) {
    section.check(options.gap_extension == GapExtension::symmetric, "Gap extension",
                  "does not belong to Type = " + section.peek("Type") +
                      ", which takes the fields at the faces. Remove it.");
    options.gap_extension = GapExtension::none;
  }
  options.with_bridges =
      !section.documenting() && method->asks_bridges() && options.gap_extension != GapExtension::none;
  const std::vector<std::string> answers = {"error", "warn", "allow"};
  uncovered = answers[section.choose("Uncovered", answers, 0,
                                     "Reaction if both sides have parts without a partner [-]")];
  const auto shift =
      section.read_point("Shift", {},
                         "Translation of the source for the search of partners: X + Shift of the source "
                         "faces X of the destination, for instance in periodic bodies; solution, laws and "
                         "expressions use the original positions [m]");
  for (unsigned int d = 0; d < dim; ++d)
    sides[source].shift[d] = shift[d];
  if (section.documenting()) {
    read_jump();
    for (const std::string entry : {"Source", "Destination"})
      read_material_ids(section, entry);
    read_tied_names(section);
    read_co_fields(section);
    read_partition();
    return;
  }
  check_toggle();
  check_not_to_itself();
  options.integrate_on = method->integrates_on();
  read_fields();
  read_jump();
  read_partition();
  method->set_fields(section, fields);
  find_components();
}

/// One that looks at fields asks for points, and for a side that has each of them.
template <int dim>
void Interface<dim>::check_toggle() const
{
  const std::vector<std::string> names = names_in_toggle(section);
  section.check(
      names.empty() || method->follows_fields(), "Toggle",
      "names '" + toggle +
          "', which looks at fields and switches point by point, but Type = " + section.peek("Type") +
          " ties node by node. Use Nitsche, contact resistance or gap radiation, or a toggle of t.");
  for (const std::string &name : names) {
    const bool is_there = std::any_of(sides.begin(), sides.end(), [&name](const auto &side) {
      const auto &all = side.domain->fields();
      return std::any_of(all.begin(), all.end(),
                         [&name](const Field &field) { return name_in_toggles(field.name) == name; });
    });
    section.check(is_there, "Toggle",
                  "names '" + toggle + "', which looks at the " + name + ", but neither " +
                      sides[source].domain->name + " nor " + sides[destination].domain->name +
                      " has this field. Take a toggle of fields that a side has.");
  }
}

/// No face may be on both sides.
template <int dim>
void Interface<dim>::check_not_to_itself() const
{
  if (!sides[source].overlaps(sides[destination]))
    return;
  constexpr unsigned int none = dealii::numbers::invalid_unsigned_int;
  unsigned int shared = none;
  for (const auto &[cell, face, id] : sides[source].domain->boundary_faces())
    if (cell->is_locally_owned() && sides[source].belongs(cell, id) && sides[destination].belongs(cell, id))
      shared = std::min<unsigned int>(shared, id);
  shared = dealii::Utilities::MPI::min(shared, sides[source].domain->mesh().get_communicator());
  section.check(shared == none, "Destination",
                "and Source both have the boundary id " + std::to_string(shared) + " of the domain " +
                    sides[source].domain->name + ": a boundary cannot be tied to itself.");
}

template <int dim>
void Interface<dim>::check_against(const Interface &other, const std::string &when) const
{
  const auto difference = [](const Interface &interface) {
    return interface.sides[source].shift - interface.sides[destination].shift;
  };
  for (const unsigned int first : {source, destination})
    if (sides[source].overlaps(other.sides[first]) && sides[destination].overlaps(other.sides[1 - first]) &&
        difference(*this) == (first == source ? 1. : -1.) * difference(other))
      for (const TiedField &field : fields)
        for (const TiedField &other_field : other.fields)
          section.check(field.names[source] != other_field.names[first] &&
                            field.names[destination] != other_field.names[1 - first],
                        "Fields",
                        "include " + field.name + ", which the interface " + other.name +
                            " ties on the same boundaries, too, and " + when +
                            ". Give the two different Fields or boundary ids, or toggles that alternate.");
}

template <int dim>
void Interface<dim>::read_fields()
{
  const auto pairs = read_co_fields(section);
  std::vector<std::string> common;
  for (const Field &field : sides[source].domain->fields())
    if (const Field *other = sides[destination].domain->material.find_field(field.name);
        other != nullptr && field.is_continuous && other->is_continuous)
      common.push_back(field.name);
  auto asked = read_tied_names(section);
  section.check(!common.empty() || !pairs.empty(), "Source",
                "and Destination have no field in common: " + sides[source].domain->name + " and " +
                    sides[destination].domain->name +
                    " share no field. Fields of different names can be tied by Co-fields.");
  if (asked.empty())
    asked = common;
  else if (asked == std::vector<std::string>{"none"} && !pairs.empty())
    asked.clear();
  for (const std::string &field : asked) {
    section.check(field != "none" || std::count(common.begin(), common.end(), field) > 0, "Fields",
                  asked.size() > 1
                      ? "names 'none' beside other fields: it stands alone, and leaves the Co-fields."
                      : "is none, which ties the Co-fields alone, but there are no Co-fields. Set "
                        "Co-fields, or remove the interface from Interfaces.");
    for (const InterfaceSide<dim> &side : sides)
      if (const Field *side_field = side.domain->material.find_field(field); side_field != nullptr)
        section.check(side_field->is_continuous, "Fields",
                      "names '" + field +
                          "', which is discontinuous: it has no trace that a tie could hold. "
                          "Remove it from the list.");
    if (std::find(common.begin(), common.end(), field) == common.end())
      section.fail("Fields", "names '" + field + "', but the fields that both domains have are " +
                                 comma_separated(common) + ". " + did_you_mean(field, common));
    section.check(std::count(asked.begin(), asked.end(), field) <= 1, "Fields", "has '" + field + "' twice.");
    const bool has_other = std::any_of(pairs.begin(), pairs.end(), [&field](const auto &pair) {
      return pair[source] == field || pair[destination] == field;
    });
    section.check(!has_other || !section.is_set("Fields"), "Fields",
                  "names '" + field +
                      "', which Co-fields ties to another field. Remove it from one of them.");
    if (!has_other)
      add_field({{field, field}});
  }
  for (const auto &pair : pairs) {
    check_co_fields(pair);
    add_field(pair);
  }
}

/// An error if one side does not have its field, if the two differ in kind, or if one is tied twice.
template <int dim>
void Interface<dim>::check_co_fields(const std::array<std::string, 2> &names) const
{
  std::array<const Field *, 2> found;
  for (const unsigned int side : {source, destination}) {
    std::vector<std::string> known;
    for (const Field &field : sides[side].domain->fields())
      if (field.is_continuous)
        known.push_back(field.name);
    found[side] = sides[side].domain->material.find_field(names[side]);
    section.check(found[side] != nullptr && found[side]->is_continuous, "Co-fields",
                  std::string("names '") + names[side] + "' for the " +
                      (side == source ? "source" : "destination") + ", but the fields of " +
                      sides[side].domain->name + " are " + comma_separated(known) + ". " +
                      did_you_mean(names[side], known));
    for (const TiedField &tied : fields)
      section.check(tied.names[side] != names[side], "Co-fields",
                    "tie '" + names[side] + "' of the domain " + sides[side].domain->name + " twice.");
  }
  if (found[source] != nullptr && found[destination] != nullptr)
    section.check(found[source]->n_components == 1 && found[destination]->n_components == 1, "Co-fields",
                  "tie '" + names[source] + "' and '" + names[destination] +
                      "', but only scalars can have different names.");
}

template <int dim>
void Interface<dim>::add_field(const std::array<std::string, 2> &names)
{
  TiedField tied;
  tied.name = names[source];
  tied.names = names;
  tied.index = fields.size();
  for (const unsigned int side : {source, destination})
    for (unsigned int f = 0; f < sides[side].domain->fields().size(); ++f)
      if (const Field &side_field = sides[side].domain->fields()[f]; side_field.name == names[side]) {
        if (side == source)
          tied.symbol = side_field.symbol;
        tied.n_components = side_field.n_components;
        tied.first_component[side] = side_field.first_component;
        tied.field[side] = f;
        tied.n_nodes[side] = sides[side].domain->layout().n_nodes(side_field.first_component);
        tied.first_shape[side] = sides[side].domain->layout().first_shape(side_field.first_component);
        tied.has_curvature = tied.has_curvature && sides[side].domain->material.has_curvature(f);
      }
  fields.push_back(tied);
}

template <int dim>
void Interface<dim>::read_partition()
{
  const double K = section.read<double>(
      "Partition coefficient", 1,
      "K of a species that two materials dissolve differently: B_source = K B_destination on the interface, "
      "with the same flux on both sides; a Jump is then B_source - K B_destination; not with constraints [-]",
      Patterns::Double(1e-300));
  if (K == 1 || section.documenting())
    return;
  section.check(
      fields.size() == 1 && fields[0].n_components == 1, "Partition coefficient",
      "belongs to one scalar field, but the interface ties " +
          std::string(fields.size() > 1 ? "several" : "a vector") +
          ". Set Fields to one scalar, or to none beside Co-fields, and tie the others by interfaces "
          "of their own.");
  section.check(method->allows_partition(), "Partition coefficient",
                "is not 1, which Type = " + section.peek("Type") +
                    " cannot give. Use Type = Nitsche or contact resistance.");
  fields[0].partition = K;
}

template <int dim>
void Interface<dim>::read_jump()
{
  const std::string names = fields.size() > 1 ? fields[0].name + " and " + fields[1].name : "";
  section.check(fields.size() < 2 || !section.is_set("Jump"), "Jump",
                "belongs to one field, but the interface ties the " + names +
                    ". Set Fields to one of them, and tie the others by interfaces of their own.");
  given_jump = section.read_expression(
      "Jump", "", {fields.empty() ? 1 : fields[0].n_components},
      "Prescribed jump c of the field from the destination to the source, B_source - B_destination = c, one "
      "formula per component: an interference fit, a drop of temperature; with a contact resistance the jump "
      "without flux [m or K]");
  has_jump = section.is_set("Jump") && !given_jump.is_zero();
}

template <int dim>
double Interface<dim>::prescribed_jump(const dealii::Point<dim> &X, const double t,
                                       const unsigned int component) const
{
  return finite(given_jump.value(X, t, component), section, "Jump", X, t);
}

template <int dim>
void Interface<dim>::find_components()
{
  const std::vector<std::string> in_toggle = names_in_toggle(section);
  for (const unsigned int side : {source, destination})
    for (unsigned int g = 0; g < sides[side].domain->fields().size(); ++g) {
      const Field &field = sides[side].domain->fields()[g];
      bool is_needed = std::find(in_toggle.begin(), in_toggle.end(), name_in_toggles(field.name)) !=
                           in_toggle.end() || // if only to look at it
                       sides[side].domain->material.chooses_by(field.first_component) ||
                       looks_at(*method, *sides[side].domain, g);
      for (const TiedField &tied : fields)
        is_needed = is_needed || tied.field[side] == g ||
                    sides[side].domain->material.flux_depends(tied.field[side], g);
      for (unsigned int c = 0; is_needed && c < field.n_components; ++c) {
        components[side].push_back(field.first_component + c);
        n_unknowns[side] += sides[side].domain->layout().n_nodes(field.first_component);
      }
    }
}

template <int dim>
void Interface<dim>::pair(const MPI_Comm &communicator)
{
  std::array<bool, 2> with_cover;
  for (const unsigned int side : {source, destination})
    with_cover[side] = has_conditions(side);
  geometry = std::make_unique<Pairing<dim>>(sides, options, with_cover, communicator);
  all_work += geometry->work();
  std::vector<typename Pairing<dim>::OwnShare> shares;
  for (const TiedField &field : fields)
    shares.push_back([this, &field](const unsigned int own, const unsigned int q) {
      return own_share_of_gap(*this, field, own, {{geometry->X(source, q), geometry->X(destination, q)}});
    });
  geometry->extend(shares);
  find_leading();
  std::vector<double> of_joint;
  for (const InternalVariable &variable : method->internal_variables())
    of_joint.insert(of_joint.end(), variable.n_components, variable.initial);
  memory.set_points(*geometry, sides, of_joint, communicator);
  check_coverage(communicator);
}

/// Only terms at points ask for them.
template <int dim>
void Interface<dim>::find_leading()
{
  if (method->parts().point_terms == nullptr)
    return;
  const unsigned int anywhere = dealii::numbers::invalid_unsigned_int;
  every_unknown = find_leading_unknowns(*this, {{anywhere, anywhere}});
  leading_by_faces.clear();
  leading.clear();
  for (const auto &group : geometry->groups) {
    const std::array<unsigned int, 2> faces = {{face_of_group(*this, source, group.begin, group.end),
                                                face_of_group(*this, destination, group.begin, group.end)}};
    if (leading_by_faces.count(faces) == 0)
      leading_by_faces[faces] = find_leading_unknowns(*this, faces);
    leading.push_back(&leading_by_faces.at(faces));
  }
}

template <int dim>
FaceLocator<dim> Interface<dim>::make_locator(const unsigned int side, const MPI_Comm &communicator) const
{
  return {faces_of(sides[side]), options.search_radius, options.least_reach, communicator};
}

template <int dim>
void Interface<dim>::follow(const Interface &other)
{
  all_work += other.all_work;
  options.least_reach = (1 + 1e-6) * other.pairing().coverage().largest_gap;
  memory = other.memory;
}

/// The smallest distance of some points of the source to the destination; negative if it is that of a point
/// inside the other body: the destination faces it from behind, and no farther than half of the bodies' size.
template <int dim>
double Interface<dim>::distance_of_sides(const MPI_Comm &communicator) const
{
  const Domain<dim> &one = *sides[source].domain, &other = *sides[destination].domain;
  const SideFaces<dim> faces = faces_of(sides[source]);
  const double reach = one.centre().distance(other.centre()) + one.typical_length() + other.typical_length() +
                       sides[source].shift.norm();
  const FaceLocator<dim> locator(faces_of(sides[destination]), 0, reach, communicator);
  constexpr unsigned int n_points = 100;
  std::vector<typename FaceLocator<dim>::Query> queries;
  for (unsigned int i = 0; i < faces.faces.size(); i += 1 + faces.faces.size() / n_points) {
    const auto middle = faces.shape.evaluate(faces.nodes(i), faces.shape.centre());
    const auto N = faces.shape.normal(faces.faces[i].face_no, middle);
    queries.push_back({middle.X, N / N.norm(), faces.faces[i].size});
  }
  const double depth = std::min(one.typical_length(), other.typical_length()) / 2;
  double least = std::numeric_limits<double>::infinity(), least_overlap = least;
  const auto matches = locator.locate(queries);
  for (unsigned int i = 0; i < matches.size(); ++i) {
    const auto &match = matches[i];
    least = std::min(least, match.distance);
    if (match.distance < depth && match.N * queries[i].N < 0 &&
        (match.X - queries[i].X) * (queries[i].N - match.N) < 0)
      least_overlap = std::min(least_overlap, match.distance);
  }
  least = dealii::Utilities::MPI::min(least, communicator);
  return dealii::Utilities::MPI::min(least_overlap, communicator) == least ? -least : least;
}

template <int dim>
bool Interface<dim>::has_conditions(const unsigned int side) const
{
  const auto &ids = sides[side].boundary_ids;
  for (const auto &condition : sides[side].domain->conditions())
    for (const TiedField &field : fields)
      if (field.names[side] == condition->field.name &&
          std::any_of(condition->boundary_ids.begin(), condition->boundary_ids.end(),
                      [&](const auto id) { return ids.count(id) > 0; }))
        return true;
  return false;
}

template <int dim>
void Interface<dim>::check_coverage(const MPI_Comm &communicator)
{
  const Coverage &coverage = pairing().coverage();
  std::ostringstream message;
  message.precision(3);
  if (coverage.n_points == 0) {
    const double distance = distance_of_sides(communicator);
    message << "and Destination do not face each other anywhere; they "
            << (distance < 0 ? "overlap by about " : "are about ") << std::abs(distance)
            << (distance < 0 ? "" : " apart") << ". Check the boundary ids, Scale and Shift of the two meshes"
            << (sides[source].shift.norm() > 0 ? " and the Shift of the interface" : "")
            << ", or enlarge Search radius (now " << options.search_radius << " of the face size).";
    section.fail("Source", message.str());
  }
  if (coverage.is_complete(source) || coverage.is_complete(destination) || uncovered == "allow")
    return;
  message << 100 * (1 - coverage.covered[source] / coverage.area[source]) << " % of the source and "
          << 100 * (1 - coverage.covered[destination] / coverage.area[destination])
          << " % of the destination face nothing (" << coverage.n_uncovered
          << " points). Enlarge Search radius if a gap is the reason (now " << options.search_radius
          << " of the face size), or set Uncovered = allow if this is meant.";
  if (uncovered == "error")
    section.fail("Uncovered", "is error: " + message.str());
  geometry_notes.push_back(of_coverage(message.str()));
}

template <int dim>
NoteList Interface<dim>::notes() const
{
  NoteList all = geometry_notes;
  for (const Note &note : method->notes())
    all.push_back(note);
  return all;
}

template <int dim>
void Interface<dim>::group_dofs(const typename Pairing<dim>::Group &group,
                                std::vector<dealii::types::global_dof_index> &dofs) const
{
  dofs.clear();
  for (const unsigned int side : {source, destination}) {
    const auto &cell_unknowns = pairing().cells[side][group.cells[side]].dofs;
    const auto &layout = sides[side].domain->layout();
    for (const unsigned int c : components[side])
      dofs.insert(dofs.end(), cell_unknowns.begin() + layout.first(c),
                  cell_unknowns.begin() + layout.first(c + 1));
  }
}

template <int dim>
void Interface<dim>::jump(const TiedField &field, const unsigned int q, const double t,
                          const std::vector<double> &unknowns, std::vector<double> &result) const
{
  result.assign(field.n_components, 0.);
  for (unsigned int c = 0; has_jump && c < field.n_components; ++c)
    result[c] = -prescribed_jump(pairing().X(source, q), t, c);
  for (const unsigned int side : {source, destination}) {
    const unsigned int n = field.n_nodes[side];
    const double *trial = pairing().trial(side, q, field.index) + field.first_shape[side];
    const double sign = (side == source ? 1 : -1) * field.in_jump(side);
    const unsigned int first = first_unknown(side, field.first_component[side]);
    for (unsigned int c = 0; c < field.n_components; ++c)
      for (unsigned int a = 0; a < n; ++a)
        result[c] += sign * trial[a] * unknowns[first + c * n + a];
  }
}

template <int dim>
std::vector<bool> Interface<dim>::unknowns_in_jump(const typename Pairing<dim>::Group &group) const
{
  std::vector<bool> in_jump(n_local(source) + n_local(destination), false);
  for (unsigned int f = 0; f < fields.size(); ++f)
    for (const unsigned int side : {source, destination}) {
      const unsigned int n = fields[f].n_nodes[side], first_shape = fields[f].first_shape[side];
      const unsigned int first = first_unknown(side, fields[f].first_component[side]);
      for (unsigned int q = group.begin; q < group.end; ++q) {
        const double *trial = pairing().trial(side, q, f) + first_shape,
                     *test = pairing().test(side, q, f) + first_shape;
        for (unsigned int a = 0; a < n; ++a)
          if (std::abs(trial[a]) > least_in_jump || std::abs(test[a]) > least_in_jump)
            for (unsigned int c = 0; c < fields[f].n_components; ++c)
              in_jump[first + c * n + a] = true;
      }
    }
  if (leading.empty()) // the tie has no terms at points
    return in_jump;
  // across a gap that is hardly more than rounding a node may be in the jump and those that follow it not,
  // but they get entries from it
  const LeadingUnknowns &of_group = leading_unknowns(group);
  std::vector<bool> leads(of_group.size(), false);
  for (unsigned int i = 0; i < in_jump.size(); ++i)
    if (in_jump[i])
      leads[of_group.leader[i]] = true;
  for (unsigned int i = 0; i < in_jump.size(); ++i)
    in_jump[i] = leads[of_group.leader[i]];
  return in_jump;
}

template <int dim>
unsigned int Interface<dim>::position(const unsigned int side, const unsigned int component) const
{
  return std::find(components[side].begin(), components[side].end(), component) - components[side].begin();
}

template <int dim>
unsigned int Interface<dim>::first_unknown(const unsigned int side, const unsigned int component) const
{
  const auto &layout = sides[side].domain->layout();
  unsigned int first = side == source ? 0 : n_local(source);
  for (const unsigned int c : components[side]) {
    if (c == component)
      break;
    first += layout.n_nodes(c);
  }
  return first;
}

template <int dim>
bool Interface<dim>::couples(const unsigned int row, const unsigned int column) const
{
  const auto side_and_component = [this](const unsigned int i) {
    return i < components[source].size()
               ? std::make_pair(source, components[source][i])
               : std::make_pair(destination, components[destination][i - components[source].size()]);
  };
  const auto contains = [](const unsigned int first, const unsigned int n, const unsigned int c) {
    return c >= first && c < first + n;
  };
  const auto [row_side, row_component] = side_and_component(row);
  const auto [side, component] = side_and_component(column);
  for (const TiedField &tied : fields)
    if (contains(tied.first_component[row_side], tied.n_components, row_component) ||
        pressure_of_flux(*sides[row_side].domain, tied.field[row_side]) == row_component) {
      const auto &side_field = sides[side].domain->fields();
      for (unsigned int g = 0; g < side_field.size(); ++g)
        if (contains(side_field[g].first_component, side_field[g].n_components, component))
          return sides[side].domain->material.flux_depends(tied.field[side], g) ||
                 (tied.n_components == 1 && looks_at(*method, *sides[side].domain, g));
    }
  return false;
}

template <int dim>
bool Interface<dim>::is_linear() const
{
  for (const TiedField &tied : fields)
    for (const unsigned int side : {source, destination})
      if (!sides[side].domain->material.has_linear_flux(tied.field[side]))
        return false;
  return true;
}

template <int dim>
bool Interface<dim>::has_constant_fluxes() const
{
  return std::all_of(fields.begin(), fields.end(),
                     [this](const TiedField &field) { return has_constant_flux(field); });
}

template <int dim>
bool Interface<dim>::has_constant_flux(const TiedField &field) const
{
  return std::all_of(sides.begin(), sides.end(), [&](const InterfaceSide<dim> &side) {
    const Material<dim> &material = side.domain->material;
    return material.has_linear_flux(field.field[&side - sides.data()]) && !material.depends_on_time();
  });
}

template <int dim>
std::string Interface<dim>::description() const
{
  const std::array<bool, 2> on = options.integrate_on;
  const std::string tie_description = method->description();
  return section.peek("Type") + (tie_description.empty() ? "" : ", " + tie_description) + ", " +
         (options.quadrature == FaceQuadrature::segments ? "segments" : "mapped points") + " on the " +
         (on[source] && on[destination] ? "faces of both sides"
          : on[source]                  ? "source"
                                        : "destination");
}

template class Interface<2>;
template class Interface<3>;

} // namespace dovetail
