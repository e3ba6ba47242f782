// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The kernel z_k of K is lifted by K + tau sum z_k z_k^T, z_k orthonormal: M vanishes on it, so no other
// eigenvalue changes, and K becomes positive for LAPACK's symmetric generalised solver.

#include <dovetail/domain/cell_terms.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/interface/trace_eigenvalue.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/lapack_full_matrix.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace dovetail {

namespace {

using dealii::FullMatrix;
using dealii::Tensor;

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

/// M of the cells behind the points of this rank.
template <int dim>
std::array<std::vector<FullMatrix<double>>, 2> surface_terms(const Interface<dim> &interface,
                                                             const TiedField &field, const double t,
                                                             const typename Tie<dim>::Unknowns &unknowns)
{
  const Pairing<dim> &pairing = interface.pairing();
  std::array<std::vector<FullMatrix<double>>, 2> M;
  std::array<std::unique_ptr<State<dim>>, 2> state;
  std::array<std::unique_ptr<Response<dim>>, 2> response;
  for (const unsigned int side : {source, destination}) {
    const Domain<dim> &domain = *interface.sides[side].domain;
    const unsigned int n = field.n_components * domain.n_nodes();
    M[side].assign(pairing.cells[side].size(), FullMatrix<double>(n, n));
    state[side] = std::make_unique<State<dim>>(domain.n_components());
    response[side] = std::make_unique<Response<dim>>(domain.n_components());
  }
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> of_group, flux;
  for (const auto &group : pairing.groups) {
    interface.group_dofs(group, dofs);
    unknowns(dofs, of_group);
    for (unsigned int q = group.begin; q < group.end; ++q)
      for (const unsigned int side : {source, destination}) {
        const Domain<dim> &domain = *interface.sides[side].domain;
        const unsigned int n_nodes = domain.n_nodes(), n = field.n_components * n_nodes,
                           first = field.first_component[side];
        FullMatrix<double> &of_cell = M[side][group.cells[side]];
        interface.evaluate(side, q, of_group, *state[side]);
        state[side]->X = pairing.X(side, q);
        state[side]->t = t;
        if (!domain.material.evaluate(*state[side], true, *response[side])) {
          of_cell(0, 0) = undefined;
          continue;
        }
        const Tensor<1, dim> *gradients = pairing.gradients(side, q);
        flux.resize(n);
        for (unsigned int c = 0; c < field.n_components; ++c) {
          for (unsigned int d = 0; d < field.n_components; ++d) {
            const Tensor<1, dim> N_D =
                pairing.N(side, q) *
                response[side]->by_gradient[(first + c) * domain.n_components() + first + d];
            for (unsigned int a = 0; a < n_nodes; ++a)
              flux[d * n_nodes + a] = N_D * gradients[a];
          }
          for (unsigned int i = 0; i < n; ++i)
            for (unsigned int j = 0; j <= i; ++j)
              of_cell(i, j) += pairing.weight(q) * flux[i] * flux[j];
        }
      }
  }
  return M;
}

/// K and its kernel on a cell at the given unknowns of all fields.
template <int dim>
class CellEnergy
{
public:
  CellEnergy(const Domain<dim> &domain, const Field &field, double t);

  /// @return whether the law is defined on the cell.
  bool reinit(const typename Domain<dim>::cell_iterator &cell, const std::vector<double> &unknowns);

  FullMatrix<double> K;
  std::vector<std::vector<double>> kernel;

private:
  void make_kernel(const std::vector<double> &unknowns);

  const Domain<dim> &domain;
  const Field &field;
  dealii::FEValues<dim> values, at_nodes;
  State<dim> state;
  Response<dim> response;
};

template <int dim>
CellEnergy<dim>::CellEnergy(const Domain<dim> &domain, const Field &field, const double t)
    : K(field.n_components * domain.n_nodes(), field.n_components * domain.n_nodes()), domain(domain),
      field(field), values(domain.mapping(), domain.scalar_element(),
                           gauss_rule<dim>(domain.scalar_element().reference_cell(), domain.degree + 1),
                           dealii::update_values | dealii::update_gradients |
                               dealii::update_quadrature_points | dealii::update_JxW_values),
      at_nodes(domain.mapping(), domain.scalar_element(), domain.scalar_element().get_unit_support_points(),
               dealii::update_quadrature_points),
      state(domain.n_components()), response(domain.n_components())
{
  state.t = t;
}

template <int dim>
bool CellEnergy<dim>::reinit(const typename Domain<dim>::cell_iterator &cell,
                             const std::vector<double> &unknowns)
{
  const typename dealii::Triangulation<dim>::active_cell_iterator mesh_cell(cell);
  values.reinit(mesh_cell);
  at_nodes.reinit(mesh_cell);
  make_kernel(unknowns);
  K = 0;
  const unsigned int n_nodes = domain.n_nodes(), n = domain.n_components(), first = field.first_component;
  std::vector<double> shape(n_nodes);
  std::vector<Tensor<1, dim>> gradient(n_nodes);
  for (const unsigned int q : values.quadrature_point_indices()) {
    for (unsigned int a = 0; a < n_nodes; ++a) {
      shape[a] = values.shape_value(a, q);
      gradient[a] = values.shape_grad(a, q);
    }
    state.X = values.quadrature_point(q);
    evaluate_state<dim>(n, n_nodes, shape.data(), gradient.data(), unknowns.data(), state);
    if (!domain.material.evaluate(state, true, response))
      return false;
    for (unsigned int c = 0; c < field.n_components; ++c)
      for (unsigned int d = 0; d <= c; ++d) {
        const auto &D = response.by_gradient[(first + c) * n + first + d];
        for (unsigned int a = 0; a < n_nodes; ++a) {
          const Tensor<1, dim> g = values.JxW(q) * (gradient[a] * D);
          for (unsigned int b = 0; b < (c == d ? a + 1 : n_nodes); ++b)
            K(c * n_nodes + a, d * n_nodes + b) += g * gradient[b];
        }
      }
  }
  return true;
}

template <int dim>
void CellEnergy<dim>::make_kernel(const std::vector<double> &unknowns)
{
  const unsigned int n_nodes = domain.n_nodes(), n_c = field.n_components;
  kernel.clear();
  for (unsigned int c = 0; c < n_c; ++c) {
    kernel.emplace_back(n_c * n_nodes, 0.);
    std::fill(kernel.back().begin() + c * n_nodes, kernel.back().begin() + (c + 1) * n_nodes, 1.);
  }
  if (n_c == 1)
    return;
  // rotations in the planes of two axes, of the position where the law sees the body
  const bool is_linear = domain.material.is_linear(&field - domain.fields().data());
  for (unsigned int c = 0; c < n_c; ++c)
    for (unsigned int d = 0; d < c; ++d) {
      kernel.emplace_back(n_c * n_nodes, 0.);
      for (unsigned int a = 0; a < n_nodes; ++a) {
        const auto position = [&](const unsigned int e) {
          return at_nodes.quadrature_point(a)[e] - at_nodes.quadrature_point(0)[e] +
                 (is_linear ? 0. : unknowns[(field.first_component + e) * n_nodes + a]);
        };
        kernel.back()[c * n_nodes + a] = -position(d);
        kernel.back()[d * n_nodes + a] = position(c);
      }
    }
}

/// The largest eigenvalues of cells, most of which have the same matrices up to a factor: a solved problem is
/// kept and compared with.
class Eigenvalues
{
public:
  double largest(const FullMatrix<double> &M, const FullMatrix<double> &K,
                 const std::vector<std::vector<double>> &kernel)
  {
    const double trace_M = M.trace(), trace_K = K.trace();
    const auto found = std::find_if(solved.begin(), solved.end(), [&](const Solved &other) {
      return is_multiple(M, trace_M, other.M) && is_multiple(K, trace_K, other.K);
    });
    if (found != solved.end())
      return found->lambda * trace_M / trace_K;
    const double lambda = largest_eigenvalue(M, K, kernel);
    if (solved.size() < most && std::isfinite(lambda) && trace_M > 0) {
      solved.push_back({M, K, lambda * trace_K / trace_M});
      solved.back().M /= trace_M;
      solved.back().K /= trace_K;
    }
    return lambda;
  }

private:
  struct Solved
  {
    FullMatrix<double> M, K; ///< of trace one
    double lambda;
  };

  static bool is_multiple(const FullMatrix<double> &matrix, const double trace,
                          const FullMatrix<double> &of_trace_one)
  {
    for (unsigned int i = 0; i < matrix.m(); ++i)
      for (unsigned int j = 0; j <= i; ++j)
        if (!(std::abs(matrix(i, j) - trace * of_trace_one(i, j)) <= 1e-12 * trace))
          return false;
    return true;
  }

  static constexpr unsigned int most = 8;
  std::vector<Solved> solved;
};

/// How many sides of interfaces other than this one tie the field on faces of a cell.
template <int dim>
unsigned int n_other_interfaces(const InterfaceSide<dim> &side, const std::string &field,
                                const typename dealii::Triangulation<dim>::active_cell_iterator &cell)
{
  unsigned int n = 0;
  const auto others = side.others.find(field);
  if (others == side.others.end())
    return 0;
  for (const InterfaceSide<dim> *other : others->second) {
    bool has_face = false;
    for (const unsigned int face : cell->face_indices())
      has_face = has_face ||
                 (cell->face(face)->at_boundary() && other->belongs(cell, cell->face(face)->boundary_id()));
    n += has_face ? 1 : 0;
  }
  return n;
}

/// The eigenvalues of the owned cells of one side, from the surface terms of all ranks: for each rank the
/// indices of faces of the side on this rank, and the lower triangles of M.
template <int dim>
OfRanks solve_cells(const Interface<dim> &interface, const unsigned int side, const TiedField &tied,
                    const double t, const typename Tie<dim>::Unknowns &unknowns,
                    const OfRanks &packed_of_rank)
{
  const InterfaceSide<dim> &of_side = interface.sides[side];
  const Domain<dim> &domain = *of_side.domain;
  const Field &field = domain.fields()[tied.field[side]];
  const unsigned int n = field.n_components * domain.n_nodes();
  std::vector<typename dealii::Triangulation<dim>::active_cell_iterator> cell_of_face; // as in SideFaces
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (cell->is_locally_owned() && of_side.belongs(cell, id))
      cell_of_face.push_back(cell);

  std::map<unsigned int, FullMatrix<double>> M; // by cell
  std::map<unsigned int, typename dealii::Triangulation<dim>::active_cell_iterator> cells;
  const unsigned int stride = 1 + n * (n + 1) / 2;
  for (const auto &[rank, packed] : packed_of_rank)
    for (std::size_t begin = 0; begin < packed.size(); begin += stride) {
      const auto cell = cell_of_face[static_cast<unsigned int>(packed[begin])];
      cells[cell->active_cell_index()] = cell;
      FullMatrix<double> &of_cell = M[cell->active_cell_index()];
      if (of_cell.m() == 0)
        of_cell.reinit(n, n);
      for (unsigned int i = 0, k = begin + 1; i < n; ++i)
        for (unsigned int j = 0; j <= i; ++j, ++k)
          of_cell(i, j) += packed[k];
    }

  CellEnergy<dim> energy(domain, field, t);
  Eigenvalues eigenvalues;
  std::map<unsigned int, double> lambda;
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> of_cell;
  for (auto &[index, cell] : cells) {
    domain.cell_dofs(domain.dof_cell(cell), dofs);
    unknowns(dofs, of_cell);
    lambda[index] = energy.reinit(domain.dof_cell(cell), of_cell)
                        ? (1 + n_other_interfaces(of_side, field.name, cell)) *
                              eigenvalues.largest(M[index], energy.K, energy.kernel)
                        : undefined;
  }

  interface.work().eigenvalue_problems += cells.size();
  OfRanks answers;
  for (const auto &[rank, packed] : packed_of_rank)
    for (std::size_t begin = 0; begin < packed.size(); begin += stride)
      answers[rank].push_back(
          lambda.at(cell_of_face[static_cast<unsigned int>(packed[begin])]->active_cell_index()));
  return answers;
}

/// By the factors of Cholesky, which replace the lower triangle.
bool is_positive_definite(FullMatrix<double> &L)
{
  for (unsigned int j = 0; j < L.m(); ++j)
    for (unsigned int i = j; i < L.m(); ++i) {
      double sum = L(i, j);
      for (unsigned int k = 0; k < j; ++k)
        sum -= L(i, k) * L(j, k);
      if (i == j && !(sum > 0))
        return false;
      L(i, j) = i == j ? std::sqrt(sum) : sum / L(j, j);
    }
  return true;
}

} // namespace

double largest_eigenvalue(const FullMatrix<double> &M, const FullMatrix<double> &K,
                          const std::vector<std::vector<double>> &kernel)
{
  const unsigned int n = K.m();
  double trace = 0;
  for (unsigned int i = 0; i < n; ++i)
    trace += K(i, i);
  if (!(trace > 0) || !std::isfinite(M(0, 0)))
    return undefined;
  // Gram and Schmidt, twice
  std::vector<std::vector<double>> z = kernel;
  for (unsigned int k = 0; k < z.size(); ++k)
    for (unsigned int pass = 0; pass < 2; ++pass) {
      for (unsigned int l = 0; l < k; ++l) {
        double product = 0;
        for (unsigned int i = 0; i < n; ++i)
          product += z[k][i] * z[l][i];
        for (unsigned int i = 0; i < n; ++i)
          z[k][i] -= product * z[l][i];
      }
      double square = 0;
      for (unsigned int i = 0; i < n; ++i)
        square += z[k][i] * z[k][i];
      for (unsigned int i = 0; i < n; ++i)
        z[k][i] /= std::sqrt(square);
    }

  dealii::LAPACKFullMatrix<double> A(n), B(n);
  FullMatrix<double> L(n, n);
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int j = 0; j <= i; ++j) {
      double lifted = K(i, j);
      for (const auto &mode : z)
        lifted += trace * mode[i] * mode[j];
      A(i, j) = A(j, i) = M(i, j);
      B(i, j) = B(j, i) = L(i, j) = lifted;
    }
  if (!is_positive_definite(L))
    return undefined;
  std::vector<dealii::Vector<double>> no_vectors;
  A.compute_generalized_eigenvalues_symmetric(B, no_vectors);
  double largest = 0;
  for (unsigned int i = 0; i < n; ++i)
    largest = std::max(largest, A.eigenvalue(i).real());
  return largest;
}

namespace {

/// NaN where the tangent at these unknowns is not positive on the cell.
template <int dim>
std::array<std::vector<double>, 2> eigenvalues_at(const Interface<dim> &interface, const TiedField &field,
                                                  const double t, const typename Tie<dim>::Unknowns &unknowns,
                                                  const MPI_Comm &communicator)
{
  const Pairing<dim> &pairing = interface.pairing();
  const auto M = surface_terms(interface, field, t, unknowns);
  std::array<std::vector<double>, 2> result;
  for (const unsigned int side : {source, destination}) {
    const auto &cells = pairing.cells[side];
    OfRanks questions;
    std::map<unsigned int, std::vector<unsigned int>> asked;
    for (unsigned int i = 0; i < cells.size(); ++i) {
      std::vector<double> &packed = questions[cells[i].rank];
      asked[cells[i].rank].push_back(i);
      packed.push_back(cells[i].face);
      for (unsigned int r = 0; r < M[side][i].m(); ++r)
        for (unsigned int s = 0; s <= r; ++s)
          packed.push_back(M[side][i](r, s));
    }
    questions = exchange(std::move(questions), communicator, interface.work());
    const OfRanks answers =
        exchange(solve_cells(interface, side, field, t, unknowns, questions), communicator, interface.work());
    result[side].resize(cells.size());
    for (const auto &[rank, lambda] : answers)
      for (unsigned int k = 0; k < lambda.size(); ++k)
        result[side][asked.at(rank)[k]] = lambda[k];
  }
  return result;
}

} // namespace

template <int dim>
std::array<std::vector<double>, 2>
trace_eigenvalues(const Interface<dim> &interface, const TiedField &field, const double t,
                  const typename Tie<dim>::Unknowns &unknowns, const MPI_Comm &communicator)
{
  auto lambda = eigenvalues_at(interface, field, t, unknowns, communicator);
  const auto is_undefined = [](const double value) { return std::isnan(value); };
  int is_incomplete = 0;
  for (const auto &of_side : lambda)
    is_incomplete = std::any_of(of_side.begin(), of_side.end(), is_undefined) ? 1 : is_incomplete;
  if (dealii::Utilities::MPI::max(is_incomplete, communicator) == 0)
    return lambda;
  const auto at_rest = eigenvalues_at(
      interface, field, t,
      [](const std::vector<dealii::types::global_dof_index> &dofs, std::vector<double> &values) {
        values.assign(dofs.size(), 0.);
      },
      communicator);
  for (const unsigned int side : {source, destination})
    for (unsigned int i = 0; i < lambda[side].size(); ++i)
      if (is_undefined(lambda[side][i]))
        lambda[side][i] = at_rest[side][i];
  return lambda;
}

template std::array<std::vector<double>, 2> trace_eigenvalues(const Interface<2> &, const TiedField &, double,
                                                              const Tie<2>::Unknowns &, const MPI_Comm &);
template std::array<std::vector<double>, 2> trace_eigenvalues(const Interface<3> &, const TiedField &, double,
                                                              const Tie<3>::Unknowns &, const MPI_Comm &);

} // namespace dovetail
