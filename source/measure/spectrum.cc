// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/spectrum.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/full_matrix.h>

#include <boost/serialization/map.hpp>
#include <boost/serialization/utility.hpp>

#include <Teuchos_LAPACK.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

namespace {

using nlohmann::ordered_json;
using Matrix = dealii::FullMatrix<double>; // row by row; LAPACK sees the transpose
using Lapack = Teuchos::LAPACK<int, double>;

/// The matrix of a group on the first rank, and what is known of its unknowns.
struct Dense
{
  Matrix K;
  std::vector<bool> is_multiplier;
  unsigned int n() const { return K.m(); }
};

/// Eigenvalues of a symmetric matrix in increasing order; none if LAPACK fails.
std::vector<double> eigenvalues(Matrix A)
{
  const int n = A.m();
  std::vector<double> values(n), work(64 * n + 64);
  int info = 0;
  Lapack().SYEV('N', 'U', n, &A(0, 0), n, values.data(), work.data(), work.size(), &info);
  return info == 0 ? values : std::vector<double>();
}

/// Singular values in decreasing order.
std::vector<double> singular_values(Matrix A)
{
  const int n = A.m();
  std::vector<double> values(n), work(64 * n + 64);
  double unused = 0;
  int info = 0;
  Lapack().GESVD('N', 'N', n, n, &A(0, 0), n, values.data(), &unused, 1, &unused, 1, work.data(), work.size(),
                 nullptr, &info);
  return info == 0 ? values : std::vector<double>();
}

/// In decreasing order.
std::vector<double> absolute_values(std::vector<double> values)
{
  for (double &value : values)
    value = std::abs(value);
  std::sort(values.rbegin(), values.rend());
  return values;
}

/// The inverse by LU factorisation; false if there is none.
bool invert(Matrix &A)
{
  const int n = A.m();
  std::vector<int> pivots(n);
  std::vector<double> work(64 * n + 64);
  int info = 0;
  Lapack().GETRF(n, n, &A(0, 0), n, pivots.data(), &info);
  if (info == 0)
    Lapack().GETRI(n, &A(0, 0), n, pivots.data(), work.data(), work.size(), &info);
  return info == 0;
}

Matrix symmetric_part(const Matrix &A)
{
  Matrix result(A.m(), A.m());
  for (unsigned int i = 0; i < A.m(); ++i)
    for (unsigned int j = 0; j < A.m(); ++j)
      result(i, j) = (A(i, j) + A(j, i)) / 2;
  return result;
}

Matrix scaled(Matrix A, const std::vector<double> &factor)
{
  for (unsigned int i = 0; i < A.m(); ++i)
    for (unsigned int j = 0; j < A.m(); ++j)
      A(i, j) *= factor[i] * factor[j];
  return A;
}

/// D^-1/2
std::vector<double> scale(const Dense &dense)
{
  std::vector<double> factor(dense.n(), 1.);
  const auto set = [&](const unsigned int i, const double d) {
    if (d > 0 && std::isfinite(d))
      factor[i] = 1 / std::sqrt(d);
  };
  for (unsigned int i = 0; i < dense.n(); ++i)
    if (!dense.is_multiplier[i])
      set(i, std::abs(dense.K(i, i)));
  for (unsigned int i = 0; i < dense.n(); ++i)
    if (dense.is_multiplier[i]) {
      double sum = 0;
      for (unsigned int j = 0; j < dense.n(); ++j)
        if (!dense.is_multiplier[j])
          sum += std::pow(dense.K(i, j) * factor[j], 2);
      set(i, sum);
    }
  return factor;
}

/// The smallest of the values that @p largest gives for a matrix, through the largest of the inverse: in a
/// matrix whose entries differ by many orders the small ones are lost in the rounding of the large ones, but
/// not in the inverse of the scaled matrix.
template <typename Largest>
double smallest_by_inverse(Matrix scaled_matrix, const std::vector<double> &factor, const Largest &largest)
{
  if (!invert(scaled_matrix))
    return 0;
  return 1 / largest(scaled(scaled_matrix, factor));
}

bool is_symmetric(const Matrix &A)
{
  double difference = 0, largest = 0;
  for (unsigned int i = 0; i < A.m(); ++i)
    for (unsigned int j = 0; j < i; ++j) {
      difference = std::max(difference, std::abs(A(i, j) - A(j, i)));
      largest = std::max(largest, std::abs(A(i, j)));
    }
  return difference <= 1e-10 * largest;
}

ordered_json spectrum(const Dense &dense)
{
  ordered_json result;
  result["unknowns"] = dense.n();
  const std::vector<double> factor = scale(dense);
  const Matrix S = scaled(dense.K, factor), symmetric_S = symmetric_part(S);
  const bool symmetric = is_symmetric(S);
  result["symmetric"] = symmetric;
  const auto of_S = eigenvalues(symmetric_S), of_K = eigenvalues(symmetric_part(dense.K));
  if (of_S.empty() || of_K.empty())
    return result; // not finite
  const auto singular_of_K = symmetric ? absolute_values(of_K) : singular_values(dense.K);
  const auto singular_of_S = symmetric ? absolute_values(of_S) : singular_values(S);
  if (singular_of_K.empty() || singular_of_S.empty())
    return result;

  const auto largest_eigenvalue = [](const Matrix &A) {
    const auto values = eigenvalues(symmetric_part(A));
    return values.empty() ? std::numeric_limits<double>::infinity() : values.back();
  };
  const auto largest_singular_value = [symmetric](const Matrix &A) {
    const auto values = symmetric ? absolute_values(eigenvalues(symmetric_part(A))) : singular_values(A);
    return values.empty() ? std::numeric_limits<double>::infinity() : values[0];
  };
  const double smallest_eigenvalue =
      of_S[0] > 0 ? smallest_by_inverse(symmetric_S, factor, largest_eigenvalue) : of_K[0];
  const double smallest_singular_value =
      symmetric && of_S[0] > 0 ? smallest_eigenvalue : smallest_by_inverse(S, factor, largest_singular_value);
  result["smallest eigenvalue"] = smallest_eigenvalue;
  result["largest eigenvalue"] = of_K.back();
  result["condition number"] = singular_of_K[0] / smallest_singular_value;
  result["scaled smallest eigenvalue"] = of_S[0];
  result["scaled condition number"] = singular_of_S[0] / singular_of_S.back();
  const auto n_multipliers = std::count(dense.is_multiplier.begin(), dense.is_multiplier.end(), true);
  if (n_multipliers > 0) {
    result["multipliers"] = n_multipliers;
    result["negative eigenvalues"] =
        std::count_if(of_S.begin(), of_S.end(), [](const double value) { return value < 0; });
    result["smallest absolute eigenvalue"] = smallest_singular_value;
  }
  return result;
}

using Index = dealii::types::global_dof_index;
using Entries = std::map<std::pair<Index, Index>, double>; ///< by row and column

/// Of the rows of the group that this rank owns: the entries, and whether each row is taken by a constraint
/// or is of a multiplier that was dropped.
template <int dim>
void collect(const BlockSystem<dim> &system, const Numbering &numbering, const SolveGroup &group,
             Entries &entries, std::map<Index, bool> &rows)
{
  std::vector<unsigned int> blocks = group.blocks;
  blocks.insert(blocks.end(), group.multiplier_blocks.begin(), group.multiplier_blocks.end());
  const auto is_in_group = [&](const Index dof) {
    return std::find(blocks.begin(), blocks.end(), numbering.block_of(dof)) != blocks.end();
  };
  std::vector<Index> columns;
  std::vector<double> values;
  for (const Index row : numbering.owned)
    if (is_in_group(row)) {
      rows[row] = system.is_constrained(row) || system.is_dropped(row);
      system.tangent().extract_row(row, columns, values);
      for (unsigned int k = 0; k < columns.size(); ++k)
        if (values[k] != 0 && is_in_group(columns[k]))
          entries[{row, columns[k]}] = values[k];
    }
}

/// On the first rank.
template <int dim>
Dense gather(const BlockSystem<dim> &system, const Numbering &numbering, const SolveGroup &group,
             const MPI_Comm &communicator)
{
  Entries own_entries, entries;
  std::map<Index, bool> own_rows, is_left_out;
  collect(system, numbering, group, own_entries, own_rows);
  for (auto &rank_entries : dealii::Utilities::MPI::gather(communicator, own_entries))
    entries.merge(rank_entries);
  for (auto &rank_entries : dealii::Utilities::MPI::gather(communicator, own_rows))
    is_left_out.merge(rank_entries);

  const auto is_multiplier = [&](const Index row) {
    return numbering.blocks()[numbering.block_of(row)].is_of_multipliers;
  };

  Dense dense;
  std::map<Index, unsigned int> position;
  for (const auto &[row, left_out] : is_left_out)
    if (!left_out) {
      const unsigned int next = position.size();
      position[row] = next;
      dense.is_multiplier.push_back(is_multiplier(row));
    }
  if (position.size() > largest_spectrum) {
    dense.is_multiplier.clear();
    return dense;
  }
  dense.K.reinit(position.size(), position.size());
  for (const auto &[place, value] : entries) {
    const auto row = position.find(place.first), column = position.find(place.second);
    if (row != position.end() && column != position.end())
      dense.K(row->second, column->second) = value;
  }
  return dense;
}

} // namespace

template <int dim>
ordered_json measure_spectrum(const BlockSystem<dim> &system, const Numbering &numbering,
                              const std::vector<SolveGroup> &groups, const MPI_Comm &communicator,
                              std::vector<std::string> &left_out)
{
  const bool is_first = dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
  ordered_json result = ordered_json::object();
  for (const SolveGroup &group : groups) {
    unsigned long n_rows = 0;
    for (const unsigned int block : group.blocks)
      n_rows += numbering.blocks()[block].end - numbering.blocks()[block].begin;
    const BlockMatrix &tangent = system.tangent();
    if (tangent.part_operator(tangent.part_of(group.blocks.front())) != nullptr) {
      left_out.push_back("spectrum of " + group.name +
                         ": its matrix has no entries (Linear solver, Type = direct has them)");
      continue;
    }
    if (n_rows > 2 * largest_spectrum) { // hardly fewer without the constrained ones
      left_out.push_back("spectrum of " + group.name + ": " + std::to_string(n_rows) +
                         " unknowns are too many for LAPACK");
      continue;
    }
    const Dense dense = gather(system, numbering, group, communicator);
    bool is_left_out = is_first && dense.n() == 0;
    is_left_out = dealii::Utilities::MPI::max(static_cast<int>(is_left_out), communicator) != 0;
    if (is_left_out)
      left_out.push_back("spectrum of " + group.name + ": no unknowns, or more than " +
                         std::to_string(largest_spectrum));
    else if (is_first)
      result[group.name] = spectrum(dense);
  }
  return result;
}

template ordered_json measure_spectrum(const BlockSystem<2> &, const Numbering &,
                                       const std::vector<SolveGroup> &, const MPI_Comm &,
                                       std::vector<std::string> &);
template ordered_json measure_spectrum(const BlockSystem<3> &, const Numbering &,
                                       const std::vector<SolveGroup> &, const MPI_Comm &,
                                       std::vector<std::string> &);

} // namespace dovetail
