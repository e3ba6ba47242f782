// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_operator.h>
#include <dovetail/domain/measure_by_vertices.h>
#include <dovetail/domain/simplices.h>
#include <dovetail/domain/usual_stiffness.h>
#include <dovetail/system/linear_part.h>
#include <dovetail/system/mesh_levels.h>
#include <dovetail/system/rigid_motions.h>
#include <dovetail/system/solve_groups.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

namespace dovetail {

namespace {

/// Why the tangent of the cells must be a matrix; empty if products do.
template <int dim>
std::string why_entries(const Model<dim> &model, const std::vector<std::string> &fields,
                        const SolveGroup &group)
{
  if (fields.size() > 1)
    return "its fields depend on each other";
  if (std::any_of(group.multiplier_blocks.begin(), group.multiplier_blocks.end(), group.is_of_body))
    return "it has a pressure";
  for (const unsigned int b : group.blocks) {
    const Block &block = model.numbering->blocks()[b];
    const Domain<dim> &domain = *model.domains[block.domain_index];
    if (std::string reason = CellOperator<dim>::objection(domain, domain.fields()[block.field_index]);
        !reason.empty())
      return reason;
  }
  return "";
}

/// Why a matrix of the group is faster than products; empty if it is not.
template <int dim>
std::string why_matrix(const Model<dim> &model, const SolveGroup &group)
{
  for (const unsigned int b : group.blocks)
    if (const Domain<dim> &domain = *model.domains[model.numbering->blocks()[b].domain_index];
        domain.degree < 2)
      return "the domain " + domain.name + " has degree 1, where a matrix is faster";
  return "";
}

/// Whether two bodies differ so much that rounding of K may move one of them. In time, the residual is a
/// product with entries. Collective.
template <int dim>
bool expects_contrast(const Model<dim> &model, const std::vector<std::string> &fields,
                      const SolveGroup &group)
{
  if (group.blocks.size() < 2 || !group.why_entries.empty() || !model.is_linear(fields) ||
      model.order_in_time() > 0)
    return false;
  const auto domain_of = [&model](const unsigned int b) -> const Domain<dim> & {
    return *model.domains[model.numbering->blocks()[b].domain_index];
  };
  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(model.communicator);
  std::vector<unsigned int> first_rank; // with cells of the body: it alone evaluates a law
  for (const unsigned int b : group.blocks)
    first_rank.push_back(domain_of(b).mesh().n_locally_owned_active_cells() > 0
                             ? rank
                             : dealii::numbers::invalid_unsigned_int);
  dealii::Utilities::MPI::min(first_rank, model.communicator, first_rank);
  std::vector<double> stiffness;
  for (const unsigned int b : group.blocks)
    stiffness.push_back(
        first_rank[stiffness.size()] == rank
            ? usual_stiffness(domain_of(b), domain_of(b).fields()[model.numbering->blocks()[b].field_index])
            : 0.);
  dealii::Utilities::MPI::max(stiffness, model.communicator, stiffness);
  const auto [softest, stiffest] = std::minmax_element(stiffness.begin(), stiffness.end());
  return *softest > 0 && *stiffest > GroupFacts::large_contrast * *softest;
}

/// How many the fields of a group's bodies have.
template <int dim>
std::vector<unsigned int> components_of_fields(const Model<dim> &model, const SolveGroup &group)
{
  std::map<std::string, unsigned int> of_field;
  for (const unsigned int b : group.blocks) {
    const Block &block = model.numbering->blocks()[b];
    of_field[block.field] = model.domains[block.domain_index]->fields()[block.field_index].n_components;
  }
  std::vector<unsigned int> result;
  for (const auto &[field, n_components] : of_field)
    result.push_back(n_components);
  return result;
}

/// The boundary ids of a domain at which it is tied to another one, and goes on there.
template <int dim>
std::set<dealii::types::boundary_id> tied_ids(const Model<dim> &model, const Domain<dim> &domain)
{
  std::set<dealii::types::boundary_id> result;
  for (const auto &interface : model.interfaces)
    for (const auto &side : interface->sides)
      if (side.domain == &domain)
        result.insert(side.boundary_ids.begin(), side.boundary_ids.end());
  return result;
}

/// The share of a side that faces the other one; all, as long as they are not paired.
template <int dim>
double covered_share(const Interface<dim> &interface, const unsigned int side)
{
  if (!interface.is_paired() || interface.pairing().coverage().is_complete(side))
    return 1;
  const Coverage &coverage = interface.pairing().coverage();
  return coverage.covered[side] / coverage.area[side];
}

/// About which share of a boundary face is not tied to another domain, at which the body goes on.
template <int dim>
double open_share(const Model<dim> &model, const Domain<dim> &domain,
                  const typename Domain<dim>::BoundaryFace &face, const unsigned int field)
{
  double open = 1;
  for (const auto &interface : model.interfaces)
    for (const unsigned int side : {source, destination}) {
      const InterfaceSide<dim> &its_side = interface->sides[side];
      const auto &fields = interface->fields;
      if (its_side.domain == &domain && its_side.belongs(face.cell, face.id) &&
          std::any_of(fields.begin(), fields.end(),
                      [&](const TiedField &tied) { return tied.field[side] == field; }))
        open -= covered_share(*interface, side);
    }
  return open > 1e-5 ? open : 0;
}

template <int dim>
double area_by_vertices(const typename dealii::Triangulation<dim>::face_iterator &face)
{
  if constexpr (dim == 3)
    return dealii::cross_product_3d(face->vertex(face->n_vertices() - 1) - face->vertex(0),
                                    face->vertex(2) - face->vertex(1))
               .norm() /
           2;
  return 0;
}

/// A part of the boundary of bodies, with the volume behind it.
struct Surface
{
  double volume = 0, area = 0, n_nodes = 0;

  /// A plate has half of its surface on either side.
  double thickness() const { return 2 * volume / area; }
  double distance_of_nodes() const { return std::sqrt(area / n_nodes); }
};

/// Of blocks one by one: with the free part of their boundaries, and with all of it.
template <int dim>
std::vector<std::pair<Surface, Surface>> surfaces_of(const Model<dim> &model,
                                                     const std::vector<unsigned int> &blocks)
{
  std::vector<double> mine, all; // V, A and the nodes in A, free and in all
  for (const unsigned int b : blocks) {
    const Block &block = model.numbering->blocks()[b];
    const Domain<dim> &domain = *model.domains[block.domain_index];
    double volume = 0;
    std::array<double, 2> area{}, n_nodes{};
    for (const auto &cell : domain.dof_handler().active_cell_iterators())
      if (cell->is_locally_owned())
        volume += measure_by_vertices<dim>(cell);
    for (const auto &face : domain.boundary_faces())
      if (face.cell->is_locally_owned()) {
        const auto its_face = face.cell->face(face.number);
        const double open = open_share(model, domain, face, block.field_index),
                     its_area = area_by_vertices<dim>(its_face),
                     its_nodes = domain.degree * domain.degree * (its_face->n_vertices() == 3 ? 0.5 : 1);
        for (const unsigned int i : {0u, 1u}) {
          area[i] += (i == 0 ? open : 1) * its_area;
          n_nodes[i] += (i == 0 ? open : 1) * its_nodes;
        }
      }
    mine.insert(mine.end(), {volume, area[0], n_nodes[0], area[1], n_nodes[1]});
  }
  all.resize(mine.size());
  dealii::Utilities::MPI::sum(mine, model.communicator, all);
  std::vector<std::pair<Surface, Surface>> result;
  for (auto sums = all.begin(); sums != all.end(); sums += 5)
    result.push_back({{sums[0], sums[1], sums[2]}, {sums[0], sums[3], sums[4]}});
  return result;
}

/// Much wider than thick, and nodes are about as far apart along it as it is thick.
bool is_flat(const Surface &surface)
{
  const double largest_share = 0.06,
               least_distance = 0.7; // a square plate 8.6 times as wide as thick, or a bar 17 times as long
  return surface.area > 0 && surface.thickness() < largest_share * std::sqrt(surface.area) &&
         surface.distance_of_nodes() > least_distance * surface.thickness();
}

template <int dim>
BodyShape shape_of(const Model<dim> &model, const std::vector<unsigned int> &blocks)
{
  const std::vector<std::pair<Surface, Surface>> surfaces = surfaces_of(model, blocks);
  Surface open;
  double n_nodes = 0, n_flat = 0;
  for (unsigned int i = 0; i < blocks.size(); ++i) {
    const Block &block = model.numbering->blocks()[blocks[i]];
    const double n = static_cast<double>(block.end - block.begin) / dim;
    n_nodes += n;
    n_flat += is_flat(surfaces[i].second) ? n : 0;
    open.volume += surfaces[i].first.volume;
    open.area += surfaces[i].first.area;
    open.n_nodes += surfaces[i].first.n_nodes;
  }
  if (!(open.area > 0 && open.volume > 0))
    return {};
  return {2 * n_nodes / open.n_nodes, open.distance_of_nodes() / open.thickness(), n_flat / n_nodes};
}

template <int dim>
std::vector<bool> find_dropped(const Block &block, const BlockSystem<dim> &system)
{
  std::vector<bool> own_part;
  for (const auto i : block.owned)
    own_part.push_back(system.is_dropped(block.begin + i));
  return own_part;
}

/// SolveGroup::follower
template <int dim>
std::vector<dealii::types::global_dof_index> find_followers(const Model<dim> &model, const Block &block)
{
  std::vector<dealii::types::global_dof_index> result;
  for (const auto &interface : model.interfaces)
    for (const TiedField &field : interface->fields)
      if (interface->name == block.name && field.name == block.field && field.n_multipliers > 0)
        result = interface->tie().parts().multipliers->unknowns_with_multiplier(*interface, field);
  AssertDimension(result.size(), block.owned.n_elements());
  return result;
}

template <int dim>
void tell_of_multipliers(SolveGroup &group, const Model<dim> &model,
                         const std::function<const BlockSystem<dim> &()> &system)
{
  group.is_of_body = [&model](const unsigned int block) {
    return !model.numbering->blocks()[block].is_of_multipliers;
  };
  group.dropped = [&model, system](const unsigned int block) {
    return find_dropped(model.numbering->blocks()[block], system());
  };
  group.follower = [&model](const unsigned int block) {
    return find_followers(model, model.numbering->blocks()[block]);
  };
}

/// GroupTraits::n_followed
template <int dim>
double mean_followed(const Model<dim> &model, const std::vector<unsigned int> &blocks,
                     const dealii::AffineConstraints<double> &constraints)
{
  unsigned long n_entries = 0, n_unknowns = 0;
  for (const unsigned int b : blocks) {
    const Block &block = model.numbering->blocks()[b];
    n_unknowns += block.end - block.begin;
    for (const auto i : block.owned)
      if (const auto *entries = constraints.get_constraint_entries(block.begin + i); entries != nullptr)
        n_entries += entries->size();
  }
  return dealii::Utilities::MPI::sum(static_cast<double>(n_entries), model.communicator) / n_unknowns;
}

template <int dim>
RowSums linear_part_of(const Model<dim> &model, const unsigned int number, const bool may_solve_in_cells,
                       const dealii::AffineConstraints<double> &constraints)
{
  const Block &block = model.numbering->blocks()[number];
  const Domain<dim> &domain = *model.domains[block.domain_index];
  return linear_part(domain, block, constraints,
                     may_solve_in_cells ? smallest_stretch_beside_solves : smallest_stretch,
                     tied_ids(model, domain));
}

/// Of refined cells, aggregates serve scalars as well, in less time, and higher degrees, in less memory.
template <int dim>
bool has_useful_levels(const Model<dim> &model, const SolveGroup &group)
{
  const bool is_vector_of_degree_one = group.n_components > 1 && group.degree == 1;
  return std::any_of(model.domains.begin(), model.domains.end(), [&](const auto &domain) {
    return is_vector_of_degree_one ? has_coarser_meshes(domain->mesh())
                                   : added_vertices(domain->mesh()) != nullptr;
  });
}

/// Of the nodes of some of this rank's unknowns, or of all.
template <int dim>
std::vector<std::array<double, 3>> positions_of(const Model<dim> &model, const unsigned int number,
                                                const Selection *unknowns)
{
  const Block &block = model.numbering->blocks()[number];
  const auto places = places_of_unknowns(*model.domains[block.domain_index], block);
  std::vector<std::array<double, 3>> positions(unknowns != nullptr ? unknowns->size() : places.size());
  for (unsigned int i = 0; i < positions.size(); ++i) {
    const Place<dim> &place = places[unknowns != nullptr ? (*unknowns)[i] : i];
    std::copy(place.position.begin_raw(), place.position.end_raw(), positions[i].begin());
  }
  return positions;
}

} // namespace

template <int dim>
std::vector<SolveGroup> make_solve_groups(const Model<dim> &model,
                                          const std::function<const BlockSystem<dim> &()> &system)
{
  std::vector<SolveGroup> groups;
  if (!model.numbering) // while documenting
    return groups;
  for (const auto &fields : model.field_groups()) {
    SolveGroup group;
    group.name = comma_separated(fields);
    group.dim = dim;
    group.degree = model.degree();
    group.allows_jumps = std::any_of(fields.begin(), fields.end(),
                                     [&model](const auto &field) { return model.allows_jumps(field); });
    group.near_null_space = [&model, system](const unsigned int number, const bool about_one_point,
                                             const Selection *unknowns) {
      return model.near_null_space(model.numbering->blocks()[number], about_one_point, unknowns,
                                   system().last_state());
    };
    group.positions = [&model](const unsigned int number, const Selection *unknowns) {
      return positions_of(model, number, unknowns);
    };
    group.linear_part = [&model, system](const unsigned int number, const bool by_products) {
      return linear_part_of(model, number, by_products, system().all_constraints());
    };
    tell_of_multipliers(group, model, system);
    const auto &blocks = model.numbering->blocks();
    std::set<std::string> body_fields;
    for (unsigned int b = 0; b < blocks.size(); ++b)
      if (std::find(fields.begin(), fields.end(), blocks[b].field) != fields.end()) {
        (blocks[b].is_constraint ? group.multiplier_blocks : group.blocks).push_back(b);
        group.n_unknowns += blocks[b].end - blocks[b].begin;
        if (!blocks[b].is_constraint)
          body_fields.insert(blocks[b].field);
      }
    group.is_symmetric = body_fields.size() == 1 && model.is_symmetric(*body_fields.begin());
    if (group.is_symmetric) // on all ranks or none: nothing has been assembled yet
      group.is_still_symmetric = [&model, field = *body_fields.begin()]() {
        return model.is_symmetric(field);
      };
    group.why_entries = why_entries(model, fields, group);
    group.why_matrix = why_matrix(model, group);
    group.expects_contrast = expects_contrast(model, fields, group);
    const auto components = components_of_fields(model, group);
    group.n_components = std::accumulate(components.begin(), components.end(), 0u);
    if (has_useful_levels(model, group))
      group.mesh_levels = [&model](const unsigned int number, const bool with_parents) {
        const Block &block = model.numbering->blocks()[number];
        return mesh_levels(*model.domains[block.domain_index], block, with_parents, model.communicator);
      };
    if (dim == 3 && std::all_of(components.begin(), components.end(), [](const auto n) { return n > 1; }))
      group.present_shape = [&model, blocks = group.blocks]() { return shape_of(model, blocks); };
    group.present_followed = [&model, system, blocks = group.blocks]() {
      return mean_followed(model, blocks, system().all_constraints());
    };
    group.field = [&model](const unsigned int block) { return model.numbering->blocks()[block].field; };
    groups.push_back(std::move(group));
  }
  return groups;
}

template std::vector<SolveGroup> make_solve_groups(const Model<2> &,
                                                   const std::function<const BlockSystem<2> &()> &);
template std::vector<SolveGroup> make_solve_groups(const Model<3> &,
                                                   const std::function<const BlockSystem<3> &()> &);

} // namespace dovetail
