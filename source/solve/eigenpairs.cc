// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/eigenpairs.h>

#include <deal.II/lac/full_matrix.h>

#include <Teuchos_LAPACK.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace dovetail {

namespace {

using Column = EigenProblem::Column;
using Matrix = dealii::FullMatrix<double>;

const unsigned int n_at_once = 4; ///< vectors that the search begins with
const double tolerance = 1e-12;   ///< of a Ritz vector, relative to its value
const double dependent = 1e-11;   ///< a vector with so little of its own, relative to the largest value
const double largest_residual = 1e-7;
const unsigned int most_rounds = 60; ///< from restart to restart
/// Relative to the distance from the shift: what is nearer is one eigenvalue.
const double repeated = 1e-7;

/// Of a symmetric matrix, in increasing order; the rows of A become the eigenvectors.
std::vector<double> eigenvectors(Matrix &A)
{
  const int n = A.m();
  std::vector<double> values(n), work(64 * n + 64);
  int info = 0;
  if (n > 0)
    Teuchos::LAPACK<int, double>().SYEV('V', 'U', n, &A(0, 0), n, values.data(), work.data(), work.size(),
                                        &info);
  if (info != 0)
    throw std::runtime_error("LAPACK finds no eigenvalues");
  return values;
}

std::vector<double> products(const std::vector<Column> &all, const Column &x, const MPI_Comm &communicator)
{
  std::vector<double> result;
  for (const Column &y : all)
    result.push_back(std::inner_product(y.begin(), y.end(), x.begin(), 0.));
  dealii::Utilities::MPI::sum(result, communicator, result);
  return result;
}

void add(const double factor, const Column &y, Column &x)
{
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] += factor * y[i];
}

/// sum_k factors(row, k) columns[k]
Column combination(const Matrix &factors, const unsigned int row, const std::vector<Column> &columns,
                   const std::size_t n_own)
{
  Column result(n_own, 0.);
  for (unsigned int k = 0; k < factors.n(); ++k)
    add(factors(row, k), columns[k], result);
  return result;
}

/// A basis V with V^T M V = 1 that grows by what A = (K - shift M)^-1 M makes of its vectors, in order, and
/// H = V^T M A V. The vectors that have been multiplied are the first ones.
class Lanczos
{
public:
  Lanczos(const EigenProblem &problem, const unsigned int n)
      : problem(problem), n_wanted(n), largest_size(2 * n + 10 * n_at_once), n_own(problem.guides[0].size()),
        H(largest_size + n_at_once, largest_size + n_at_once)
  {
  }

  /// @return whether the wanted Ritz vectors have converged, or there are no more.
  bool search();

  std::vector<double> values;  ///< of A, the largest first
  std::vector<Column> vectors; ///< the Ritz vectors

private:
  double norm(const Column &x, Column &Mx) const;
  bool append(Column x, std::vector<double> &coefficients);
  bool begin_anew();
  void expand();
  bool have_converged();
  void restart();
  unsigned int n_found() const { return std::min<unsigned int>(n_wanted, ritz_values.size()); }

  const EigenProblem &problem;
  const unsigned int n_wanted, largest_size;
  const std::size_t n_own;
  std::vector<Column> basis, mass_basis;
  unsigned int n_multiplied = 0, n_starts = 0;
  double largest_value = 0; ///< of A, so far
  bool is_exhausted = false;
  Matrix H;
  std::vector<double> ritz_values; ///< of the multiplied part, the largest first
  Matrix ritz_vectors;             ///< rows
};

double Lanczos::norm(const Column &x, Column &Mx) const
{
  Mx = problem.mass(x);
  return std::sqrt(std::max(0., products({Mx}, x, problem.communicator)[0]));
}

/// What is left of x beside the basis becomes its next vector. @p coefficients: those of x on the basis, also
/// on the new vector. @return false if nothing is left.
bool Lanczos::append(Column x, std::vector<double> &coefficients)
{
  coefficients.assign(basis.size(), 0.);
  Column Mx;
  const double size = norm(x, Mx);
  largest_value = std::max(largest_value, size);
  const auto orthogonalise = [&](const double factor) {
    const std::vector<double> h = products(mass_basis, x, problem.communicator);
    for (unsigned int k = 0; k < h.size(); ++k) {
      coefficients[k] += factor * h[k];
      add(-h[k], basis[k], x);
    }
  };
  orthogonalise(1);
  orthogonalise(1);
  const double rest = norm(x, Mx);
  if (!(rest > dependent * largest_value))
    return false;
  for (double &entry : x)
    entry /= rest;
  orthogonalise(rest);
  const double again = norm(x, Mx);
  for (std::size_t i = 0; i < n_own; ++i) {
    x[i] /= again;
    Mx[i] /= again;
  }
  coefficients.push_back(rest * again);
  basis.push_back(std::move(x));
  mass_basis.push_back(std::move(Mx));
  return true;
}

/// With the next guide or, after those, a function that knows no partition either. Multiplied once, so that
/// nothing of it is without mass. @return false if the basis spans all there is.
bool Lanczos::begin_anew()
{
  const unsigned int most_attempts = 3, n_guides = problem.guides.size();
  for (unsigned int attempt = 0; attempt < most_attempts; ++attempt, ++n_starts) {
    Column x = problem.guides[n_starts % n_guides];
    if (n_starts >= n_guides)
      for (double &entry : x)
        entry = std::sin(1e4 * (n_starts + 1) * entry);
    Column Mx;
    const double size = norm(x, Mx);
    for (double &entry : x)
      entry /= size > 0 ? size : 1;
    std::vector<double> unused;
    if (append(problem.inverse(problem.mass(x)), unused)) {
      ++n_starts;
      return true;
    }
  }
  return false;
}

/// Multiply the next vector.
void Lanczos::expand()
{
  std::vector<double> column;
  append(problem.inverse(mass_basis[n_multiplied]), column);
  for (unsigned int k = 0; k < column.size(); ++k)
    H(k, n_multiplied) = H(n_multiplied, k) = column[k];
  ++n_multiplied;
}

bool Lanczos::have_converged()
{
  Matrix A(n_multiplied, n_multiplied);
  for (unsigned int i = 0; i < n_multiplied; ++i)
    for (unsigned int j = 0; j < n_multiplied; ++j)
      A(i, j) = H(i, j);
  const std::vector<double> all = eigenvectors(A);
  std::vector<unsigned int> order(n_multiplied);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](const unsigned int i, const unsigned int j) { return std::abs(all[i]) > std::abs(all[j]); });
  ritz_values.clear();
  ritz_vectors.reinit(n_multiplied, n_multiplied);
  for (unsigned int k = 0; k < n_multiplied; ++k) {
    ritz_values.push_back(all[order[k]]);
    for (unsigned int i = 0; i < n_multiplied; ++i)
      ritz_vectors(k, i) = A(order[k], i);
  }
  if (n_multiplied < n_wanted && !is_exhausted)
    return false;
  for (unsigned int k = 0; k < n_found(); ++k) {
    double square = 0;
    for (unsigned int row = n_multiplied; row < basis.size(); ++row) {
      double coupling = 0;
      for (unsigned int i = 0; i < n_multiplied; ++i)
        coupling += H(row, i) * ritz_vectors(k, i);
      square += coupling * coupling;
    }
    if (std::sqrt(square) > tolerance * std::abs(ritz_values[k]))
      return false;
  }
  return true;
}

/// The basis becomes the best Ritz vectors and those that have not been multiplied.
void Lanczos::restart()
{
  const unsigned int n_kept = std::min(n_wanted + 2 * n_at_once, n_multiplied),
                     n_rest = basis.size() - n_multiplied;
  std::vector<Column> kept, mass_kept;
  Matrix kept_H(H.m(), H.n());
  const std::vector<Column> multiplied(basis.begin(), basis.begin() + n_multiplied),
      mass_multiplied(mass_basis.begin(), mass_basis.begin() + n_multiplied);
  for (unsigned int k = 0; k < n_kept; ++k) {
    kept.push_back(combination(ritz_vectors, k, multiplied, n_own));
    mass_kept.push_back(combination(ritz_vectors, k, mass_multiplied, n_own));
    kept_H(k, k) = ritz_values[k];
    for (unsigned int row = 0; row < n_rest; ++row)
      for (unsigned int i = 0; i < n_multiplied; ++i)
        kept_H(n_kept + row, k) += H(n_multiplied + row, i) * ritz_vectors(k, i);
    for (unsigned int row = 0; row < n_rest; ++row)
      kept_H(k, n_kept + row) = kept_H(n_kept + row, k);
  }
  kept.insert(kept.end(), basis.begin() + n_multiplied, basis.end());
  mass_kept.insert(mass_kept.end(), mass_basis.begin() + n_multiplied, mass_basis.end());
  basis = std::move(kept);
  mass_basis = std::move(mass_kept);
  H = kept_H;
  n_multiplied = n_kept;
}

bool Lanczos::search()
{
  bool is_done = false;
  for (unsigned int n_first = 0; n_first < n_at_once && begin_anew();)
    ++n_first;
  for (unsigned int round = 0; round < most_rounds && !is_done; ++round) {
    while (basis.size() < largest_size && !is_exhausted && !is_done) {
      for (unsigned int k = 0; k < n_at_once && n_multiplied < basis.size(); ++k)
        expand();
      is_exhausted = n_multiplied == basis.size() && !begin_anew();
      is_done = have_converged();
    }
    is_done = is_done || is_exhausted;
    if (!is_done)
      restart();
  }
  have_converged();
  for (unsigned int k = 0; k < n_found(); ++k) {
    values.push_back(ritz_values[k]);
    vectors.push_back(combination(ritz_vectors, k, basis, n_own));
  }
  return is_done;
}

/// Rotate vectors first … end-1, which belong to one eigenvalue, so that each is next to a guide; a single
/// one gets its sign.
void choose_vectors(const EigenProblem &problem, const unsigned int first, const unsigned int end,
                    std::vector<Column> &vectors)
{
  const unsigned int n = end - first;
  const std::vector<Column> old(vectors.begin() + first, vectors.begin() + end);
  std::vector<std::vector<double>> on_guides; // of each guide the coefficients
  for (const Column &guide : problem.guides)
    on_guides.push_back(products(old, problem.mass(guide), problem.communicator));
  Matrix rotation(n, n);
  unsigned int n_chosen = 0;
  double largest = 0;
  for (auto &row : on_guides) {
    const auto length = [&]() {
      return std::sqrt(std::inner_product(row.begin(), row.end(), row.begin(), 0.));
    };
    largest = std::max(largest, length());
    for (unsigned int pass = 0; pass < 2; ++pass)
      for (unsigned int k = 0; k < n_chosen; ++k) {
        const double share = std::inner_product(row.begin(), row.end(), &rotation(k, 0), 0.);
        for (unsigned int i = 0; i < n; ++i)
          row[i] -= share * rotation(k, i);
      }
    const double size = length();
    if (n_chosen == n || !(size > 1e-3 * largest))
      continue;
    for (unsigned int i = 0; i < n; ++i)
      rotation(n_chosen, i) = row[i] / size;
    ++n_chosen;
  }
  if (n_chosen == n)
    for (unsigned int k = 0; k < n; ++k)
      vectors[first + k] = combination(rotation, k, old, old[0].size());
}

/// The pairs in the span of the columns, for which K and M are projected.
EigenPairs pairs_in_span(const EigenProblem &problem, std::vector<Column> columns)
{
  const unsigned int n = columns.size();
  const auto projected = [&](const EigenProblem::Product &product) {
    Matrix A(n, n);
    for (unsigned int j = 0; j < n; ++j) {
      const auto column = products(columns, product(columns[j]), problem.communicator);
      std::copy(column.begin(), column.end(), &A(j, 0));
    }
    for (unsigned int i = 0; i < n; ++i)
      for (unsigned int j = 0; j < i; ++j)
        A(i, j) = A(j, i) = (A(i, j) + A(j, i)) / 2;
    return A;
  };
  const auto combine = [&](const Matrix &factors) {
    std::vector<Column> combined;
    for (unsigned int k = 0; k < n; ++k)
      combined.push_back(combination(factors, k, columns, columns[k].size()));
    columns = std::move(combined);
  };
  EigenPairs result;
  if (n == 0)
    return result;
  Matrix M = projected(problem.mass);
  const std::vector<double> masses = eigenvectors(M);
  for (unsigned int k = 0; k < n; ++k)
    for (unsigned int i = 0; i < n; ++i)
      M(k, i) /= std::sqrt(masses[k]);
  combine(M);
  Matrix K = projected(problem.stiffness);
  result.values = eigenvectors(K);
  combine(K);
  result.vectors = std::move(columns);
  return result;
}

} // namespace

EigenPairs nearest_eigenpairs(const EigenProblem &problem, const unsigned int n)
{
  Lanczos lanczos(problem, n + n_at_once);
  const bool has_converged = lanczos.search();

  std::vector<Column> columns; // multiplied once more, which takes away what is far from the shift
  std::vector<std::pair<double, double>> residuals; // with the values
  for (unsigned int k = 0; k < lanczos.values.size(); ++k) {
    const double value = lanczos.values[k];
    columns.push_back(problem.inverse(problem.mass(lanczos.vectors[k])));
    for (double &entry : columns.back())
      entry /= value;
    Column difference = columns.back();
    add(-1, lanczos.vectors[k], difference);
    const double square = products({problem.mass(difference)}, difference, problem.communicator)[0];
    residuals.emplace_back(problem.shift + 1 / value, std::sqrt(std::max(0., square)));
  }
  EigenPairs result = pairs_in_span(problem, std::move(columns));
  std::sort(residuals.begin(), residuals.end());
  for (const auto &[value, residual] : residuals) { // an inverse of another matrix shows in the values alone
    const double difference = result.values[result.residuals.size()] - value;
    result.residuals.push_back(std::max(residual, std::abs(difference / (value - problem.shift))));
  }
  result.has_converged =
      has_converged && std::all_of(result.residuals.begin(), result.residuals.end(),
                                   [](const double residual) { return residual <= largest_residual; });
  for (unsigned int first = 0, end = 0; first < result.values.size(); first = end) {
    for (end = first + 1; end < result.values.size(); ++end)
      if (result.values[end] - result.values[end - 1] >
          repeated * std::abs(result.values[end] - problem.shift))
        break;
    choose_vectors(problem, first, end, result.vectors);
  }
  return result;
}

} // namespace dovetail
