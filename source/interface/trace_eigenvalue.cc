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
//
// Around an axis the strain u_r/r of a vector field is one more entry of grad v, whose derivatives the
// response has as those by the value.

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/interface/factored_eigenvalue.h>
#include <dovetail/interface/trace_eigenvalue.h>

#include <deal.II/base/mpi.h>

#include <Teuchos_BLAS.hpp>
#include <Teuchos_LAPACK.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

namespace dovetail {

namespace {

using dealii::Point;
using dealii::Tensor;

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
constexpr double largest_amplification = 4;

/// A point of an interface and the shape functions of a cell behind it there.
template <int dim>
struct FacePoint
{
  double weight = 0;
  Point<dim> X;
  Tensor<1, dim> N;
  std::vector<double> values;
  std::vector<Tensor<1, dim>> gradients;

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &weight &X &N &values &gradients;
  }
};

/// What the rank that owns a cell is told of it.
template <int dim>
struct FaceOfCell
{
  unsigned int face = 0; ///< of the side, as in SideFaces
  std::vector<FacePoint<dim>> points;

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &face &points;
  }
};

template <int dim>
using Questions = OfRanks<std::vector<FaceOfCell<dim>>>;

/// The tangent of a field of n_c components at a point and its positive part, n x n matrices with n = n_c
/// dim, row (c, J), column (d, L); with one more for the strain around an axis.
template <int dim>
class TangentParts
{
public:
  TangentParts(const unsigned int n_c, const bool has_hoop)
      : n(n_c * dim + has_hoop), n_gradient(n_c * dim), D(n * n), values(n), vectors(n * n), work(64 * n)
  {
  }

  /// @return whether it is a number.
  bool reinit(const Response<dim> &response, const State<dim> &state, unsigned int first_component);

  const unsigned int n, n_gradient;
  std::vector<double> D, positive;     ///< positive: with the skew part; empty if it is D
  std::vector<double> values, vectors; ///< of the symmetric part; vector e begins at e n, 0: no energy

private:
  std::vector<double> work;
};

template <int dim>
bool TangentParts<dim>::reinit(const Response<dim> &response, const State<dim> &state,
                               const unsigned int first)
{
  const unsigned int n_components = state.value.size(), hoop = n_gradient;
  std::vector<double> now(n * n);
  for (unsigned int i = 0; i < n_gradient; ++i)
    for (unsigned int j = 0; j < n_gradient; ++j)
      now[i * n + j] =
          response.by_gradient[(first + i / dim) * n_components + first + j / dim][i % dim][j % dim];
  if (n > n_gradient) {
    const double r = state.X[0];
    for (unsigned int i = 0; i < n_gradient; ++i) {
      now[i * n + hoop] = r * response.by_value[(first + i / dim) * n_components + first][i % dim];
      now[hoop * n + i] = r * response.source_by_gradient[first * n_components + first + i / dim][i % dim];
    }
    now[hoop * n + hoop] = r * r * response.source_by_value[first * n_components + first];
  }
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
  bool find_tangent();
  void add_flux_rows(const std::vector<double> &D, const FacePoint<dim> &point,
                     std::vector<double> &rows) const;
  void find_rotations(const std::vector<double> &unknowns);
  void hold_axis();
  /// The derivative of the strain u_r/r by the unknown of node a of a component, at the current point.
  double hoop_strain(const double value, const unsigned int component) const
  {
    return has_hoop && component == 0 && point.state.X[0] > 0 ? value / point.state.X[0] : 0;
  }

  const Domain<dim> &domain;
  const Field &field;
  const bool has_hoop;
  const std::vector<unsigned int> &components;
  const unsigned int n_nodes;
  dealii::FEValues<dim> values, at_nodes;
  CellPoints<dim> point;
  TangentParts<dim> tangent;
};

template <int dim>
CellProblem<dim>::CellProblem(const Domain<dim> &domain, const Field &field,
                              const std::vector<unsigned int> &components, const double t)
    : domain(domain), field(field), has_hoop(domain.measure.has_hoop_strain(field)), components(components),
      n_nodes(domain.n_nodes()),
      values(domain.mapping(), domain.scalar_element(),
             gauss_rule<dim>(domain.scalar_element().reference_cell(), domain.degree + 1),
             dealii::update_values | dealii::update_gradients | dealii::update_quadrature_points |
                 dealii::update_JxW_values),
      at_nodes(domain.mapping(), domain.scalar_element(), domain.scalar_element().get_unit_support_points(),
               dealii::update_quadrature_points),
      point(domain, t), tangent(field.n_components, has_hoop)
{
  problem.n = field.n_components * n_nodes;
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
  else if (field.n_components > 1 && !has_hoop) {
    at_nodes.reinit(cell);
    find_rotations(unknowns);
  }
  if (has_hoop && domain.reaches_axis()) {
    at_nodes.reinit(cell);
    hold_axis();
  }
  return true;
}

/// u_r = 0 at the nodes on the axis: their unknowns are in the kernel.
template <int dim>
void CellProblem<dim>::hold_axis()
{
  for (unsigned int a = 0; a < n_nodes; ++a)
    if (domain.is_on_axis(at_nodes.quadrature_point(a)))
      for (std::vector<double> *rows : {&problem.S, &problem.B, &problem.C, &positive_S})
        for (unsigned int i = a; i < rows->size(); i += problem.n)
          (*rows)[i] = 0;
}

/// Of the law at the current point.
template <int dim>
bool CellProblem<dim>::find_tangent()
{
  for (unsigned int c = 0; c < domain.n_components(); ++c)
    if (std::find(components.begin(), components.end(), c) == components.end())
      point.state.value[c] = no_number;
  return point.evaluate(true) && tangent.reinit(point.response, point.state, field.first_component);
}

template <int dim>
bool CellProblem<dim>::add_energy(const std::vector<double> &unknowns)
{
  for (const unsigned int q : values.quadrature_point_indices()) {
    point.reinit(values, q, unknowns);
    if (!find_tangent())
      return false;
    for (unsigned int e = 0; e < tangent.n; ++e) {
      if (tangent.values[e] == 0)
        continue;
      const double factor = std::sqrt(domain.measure(values, q) * std::abs(tangent.values[e]));
      std::vector<double> &rows = tangent.values[e] > 0 ? problem.B : problem.C;
      for (unsigned int d = 0; d < field.n_components; ++d) {
        Tensor<1, dim> direction;
        for (unsigned int L = 0; L < dim; ++L)
          direction[L] = factor * tangent.vectors[e * tangent.n + d * dim + L];
        const double around = factor * tangent.vectors[e * tangent.n + tangent.n - 1];
        for (unsigned int a = 0; a < n_nodes; ++a)
          rows.push_back(direction * point.shape_gradients()[a] +
                         around * hoop_strain(point.shape_values()[a], d));
      }
    }
  }
  return true;
}

template <int dim>
bool CellProblem<dim>::add_flux(const FacePoint<dim> &of_face, const std::vector<double> &unknowns)
{
  point.reinit(of_face.X, of_face.values.data(), of_face.gradients.data(), unknowns);
  if (!find_tangent())
    return false;
  add_flux_rows(tangent.D, of_face, problem.S);
  add_flux_rows(tangent.positive.empty() ? tangent.D : tangent.positive, of_face, positive_S);
  return true;
}

template <int dim>
void CellProblem<dim>::add_flux_rows(const std::vector<double> &D, const FacePoint<dim> &of_face,
                                     std::vector<double> &rows) const
{
  for (unsigned int c = 0; c < field.n_components; ++c)
    for (unsigned int d = 0; d < field.n_components; ++d) {
      Tensor<1, dim> N_D;
      for (unsigned int J = 0; J < dim; ++J)
        for (unsigned int L = 0; L < dim; ++L)
          N_D[L] += std::sqrt(of_face.weight) * of_face.N[J] * D[(c * dim + J) * tangent.n + d * dim + L];
      double around = 0;
      for (unsigned int J = 0; has_hoop && J < dim; ++J)
        around += std::sqrt(of_face.weight) * of_face.N[J] * D[(c * dim + J) * tangent.n + tangent.n - 1];
      for (unsigned int a = 0; a < n_nodes; ++a)
        rows.push_back(N_D * of_face.gradients[a] + around * hoop_strain(of_face.values[a], d));
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

/// The cells of this rank behind the faces of a side.
template <int dim>
class SideProblems
{
public:
  SideProblems(const Interface<dim> &interface, const unsigned int side, const TiedField &tied);

  /// The eigenvalues of the cells behind the points that all ranks have sent.
  OfRanks<std::vector<Pair>> solve(double t, const typename Tie<dim>::Unknowns &unknowns,
                                   Questions<dim> questions) const;

private:
  using cell_iterator = typename dealii::Triangulation<dim>::active_cell_iterator;

  const Interface<dim> &interface;
  const InterfaceSide<dim> &of_side;
  const Domain<dim> &domain;
  const Field &field;
  const std::vector<unsigned int> &components;
  const std::vector<cell_iterator> cell_of_face;
};

template <int dim>
SideProblems<dim>::SideProblems(const Interface<dim> &interface, const unsigned int side,
                                const TiedField &tied)
    : interface(interface), of_side(interface.sides[side]), domain(*of_side.domain),
      field(domain.fields()[tied.field[side]]), components(interface.components[side]),
      cell_of_face(cells_behind(of_side))
{
}

template <int dim>
OfRanks<std::vector<Pair>> SideProblems<dim>::solve(const double t,
                                                    const typename Tie<dim>::Unknowns &unknowns,
                                                    Questions<dim> questions) const
{
  std::map<cell_iterator, std::vector<FacePoint<dim>>> points_of_cell;
  for (auto &[rank, faces] : questions)
    for (auto &[face, points] : faces) {
      auto &of_cell = points_of_cell[cell_of_face[face]];
      std::move(points.begin(), points.end(), std::back_inserter(of_cell));
    }
  CellProblem<dim> problem(domain, field, components, t);
  Eigenvalues eigenvalues;
  std::map<cell_iterator, Pair> lambda;
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> values;
  for (const auto &[cell, points] : points_of_cell) {
    domain.cell_dofs(domain.dof_cell(cell), dofs);
    unknowns(dofs, values);
    Pair &of_cell = lambda[cell] = {{no_number, no_number}};
    if (!problem.reinit(cell, points, values))
      continue;
    of_cell = eigenvalues.largest(problem.problem, problem.positive_S);
    for (double &value : of_cell)
      value *= 1 + n_other_interfaces(of_side, field.name, cell);
  }
  interface.work().eigenvalue_problems += lambda.size();

  OfRanks<std::vector<Pair>> answers;
  for (const auto &[rank, faces] : questions)
    for (const auto &of_cell : faces)
      answers[rank].push_back(lambda.at(cell_of_face[of_cell.face]));
  return answers;
}

/// For each rank its cells behind a side; and which they are, in Pairing::cells.
template <int dim>
std::pair<Questions<dim>, OfRanks<std::vector<unsigned int>>> ask_owners(const Interface<dim> &interface,
                                                                         const unsigned int side)
{
  const Pairing<dim> &pairing = interface.pairing();
  const auto &cells = pairing.cells[side];
  const unsigned int n_nodes = interface.sides[side].domain->n_nodes();
  std::vector<std::vector<FacePoint<dim>>> points(cells.size());
  for (const auto &group : pairing.groups)
    for (unsigned int q = group.begin; q < group.end; ++q) {
      const double *values = pairing.values(side, q);
      const Tensor<1, dim> *gradients = pairing.gradients(side, q);
      points[group.cells[side]].push_back({pairing.weight(q),
                                           pairing.X(side, q),
                                           pairing.N(side, q),
                                           {values, values + n_nodes},
                                           {gradients, gradients + n_nodes}});
    }
  Questions<dim> questions;
  OfRanks<std::vector<unsigned int>> asked;
  for (unsigned int i = 0; i < cells.size(); ++i) {
    questions[cells[i].rank].push_back({cells[i].face, std::move(points[i])});
    asked[cells[i].rank].push_back(i);
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
    auto answers = SideProblems<dim>(interface, side, field)
                       .solve(t, unknowns, exchange(std::move(questions), communicator, interface.work()));
    for (const auto &[rank, lambda] : exchange(std::move(answers), communicator, interface.work()))
      for (unsigned int k = 0; k < lambda.size(); ++k) {
        const unsigned int cell = asked.at(rank)[k];
        result.of_tangent[side][cell] = lambda[k][0];
        result.of_penalty[side][cell] = lambda[k][1];
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
