// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The tangent D of the field at a point, by grad v and symmetric in the energy, has the spectral
// decomposition D = sum_e d_e v_e v_e^T. With the rows b_eq = sqrt(w_q |d_e|) v_e.grad at the points of the
// cell's quadrature the energy is sum |b x|^2 over d_e > 0 minus that over d_e < 0, and with the rows s_cq =
// sqrt(w_q) (N.D grad)_c at the points of the interface the left-hand side is sum |s x|^2
// (factored_eigenvalue.h). The skew part of D, which a conductivity may have, carries no energy but a flux.
//
// Under stress d_e < 0 is usual (compression turns fibres over), and the energy of a cell may still be
// positive. Where it is not, or so nearly that the eigenvalue is more than `largest_amplification` times that
// without the negative part of D, weights and penalty follow the latter, which is bounded by the law's
// stiffness.

#include <dovetail/domain/cell_terms.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/interface/factored_eigenvalue.h>
#include <dovetail/interface/trace_eigenvalue.h>

#include <deal.II/base/mpi.h>

#include <Teuchos_BLAS.hpp>
#include <Teuchos_LAPACK.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace dovetail {

namespace {

using dealii::Point;
using dealii::Tensor;

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
constexpr double largest_amplification = 4;

/// A point of an interface in the numbers that are sent to the rank that owns a cell behind it: weight, X, N,
/// values and gradients of the shape functions of the cell.
template <int dim>
struct FacePoint
{
  static unsigned int n_numbers(const unsigned int n_nodes) { return 1 + 2 * dim + (1 + dim) * n_nodes; }
  static void pack(const Pairing<dim> &pairing, unsigned int side, unsigned int q, unsigned int n_nodes,
                   std::vector<double> &numbers);
  FacePoint(const double *numbers, unsigned int n_nodes);

  double weight;
  Point<dim> X;
  Tensor<1, dim> N;
  const double *values, *gradients; ///< in the numbers
};

template <int dim>
void FacePoint<dim>::pack(const Pairing<dim> &pairing, const unsigned int side, const unsigned int q,
                          const unsigned int n_nodes, std::vector<double> &numbers)
{
  numbers.push_back(pairing.weight(q));
  for (unsigned int d = 0; d < dim; ++d)
    numbers.insert(numbers.end(), {pairing.X(side, q)[d], pairing.N(side, q)[d]});
  numbers.insert(numbers.end(), pairing.values(side, q), pairing.values(side, q) + n_nodes);
  for (unsigned int a = 0; a < n_nodes; ++a)
    for (unsigned int d = 0; d < dim; ++d)
      numbers.push_back(pairing.gradients(side, q)[a][d]);
}

template <int dim>
FacePoint<dim>::FacePoint(const double *numbers, const unsigned int n_nodes) : weight(*numbers++)
{
  for (unsigned int d = 0; d < dim; ++d) {
    X[d] = *numbers++;
    N[d] = *numbers++;
  }
  values = numbers;
  gradients = numbers + n_nodes;
}

/// The tangent of a field of n_c components at a point and its positive part, n x n matrices with n = n_c
/// dim, row (c, J), column (d, L).
template <int dim>
class TangentParts
{
public:
  explicit TangentParts(const unsigned int n_c)
      : n(n_c * dim), D(n * n), values(n), vectors(n * n), work(64 * n)
  {
  }

  /// @return whether it is a number.
  bool reinit(const Response<dim> &response, unsigned int first_component, unsigned int n_components);

  const unsigned int n;
  std::vector<double> D, positive;     ///< positive: with the skew part; empty if it is D
  std::vector<double> values, vectors; ///< of the symmetric part; vector e begins at e n, 0: no energy

private:
  std::vector<double> work;
};

template <int dim>
bool TangentParts<dim>::reinit(const Response<dim> &response, const unsigned int first,
                               const unsigned int n_components)
{
  std::vector<double> now(n * n);
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int j = 0; j < n; ++j)
      now[i * n + j] =
          response.by_gradient[(first + i / dim) * n_components + first + j / dim][i % dim][j % dim];
  if (!std::all_of(now.begin(), now.end(), [](const double entry) { return std::isfinite(entry); }))
    return false;
  if (now == D)
    return true;
  D = now;
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int j = 0; j < n; ++j)
      vectors[i * n + j] = (D[i * n + j] + D[j * n + i]) / 2;
  int info = 0;
  Teuchos::LAPACK<int, double>().SYEV('V', 'U', n, vectors.data(), n, values.data(), work.data(), work.size(),
                                      &info);
  const double rounding = 1e-13 * std::max(std::abs(values.front()), std::abs(values.back()));
  positive.clear();
  for (unsigned int e = 0; e < n; ++e)
    if (std::abs(values[e]) <= rounding)
      values[e] = 0;
    else if (values[e] < 0) {
      if (positive.empty())
        positive = D;
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int j = 0; j < n; ++j)
          positive[i * n + j] -= values[e] * vectors[e * n + i] * vectors[e * n + j];
    }
  return info == 0;
}

/// The rows of one cell after the other, at the given unknowns of all fields.
template <int dim>
class CellProblem
{
public:
  using cell_iterator = typename dealii::Triangulation<dim>::active_cell_iterator;

  /// @p components: those that the fluxes of the field need; laws of other fields are not asked.
  CellProblem(const Domain<dim> &domain, const Field &field, const std::vector<unsigned int> &components,
              double t);

  /// @return whether the law is defined at all points.
  bool reinit(const cell_iterator &cell, const std::vector<FacePoint<dim>> &points,
              const std::vector<double> &unknowns);

  FactoredProblem problem;
  std::vector<double> positive_S; ///< with the positive part of the tangent; empty if that is all of it

private:
  bool add_energy(const std::vector<double> &unknowns);
  bool add_flux(const FacePoint<dim> &point, const std::vector<double> &unknowns);
  bool find_tangent(const std::vector<double> &unknowns);
  void add_flux_rows(const std::vector<double> &D, const FacePoint<dim> &point,
                     std::vector<double> &rows) const;
  void find_rotations(const std::vector<double> &unknowns);

  const Domain<dim> &domain;
  const Field &field;
  const std::vector<unsigned int> &components;
  const unsigned int n_nodes;
  dealii::FEValues<dim> values, at_nodes;
  State<dim> state;
  Response<dim> response;
  TangentParts<dim> tangent;
  std::vector<double> shape;
  std::vector<Tensor<1, dim>> gradient;
};

template <int dim>
CellProblem<dim>::CellProblem(const Domain<dim> &domain, const Field &field,
                              const std::vector<unsigned int> &components, const double t)
    : domain(domain), field(field), components(components), n_nodes(domain.n_nodes()),
      values(domain.mapping(), domain.scalar_element(),
             gauss_rule<dim>(domain.scalar_element().reference_cell(), domain.degree + 1),
             dealii::update_values | dealii::update_gradients | dealii::update_quadrature_points |
                 dealii::update_JxW_values),
      at_nodes(domain.mapping(), domain.scalar_element(), domain.scalar_element().get_unit_support_points(),
               dealii::update_quadrature_points),
      state(domain.n_components()), response(domain.n_components()), tangent(field.n_components),
      shape(n_nodes), gradient(n_nodes)
{
  problem.n = field.n_components * n_nodes;
  state.t = t;
}

template <int dim>
bool CellProblem<dim>::reinit(const cell_iterator &cell, const std::vector<FacePoint<dim>> &points,
                              const std::vector<double> &unknowns)
{
  for (std::vector<double> *rows : {&problem.S, &problem.B, &problem.C, &positive_S})
    rows->clear();
  values.reinit(cell);
  if (!add_energy(unknowns))
    return false;
  bool has_negative = !problem.C.empty();
  for (const FacePoint<dim> &point : points) {
    if (!add_flux(point, unknowns))
      return false;
    has_negative = has_negative || !tangent.positive.empty();
  }
  problem.lifted.clear();
  if (!has_negative)
    positive_S.clear();
  else if (field.n_components > 1) {
    at_nodes.reinit(cell);
    find_rotations(unknowns);
  }
  return true;
}

/// Of the law at the current shape functions and X.
template <int dim>
bool CellProblem<dim>::find_tangent(const std::vector<double> &unknowns)
{
  evaluate_state<dim>(domain.n_components(), n_nodes, shape.data(), gradient.data(), unknowns.data(), state);
  for (unsigned int c = 0; c < domain.n_components(); ++c)
    if (std::find(components.begin(), components.end(), c) == components.end())
      state.value[c] = no_number;
  return domain.material.evaluate(state, true, response) &&
         tangent.reinit(response, field.first_component, domain.n_components());
}

template <int dim>
bool CellProblem<dim>::add_energy(const std::vector<double> &unknowns)
{
  for (const unsigned int q : values.quadrature_point_indices()) {
    for (unsigned int a = 0; a < n_nodes; ++a) {
      shape[a] = values.shape_value(a, q);
      gradient[a] = values.shape_grad(a, q);
    }
    state.X = values.quadrature_point(q);
    if (!find_tangent(unknowns))
      return false;
    for (unsigned int e = 0; e < tangent.n; ++e) {
      if (tangent.values[e] == 0)
        continue;
      const double factor = std::sqrt(values.JxW(q) * std::abs(tangent.values[e]));
      std::vector<double> &rows = tangent.values[e] > 0 ? problem.B : problem.C;
      for (unsigned int d = 0; d < field.n_components; ++d) {
        Tensor<1, dim> direction;
        for (unsigned int L = 0; L < dim; ++L)
          direction[L] = factor * tangent.vectors[e * tangent.n + d * dim + L];
        for (unsigned int a = 0; a < n_nodes; ++a)
          rows.push_back(direction * gradient[a]);
      }
    }
  }
  return true;
}

template <int dim>
bool CellProblem<dim>::add_flux(const FacePoint<dim> &point, const std::vector<double> &unknowns)
{
  for (unsigned int a = 0; a < n_nodes; ++a) {
    shape[a] = point.values[a];
    for (unsigned int d = 0; d < dim; ++d)
      gradient[a][d] = point.gradients[a * dim + d];
  }
  state.X = point.X;
  if (!find_tangent(unknowns))
    return false;
  add_flux_rows(tangent.D, point, problem.S);
  add_flux_rows(tangent.positive.empty() ? tangent.D : tangent.positive, point, positive_S);
  return true;
}

template <int dim>
void CellProblem<dim>::add_flux_rows(const std::vector<double> &D, const FacePoint<dim> &point,
                                     std::vector<double> &rows) const
{
  for (unsigned int c = 0; c < field.n_components; ++c)
    for (unsigned int d = 0; d < field.n_components; ++d) {
      Tensor<1, dim> N_D;
      for (unsigned int J = 0; J < dim; ++J)
        for (unsigned int L = 0; L < dim; ++L)
          N_D[L] += std::sqrt(point.weight) * point.N[J] * D[(c * dim + J) * tangent.n + d * dim + L];
      for (unsigned int a = 0; a < n_nodes; ++a)
        rows.push_back(N_D * gradient[a]);
    }
}

/// Rotations in the planes of two axes, of the current position about its centre, made orthonormal.
template <int dim>
void CellProblem<dim>::find_rotations(const std::vector<double> &unknowns)
{
  std::array<std::vector<double>, dim> position;
  for (unsigned int c = 0; c < dim; ++c) {
    double mean = 0;
    for (unsigned int a = 0; a < n_nodes; ++a) {
      position[c].push_back(at_nodes.quadrature_point(a)[c] - at_nodes.quadrature_point(0)[c] +
                            unknowns[(field.first_component + c) * n_nodes + a]);
      mean += position[c].back() / n_nodes;
    }
    for (double &x : position[c])
      x -= mean;
  }
  for (unsigned int c = 0; c < dim; ++c)
    for (unsigned int d = 0; d < c; ++d) {
      dealii::Vector<double> z(problem.n);
      for (unsigned int a = 0; a < n_nodes; ++a) {
        z[c * n_nodes + a] = -position[d][a];
        z[d * n_nodes + a] = position[c][a];
      }
      for (unsigned int pass = 0; pass < 2; ++pass) { // Gram and Schmidt, twice
        for (const std::vector<double> &other : problem.lifted) {
          const dealii::Vector<double> y(other.begin(), other.end());
          z.add(-(z * y), y);
        }
        z /= z.l2_norm();
      }
      problem.lifted.emplace_back(z.begin(), z.end());
    }
}

/// Of the tangent, and for the penalty.
using Pair = std::array<double, 2>;

/// The eigenvalues of cells, most of which have the same rows up to a factor: a solved problem is kept and
/// compared with.
class Eigenvalues
{
public:
  Pair largest(const FactoredProblem &problem, const std::vector<double> &positive_S);

private:
  struct Solved
  {
    std::vector<double> B, M; ///< B, and M = S^T S above its diagonal; of norm and trace one
    double lambda;
  };

  double largest_without_stress(const FactoredProblem &problem);
  static bool is_multiple(const std::vector<double> &numbers, double factor,
                          const std::vector<double> &other);

  static constexpr unsigned int most = 8;
  std::vector<Solved> solved;
};

Pair Eigenvalues::largest(const FactoredProblem &problem, const std::vector<double> &positive_S)
{
  if (positive_S.empty()) {
    const double lambda = largest_without_stress(problem);
    return {{lambda, lambda}};
  }
  const double of_tangent = largest_eigenvalue(problem),
               of_positive = largest_eigenvalue({problem.n, positive_S, problem.B, {}, {}});
  return {{of_tangent, std::isfinite(of_positive) ? std::min(of_tangent, largest_amplification * of_positive)
                                                  : of_tangent}};
}

double Eigenvalues::largest_without_stress(const FactoredProblem &problem)
{
  const int n = problem.n, n_rows = problem.S.size() / n;
  if (n_rows == 0)
    return 0;
  std::vector<double> M(n * n);
  Teuchos::BLAS<int, double>().SYRK(Teuchos::UPPER_TRI, Teuchos::NO_TRANS, n, n_rows, 1., problem.S.data(), n,
                                    0., M.data(), n);
  double trace = 0, norm = 0;
  for (int i = 0; i < n; ++i)
    trace += M[i * n + i];
  for (const double b : problem.B)
    norm += b * b;
  norm = std::sqrt(norm);
  const auto found = std::find_if(solved.begin(), solved.end(), [&](const Solved &other) {
    return is_multiple(problem.B, norm, other.B) && is_multiple(M, trace, other.M);
  });
  if (found != solved.end())
    return found->lambda * trace / (norm * norm);
  const double lambda = largest_eigenvalue(problem);
  if (solved.size() < most && std::isfinite(lambda) && trace > 0) {
    solved.push_back({problem.B, std::move(M), lambda * norm * norm / trace});
    for (double &b : solved.back().B)
      b /= norm;
    for (double &m : solved.back().M)
      m /= trace;
  }
  return lambda;
}

bool Eigenvalues::is_multiple(const std::vector<double> &numbers, const double factor,
                              const std::vector<double> &other)
{
  if (numbers.size() != other.size())
    return false;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (!(std::abs(numbers[i] - factor * other[i]) <= 1e-12 * factor))
      return false;
  return true;
}

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

/// What a rank is asked about a side: for each of its cells the index of the face of the side, as in
/// SideFaces, the number of points, and the points.
template <int dim>
class SideProblems
{
public:
  SideProblems(const Interface<dim> &interface, const unsigned int side, const TiedField &tied);

  /// The eigenvalues of the cells of this rank behind the points that all ranks have sent, cell by cell.
  OfRanks solve(double t, const typename Tie<dim>::Unknowns &unknowns, const OfRanks &packed_of_rank) const;

private:
  using cell_iterator = typename dealii::Triangulation<dim>::active_cell_iterator;
  struct OfCell
  {
    cell_iterator cell;
    std::vector<FacePoint<dim>> points;
    Pair lambda = {{no_number, no_number}};
  };
  std::map<unsigned int, OfCell> unpack(const OfRanks &packed_of_rank) const;

  const Interface<dim> &interface;
  const InterfaceSide<dim> &of_side;
  const Domain<dim> &domain;
  const Field &field;
  const std::vector<unsigned int> &components;
  std::vector<cell_iterator> cell_of_face;
};

template <int dim>
SideProblems<dim>::SideProblems(const Interface<dim> &interface, const unsigned int side,
                                const TiedField &tied)
    : interface(interface), of_side(interface.sides[side]), domain(*of_side.domain),
      field(domain.fields()[tied.field[side]]), components(interface.components[side])
{
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (cell->is_locally_owned() && of_side.belongs(cell, id))
      cell_of_face.push_back(cell);
}

template <int dim>
std::map<unsigned int, typename SideProblems<dim>::OfCell>
SideProblems<dim>::unpack(const OfRanks &packed_of_rank) const
{
  std::map<unsigned int, OfCell> cells;
  for (const auto &[rank, packed] : packed_of_rank)
    for (std::size_t i = 0; i < packed.size();) {
      const cell_iterator cell = cell_of_face[static_cast<unsigned int>(packed[i])];
      OfCell &of_cell = cells[cell->active_cell_index()];
      of_cell.cell = cell;
      const unsigned int n_points = packed[i + 1];
      i += 2;
      for (unsigned int q = 0; q < n_points; ++q, i += FacePoint<dim>::n_numbers(domain.n_nodes()))
        of_cell.points.emplace_back(&packed[i], domain.n_nodes());
    }
  return cells;
}

template <int dim>
OfRanks SideProblems<dim>::solve(const double t, const typename Tie<dim>::Unknowns &unknowns,
                                 const OfRanks &packed_of_rank) const
{
  std::map<unsigned int, OfCell> cells = unpack(packed_of_rank);
  CellProblem<dim> problem(domain, field, components, t);
  Eigenvalues eigenvalues;
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> values;
  for (auto &[index, of_cell] : cells) {
    domain.cell_dofs(domain.dof_cell(of_cell.cell), dofs);
    unknowns(dofs, values);
    if (!problem.reinit(of_cell.cell, of_cell.points, values))
      continue;
    of_cell.lambda = eigenvalues.largest(problem.problem, problem.positive_S);
    for (double &lambda : of_cell.lambda)
      lambda *= 1 + n_other_interfaces(of_side, field.name, of_cell.cell);
  }
  interface.work().eigenvalue_problems += cells.size();

  OfRanks answers;
  for (const auto &[rank, packed] : packed_of_rank)
    for (std::size_t i = 0; i < packed.size();
         i += 2 + FacePoint<dim>::n_numbers(domain.n_nodes()) * static_cast<std::size_t>(packed[i + 1])) {
      const auto cell = cell_of_face[static_cast<unsigned int>(packed[i])];
      const Pair &lambda = cells.at(cell->active_cell_index()).lambda;
      answers[rank].insert(answers[rank].end(), lambda.begin(), lambda.end());
    }
  return answers;
}

/// For each rank its cells behind a side, as SideProblems reads them; and which they are.
template <int dim>
std::pair<OfRanks, std::map<unsigned int, std::vector<unsigned int>>>
ask_owners(const Interface<dim> &interface, const unsigned int side)
{
  const Pairing<dim> &pairing = interface.pairing();
  const auto &cells = pairing.cells[side];
  const unsigned int n_nodes = interface.sides[side].domain->n_nodes();
  std::vector<std::vector<const typename Pairing<dim>::Group *>> groups(cells.size());
  for (const auto &group : pairing.groups)
    groups[group.cells[side]].push_back(&group);
  OfRanks questions;
  std::map<unsigned int, std::vector<unsigned int>> asked;
  for (unsigned int i = 0; i < cells.size(); ++i) {
    std::vector<double> &packed = questions[cells[i].rank];
    asked[cells[i].rank].push_back(i);
    unsigned int n_points = 0;
    for (const auto *group : groups[i])
      n_points += group->end - group->begin;
    packed.push_back(cells[i].face);
    packed.push_back(n_points);
    for (const auto *group : groups[i])
      for (unsigned int q = group->begin; q < group->end; ++q)
        FacePoint<dim>::pack(pairing, side, q, n_nodes, packed);
  }
  return {std::move(questions), std::move(asked)};
}

/// NaN where a law is not defined.
template <int dim>
TraceEigenvalues eigenvalues_at(const Interface<dim> &interface, const TiedField &field, const double t,
                                const typename Tie<dim>::Unknowns &unknowns, const MPI_Comm &communicator)
{
  TraceEigenvalues result;
  for (const unsigned int side : {source, destination}) {
    const unsigned int n_cells = interface.pairing().cells[side].size();
    result.of_tangent[side].resize(n_cells);
    result.of_penalty[side].resize(n_cells);
    auto [questions, asked] = ask_owners(interface, side);
    const OfRanks received = exchange(std::move(questions), communicator, interface.work());
    const SideProblems<dim> problems(interface, side, field);
    const OfRanks answers = exchange(problems.solve(t, unknowns, received), communicator, interface.work());
    for (const auto &[rank, lambda] : answers)
      for (unsigned int k = 0; k < lambda.size() / 2; ++k) {
        result.of_tangent[side][asked.at(rank)[k]] = lambda[2 * k];
        result.of_penalty[side][asked.at(rank)[k]] = lambda[2 * k + 1];
      }
  }
  return result;
}

} // namespace

template <int dim>
TraceEigenvalues trace_eigenvalues(const Interface<dim> &interface, const TiedField &field, const double t,
                                   const typename Tie<dim>::Unknowns &unknowns, const MPI_Comm &communicator)
{
  TraceEigenvalues lambda = eigenvalues_at(interface, field, t, unknowns, communicator);
  const auto is_undefined = [](const double value) { return std::isnan(value); };
  int is_incomplete = 0;
  for (auto &of_side : lambda.of_tangent) {
    is_incomplete = std::any_of(of_side.begin(), of_side.end(), is_undefined) ? 1 : is_incomplete;
    std::replace_if(of_side.begin(), of_side.end(), is_undefined, std::numeric_limits<double>::infinity());
  }
  if (dealii::Utilities::MPI::max(is_incomplete, communicator) == 0)
    return lambda;
  const TraceEigenvalues at_rest = eigenvalues_at(
      interface, field, t,
      [](const std::vector<dealii::types::global_dof_index> &dofs, std::vector<double> &values) {
        values.assign(dofs.size(), 0.);
      },
      communicator);
  for (const unsigned int side : {source, destination})
    for (unsigned int i = 0; i < lambda.of_penalty[side].size(); ++i)
      if (is_undefined(lambda.of_penalty[side][i]))
        lambda.of_penalty[side][i] = at_rest.of_penalty[side][i];
  return lambda;
}

template TraceEigenvalues trace_eigenvalues(const Interface<2> &, const TiedField &, double,
                                            const Tie<2>::Unknowns &, const MPI_Comm &);
template TraceEigenvalues trace_eigenvalues(const Interface<3> &, const TiedField &, double,
                                            const Tie<3>::Unknowns &, const MPI_Comm &);

} // namespace dovetail
