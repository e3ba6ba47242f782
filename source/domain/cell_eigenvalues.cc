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

#include <dovetail/domain/cell_eigenvalues.h>
#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/factored_eigenvalue.h>
#include <dovetail/domain/quadrature.h>

#include <Teuchos_BLAS.hpp>
#include <Teuchos_LAPACK.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace dovetail {

namespace {

using dealii::Tensor;

constexpr double without_law = std::numeric_limits<double>::quiet_NaN();
constexpr double largest_amplification = 4;

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

/// What gradients in a cell are off by, relative to the largest ones: they are made of differences of
/// coordinates, which far from the origin have lost digits. Less than what gradients along a thin cell are
/// beside those across it.
template <int dim>
double rounding_of_gradients(const dealii::FEValues<dim> &values)
{
  const auto &cell = values.get_cell();
  const auto &JxW = values.get_JxW_values();
  const double volume = std::accumulate(JxW.begin(), JxW.end(), 0.), length = cell->diameter(),
               thickness = volume / std::pow(length, dim - 1);
  return std::min(16 * std::numeric_limits<double>::epsilon() * cell->center().norm() / thickness,
                  1e-4 * thickness / length);
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
  bool reinit(const cell_iterator &cell, const std::vector<TracePoint<dim>> &points,
              const std::vector<double> &unknowns);

  FactoredProblem problem;
  std::vector<double> positive_S; ///< with the positive part of the tangent; empty if that is all of it

private:
  bool add_energy(const std::vector<double> &unknowns);
  bool add_flux(const TracePoint<dim> &point, const std::vector<double> &unknowns);
  bool find_tangent();
  void add_flux_rows(const std::vector<double> &D, const TracePoint<dim> &point,
                     std::vector<double> &rows) const;
  void find_rotations(const std::vector<double> &unknowns);
  void hold_axis();
  /// What a row has at the nodes of one component.
  double *add_row(std::vector<double> &rows) const
  {
    rows.resize(rows.size() + n_nodes);
    return rows.data() + rows.size() - n_nodes;
  }
  /// The derivative of the strain u_r/r by the unknown of node a of a component, at the current point.
  double hoop_strain(const double value, const unsigned int component) const
  {
    return has_hoop && component == 0 && point.state.X[0] > 0 ? value / point.state.X[0] : 0;
  }

  const Domain<dim> &domain;
  const Field &field;
  const bool has_hoop;
  const std::vector<unsigned int> &components;
  const unsigned int n_nodes, first_shape; ///< of the field
  dealii::FEValues<dim> values, at_nodes;
  CellPoints<dim> point;
  TangentParts<dim> tangent;
};

template <int dim>
CellProblem<dim>::CellProblem(const Domain<dim> &domain, const Field &field,
                              const std::vector<unsigned int> &components, const double t)
    : domain(domain), field(field), has_hoop(domain.measure.has_hoop_strain(field)), components(components),
      n_nodes(domain.layout().n_nodes(field.first_component)),
      first_shape(domain.layout().first_shape(field.first_component)),
      values(domain.mapping(), domain.layout().shape_element(),
             gauss_rule<dim>(domain.cell_shape(), domain.degree + 1),
             dealii::update_values | dealii::update_gradients | dealii::update_quadrature_points |
                 dealii::update_JxW_values),
      at_nodes(domain.mapping(), domain.layout().element(field.first_component),
               domain.layout().element(field.first_component).get_unit_support_points(),
               dealii::update_quadrature_points),
      point(domain, t), tangent(field.n_components, has_hoop)
{
  problem.n = field.n_components * n_nodes;
}

template <int dim>
bool CellProblem<dim>::reinit(const cell_iterator &cell, const std::vector<TracePoint<dim>> &points,
                              const std::vector<double> &unknowns)
{
  for (std::vector<double> *rows : {&problem.S, &problem.B, &problem.C, &positive_S})
    rows->clear();
  values.reinit(cell);
  problem.rounding = rounding_of_gradients(values);
  if (!add_energy(unknowns))
    return false;
  for (const TracePoint<dim> &point : points)
    if (!add_flux(point, unknowns))
      return false;
  if (positive_S.empty() && !problem.C.empty())
    positive_S = problem.S;
  problem.lifted.clear();
  if (!positive_S.empty() && field.n_components > 1 && !has_hoop) {
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
      point.state.value[c] = without_law;
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
        double *const row = add_row(rows);
        for (unsigned int a = 0; a < n_nodes; ++a)
          row[a] = direction * point.shape_gradients()[first_shape + a] +
                   around * hoop_strain(point.shape_values()[first_shape + a], d);
      }
    }
  }
  return true;
}

template <int dim>
bool CellProblem<dim>::add_flux(const TracePoint<dim> &face_point, const std::vector<double> &unknowns)
{
  point.reinit(face_point.X, face_point.values.data(), face_point.gradients.data(), unknowns);
  if (!find_tangent())
    return false;
  if (!tangent.positive.empty() && positive_S.empty())
    positive_S = problem.S; // of the points before, at which the tangent is positive
  add_flux_rows(tangent.D, face_point, problem.S);
  if (!tangent.positive.empty() || !positive_S.empty())
    add_flux_rows(tangent.positive.empty() ? tangent.D : tangent.positive, face_point, positive_S);
  return true;
}

template <int dim>
void CellProblem<dim>::add_flux_rows(const std::vector<double> &D, const TracePoint<dim> &face_point,
                                     std::vector<double> &rows) const
{
  for (unsigned int c = 0; c < field.n_components; ++c)
    for (unsigned int d = 0; d < field.n_components; ++d) {
      Tensor<1, dim> N_D;
      for (unsigned int J = 0; J < dim; ++J)
        for (unsigned int L = 0; L < dim; ++L)
          N_D[L] +=
              std::sqrt(face_point.weight) * face_point.N[J] * D[(c * dim + J) * tangent.n + d * dim + L];
      double around = 0;
      for (unsigned int J = 0; has_hoop && J < dim; ++J)
        around +=
            std::sqrt(face_point.weight) * face_point.N[J] * D[(c * dim + J) * tangent.n + tangent.n - 1];
      double *const row = add_row(rows);
      for (unsigned int a = 0; a < n_nodes; ++a)
        row[a] = N_D * face_point.gradients[first_shape + a] +
                 around * hoop_strain(face_point.values[first_shape + a], d);
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
                            unknowns[domain.layout().index(field.first_component + c, a)]);
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
using EigenvaluePair = std::array<double, 2>;

/// The eigenvalues of cells, most of which have the same rows up to a factor: a solved problem is kept and
/// compared with. Matrices M = S^T S are compared by what they make of some vectors.
class Eigenvalues
{
public:
  EigenvaluePair largest(const FactoredProblem &problem, const std::vector<double> &positive_S);

private:
  struct Solved
  {
    std::vector<double> B, MZ; ///< with B of norm and M of trace one
    double lambda;
  };

  double largest_without_stress(const FactoredProblem &problem);
  std::vector<double> multiply_vectors(const std::vector<double> &S, int n);
  static bool is_multiple(const std::vector<double> &numbers, double factor,
                          const std::vector<double> &other);

  static constexpr unsigned int most = 8;
  std::vector<Solved> solved;
  std::vector<double> Z; ///< column by column
};

EigenvaluePair Eigenvalues::largest(const FactoredProblem &problem, const std::vector<double> &positive_S)
{
  if (positive_S.empty()) {
    const double lambda = largest_without_stress(problem);
    return {{lambda, lambda}};
  }
  const double tangent_eigenvalue = largest_eigenvalue(problem),
               positive_eigenvalue =
                   largest_eigenvalue({problem.n, positive_S, problem.B, {}, {}, problem.rounding});
  return {{tangent_eigenvalue, std::isfinite(positive_eigenvalue)
                                   ? std::min(tangent_eigenvalue, largest_amplification * positive_eigenvalue)
                                   : tangent_eigenvalue}};
}

/// S^T S Z. Matrices that differ agree on the vectors of a subspace only, in which numbers as irregular as
/// these do not lie.
std::vector<double> Eigenvalues::multiply_vectors(const std::vector<double> &S, const int n)
{
  const int n_vectors = 3, n_rows = S.size() / n;
  for (int i = Z.size(); i < n_vectors * n; ++i)
    Z.push_back(std::sin(1e4 * (1 + i) * (1 + i))); // squared, or two of them would give the third
  std::vector<double> SZ(n_vectors * n_rows), MZ(n_vectors * n);
  const Teuchos::BLAS<int, double> blas;
  blas.GEMM(Teuchos::TRANS, Teuchos::NO_TRANS, n_rows, n_vectors, n, 1., S.data(), n, Z.data(), n, 0.,
            SZ.data(), n_rows);
  blas.GEMM(Teuchos::NO_TRANS, Teuchos::NO_TRANS, n, n_vectors, n_rows, 1., S.data(), n, SZ.data(), n_rows,
            0., MZ.data(), n);
  return MZ;
}

double Eigenvalues::largest_without_stress(const FactoredProblem &problem)
{
  const int n = problem.n;
  if (problem.S.empty())
    return 0;
  std::vector<double> MZ = multiply_vectors(problem.S, n);
  const auto square = [](const std::vector<double> &numbers) {
    return std::inner_product(numbers.begin(), numbers.end(), numbers.begin(), 0.);
  };
  const double trace = square(problem.S), norm = std::sqrt(square(problem.B));
  const auto found = std::find_if(solved.begin(), solved.end(), [&](const Solved &other) {
    return is_multiple(problem.B, norm, other.B) && is_multiple(MZ, trace, other.MZ);
  });
  if (found != solved.end())
    return found->lambda * trace / (norm * norm);
  const double lambda = largest_eigenvalue(problem);
  if (solved.size() < most && std::isfinite(lambda) && trace > 0) {
    solved.push_back({problem.B, std::move(MZ), lambda * norm * norm / trace});
    for (double &b : solved.back().B)
      b /= norm;
    for (double &m : solved.back().MZ)
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

} // namespace

template <int dim>
struct CellEigenvalues<dim>::Implementation
{
  CellProblem<dim> problem;
  Eigenvalues eigenvalues;
};

template <int dim>
CellEigenvalues<dim>::CellEigenvalues(const Domain<dim> &domain, const Field &field,
                                      const std::vector<unsigned int> &components, const double t)
    : implementation(new Implementation{CellProblem<dim>(domain, field, components, t), {}})
{
}

template <int dim>
CellEigenvalues<dim>::~CellEigenvalues() = default;

template <int dim>
std::array<double, 2> CellEigenvalues<dim>::evaluate(const cell_iterator &cell,
                                                     const std::vector<TracePoint<dim>> &points,
                                                     const std::vector<double> &unknowns)
{
  CellProblem<dim> &problem = implementation->problem;
  if (!problem.reinit(cell, points, unknowns))
    return {{without_law, without_law}};
  return implementation->eigenvalues.largest(problem.problem, problem.positive_S);
}

template <int dim>
std::vector<unsigned int> components_for_flux(const Material<dim> &material, const unsigned int field)
{
  std::vector<unsigned int> components;
  for (unsigned int g = 0; g < material.fields().size(); ++g)
    for (unsigned int c = 0; material.flux_depends(field, g) && c < material.fields()[g].n_components; ++c)
      components.push_back(material.fields()[g].first_component + c);
  return components;
}

template class CellEigenvalues<2>;
template class CellEigenvalues<3>;
template std::vector<unsigned int> components_for_flux(const Material<2> &, unsigned int);
template std::vector<unsigned int> components_for_flux(const Material<3> &, unsigned int);

} // namespace dovetail
