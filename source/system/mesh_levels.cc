// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/edge_lengths.h>
#include <dovetail/domain/simplices.h>
#include <dovetail/system/mesh_levels.h>

#include <deal.II/base/mpi.h>
#include <deal.II/grid/cell_id.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

namespace dovetail {

namespace {

/// The cells of a domain that are divided, as far as owned cells descend from them.
template <int dim>
class Parents
{
public:
  using Dof = dealii::types::global_dof_index;
  using Cell = typename dealii::Triangulation<dim>::cell_iterator;
  static constexpr unsigned int n_vertices = 1u << dim;
  static constexpr unsigned char remains = 255;

  Parents(const Domain<dim> &domain, const Block &block, const MPI_Comm &communicator);

  MeshLevels levels() const;

private:
  struct Parent
  {
    unsigned int step = 0;  ///< that replaces its children
    bool is_shared = false; ///< with cells of other ranks
    std::vector<Dof> dofs;  ///< vertex by vertex; none: no owned cell descends from it
  };
  /// What an unknown is in the smallest parent that it is no vertex of.
  struct Middle
  {
    const Parent *parent = nullptr;
    unsigned char step = remains, component = 0;
    unsigned char child = 0, between = 0; ///< one at which it is, and the directions in which it is halfway
  };

  void add_descendant(const Cell &cell, const std::vector<Dof> &of_vertices);
  void find_steps();
  void share();
  void find_middles();
  void find_middle(const typename Domain<dim>::cell_iterator &cell, unsigned int v);
  void share_steps();

  const Domain<dim> &domain;
  const Block &block;
  const Field &field;
  const MPI_Comm communicator;
  std::vector<std::vector<Parent>> parents; ///< by level and index
  std::vector<Middle> middles;              ///< of owned unknowns
  std::map<Dof, unsigned char> steps;       ///< of other ranks' unknowns
  std::vector<Dof> dofs;                    ///< of a cell
};

template <int dim>
Parents<dim>::Parents(const Domain<dim> &domain, const Block &block, const MPI_Comm &communicator)
    : domain(domain), block(block), field(domain.fields()[block.field_index]), communicator(communicator),
      middles(block.owned.n_elements())
{
  for (unsigned int level = 0; level < domain.mesh().n_levels(); ++level)
    parents.emplace_back(domain.mesh().n_raw_cells(level));
  std::vector<Dof> of_vertices;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned() && cell->level() > 0) {
      domain.cell_dofs(cell, dofs);
      of_vertices.clear();
      for (unsigned int v = 0; v < n_vertices; ++v)
        for (unsigned int c = 0; c < field.n_components; ++c)
          of_vertices.push_back(dofs[domain.layout().index(field.first_component + c, v)]);
      add_descendant(Cell(cell), of_vertices);
    }
  find_steps();
  share();
  find_middles();
  share_steps();
}

/// To all ancestors of a cell. A vertex of a parent is that of its child there.
template <int dim>
void Parents<dim>::add_descendant(const Cell &cell, const std::vector<Dof> &of_vertices)
{
  const unsigned int n = field.n_components;
  std::array<bool, n_vertices> is_common{}; // with the ancestor
  is_common.fill(true);
  for (Cell child = cell; child->level() > 0; child = child->parent()) {
    const Cell ancestor = child->parent();
    Parent &parent = parents[ancestor->level()][ancestor->index()];
    parent.dofs.resize(n_vertices * n, dealii::numbers::invalid_dof_index);
    for (unsigned int v = 0; v < n_vertices; ++v)
      if (is_common[v] = is_common[v] && ancestor->child(v) == child; is_common[v])
        std::copy_n(&of_vertices[v * n], n, &parent.dofs[v * n]);
  }
}

/// From the finest level on. Of cells without owned descendants nothing is known here.
template <int dim>
void Parents<dim>::find_steps()
{
  for (unsigned int level = parents.size(); level-- > 0;)
    for (unsigned int index = 0; index < parents[level].size(); ++index) {
      Parent &parent = parents[level][index];
      if (parent.dofs.empty())
        continue;
      const Cell cell(&domain.mesh(), level, index);
      for (unsigned int k = 0; k < n_vertices; ++k) {
        const Cell child = cell->child(k);
        const Parent &as_parent = parents[level + 1][child->index()];
        const bool is_leaf = child->is_active();
        parent.is_shared = parent.is_shared || (is_leaf ? !child->is_locally_owned()
                                                        : as_parent.dofs.empty() || as_parent.is_shared);
        parent.step = std::max(parent.step, is_leaf ? 1u : as_parent.step + 1);
      }
      const auto lengths = edge_lengths<dim>(cell);
      const bool is_stretched = *std::max_element(lengths.begin(), lengths.end()) >
                                smallest_stretch * *std::min_element(lengths.begin(), lengths.end());
      parent.step = is_stretched ? remains : std::min<unsigned int>(parent.step, remains);
    }
}

/// What ranks know of the parents that they share. The rank that collects it depends on the parent.
template <int dim>
void Parents<dim>::share()
{
  using Key = std::array<unsigned int, 4>;
  using Messages = std::map<unsigned int, std::vector<Dof>>;
  const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(communicator),
                     n_dofs = n_vertices * field.n_components, length = n_dofs + 5;
  const auto merge = [](Dof *const known, const Dof *const other, const unsigned int n) {
    known[0] = std::max(known[0], other[0]);
    for (unsigned int i = 1; i < n; ++i)
      known[i] = std::min(known[i], other[i]); // an unknown one is the largest number
  };
  Messages sent;
  std::map<Key, Parent *> shared;
  for (unsigned int level = 0; level < parents.size(); ++level)
    for (unsigned int index = 0; index < parents[level].size(); ++index)
      if (Parent &parent = parents[level][index]; parent.is_shared) {
        const Key key = Cell(&domain.mesh(), level, index)->id().template to_binary<dim>();
        shared[key] = &parent;
        std::vector<Dof> &message = sent[(key[0] + 31 * key[1] + 961 * key[2]) % n_ranks];
        message.insert(message.end(), key.begin(), key.end());
        message.push_back(parent.step);
        message.insert(message.end(), parent.dofs.begin(), parent.dofs.end());
      }
  std::map<Key, std::vector<Dof>> collected;
  std::map<unsigned int, std::vector<Key>> asked;
  for (const auto &[rank, message] : dealii::Utilities::MPI::some_to_some(communicator, sent))
    for (auto part = message.begin(); part != message.end(); part += length) {
      Key key{};
      std::copy_n(part, key.size(), key.begin());
      asked[rank].push_back(key);
      const auto [found, is_new] = collected.try_emplace(key, part + 4, part + length);
      if (!is_new)
        merge(found->second.data(), &part[4], n_dofs + 1);
    }
  Messages answers;
  for (const auto &[rank, keys] : asked)
    for (const Key &key : keys) {
      std::vector<Dof> &answer = answers[rank];
      answer.insert(answer.end(), key.begin(), key.end());
      answer.insert(answer.end(), collected.at(key).begin(), collected.at(key).end());
    }
  for (const auto &[rank, message] : dealii::Utilities::MPI::some_to_some(communicator, answers))
    for (auto part = message.begin(); part != message.end(); part += length) {
      Key key{};
      std::copy_n(part, key.size(), key.begin());
      shared.at(key)->step = part[4];
      shared.at(key)->dofs.assign(part + 5, part + length);
    }
}

/// Of the vertices of owned cells.
template <int dim>
void Parents<dim>::find_middles()
{
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      for (unsigned int v = 0; v < n_vertices; ++v)
        find_middle(cell, v);
    }
}

template <int dim>
void Parents<dim>::find_middle(const typename Domain<dim>::cell_iterator &cell, const unsigned int v)
{
  Cell child(cell);
  while (child->level() > 0 && child->parent()->child(v) == child)
    child = child->parent();
  if (child->level() == 0)
    return;
  const Cell its_parent = child->parent();
  const Parent &parent = parents[its_parent->level()][its_parent->index()];
  unsigned char number = 0;
  while (its_parent->child(number) != child)
    ++number;
  for (unsigned int c = 0; c < field.n_components; ++c) {
    const Dof dof = dofs[domain.layout().index(field.first_component + c, v)];
    unsigned char step = parent.step;
    if (block.owned.is_element(dof - block.begin)) {
      Middle &middle = middles[block.owned.index_within_set(dof - block.begin)];
      step = std::min(step, middle.step);
      middle = {&parent, step, static_cast<unsigned char>(c), number, static_cast<unsigned char>(number ^ v)};
    } else
      steps[dof] = std::min(step, steps.try_emplace(dof, remains).first->second);
  }
}

/// The rank that owns an unknown may not see all parents that it is halfway in.
template <int dim>
void Parents<dim>::share_steps()
{
  std::map<unsigned int, std::vector<std::pair<Dof, unsigned char>>> sent;
  const auto &first = block.first_of_rank;
  for (const auto &[dof, step] : steps)
    sent[std::upper_bound(first.begin(), first.end(), dof - block.begin) - first.begin() - 1].emplace_back(
        dof, step);
  for (const auto &received : dealii::Utilities::MPI::some_to_some(communicator, sent))
    for (const auto &[dof, step] : received.second) {
      Middle &middle = middles[block.owned.index_within_set(dof - block.begin)];
      middle.step = std::min(middle.step, step);
    }
}

template <int dim>
MeshLevels Parents<dim>::levels() const
{
  MeshLevels result;
  std::array<unsigned int, dim + 1> weights{}; // of a mean of 2^k
  for (unsigned int k = 1; k <= dim; ++k)
    weights[k] = result.means.add_weights(std::vector<double>(1u << k, 1. / (1u << k)));
  for (const Middle &middle : middles) {
    const bool is_gone = middle.parent != nullptr && middle.step != remains;
    result.step.push_back(is_gone ? middle.step : 0);
    if (!is_gone) {
      result.means.add_row(0, 0);
      continue;
    }
    unsigned int n_directions = 0;
    for (unsigned int d = 0; d < dim; ++d)
      n_directions += (middle.between >> d) & 1u;
    Dof *column = result.means.add_row(1u << n_directions, weights[n_directions]);
    for (unsigned int w = 0; w < n_vertices; ++w)
      if ((w & ~middle.between) == (middle.child & ~middle.between))
        *column++ = middle.parent->dofs[w * field.n_components + middle.component];
  }
  return result;
}

/// Calls @p visit(dof, column) for each owned unknown of a vertex that was added, and each vertex beside it
/// that was not. These are the vertices of a face, some of them several times.
/// @param is_added by vertex
template <int dim, typename Visit>
void for_parts(const Domain<dim> &domain, const Block &block, const std::vector<bool> &is_added,
               const Visit &visit)
{
  const Field &field = domain.fields()[block.field_index];
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators()) {
    if (cell->is_artificial())
      continue;
    domain.cell_dofs(cell, dofs);
    for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c)
      for (const unsigned int v : cell->vertex_indices()) {
        const auto dof = dofs[domain.layout().index(c, v)] - block.begin;
        if (is_added[cell->vertex_index(v)] && block.owned.is_element(dof))
          for (const unsigned int w : cell->vertex_indices())
            if (!is_added[cell->vertex_index(w)])
              visit(block.owned.index_within_set(dof), dofs[domain.layout().index(c, w)]);
      }
  }
}

/// Of tetrahedra that are parts of hexahedra. The vertex in the middle of a face is the mean of its four.
template <int dim>
MeshLevels levels_of_parts(const Domain<dim> &domain, const Block &block, const std::vector<bool> &is_added)
{
  using Dof = dealii::types::global_dof_index;
  const unsigned int n = 4;
  const Dof none = dealii::numbers::invalid_dof_index;
  MeshLevels result;
  result.has_parts = true;
  result.step.assign(block.owned.n_elements(), 0);
  for_parts(domain, block, is_added, [&](const unsigned int i, Dof) { result.step[i] = 1; });
  const unsigned int weights = result.means.add_weights(std::vector<double>(n, 1. / n));
  for (const unsigned char step : result.step)
    std::fill_n(result.means.add_row(n * step, weights), n * step, none);
  for_parts(domain, block, is_added, [&](const unsigned int i, const Dof dof) {
    Dof *const found = result.means.columns_of(i);
    Dof *const place = std::find_if(found, found + n, [&](const Dof d) { return d == dof || d == none; });
    AssertThrow(place != found + n, dealii::ExcInternalError());
    *place = dof;
  });
  return result;
}

} // namespace

template <int dim>
bool has_coarser_meshes(const Mesh<dim> &mesh)
{
  return mesh.n_global_levels() > 1 || added_vertices(mesh) != nullptr;
}

template <int dim>
MeshLevels mesh_levels(const Domain<dim> &domain, const Block &block, const bool with_parents,
                       const MPI_Comm &communicator)
{
  const Field &field = domain.fields()[block.field_index];
  const bool has_vertices = domain.layout().is_continuous(field.first_component);
  if (has_vertices && added_vertices(domain.mesh()) != nullptr)
    return levels_of_parts(domain, block, *added_vertices(domain.mesh()));
  if (with_parents && has_vertices && !has_simplices(domain.mesh()) && domain.mesh().n_global_levels() > 1)
    return Parents<dim>(domain, block, communicator).levels();
  MeshLevels result;
  result.step.assign(block.owned.n_elements(), 0);
  for (unsigned int i = 0; i < result.step.size(); ++i)
    result.means.add_row(0, 0);
  return result;
}

template bool has_coarser_meshes(const Mesh<2> &);
template bool has_coarser_meshes(const Mesh<3> &);

template MeshLevels mesh_levels(const Domain<2> &, const Block &, bool, const MPI_Comm &);
template MeshLevels mesh_levels(const Domain<3> &, const Block &, bool, const MPI_Comm &);

} // namespace dovetail
