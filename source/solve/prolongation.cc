// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/prolongation.h>

#include <Epetra_Comm.h>
#include <Epetra_CrsGraph.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <unordered_map>

namespace dovetail {

namespace {

std::vector<int> columns_of_others(const Epetra_Map &rows, const Epetra_Map &domain,
                                   const Prolongation::ReadRow &read)
{
  std::set<int> others;
  if (domain.Comm().NumProc() == 1)
    return {};
  std::vector<int> columns;
  std::vector<double> weights;
  for (int row = 0; row < rows.NumMyElements(); ++row) {
    read(row, columns, weights);
    for (const int column : columns)
      if (!domain.MyGID(column))
        others.insert(column);
  }
  return {others.begin(), others.end()};
}

void read_row_of(const Epetra_CrsMatrix &P, const int row, std::vector<int> &columns,
                 std::vector<double> &weights)
{
  int n = 0, *local = nullptr;
  double *values = nullptr;
  P.ExtractMyRowView(row, n, values, local);
  weights.assign(values, values + n);
  columns.clear();
  for (int k = 0; k < n; ++k)
    columns.push_back(P.GCID(local[k]));
}

} // namespace

/// Adds rows, and finds what they share.
class Prolongation::Builder
{
public:
  explicit Builder(Prolongation &P) : P(P) {}
  void add(int row, const std::vector<int> &columns, const std::vector<double> &weights);

private:
  unsigned int find_weights();

  Prolongation &P;
  std::vector<int> offsets, last_offsets;
  std::vector<float> weights, last_weights;
  std::unordered_multimap<std::size_t, unsigned int> known; ///< short lists of weights, by their bytes
};

void Prolongation::Builder::add(const int row, const std::vector<int> &columns,
                                const std::vector<double> &given_weights)
{
  const int first_column = columns.empty() ? 0 : P.exchange.number(columns[0]);
  weights.assign(given_weights.begin(), given_weights.end());
  offsets.clear();
  for (const int column : columns)
    offsets.push_back(P.exchange.number(column) - first_column);
  const bool is_first = P.groups.empty(), has_same_offsets = !is_first && offsets == last_offsets,
             has_same_weights = !is_first && weights == last_weights;
  if (has_same_offsets && has_same_weights) {
    const Group &last = P.groups.back();
    if (columns.empty() || first_column == last.first_column + row - last.first_row)
      return;
  }
  Group group{0, 0, row, first_column};
  if (has_same_offsets)
    group.offsets = P.groups.back().offsets;
  else {
    group.offsets = P.offsets.size();
    P.offsets.push_back(offsets.size());
    P.offsets.insert(P.offsets.end(), offsets.begin(), offsets.end());
    std::swap(last_offsets, offsets);
  }
  group.first_weight = has_same_weights ? P.groups.back().first_weight : find_weights();
  std::swap(last_weights, weights);
  P.groups.push_back(group);
}

unsigned int Prolongation::Builder::find_weights()
{
  const unsigned int longest_known = 27;
  const auto add_list = [&]() {
    P.weights.insert(P.weights.end(), weights.begin(), weights.end());
    return P.weights.size() - weights.size();
  };
  if (weights.size() > longest_known)
    return add_list();
  std::size_t hash = weights.size();
  for (const float weight : weights) {
    unsigned int bits = 0;
    std::memcpy(&bits, &weight, sizeof(bits));
    hash = (hash ^ bits) * 0x9E3779B97F4A7C15u;
    hash ^= hash >> 29;
  }
  const auto [begin, end] = known.equal_range(hash);
  for (auto other = begin; other != end; ++other)
    if (other->second + weights.size() <= P.weights.size() &&
        std::equal(weights.begin(), weights.end(), P.weights.begin() + other->second))
      return other->second;
  return known.emplace(hash, add_list())->second;
}

Prolongation::Prolongation(const Epetra_Map &rows, const Epetra_Map &domain, const ReadRow &read)
    : range(rows), exchange(domain, columns_of_others(rows, domain, read))
{
  groups.reserve(rows.NumMyElements()); // what is not touched takes no memory
  Builder builder(*this);
  std::vector<int> columns;
  std::vector<double> row_weights;
  for (int row = 0; row < rows.NumMyElements(); ++row) {
    read(row, columns, row_weights);
    builder.add(row, columns, row_weights);
  }
}

Prolongation::Prolongation(const Epetra_CrsMatrix &P)
    : Prolongation(P.RowMap(), P.DomainMap(), [&P](const int row, auto &columns, auto &weights) {
        read_row_of(P, row, columns, weights);
      })
{
}

template <typename Visit>
void Prolongation::for_rows(const Visit &visit) const
{
  for (unsigned int g = 0; g < groups.size(); ++g) {
    const Group &group = groups[g];
    const int end_row = g + 1 < groups.size() ? groups[g + 1].first_row : range.NumMyElements();
    const int n = offsets[group.offsets], *const begin = offsets.data() + group.offsets + 1;
    const float *const factors = weights.data() + group.first_weight;
    for (int row = group.first_row; row < end_row; ++row)
      visit(row, group.first_column + row - group.first_row, n, begin, factors);
  }
}

void Prolongation::multiply(Epetra_Vector &y, const Epetra_Vector &x) const
{
  std::vector<double> buffer;
  const double *const of_columns = exchange.of_columns(x, buffer);
  for_rows([&](const int row, const int column, const int n, const int *offset, const float *weight) {
    double sum = 0;
    for (int k = 0; k < n; ++k)
      sum += static_cast<double>(weight[k]) * of_columns[column + offset[k]];
    y[row] = sum;
  });
}

void Prolongation::multiply_transposed(Epetra_Vector &y, const Epetra_Vector &x) const
{
  std::vector<double> sums(exchange.n_columns(), 0.);
  for_rows([&](const int row, const int column, const int n, const int *offset, const float *weight) {
    for (int k = 0; k < n; ++k)
      sums[column + offset[k]] += static_cast<double>(weight[k]) * x[row];
  });
  exchange.add_up(sums, y);
}

/// Of its graph, so that weights are held once.
std::unique_ptr<Epetra_CrsMatrix> Prolongation::matrix() const
{
  std::vector<int> lengths(range.NumMyElements()), columns;
  for_rows([&](const int row, int, const int n, const int *, const float *) { lengths[row] = n; });
  Epetra_CrsGraph graph(Copy, range, lengths.data(), true);
  const auto find_columns = [&](const int first, const int n, const int *offset) {
    columns.clear();
    for (int k = 0; k < n; ++k)
      columns.push_back(exchange.global(first + offset[k]));
  };
  for_rows([&](const int row, const int column, const int n, const int *offset, const float *) {
    find_columns(column, n, offset);
    graph.InsertGlobalIndices(range.GID(row), n, columns.data());
  });
  graph.FillComplete(domain(), range);
  graph.OptimizeStorage();
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, graph);
  std::vector<double> values;
  for_rows([&](const int row, const int column, const int n, const int *offset, const float *weight) {
    find_columns(column, n, offset);
    values.assign(weight, weight + n);
    result->SumIntoGlobalValues(range.GID(row), n, values.data(), columns.data());
  });
  result->FillComplete(domain(), range);
  return result;
}

std::size_t Prolongation::memory_consumption() const
{
  return groups.size() * sizeof(Group) + offsets.capacity() * sizeof(int) +
         weights.capacity() * sizeof(float);
}

Prolongation::Rows::Rows(const Prolongation &P) : P(P), group_of_row(P.range.NumMyElements())
{
  unsigned int group = 0;
  for (unsigned int row = 0; row < group_of_row.size(); ++row) {
    if (group + 1 < P.groups.size() && P.groups[group + 1].first_row == static_cast<int>(row))
      ++group;
    group_of_row[row] = group;
  }
}

Prolongation::Row Prolongation::Rows::operator[](const int row)
{
  const Group &group = P.groups[group_of_row[row]];
  const int n = P.offsets[group.offsets], *const offset = P.offsets.data() + group.offsets + 1;
  const float *const weight = P.weights.data() + group.first_weight;
  weights.assign(weight, weight + n);
  columns.resize(n);
  for (int k = 0; k < n; ++k)
    columns[k] = group.first_column + row - group.first_row + offset[k];
  return {n, columns.data(), weights.data()};
}

} // namespace dovetail
