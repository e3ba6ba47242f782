// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/free_motion.h>

#include <dovetail/compatibility.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/lapack_full_matrix.h>

#include <cmath>
#include <limits>

namespace dovetail {

namespace {

/// Eigenvalues of scaled modes below this are rounding; a soft tie is not: a body of 1e10 times the stiffness
/// of what holds it has 1e-12.
const double rounding = 1e-14;

/// A rigid motion or constant of one body.
struct Mode
{
  unsigned int block, number;
  Vector values;
};

template <int dim>
std::vector<Mode> modes_of_bodies(const Model<dim> &model, const std::string &field,
                                  const dealii::AffineConstraints<double> &constraints)
{
  std::vector<Mode> modes;
  const auto &blocks = model.numbering->blocks();
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (!blocks[b].is_of_multipliers && blocks[b].field == field) {
      const auto of_block = model.near_null_space(blocks[b], false);
      for (unsigned int m = 0; m < of_block.size(); ++m) {
        modes.push_back({b, m, Vector(model.numbering->split(model.numbering->owned), model.communicator)});
        auto values = of_block[m].begin();
        for (const auto local : blocks[b].owned) {
          if (!constraints.is_constrained(blocks[b].begin + local))
            modes.back().values.block(b)(local) = *values;
          ++values;
        }
        modes.back().values.compress(dealii::VectorOperation::insert);
      }
    }
  return modes;
}

/// Of a symmetric matrix; the eigenvectors are columns.
std::pair<dealii::Vector<double>, dealii::FullMatrix<double>>
eigenvectors(const dealii::FullMatrix<double> &matrix)
{
  dealii::LAPACKFullMatrix<double> copy(matrix.m(), matrix.n());
  copy = matrix;
  dealii::Vector<double> values;
  dealii::FullMatrix<double> vectors;
  const double all = std::numeric_limits<double>::max();
  copy.compute_eigenvalues_symmetric(-all, all, 0., values, vectors);
  return {values, vectors};
}

/// Columns V with V^T M V = 1. A body with few free unknowns has rigid motions that are alike: the directions
/// in which M is small are left out.
dealii::FullMatrix<double> orthonormal_basis(const dealii::FullMatrix<double> &M)
{
  const double least = 1e-6;
  if (M.m() == 0)
    return {};
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

/// |diag K| times a vector
Vector times_diagonal(const dealii::TrilinosWrappers::BlockSparseMatrix &tangent, const Vector &vector)
{
  Vector product(vector);
  for (unsigned int b = 0; b < product.n_blocks(); ++b) {
    const auto &matrix = tangent.block(b, b);
    for (const auto i : product.block(b).locally_owned_elements())
      product.block(b)(i) *= std::abs(matrix.diag_element(i));
    product.block(b).compress(dealii::VectorOperation::insert);
  }
  return product;
}

/// @param shares of the modes in the motion
template <int dim>
FreeMotion<dim> describe(const Model<dim> &model, const std::string &field, const std::vector<Mode> &modes,
                         const dealii::Vector<double> &shares)
{
  FreeMotion<dim> motion = {field, {}, "a constant"};
  const double relevant = 1e-3 * shares.linfty_norm();
  std::array<bool, dim> moves_along{};
  bool is_vector = false, rotates = false;
  for (unsigned int i = 0; i < modes.size(); ++i) {
    is_vector = is_vector || modes[i].number > 0;
    if (std::abs(shares[i]) <= relevant)
      continue;
    const auto *body = model.domains[model.numbering->blocks()[modes[i].block].domain_index].get();
    if (motion.bodies.empty() || motion.bodies.back() != body)
      motion.bodies.push_back(body);
    if (modes[i].number < dim)
      moves_along[modes[i].number] = true;
    else
      rotates = true;
  }
  if (is_vector && rotates)
    motion.kind = "a rotation";
  else if (is_vector) {
    std::vector<std::string> axes;
    for (unsigned int c = 0; c < dim; ++c)
      if (moves_along[c])
        axes.push_back(std::string(1, "xyz"[c]));
    motion.kind = "a translation along " + comma_separated(axes);
  }
  return motion;
}

} // namespace

template <int dim>
std::string FreeMotion<dim>::in_words() const
{
  std::vector<std::string> names;
  for (const auto *body : bodies)
    names.push_back(body->name);
  return "the " + field + " of " + comma_separated(names) + " against " + kind;
}

template <int dim>
bool is_surely_held(const Model<dim> &model, const std::string &field, const double t)
{
  std::set<const Domain<dim> *> held;
  for (const auto &domain : model.domains)
    for (const auto &condition : domain->conditions())
      if (condition->field.name == field && condition->is_active(t) &&
          condition->prescribed_components().size() == condition->field.n_components)
        held.insert(domain.get());
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (const auto &interface : model.interfaces)
      for (const auto &tied : interface->fields)
        if (tied.name == field && interface->is_active(t) && !interface->tie().allows_jump(tied))
          for (const unsigned int side : {source, destination})
            if (held.count(interface->sides[side].domain) > 0)
              is_new = held.insert(interface->sides[1 - side].domain).second || is_new;
  }
  return std::all_of(model.domains.begin(), model.domains.end(), [&](const auto &domain) {
    return domain->material.find_field(field) == nullptr || held.count(domain.get()) > 0;
  });
}

template <int dim>
std::optional<FreeMotion<dim>> find_free_motion(const Model<dim> &model, const std::string &field,
                                                const dealii::TrilinosWrappers::BlockSparseMatrix &tangent,
                                                const dealii::AffineConstraints<double> &constraints)
{
  const std::vector<Mode> modes = modes_of_bodies(model, field, constraints);
  const unsigned int n = modes.size();
  dealii::FullMatrix<double> energy(n, n), mass(n, n);
  for (unsigned int j = 0; j < n; ++j) {
    Vector product(modes[j].values);
    tangent.vmult(product, modes[j].values);
    const Vector of_diagonal = times_diagonal(tangent, modes[j].values);
    for (unsigned int i = 0; i < n; ++i) {
      energy(i, j) = modes[i].values * product;
      mass(i, j) = modes[i].block == modes[j].block ? modes[i].values * of_diagonal : 0.;
    }
  }

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
  dealii::FullMatrix<double> of_basis(basis.n(), basis.n());
  of_basis.triple_product(G, basis, basis, true, false);
  const auto [values, vectors] = eigenvectors(of_basis);
  for (unsigned int i = 0; i < values.size(); ++i)
    if (std::abs(values[i]) < rounding) {
      dealii::Vector<double> shares(n);
      for (unsigned int k = 0; k < n_free; ++k)
        for (unsigned int l = 0; l < basis.n(); ++l)
          shares[free[k]] += basis(k, l) * vectors(l, i);
      return describe(model, field, modes, shares);
    }
  return {};
}

template struct FreeMotion<2>;
template struct FreeMotion<3>;
template bool is_surely_held(const Model<2> &, const std::string &, double);
template bool is_surely_held(const Model<3> &, const std::string &, double);
template std::optional<FreeMotion<2>> find_free_motion(const Model<2> &, const std::string &,
                                                       const dealii::TrilinosWrappers::BlockSparseMatrix &,
                                                       const dealii::AffineConstraints<double> &);
template std::optional<FreeMotion<3>> find_free_motion(const Model<3> &, const std::string &,
                                                       const dealii::TrilinosWrappers::BlockSparseMatrix &,
                                                       const dealii::AffineConstraints<double> &);

} // namespace dovetail
