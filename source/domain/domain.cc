// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_examination.h>
#include <dovetail/domain/cell_terms.h>
#include <dovetail/domain/curved_cells.h>
#include <dovetail/domain/domain.h>
#include <dovetail/domain/face_nodes.h>
#include <dovetail/domain/is_covered.h>
#include <dovetail/domain/mesh_size.h>
#include <dovetail/domain/node_equations.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/domain/simplices.h>

#include <dovetail/compatibility.h>

#include <deal.II/distributed/cell_data_transfer.templates.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/fe/mapping_q.h>
#include <deal.II/lac/affine_constraints.h>

#include <algorithm>
#include <array>
#include <limits>
#include <sstream>

namespace dovetail {

template <int dim>
Domain<dim>::Domain(const std::string &name, const Section &section, const Material<dim> &material,
                    const Toggles &toggles, const MPI_Comm &communicator)
    : name(name), section(section), material(material), measure(section.top()),
      degree(section.read<unsigned int>(
          "Degree", 1, "Polynomial degree of all fields, and of the mapping where the mesh is curved [-]",
          Patterns::Integer(1, 4))),
      triangulation(make_mesh<dim>(section.subsection("Mesh"), communicator)), force(section, material)
{
  read_given(section);
  read_conditions(section, toggles);
  for (const unsigned int order_in_time : {1, 2})
    lumped_components(*this, order_in_time); // must be right in every run
  if (section.documenting())
    return;

  collect_boundary_faces(communicator);
  check_conditions();

  check_unknowns<dim>(section, triangulation->n_global_active_cells(), degree, n_components(), communicator);
  choose_elements();
  examine_cells(section.subsection("Mesh"), *triangulation, *cell_mapping, scalar_element(), communicator);
  measure_box(communicator);
  dofs.reinit(*triangulation);
  distribute_dofs();
  make_memory();
  place_conditions(communicator);
}

template <int dim>
Domain<dim>::Domain(const Domain &other, const unsigned int new_degree, const Toggles &toggles,
                    const MPI_Comm &communicator)
    : name(other.name), section(other.section), material(other.material), measure(section.top()),
      degree(new_degree), triangulation(other.triangulation.get()), cell_mapping(other.cell_mapping->clone()),
      degree_of_mapping(other.degree_of_mapping), force(section, material), shares_mesh(true)
{
  try {
    read_given(section);
    read_conditions(section, toggles);
    collect_boundary_faces(communicator);
    check_unknowns<dim>(section, triangulation->n_global_active_cells(), degree, n_components(),
                        communicator);
    cell_layout = std::make_unique<CellLayout<dim>>(fields(), degree, other.has_simplices());
    measure_box(communicator);
    dofs.reinit(*triangulation);
    distribute_dofs();
    make_memory();
    place_conditions(communicator);
  } catch (...) {
    triangulation.release();
    throw;
  }
}

template <int dim>
Domain<dim>::~Domain()
{
  if (shares_mesh)
    triangulation.release();
}

template <int dim>
void Domain<dim>::choose_elements()
{
  const bool simplices = dovetail::has_simplices(*triangulation);
  for (const Field &field : fields())
    if (const unsigned int lowest = CellLayout<dim>::lowest_degree(field, simplices); degree < lowest)
      section.fail("Degree", "is " + std::to_string(degree) + ", but the elements of the " + field.name +
                                 " have one degree less than those of other fields. Set Degree = " +
                                 std::to_string(lowest) + " or higher.");
  if (simplices) {
    section.check(degree <= largest_degree_of_simplices, "Degree",
                  "is " + std::to_string(degree) +
                      ", but triangles and tetrahedra have the degrees 1 and 2 only (with deal.II 9.6 or "
                      "newer also 3).");
    degree_of_mapping = has_curved_simplices(*triangulation) ? std::min(degree, 2u) : 1;
    cell_mapping = mapping_of_simplices(*triangulation, degree_of_mapping);
  } else if (has_curved_cells(*triangulation) && degree > 1) {
    degree_of_mapping = 2;
    cell_mapping = mapping_of_curved_cells(*triangulation);
  } else {
    degree_of_mapping = degree == 1 || is_straight(*triangulation) ? 1 : degree;
    cell_mapping = std::make_unique<dealii::MappingQ<dim>>(degree_of_mapping);
  }
  cell_layout = std::make_unique<CellLayout<dim>>(fields(), degree, simplices);
}

/// Only by the cells of this rank: without any, deal.II may give it a dummy cell.
template <int dim>
void Domain<dim>::measure_box(const MPI_Comm &communicator)
{
  std::vector<double> corners(2 * dim, std::numeric_limits<double>::max()); // smallest, minus largest
  for (const auto &cell : triangulation->active_cell_iterators())
    if (cell->is_locally_owned())
      for (const unsigned int v : cell->vertex_indices())
        for (unsigned int d = 0; d < dim; ++d) {
          corners[2 * d] = std::min(corners[2 * d], cell->vertex(v)[d]);
          corners[2 * d + 1] = std::min(corners[2 * d + 1], -cell->vertex(v)[d]);
        }
  dealii::Utilities::MPI::min(corners, communicator, corners);
  dealii::Tensor<1, dim> diagonal;
  for (unsigned int d = 0; d < dim; ++d) {
    middle[d] = (corners[2 * d] - corners[2 * d + 1]) / 2;
    diagonal[d] = -corners[2 * d + 1] - corners[2 * d];
  }
  length = diagonal.norm();
  smallest_x = corners[0];
  std::ostringstream x;
  x << smallest_x;
  section.subsection("Mesh").check(!measure.is_axisymmetric() || smallest_x >= -1e-10 * length, "",
                                   "has points with x = " + x.str() +
                                       ", but in an axisymmetric scene x is the radius and cannot be "
                                       "negative. Keep the half of the section "
                                       "with x >= 0, or move the mesh by Shift.");
}

template <int dim>
void Domain<dim>::collect_boundary_faces(const MPI_Comm &communicator)
{
  faces.clear();
  measures.clear();
  std::map<dealii::types::boundary_id, double> own_areas;
  for (const auto &cell : triangulation->active_cell_iterators())
    if (!cell->is_artificial() && cell->at_boundary())
      for (const unsigned int number : cell->face_indices())
        if (const auto face = cell->face(number); face->at_boundary()) {
          faces.push_back({cell, number, face->boundary_id()});
          if (!cell->is_locally_owned())
            continue;
          // the polygon of the vertices is enough for a message
          double &measure = own_areas[face->boundary_id()];
          if constexpr (dim == 2)
            measure += face->vertex(0).distance(face->vertex(1));
          else
            measure += dealii::cross_product_3d(face->vertex(face->n_vertices() - 1) - face->vertex(0),
                                                face->vertex(2) - face->vertex(1))
                           .norm() /
                       2;
        }
  for (const auto &rank_part : dealii::Utilities::MPI::all_gather(communicator, own_areas))
    for (const auto &[id, measure] : rank_part)
      measures[id] += measure;
}

template <int dim>
void Domain<dim>::read_given(const Section &section)
{
  for (auto [kind, given, text] :
       {std::make_tuple("Source", &given_source,
                        "Source per volume: body force or heat source [N/m^3 or W/m^3]"),
        std::make_tuple("Initial", &given_initial,
                        "State at t = 0 of a transient scene, first guess of a static one [m or K]"),
        std::make_tuple("Exact", &given_exact,
                        "Exact solution; the report contains the errors against this solution [m or K]")}) {
    const Section part = section.subsection(kind);
    for (const Field &field : fields()) {
      const Expression expression = part.read_expression(field.name, "", {field.n_components}, text);
      if (part.is_set(field.name))
        given->expressions.emplace(field.name, expression);
      if (given == &given_initial && !field.rate.empty())
        read_initial_rate(part, field);
    }
  }
}

template <int dim>
void Domain<dim>::read_initial_rate(const Section &initial, const Field &field)
{
  const Expression expression = initial.read_expression(
      field.rate, "", {field.n_components},
      "Rate of the " + field.name + " at t = 0 of a transient scene with Inertia [m/s]");
  if (!initial.is_set(field.rate) || expression.is_zero())
    return;
  initial.check(material.order_in_time(field.first_component) > 1, field.rate,
                "needs a transient scene with inertia: set Kind = transient and Inertia = true in the "
                "subsection Steps, or remove it.");
  given_initial.expressions.emplace(field.rate, expression);
}

template <int dim>
void Domain<dim>::read_conditions(const Section &section, const Toggles &toggles)
{
  for (const std::string &condition :
       section.announce("Boundary conditions", "Boundary condition",
                        "Names of the boundary conditions of this domain [-]")) {
    auto created =
        ConditionCatalogue<dim>::create(section.subsection("Boundary condition " + condition), "",
                                        "The type of the boundary condition [-]", material, toggles);
    if (!created)
      continue;
    created->section.check(
        !created->follows_fields() || (created->adds_flux() && !created->is_weak()), "Toggle",
        "names '" + created->toggle_name() +
            "', which looks at fields and switches point by point: only influxes can follow it (flux, "
            "convection, radiation, pressure, spring). Take a toggle of t, or convection with a large "
            "Coefficient in place of a value.");
    all_conditions.push_back(std::move(created));
  }
}

template <int dim>
std::set<dealii::types::boundary_id> Domain<dim>::boundary_ids() const
{
  std::set<dealii::types::boundary_id> ids;
  for (const auto &[id, measure] : measures)
    ids.insert(id);
  return ids;
}

template <int dim>
void Domain<dim>::check_boundary_id(const dealii::types::boundary_id id, const Section &asking,
                                    const std::string &entry) const
{
  if (measures.count(id) > 0)
    return;
  std::string known;
  for (const auto &[known_id, measure] : measures) {
    std::ostringstream words;
    words << (known.empty() ? "" : ", ") << known_id << " (" << (dim == 2 ? "length " : "area ") << measure
          << ")";
    known += words.str();
  }
  asking.fail(entry,
              "has the boundary id " + std::to_string(id) + ", which the mesh of domain " + name +
                  " does not have. It has " + known + "." +
                  (measures.size() == 1 && measures.count(0) > 0 && section.subsection("Mesh").is_set("File")
                       ? " The file marks no boundary: in Gmsh, give boundaries physical groups, in "
                         "Abaqus, surfaces."
                       : ""));
}

/// A component that is prescribed on a boundary id has no other condition there. Influxes add up, and a plane
/// leaves room for either; conditions with toggles may take turns.
template <int dim>
void Domain<dim>::check_conditions() const
{
  using Part = std::tuple<std::string, unsigned int, dealii::types::boundary_id>;
  std::map<Part, std::string> prescribed, with_influx;
  for (const auto &condition : all_conditions)
    for (const auto id : condition->boundary_ids) {
      check_boundary_id(id, condition->section, "Boundary ids");
      condition->section.check(condition->field.is_continuous, "Field",
                               "is " + condition->field.name +
                                   ", which is discontinuous: its equation holds in each cell by itself and "
                                   "takes no boundary condition. Remove the condition.");
      if (!condition->toggle_name().empty() || condition->constrains_normal())
        continue;
      std::vector<unsigned int> components = condition->prescribed_components();
      if (condition->adds_flux())
        for (unsigned int c = 0; c < condition->field.n_components; ++c)
          if (condition->adds_flux_to(c))
            components.push_back(c);
      for (const unsigned int c : components) {
        const Part part = {condition->field.name, c, id};
        std::string other;
        if (const auto found = prescribed.find(part); found != prescribed.end())
          other = found->second;
        else if (const auto influx = with_influx.find(part);
                 !condition->adds_flux() && influx != with_influx.end())
          other = influx->second;
        condition->section.check(other.empty(), "Boundary ids",
                                 "has " + std::to_string(id) + ", where the boundary condition '" + other +
                                     "' already acts on the same component of the " + condition->field.name +
                                     ". Remove the id from one of the two.");
        (condition->adds_flux() ? with_influx : prescribed).emplace(part, condition->name);
      }
    }
}

/// All unknowns of the first field come first, over all ranks. The components at a node follow each other,
/// also where an edge, a face or a cell has several nodes. Otherwise their order remains.
template <int dim>
void Domain<dim>::distribute_dofs()
{
  dofs.distribute_dofs(cell_layout->system_element());
  sizes_of_fields = {dofs.n_dofs()};
  if (fields().size() == 1 && (degree <= 2 || fields()[0].n_components == 1))
    return; // it is so already
  const unsigned int none = dealii::numbers::invalid_unsigned_int;
  const dealii::IndexSet &owned = dofs.locally_owned_dofs(); // contiguous
  const auto first = owned.n_elements() > 0 ? owned.nth_index_in_set(0) : 0;
  const auto own = [&](const auto dof) { // also false below `first`
    return dof - first < owned.n_elements() ? static_cast<unsigned int>(dof - first) : none;
  };
  struct Place
  {
    unsigned int field = 0, next = dealii::numbers::invalid_unsigned_int; ///< next: component at the node
    bool is_first = true;                                                 ///< component
  };
  std::vector<Place> places(owned.n_elements());
  std::vector<dealii::types::global_dof_index> indices(dofs_per_cell());
  for (const auto &cell : dofs.active_cell_iterators())
    if (cell->is_locally_owned()) {
      cell->get_dof_indices(indices);
      for (unsigned int f = 0; f < fields().size(); ++f)
        for (unsigned int c = fields()[f].first_component, end = c + fields()[f].n_components; c < end; ++c)
          for (unsigned int a = 0; a < layout().n_nodes(c); ++a)
            if (const unsigned int i = own(indices[layout().system_index(layout().index(c, a))]); i != none) {
              places[i].field = f;
              places[i].is_first = c == fields()[f].first_component;
              if (c + 1 < end)
                places[i].next = own(indices[layout().system_index(layout().index(c + 1, a))]);
            }
    }

  std::vector<dealii::types::global_dof_index> own_sizes(fields().size(), 0), next(fields().size(), 0);
  for (const Place &place : places)
    ++own_sizes[place.field];
  sizes_of_fields.assign(fields().size(), 0);
  const MPI_Comm communicator = triangulation->get_communicator();
  const unsigned int own_rank = dealii::Utilities::MPI::this_mpi_process(communicator);
  const auto sizes_of_ranks = dealii::Utilities::MPI::all_gather(communicator, own_sizes);
  for (unsigned int rank = 0; rank < sizes_of_ranks.size(); ++rank)
    for (unsigned int f = 0; f < fields().size(); ++f) {
      sizes_of_fields[f] += sizes_of_ranks[rank][f];
      next[f] += rank < own_rank ? sizes_of_ranks[rank][f] : 0;
    }
  dealii::types::global_dof_index begin = 0;
  for (unsigned int f = 0; f < fields().size(); begin += sizes_of_fields[f++])
    next[f] += begin;
  std::vector<dealii::types::global_dof_index> numbers(places.size());
  for (unsigned int i = 0; i < places.size(); ++i)
    for (unsigned int k = places[i].is_first ? i : none; k != none; k = places[k].next)
      numbers[k] = next[places[k].field]++;
  dofs.renumber_dofs(numbers);
}

template <int dim>
dealii::Quadrature<dim> Domain<dim>::cell_quadrature() const
{
  return gauss_rule<dim>(cell_shape(), degree + 1);
}

template <int dim>
void Domain<dim>::make_memory()
{
  if (material.has_memory())
    memory = std::make_unique<CellMemory<dim>>(*triangulation, *cell_mapping, cell_quadrature(),
                                               material.initial_memory());
}

/// As marked; the parts of a cell remember what it did, also on another rank.
template <int dim>
void Domain<dim>::divide_cells()
{
  if (!memory) {
    triangulation->execute_coarsening_and_refinement();
    return;
  }
  using PackedCells = typename CellMemory<dim>::PackedCells;
  dealii::parallel::distributed::CellDataTransfer<dim, dim, PackedCells> transfer(
      dynamic_cast<const dealii::parallel::distributed::Triangulation<dim> &>(*triangulation), true);
  PackedCells packed = memory->pack();
  transfer.prepare_for_coarsening_and_refinement(packed);
  triangulation->execute_coarsening_and_refinement();
  PackedCells parts_packed(triangulation->n_active_cells());
  transfer.unpack(parts_packed);
  make_memory();
  memory->unpack(parts_packed);
}

template <int dim>
bool Domain<dim>::can_refine() const
{
  return dynamic_cast<const dealii::parallel::distributed::Triangulation<dim> *>(triangulation.get()) !=
         nullptr;
}

template <int dim>
dealii::TrilinosWrappers::MPI::Vector
Domain<dim>::refine(const std::vector<bool> &marked, const dealii::TrilinosWrappers::MPI::Vector &ghosted)
{
  for (const auto &cell : triangulation->active_cell_iterators())
    if (cell->is_locally_owned() && marked[cell->active_cell_index()])
      cell->set_refine_flag();
  triangulation->prepare_coarsening_and_refinement();
  SolutionTransfer<dim, dealii::TrilinosWrappers::MPI::Vector> transfer(dofs);
  transfer.prepare_for_coarsening_and_refinement(ghosted);
  divide_cells();

  const MPI_Comm communicator = ghosted.get_mpi_communicator();
  examine_cells(section.subsection("Mesh"), *triangulation, *cell_mapping, scalar_element(), communicator);
  collect_boundary_faces(communicator);
  distribute_dofs();
  place_conditions(communicator);
  dealii::TrilinosWrappers::MPI::Vector refined(dofs.locally_owned_dofs(), communicator);
  transfer.interpolate(refined);
  return refined;
}

template <int dim>
void Domain<dim>::cell_dofs(const cell_iterator &cell,
                            std::vector<dealii::types::global_dof_index> &indices) const
{
  static thread_local std::vector<dealii::types::global_dof_index> in_order_of_element;
  in_order_of_element.resize(dofs_per_cell());
  cell->get_dof_indices(in_order_of_element);
  indices.resize(dofs_per_cell());
  for (unsigned int i = 0; i < indices.size(); ++i)
    indices[i] = first_dof() + in_order_of_element[cell_layout->system_index(i)];
}

template <int dim>
dealii::AffineConstraints<double> Domain<dim>::hanging_nodes() const
{
  auto hanging = make_affine_constraints(dofs.locally_owned_dofs(),
                                         dealii::DoFTools::extract_locally_relevant_dofs(dofs));
  if (triangulation->has_hanging_nodes())
    dealii::DoFTools::make_hanging_node_constraints(dofs, hanging);
  hanging.close();
  return hanging;
}

template <int dim>
void Domain<dim>::add_hanging_nodes(ConstraintLines &lines) const
{
  if (!triangulation->has_hanging_nodes())
    return;
  const auto hanging = hanging_nodes();
  for (const auto &line : hanging.get_lines())
    if (dofs.locally_owned_dofs().is_element(line.index))
      for (const auto &[master, weight] : line.entries)
        lines[first_dof() + line.index].entries.emplace_back(first_dof() + master, weight);
}

/// A body of revolution neither overlaps itself nor opens on its axis: u_r = 0. All points on the axis lie on
/// the boundary of the section.
template <int dim>
void Domain<dim>::add_axis(ConstraintLines &lines) const
{
  std::vector<dealii::types::global_dof_index> indices;
  for (const Field &field : fields()) {
    if (!measure.has_hoop_strain(field))
      continue;
    const auto at_nodes = nodes_of(field.first_component);
    for (const BoundaryFace &face : faces)
      if (touches_axis(face)) {
        at_nodes->reinit(face.cell);
        cell_dofs(dof_cell(face.cell), indices);
        for (unsigned int a = 0; a < at_nodes->n_quadrature_points; ++a)
          if (const auto dof = indices[cell_layout->index(field.first_component, a)];
              is_on_axis(at_nodes->quadrature_point(a)) &&
              dofs.locally_owned_dofs().is_element(dof - first_dof()))
            if (const auto [line, is_new] = lines.try_emplace(dof); is_new)
              line->second.is_of_condition = true;
      }
  }
}

/// The nodes of a component as points of a cell.
template <int dim>
std::unique_ptr<dealii::FEValues<dim>> Domain<dim>::nodes_of(const unsigned int component) const
{
  const auto &element = cell_layout->element(component);
  return std::make_unique<dealii::FEValues<dim>>(*cell_mapping, element, element.get_unit_support_points(),
                                                 dealii::update_quadrature_points);
}

template <int dim>
bool Domain<dim>::touches_axis(const BoundaryFace &face) const
{
  const auto vertices = face.cell->face(face.number)->vertex_indices();
  return std::any_of(vertices.begin(), vertices.end(), [&](const unsigned int v) {
    return is_on_axis(face.cell->face(face.number)->vertex(v));
  });
}

template <int dim>
void Domain<dim>::add_constraints(const double t, ConstraintLines &lines) const
{
  add_hanging_nodes(lines);
  if (reaches_axis())
    add_axis(lines);
  add_values(t, lines);
  if (!normals.empty())
    add_planes(t, lines);
}

/// Lagrange elements: the prescribed value at the support points of the faces. The rank that owns an unknown
/// sees all cells around it, as its own or as ghosts.
template <int dim>
bool Domain<dim>::has_conditions_by_fields() const
{
  return std::any_of(all_conditions.begin(), all_conditions.end(),
                     [](const auto &condition) { return condition->follows_fields(); });
}

template <int dim>
void Domain<dim>::add_values(const double t, ConstraintLines &lines) const
{
  std::vector<dealii::types::global_dof_index> indices;
  for (const auto &condition : all_conditions) {
    const auto components = condition->prescribed_components();
    if (components.empty() || condition->is_weak() || condition->constrains_normal() ||
        !condition->is_active(t))
      continue;
    const unsigned int first = condition->field.first_component;
    const auto face_nodes = nodes_of_faces(cell_layout->element(first));
    const auto at_nodes = nodes_of(first);
    const auto add = [&](const unsigned int a) {
      for (const unsigned int c : components) {
        const auto dof = indices[cell_layout->index(first + c, a)];
        if (!dofs.locally_owned_dofs().is_element(dof - first_dof()) || lines.count(dof) > 0)
          continue;
        ConstraintLine &line = lines[dof];
        line.inhomogeneity = condition->prescribed_value(at_nodes->quadrature_point(a), t, c);
        line.is_of_condition = true;
      }
    };
    for (const BoundaryFace &face : faces)
      if (condition->boundary_ids.count(face.id) > 0) {
        at_nodes->reinit(face.cell);
        cell_dofs(dof_cell(face.cell), indices);
        for (const unsigned int a : face_nodes[face.number])
          if (!is_covered(*this, condition->field, face, a, t))
            add(a);
      }
    if (const auto node = point_nodes.find(condition.get()); node != point_nodes.end()) {
      at_nodes->reinit(node->second.cell);
      cell_dofs(dof_cell(node->second.cell), indices);
      add(node->second.node);
    }
  }
}

/// Of conditions that constrain normal components. At a node of several planes, or with prescribed
/// components, which come first, their equations are solved together; those that follow from others are left
/// out.
template <int dim>
void Domain<dim>::add_planes(const double t, ConstraintLines &lines) const
{
  std::map<dealii::types::global_dof_index, NodeEquations<dim>> equations; // by the first unknown of a node
  std::vector<dealii::types::global_dof_index> indices;
  for (const auto &condition : all_conditions) {
    if (!condition->constrains_normal() || !condition->is_active(t))
      continue;
    const unsigned int first = condition->field.first_component;
    const auto &element = cell_layout->element(first);
    const auto at_nodes = nodes_of(first);
    for (const BoundaryFace &face : faces) {
      if (condition->boundary_ids.count(face.id) == 0)
        continue;
      at_nodes->reinit(face.cell);
      cell_dofs(dof_cell(face.cell), indices);
      for (unsigned int a = 0; a < at_nodes->n_quadrature_points; ++a) {
        if (!element.has_support_on_face(a, face.number) ||
            !dofs.locally_owned_dofs().is_element(indices[cell_layout->index(first, a)] - first_dof()) ||
            is_covered(*this, condition->field, face, a, t))
          continue;
        std::array<dealii::types::global_dof_index, dim> node_unknowns;
        for (unsigned int c = 0; c < dim; ++c)
          node_unknowns[c] = indices[cell_layout->index(first + c, a)];
        const auto &at_node = equations.try_emplace(node_unknowns[0], node_unknowns, lines).first;
        at_node->second.add(plane_normal(face),
                            condition->prescribed_normal(at_nodes->quadrature_point(a), t));
      }
    }
  }
  for (const auto &[dof, at_node] : equations)
    at_node.add_lines(lines);
}

template <int dim>
bool Domain<dim>::constrains(const Condition<dim> &condition, const BoundaryFace &face,
                             const unsigned int component) const
{
  if (condition.is_weak() || condition.boundary_ids.count(face.id) == 0)
    return false;
  if (condition.constrains_normal())
    return plane_normal(face)[component] != 0;
  const auto components = condition.prescribed_components();
  return std::find(components.begin(), components.end(), component) != components.end();
}

template <int dim>
void Domain<dim>::place_conditions(const MPI_Comm &communicator)
{
  normals = find_plane_normals(*this, communicator);
  point_nodes.clear();
  for (const auto &condition : all_conditions)
    if (condition->point())
      if (const auto node = find_node(*this, *condition, communicator))
        point_nodes.emplace(condition.get(), *node);
}

template class Domain<2>;
template class Domain<3>;

} // namespace dovetail
