// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/eigenvectors.h>
#include <dovetail/system/joined_fields.h>
#include <dovetail/system/rigid_motions.h>
#include <dovetail/system/unrestrained_mode.h>

#include <deal.II/base/array_view.h>
#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dovetail {

namespace {

/// Eigenvalues of scaled modes below this are rounding; a soft tie is not: a body of 1e10 times the stiffness
/// of what holds it has 1e-12.
const double rounding = 1e-14;

const unsigned int axis_of_revolution = 1; ///< y

/// The bodies of a field that move as one, and their rigid motions or constants by block and number: the
/// values at the unknowns of this rank.
template <int dim>
struct Group
{
  std::vector<unsigned int> blocks;
  dealii::Point<dim> centre;
  double length = 0;
  bool is_of_vector = false, is_around_axis = false;
  unsigned int n_modes = 0;
  std::map<unsigned int, std::vector<std::vector<double>>> modes;
};

/// Without their modes.
template <int dim>
std::vector<Group<dim>> groups_of(const Model<dim> &model, const std::string &field, const double t)
{
  const auto joined = joined_fields<dim>(model, [t](const auto &interface, const TiedField &tied) {
    return interface.is_active(t) && interface.tie().surely_holds(tied, t);
  });
  std::map<unsigned int, std::vector<unsigned int>> blocks_of;
  const auto &blocks = model.numbering->blocks();
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (!blocks[b].is_of_multipliers && blocks[b].field == field)
      blocks_of[joined[blocks[b].domain_index][blocks[b].field_index]].push_back(b);

  std::vector<Group<dim>> groups;
  for (const auto &group_blocks : blocks_of) {
    Group<dim> group;
    group.blocks = group_blocks.second;
    const auto body = [&](const unsigned int b) -> const Domain<dim> & {
      return *model.domains[blocks[b].domain_index];
    };
    for (const unsigned int b : group.blocks)
      group.centre += static_cast<dealii::Tensor<1, dim>>(body(b).centre()) * (1. / group.blocks.size());
    for (const unsigned int b : group.blocks)
      group.length =
          std::max(group.length, 2 * body(b).centre().distance(group.centre) + body(b).typical_length());
    const Domain<dim> &first_body = body(group.blocks[0]);
    const Field &body_field = first_body.fields()[blocks[group.blocks[0]].field_index];
    group.is_of_vector = body_field.n_components > 1;
    group.is_around_axis = first_body.measure.has_hoop_strain(body_field);
    group.n_modes = !group.is_of_vector || group.is_around_axis ? 1 : dim == 2 ? 3 : 6;
    groups.push_back(std::move(group));
  }
  return groups;
}

/// Around an axis only the translation along it.
template <int dim>
std::vector<std::vector<double>> modes_of(const Model<dim> &model, const Group<dim> &group,
                                          const Block &block)
{
  auto modes = rigid_motions(*model.domains[block.domain_index], block, group.centre, group.length);
  if (group.is_around_axis)
    modes = {modes[axis_of_revolution]};
  return modes;
}

/// Columns V with V^T M V = 1. A body with few free unknowns has rigid motions that are alike: the directions
/// in which M is small are left out.
dealii::FullMatrix<double> orthonormal_basis(const dealii::FullMatrix<double> &M)
{
  const double least = 1e-6;
  if (M.m() == 0)
    return dealii::FullMatrix<double>();
  const auto [values, vectors] = eigenvectors(M);
  std::vector<unsigned int> chosen;
  for (unsigned int i = 0; i < values.size(); ++i)
    if (values[i] > least)
      chosen.push_back(i);
  dealii::FullMatrix<double> basis(M.m(), chosen.size());
  for (unsigned int k = 0; k < M.m(); ++k)
    for (unsigned int l = 0; l < chosen.size(); ++l)
      basis(k, l) = vectors(k, chosen[l]) / std::sqrt(values[chosen[l]]);
  return basis;
}

/// Whether what is constrained in a group sees all its rigid motions: all translations, and the rotations
/// once they are taken about the middle of what is constrained (a Schur complement), whatever its size.
bool is_regular(const dealii::FullMatrix<double> &P, const unsigned int dim)
{
  const unsigned int n_translations = P.m() == 1 ? 1 : dim, n_rotations = P.m() - n_translations;
  for (unsigned int c = 0; c < n_translations; ++c)
    if (!(P(c, c) > 0))
      return false;
  dealii::FullMatrix<double> A(n_translations, n_translations), scaled(A); // translations
  for (unsigned int c = 0; c < n_translations; ++c)
    for (unsigned int d = 0; d < n_translations; ++d) {
      A(c, d) = P(c, d);
      scaled(c, d) = P(c, d) / std::sqrt(P(c, c) * P(d, d));
    }
  const auto translation_modes = eigenvectors(scaled).first;
  if (!(*std::min_element(translation_modes.begin(), translation_modes.end()) > 1e-6))
    return false;
  if (n_rotations == 0)
    return true;
  A.gauss_jordan();
  dealii::FullMatrix<double> S(n_rotations, n_rotations);
  double trace = 0, of_P = 0;
  for (unsigned int k = 0; k < n_rotations; ++k) {
    for (unsigned int l = 0; l < n_rotations; ++l) {
      S(k, l) = P(n_translations + k, n_translations + l);
      for (unsigned int c = 0; c < n_translations; ++c)
        for (unsigned int d = 0; d < n_translations; ++d)
          S(k, l) -= P(c, n_translations + k) * A(c, d) * P(d, n_translations + l);
    }
    trace += S(k, k);
    of_P += P(n_translations + k, n_translations + k);
  }
  const auto values = eigenvectors(S).first;
  const double smallest = *std::min_element(values.begin(), values.end());
  return smallest > 1e-6 * trace && trace > 1e-12 * of_P;
}

/// By group, z_k.K z_l and z_k.|diag K| z_l. The products of the blocks are apart, so the l-th modes of all
/// groups are multiplied at once.
template <int dim>
std::array<dealii::FullMatrix<double>, 2> energies(const std::vector<Group<dim>> &groups,
                                                   const BlockMatrix &tangent, const MPI_Comm &communicator)
{
  std::vector<unsigned int> first_mode = {0};
  std::map<unsigned int, unsigned int> group_of;
  unsigned int largest_number = 0;
  for (unsigned int g = 0; g < groups.size(); ++g) {
    largest_number = std::max(largest_number, groups[g].n_modes);
    first_mode.push_back(first_mode.back() + groups[g].n_modes);
    for (const unsigned int b : groups[g].blocks)
      group_of[b] = g;
  }
  const unsigned int n = first_mode.back();
  std::array<dealii::FullMatrix<double>, 2> result{{{n, n}, {n, n}}};
  dealii::FullMatrix<double> &energy = result[0], &mass = result[1]; // clang captures no binding
  const auto product = [](const std::vector<double> &one, const double *other) {
    return std::inner_product(one.begin(), one.end(), other, 0.);
  };
  for (unsigned int l = 0; l < largest_number; ++l) {
    BlockMatrix::Vector z(tangent.owned_unknowns(), communicator);
    for (const auto &[block, g] : group_of)
      if (l < groups[g].n_modes) {
        const auto &values = groups[g].modes.at(block)[l];
        std::copy(values.begin(), values.end(), z.block(block).trilinos_vector()[0]);
      }
    tangent.for_each_product(z, [&](const unsigned int row, const unsigned int column, const auto &Kz) {
      if (group_of.count(row) == 0 || group_of.count(column) == 0 || l >= groups[group_of.at(column)].n_modes)
        return;
      const unsigned int g = group_of.at(row), h = group_of.at(column);
      for (unsigned int k = 0; k < groups[g].n_modes; ++k)
        energy(first_mode[g] + k, first_mode[h] + l) +=
            product(groups[g].modes.at(row)[k], Kz.trilinos_vector()[0]);
    });
  }
  for (const auto &[row, g] : group_of) {
    const auto &row_modes = groups[g].modes.at(row);
    const std::vector<double> diagonal = tangent.diagonal(row);
    for (unsigned int k = 0; k < groups[g].n_modes; ++k)
      for (unsigned int l = 0; l < groups[g].n_modes; ++l)
        for (unsigned int i = 0; i < row_modes[k].size(); ++i)
          mass(first_mode[g] + k, first_mode[g] + l) +=
              row_modes[k][i] * std::abs(diagonal[i]) * row_modes[l][i];
  }
  for (auto &matrix : result)
    if (n > 0)
      dealii::Utilities::MPI::sum(dealii::ArrayView<const double>(&matrix(0, 0), n * n), communicator,
                                  dealii::ArrayView<double>(&matrix(0, 0), n * n));
  return result;
}

/// @param shares of the modes in the motion
template <int dim>
UnrestrainedMode<dim> describe(const Model<dim> &model, const std::string &field,
                               const std::vector<Group<dim>> &groups, const dealii::Vector<double> &shares)
{
  UnrestrainedMode<dim> motion = {field, {}, "a constant"};
  const double relevant = 1e-3 * shares.linfty_norm();
  std::array<bool, dim> moves_along{};
  bool is_vector = false, rotates = false;
  std::set<unsigned int> moving; // in the order of the scene
  unsigned int i = 0;
  for (const auto &group : groups)
    for (unsigned int mode = 0; mode < group.n_modes; ++mode, ++i) {
      is_vector = is_vector || group.is_of_vector;
      if (std::abs(shares[i]) <= relevant)
        continue;
      for (const unsigned int b : group.blocks)
        moving.insert(model.numbering->blocks()[b].domain_index);
      if (group.is_around_axis)
        moves_along[axis_of_revolution] = true;
      else if (mode < dim)
        moves_along[mode] = true;
      else
        rotates = true;
    }
  for (const unsigned int d : moving)
    motion.bodies.push_back(model.domains[d].get());
  if (is_vector && rotates)
    motion.kind = "a rotation";
  else if (is_vector) {
    std::vector<std::string> axes;
    for (unsigned int c = 0; c < dim; ++c)
      if (moves_along[c])
        axes.emplace_back(1, "xyz"[c]);
    motion.kind = "a translation along " + comma_separated(axes);
  }
  return motion;
}

/// z_i - sum_j w_j z_j of the modes z for the line of an unknown; nothing if it allows all of them, as those
/// of hanging nodes and ties do, or follows unknowns of another block.
std::vector<double> seen_by_constraint(const dealii::AffineConstraints<double> &constraints,
                                       const Block &block, const dealii::types::global_dof_index local,
                                       const std::vector<std::vector<double>> &modes)
{
  if (!constraints.is_constrained(block.begin + local))
    return {};
  const auto &entries = *constraints.get_constraint_entries(block.begin + local);
  std::vector<double> z;
  for (const auto &mode : modes)
    z.push_back(mode[block.owned.index_within_set(local)]);
  for (const auto &[other, weight] : entries) {
    if (other < block.begin || other >= block.end || !block.owned.is_element(other - block.begin))
      return {};
    for (unsigned int k = 0; k < z.size(); ++k)
      z[k] -= weight * modes[k][block.owned.index_within_set(other - block.begin)];
  }
  const bool is_seen = std::any_of(z.begin(), z.end(), [](const double v) { return std::abs(v) > 1e-8; });
  return entries.empty() || is_seen ? z : std::vector<double>();
}

} // namespace

template <int dim>
std::string UnrestrainedMode<dim>::in_words() const
{
  return "the " + field + " of " + names_of(bodies) + " against " + kind;
}

template <int dim>
bool is_surely_held(const Model<dim> &model, const std::string &field, const double t,
                    const dealii::AffineConstraints<double> &constraints, const bool do_rates_hold)
{
  const auto stores = [&](const unsigned int b) {
    const Domain<dim> &body = *model.domains[model.numbering->blocks()[b].domain_index];
    return body.material.order_in_time(body.material.find_field(field)->first_component) > 0;
  };
  for (const auto &group : groups_of(model, field, t)) {
    if (do_rates_hold && std::any_of(group.blocks.begin(), group.blocks.end(), stores))
      continue;
    dealii::FullMatrix<double> P(group.n_modes, group.n_modes);
    for (const unsigned int b : group.blocks) {
      const Block &block = model.numbering->blocks()[b];
      const auto &conditions = model.domains[block.domain_index]->conditions();
      if (std::none_of(conditions.begin(), conditions.end(), [&](const auto &condition) {
            return condition->field.name == field && condition->is_active(t) &&
                   !condition->prescribed_components().empty();
          }))
        continue;
      const auto modes = modes_of(model, group, block);
      for (const auto local : block.owned) {
        const std::vector<double> z = seen_by_constraint(constraints, block, local, modes);
        for (unsigned int k = 0; k < z.size(); ++k)
          for (unsigned int l = 0; l < z.size(); ++l)
            P(k, l) += z[k] * z[l];
      }
    }
    const unsigned int size = group.n_modes * group.n_modes;
    dealii::Utilities::MPI::sum(dealii::ArrayView<const double>(&P(0, 0), size), model.communicator,
                                dealii::ArrayView<double>(&P(0, 0), size));
    if (!is_regular(P, dim))
      return false;
  }
  return true;
}

template <int dim>
std::optional<UnrestrainedMode<dim>>
find_unrestrained_mode(const Model<dim> &model, const std::string &field, const double t,
                       const BlockMatrix &tangent, const dealii::AffineConstraints<double> &constraints)
{
  auto groups = groups_of(model, field, t);
  for (auto &group : groups)
    for (const unsigned int b : group.blocks) {
      const Block &block = model.numbering->blocks()[b];
      auto &modes = group.modes[b] = modes_of(model, group, block);
      unsigned int i = 0;
      for (const auto local : block.owned) {
        if (constraints.is_constrained(block.begin + local))
          for (auto &mode : modes)
            mode[i] = 0;
        ++i;
      }
    }
  if (std::any_of(groups.begin(), groups.end(), [&](const auto &group) {
        const Block &block = model.numbering->blocks()[group.blocks[0]];
        return !model.domains[block.domain_index]->fields()[block.field_index].is_continuous;
      }))
    return {}; // nothing restrains it from outside: a pressure is found by the displacements
  const auto [energy, mass] = energies(groups, tangent, model.communicator);
  const unsigned int n = energy.m();

  // modes of bodies that are prescribed wholly are zero; the others get the length one
  std::vector<unsigned int> free;
  for (unsigned int i = 0; i < n; ++i)
    if (mass(i, i) > 0)
      free.push_back(i);
  const unsigned int n_free = free.size();
  dealii::FullMatrix<double> G(n_free, n_free), M(n_free, n_free);
  for (unsigned int i = 0; i < n_free; ++i)
    for (unsigned int j = 0; j < n_free; ++j) {
      const double scale = 1 / std::sqrt(mass(free[i], free[i]) * mass(free[j], free[j]));
      G(i, j) = (energy(free[i], free[j]) + energy(free[j], free[i])) / 2 * scale;
      M(i, j) = mass(free[i], free[j]) * scale;
      if (!std::isfinite(G(i, j)) || !std::isfinite(M(i, j)))
        return {};
    }
  const dealii::FullMatrix<double> basis = orthonormal_basis(M);
  if (basis.n() == 0)
    return {};
  dealii::FullMatrix<double> energy_in_basis(basis.n(), basis.n());
  energy_in_basis.triple_product(G, basis, basis, true, false);
  const auto [values, vectors] = eigenvectors(energy_in_basis);
  for (unsigned int i = 0; i < values.size(); ++i)
    if (std::abs(values[i]) < rounding) {
      dealii::Vector<double> shares(n);
      for (unsigned int k = 0; k < n_free; ++k)
        for (unsigned int l = 0; l < basis.n(); ++l)
          shares[free[k]] += basis(k, l) * vectors(l, i);
      return describe(model, field, groups, shares);
    }
  return {};
}

template struct UnrestrainedMode<2>;
template struct UnrestrainedMode<3>;
template bool is_surely_held(const Model<2> &, const std::string &, double,
                             const dealii::AffineConstraints<double> &, bool);
template bool is_surely_held(const Model<3> &, const std::string &, double,
                             const dealii::AffineConstraints<double> &, bool);
template std::optional<UnrestrainedMode<2>> find_unrestrained_mode(const Model<2> &, const std::string &,
                                                                   double, const BlockMatrix &,
                                                                   const dealii::AffineConstraints<double> &);
template std::optional<UnrestrainedMode<3>> find_unrestrained_mode(const Model<3> &, const std::string &,
                                                                   double, const BlockMatrix &,
                                                                   const dealii::AffineConstraints<double> &);

} // namespace dovetail
