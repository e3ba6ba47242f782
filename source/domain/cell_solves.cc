// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_solves.h>

#include <dovetail/widest_vectors.h>

#include <deal.II/base/exceptions.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_tools.h>
#include <deal.II/lac/full_matrix.h>
#include <deal.II/lac/lapack_full_matrix.h>
#include <deal.II/lac/vector.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace dovetail {

CellSolves::CellSolves(const unsigned int degree) : n(degree + 1), stiffness(n * n), mass(n * n)
{
  AssertThrow(n >= 3 && n <= 5, dealii::ExcMessage("The loops are compiled for degrees from 2 to 4."));
  const dealii::QGauss<1> points(n);
  const dealii::FE_Q<1> element(degree);
  const auto node = dealii::FETools::lexicographic_to_hierarchic_numbering<1>(degree);
  for (unsigned int q = 0; q < n; ++q)
    for (unsigned int i = 0; i < n; ++i)
      for (unsigned int j = 0; j < n; ++j) {
        const double w = points.weight(q);
        const dealii::Point<1> &x = points.point(q);
        stiffness[i * n + j] += w * element.shape_grad(node[i], x)[0] * element.shape_grad(node[j], x)[0];
        mass[i * n + j] += w * element.shape_value(node[i], x) * element.shape_value(node[j], x);
      }
}

/// What is beyond ends is rounded, so that many lines share their eigenpairs.
const CellSolves::Pairs &CellSolves::pairs_of(const Line &line)
{
  const double steps_per_octave = 4, smallest = 1e-3;
  const int none = -1000000;
  std::array<int, 4> beyond;
  for (unsigned int e = 0; e < 4; ++e) {
    const double value = e < 2 ? line[e].ratio : line[e - 2].stiffness;
    beyond[e] = value > 0 ? std::lround(steps_per_octave * std::log2(std::max(value, smallest))) : none;
  }
  const auto [place, is_new] = known.try_emplace(beyond);
  Pairs &result = place->second;
  if (!is_new)
    return result;
  dealii::FullMatrix<double> K(n, n, stiffness.data()), M(n, n, mass.data());
  for (unsigned int e = 0; e < 4; ++e)
    if (const unsigned int i = e % 2 * (n - 1); beyond[e] != none) {
      const double value = std::exp2(beyond[e] / steps_per_octave);
      K(i, i) += stiffness[0] * (e < 2 ? 1 / value : value);
      M(i, i) += e < 2 ? mass[0] * value : 0.;
    }
  dealii::LAPACKFullMatrix<double> eigenvalues(n), weights(n);
  eigenvalues = K;
  weights = M;
  std::vector<dealii::Vector<double>> vectors(n, dealii::Vector<double>(n));
  eigenvalues.compute_generalized_eigenvalues_symmetric(weights, vectors);
  for (unsigned int mode = 0; mode < n; ++mode) {
    result.values.push_back(std::max(0., eigenvalues.eigenvalue(mode).real()));
    const double norm = std::sqrt(M.matrix_norm_square(vectors[mode]));
    for (unsigned int i = 0; i < n; ++i)
      result.vectors.push_back(vectors[mode][i] / norm);
  }
  return result;
}

template <typename Number>
CellSolvesIn<Number>::CellSolvesIn(const unsigned int dim, const unsigned int n_components,
                                   const unsigned int degree,
                                   std::shared_ptr<const std::vector<int>> given_index)
    : CellSolves(degree), dim(dim), n_components(n_components), n_nodes(dim == 2 ? n * n : n * n * n),
      index(std::move(given_index)), size_of_component(dim * n * (n + 1) + 1)
{
  const std::size_t n_tables = index->size() / (n_nodes * Lanes::size);
  all.resize(n_tables * size_of_component);
  for (std::size_t i = 1; i <= n_tables; ++i)
    all[i * size_of_component - 1] = LanesOf<Number>(1); // of a lane without a cell, not to divide by zero
}

template <typename Number>
void CellSolvesIn<Number>::set(const unsigned int slot, const unsigned int component,
                               const std::vector<Line> &lines, const std::vector<double> &a)
{
  LanesOf<Number> *const first = &all[((slot / Lanes::size) * n_components + component) * size_of_component];
  const unsigned int lane = slot % Lanes::size;
  for (unsigned int k = 0; k < dim; ++k) {
    const Pairs &pairs = pairs_of(lines[k]);
    LanesOf<Number> *const of_line = first + k * n * (n + 1);
    for (unsigned int i = 0; i < n * n; ++i)
      of_line[i][lane] = static_cast<Number>(pairs.vectors[i]);
    for (unsigned int mode = 0; mode < n; ++mode)
      of_line[n * n + mode][lane] = static_cast<Number>(pairs.values[mode] * a[k]);
  }
  first[size_of_component - 1][lane] = static_cast<Number>(a[dim]);
}

namespace {

constexpr std::size_t n_lanes = Lanes::size;
template <typename Number>
using Part = typename WideRegister<Number>::Part;

/// Along lines of n numbers that are @p stride apart: data = m data, or the transpose, each lane by its own
/// m.
template <std::size_t n, bool transposed, typename Number>
DOVETAIL_PART_OF_CALLER void sweep_lanes(const Number *const m, const std::size_t stride,
                                         const std::size_t n_outer, Number *const data)
{
  for (std::size_t part = 0; part < n_lanes; part += sizeof(Part<Number>) / sizeof(Number)) {
    Part<Number> table[n * n];
    for (std::size_t i = 0; i < n * n; ++i)
      table[i] = *reinterpret_cast<const Part<Number> *>(m + i * n_lanes + part);
    for (std::size_t o = 0; o < n_outer; ++o)
      for (std::size_t k = part; k < stride; k += n_lanes) {
        Number *const line = data + o * n * stride + k;
        Part<Number> x[n];
        for (std::size_t i = 0; i < n; ++i)
          x[i] = *reinterpret_cast<const Part<Number> *>(line + i * stride);
        for (std::size_t q = 0; q < n; ++q) {
          Part<Number> s = (transposed ? table[q] : table[q * n]) * x[0];
          for (std::size_t i = 1; i < n; ++i)
            s += (transposed ? table[i * n + q] : table[q * n + i]) * x[i];
          *reinterpret_cast<Part<Number> *>(line + q * stride) = s;
        }
      }
  }
}

/// S (sum Lambda + m)^-1 S^T
template <std::size_t n, typename Number>
DOVETAIL_PART_OF_CALLER void solve_in_cells(const unsigned int dim, const Number *const tables,
                                            Number *const data)
{
  constexpr std::size_t L = n_lanes, of_line = n * (n + 1) * L;
  const std::size_t face = dim == 2 ? n : n * n;
  std::size_t stride = L;
  for (unsigned int k = 0; k < dim; ++k, stride *= n)
    sweep_lanes<n, false>(tables + k * of_line, stride, face * L / stride, data);
  const Number *const x = tables + n * n * L, *const y = x + of_line, *const z = y + of_line;
  const Number *const m = tables + dim * of_line;
  for (std::size_t k = 0; k < (dim == 2 ? 1 : n); ++k)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t l = 0; l < L; ++l)
          data[((k * n + j) * n + i) * L + l] /=
              (dim == 2 ? Number() : z[k * L + l]) + y[j * L + l] + x[i * L + l] + m[l];
  for (unsigned int k = 0; k < dim; ++k) {
    stride /= n;
    sweep_lanes<n, true>(tables + (dim - 1 - k) * of_line, stride, face * L / stride, data);
  }
}

template <typename Number>
DOVETAIL_PART_OF_CALLER void solve_any(const unsigned int dim, const std::size_t n,
                                       const Number *const tables, Number *const data)
{
  if (n == 3)
    solve_in_cells<3>(dim, tables, data);
  else if (n == 4)
    solve_in_cells<4>(dim, tables, data);
  else
    solve_in_cells<5>(dim, tables, data);
}

// not templates, of which clang makes no versions
DOVETAIL_WIDEST_VECTORS void run_solve(const unsigned int dim, const std::size_t n,
                                       const double *const tables, double *const data)
{
  solve_any(dim, n, tables, data);
}

DOVETAIL_WIDEST_VECTORS void run_solve(const unsigned int dim, const std::size_t n, const float *const tables,
                                       float *const data)
{
  solve_any(dim, n, tables, data);
}

} // namespace

template <typename Number>
void CellSolvesIn<Number>::add_solutions(const double *const r, double *const z) const
{
  std::vector<LanesOf<Number>> data(n_nodes);
  const int *numbers = index->data();
  const std::size_t n_tables = all.size() / size_of_component;
  for (std::size_t b = 0; b < n_tables; ++b) {
    const int *const first = numbers;
    for (LanesOf<Number> &number : data)
      for (unsigned int lane = 0; lane < Lanes::size; ++lane)
        number[lane] = static_cast<Number>(r[*numbers++]);
    run_solve(dim, n, all[b * size_of_component].values.data(), data[0].values.data());
    numbers = first;
    for (const LanesOf<Number> &number : data)
      for (unsigned int lane = 0; lane < Lanes::size; ++lane)
        z[*numbers++] += static_cast<double>(number[lane]);
  }
}

template class CellSolvesIn<double>;
template class CellSolvesIn<float>;

} // namespace dovetail
