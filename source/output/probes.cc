// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/shapes.h>
#include <dovetail/output/probes.h>

#include <deal.II/base/geometry_info.h>

#include <limits>
#include <sstream>

namespace dovetail {

namespace {

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
    return {name, 1, 0};
  if (const Field *field = domain->material.find_field(name))
    return *field;
  std::vector<std::string> known;
  for (const Field &field : domain->fields())
    known.push_back(field.name);
  section.check(false, "Field",
                "names '" + name + "', but the domain " + domain->name + " has " + comma_separated(known) +
                    ". " + did_you_mean(name, known));
  return {name, 1, 0};
}

template <int dim>
std::string to_text(const dealii::Point<dim> &X)
{
  std::ostringstream text;
  for (unsigned int d = 0; d < dim; ++d)
    text << (d == 0 ? "" : "; ") << X[d];
  return text.str();
}

/// The point of a cell that is nearest to X, as far as the reference cell tells.
template <int dim>
struct Nearest
{
  typename Domain<dim>::cell_iterator cell;
  dealii::Point<dim> unit_point;
  double distance = std::numeric_limits<double>::max(); ///< in units of the cell's diameter
};

/// Where X is in the reference cell, or at its surface if X is outside.
template <int dim>
dealii::Point<dim> find_in_cell(const Domain<dim> &domain, const typename Domain<dim>::cell_iterator &cell,
                                const dealii::Point<dim> &X)
{
  if (!domain.has_simplices())
    return dealii::GeometryInfo<dim>::project_to_unit_cell(
        domain.mapping().transform_real_to_unit_cell(cell, X));
  const typename dealii::Triangulation<dim>::active_cell_iterator mesh_cell(cell);
  dealii::Point<dim> unit_point =
      domain.mapping_degree() > 1
          ? domain.mapping().transform_real_to_unit_cell(cell, X)
          : dealii::Point<dim>(dealii::invert(jacobian_of_simplex<dim>(mesh_cell)) * (X - cell->vertex(0)));
  double first = 1, sum = 0; // barycentric coordinates
  for (unsigned int d = 0; d < dim; ++d) {
    first -= unit_point[d];
    unit_point[d] = std::max(unit_point[d], 0.);
    sum += unit_point[d];
  }
  return dealii::Point<dim>(unit_point / (sum + std::max(first, 0.)));
}

template <int dim>
void compare_with_cell(const Domain<dim> &domain, const typename Domain<dim>::cell_iterator &cell,
                       const dealii::Point<dim> &X, Nearest<dim> &nearest)
{
  const double diameter = cell->diameter();
  if (X.distance(cell->center()) > 1.5 * diameter)
    return;
  try {
    const auto unit_point = find_in_cell(domain, cell, X);
    const double distance =
        X.distance(domain.mapping().transform_unit_to_real_cell(cell, unit_point)) / diameter;
    if (distance < nearest.distance)
      nearest = {cell, unit_point, distance};
  } catch (const typename dealii::Mapping<dim>::ExcTransformationFailed &) {
    // too far away for this curved cell
  }
}

} // namespace

template <int dim>
Probes<dim>::Probes(const Section &scene, const Model<dim> &model) : model(model)
{
  for (const std::string &name :
       scene.announce("Probes", "Probe", "Names of the numbers that are reported at the end [-]"))
    probes.push_back(read(name, scene.subsection("Probe " + name), model));
}

template <int dim>
typename Probes<dim>::Probe Probes<dim>::read(const std::string &name, const Section &section,
                                              const Model<dim> &model)
{
  Probe probe;
  probe.name = name;
  const bool has_point = section.is_set("Point"), has_boundary = section.is_set("Boundary");
  section.check(has_point || has_boundary, "", "needs a Point (with its Domain) or a Boundary.");
  section.check(!has_point || !has_boundary, "Boundary",
                "cannot be combined with Point: a probe is one number or vector. Make two probes.");
  section.check(!has_boundary || !section.is_set("Domain"), "Domain",
                "belongs to a Point; a Boundary names its domain itself (domain : boundary ids).");

  probe.section = section;
  if (has_point || section.documenting()) {
    const auto domain = section.require<std::string>("Domain", "The domain in which the point lies [-]");
    const auto point = section.require_point(
        "Point", "The point at which the field is evaluated, in material coordinates [m]");
    for (unsigned int d = 0; d < dim; ++d)
      probe.X[d] = point[d];
    probe.domain = find_domain(domain, section, "Domain", model);
  }
  if (has_boundary || section.documenting()) {
    const auto boundary =
        section.require_boundary("Boundary", "Instead of Domain and Point: the boundary over which the flux "
                                             "is integrated, domain : boundary ids [-]");
    probe.domain = find_domain(boundary.domain, section, "Boundary", model);
    if (!section.documenting())
      for (const unsigned int id : boundary.ids)
        probe.domain->check_boundary_id(id, section, "Boundary");
    probe.boundary_ids = {boundary.ids.begin(), boundary.ids.end()};
  }
  probe.field = find_field(section.require<std::string>("Field", "The field, for instance temperature [-]"),
                           section, probe.domain);
  if (has_point && !section.documenting())
    locate(probe, model.communicator);
  return probe;
}

template <int dim>
void Probes<dim>::locate_again()
{
  for (Probe &probe : probes)
    if (probe.boundary_ids.empty())
      locate(probe, model.communicator);
}

template <int dim>
void Probes<dim>::locate(Probe &probe, const MPI_Comm &communicator)
{
  probe.dofs.clear();
  probe.shape_values.clear();
  const Domain<dim> &domain = *probe.domain;
  Nearest<dim> nearest;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned())
      compare_with_cell(domain, cell, probe.X, nearest);

  const double least = dealii::Utilities::MPI::min(nearest.distance, communicator);
  if (least > (is_straight(domain.mesh()) ? tolerance_of_straight : tolerance_of_curved))
    fail_outside(probe, communicator);

  // several ranks may have it on a common face; the fields are continuous there
  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(communicator);
  const bool is_candidate = nearest.distance <= least + 1e-9;
  const auto winner = dealii::Utilities::MPI::min(
      is_candidate ? rank : std::numeric_limits<unsigned int>::max(), communicator);
  if (rank != winner)
    return;
  domain.cell_dofs(nearest.cell, probe.dofs);
  for (unsigned int a = 0; a < domain.n_nodes(); ++a)
    probe.shape_values.push_back(domain.scalar_element().shape_value(a, nearest.unit_point));
}

template <int dim>
void Probes<dim>::fail_outside(const Probe &probe, const MPI_Comm &communicator)
{
  double distance = std::numeric_limits<double>::max();
  std::vector<double> corners(2 * dim, std::numeric_limits<double>::max()); // smallest, minus largest
  for (const auto &cell : probe.domain->mesh().active_cell_iterators())
    if (cell->is_locally_owned())
      for (const unsigned int v : cell->vertex_indices()) {
        distance = std::min(distance, probe.X.distance(cell->vertex(v)));
        for (unsigned int d = 0; d < dim; ++d) {
          corners[d] = std::min(corners[d], cell->vertex(v)[d]);
          corners[dim + d] = std::min(corners[dim + d], -cell->vertex(v)[d]);
        }
      }
  distance = dealii::Utilities::MPI::min(distance, communicator);
  dealii::Utilities::MPI::min(corners, communicator, corners);
  dealii::Point<dim> lower, upper;
  for (unsigned int d = 0; d < dim; ++d) {
    lower[d] = corners[d];
    upper[d] = -corners[dim + d];
  }
  std::ostringstream message;
  message << "is outside the domain " << probe.domain->name << ": the nearest vertex of its mesh is "
          << distance << " away, and the domain extends from " << to_text(lower) << " to " << to_text(upper)
          << ".";
  probe.section->fail("Point", message.str());
}

template <int dim>
nlohmann::ordered_json Probes<dim>::evaluate(const Vector &solution, const Reactions<dim> &reactions) const
{
  auto result = nlohmann::ordered_json::object();
  for (const Probe &probe : probes) {
    std::vector<double> value(probe.field.n_components);
    if (!probe.boundary_ids.empty())
      value = reactions.resultant(*probe.domain, probe.boundary_ids, probe.field);
    else {
      const unsigned int n = probe.shape_values.size();
      for (unsigned int c = 0; c < value.size(); ++c)
        for (unsigned int a = 0; a < n; ++a)
          value[c] += probe.shape_values[a] * solution(probe.dofs[(probe.field.first_component + c) * n + a]);
      dealii::Utilities::MPI::sum(value, model.communicator, value);
    }
    if (value.size() == 1)
      result[probe.name] = value[0];
    else
      result[probe.name] = value;
  }
  return result;
}

template class Probes<2>;
template class Probes<3>;

} // namespace dovetail
