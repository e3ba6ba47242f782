// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "aggregate_products.h"

#include <dovetail/widest_vectors.h>

#include <Epetra_CrsGraph.h>
#include <Epetra_Export.h>
#include <Epetra_Import.h>
#include <Epetra_IntVector.h>
#include <Epetra_Map.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

namespace dovetail {

namespace {

/// y += a x
template <typename Length>
DOVETAIL_PART_OF_CALLER void add_multiple(const double a, const double *DEAL_II_RESTRICT x,
                                          double *DEAL_II_RESTRICT y, const Length length)
{
  for (int k = 0; k < length; ++k)
    y[k] += a * x[k];
}

constexpr int most_rows = 6; ///< that are multiplied at a time

/// Adds to each block of @p n_rows rows the products of factors and what the block has in one row.
DOVETAIL_WIDEST_VECTORS void add_to_blocks(const int n_rows, const int length, const double *const factors,
                                           const int n_blocks, const std::size_t *const blocks,
                                           const double *const row, double *const sums)
{
  with_known_number(
      length, [&](const auto n) __attribute__((always_inline)) {
        for (int b = 0; b < n_blocks; ++b)
          for (int r = 0; r < n_rows; ++r)
            add_multiple(factors[r], row + b * n, sums + blocks[b] + r * n, n);
      });
}

/// Sums of sparse rows whose entries come in blocks of the same length, for some rows at a time.
class ProductRows
{
public:
  ProductRows(const unsigned int n_columns, const int length) : length(length), position(n_columns, none) {}

  void clear(int number_of_rows);
  /// Adds to each of the sums its factor times a row whose blocks begin at columns that are multiples of
  /// their length.
  void add(const double *factors, const SparseRow &row);

  /// What sum @p r has in the block with this first column.
  const double *block(const int first_column, const int r) const ///< nullptr: none
  {
    const std::size_t first = position[first_column];
    return first == none ? nullptr : &entries[first + r * length];
  }

  int n_rows = 0;
  std::vector<int> blocks;     ///< first columns
  std::vector<double> entries; ///< block by block those of all sums

private:
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  const int length;
  std::vector<std::size_t> position; ///< by first column, in the entries
  std::vector<std::size_t> places;
};

void ProductRows::clear(const int number_of_rows)
{
  n_rows = number_of_rows;
  for (const int column : blocks)
    position[column] = none;
  blocks.clear();
  entries.clear();
}

void ProductRows::add(const double *const factors, const SparseRow &row)
{
  places.clear();
  for (int k = 0; k < row.n; k += length) {
    Assert(row.columns[k + length - 1] == row.columns[k] + length - 1, dealii::ExcInternalError());
    std::size_t &first = position[row.columns[k]];
    if (first == none) {
      first = entries.size();
      blocks.push_back(row.columns[k]);
      entries.resize(first + n_rows * length, 0.);
    }
    places.push_back(first);
  }
  add_to_blocks(n_rows, length, factors, places.size(), places.data(), row.values, entries.data());
}

/// The rows of P for the columns of A: P itself if this rank owns them. The columns of an aggregate follow
/// each other, also those of other ranks, which Epetra may else leave in any order.
std::shared_ptr<const Epetra_CrsMatrix> rows_for_columns(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &P)
{
  if (A.Importer() == nullptr)
    return {&P, [](const Epetra_CrsMatrix *) {}};
  auto result = std::make_shared<Epetra_CrsMatrix>(Copy, A.ColMap(), P.MaxNumEntries());
  result->Import(P, *A.Importer(), Insert);
  result->SortGhostsAssociatedWithEachProcessor(true);
  result->FillComplete(P.DomainMap(), P.RangeMap());
  return result;
}

/// The rows of T for the columns of A, each of which is one block. The columns of T are those of this rank,
/// and after them those of other ranks that it needs, in ascending order.
class TentativeRows
{
public:
  /// @param aggregates by reference
  TentativeRows(const Epetra_CrsMatrix &A, const Aggregation &aggregates);

  SparseRow operator[](const int column) const
  {
    const int first = first_column[column];
    return first < 0 ? SparseRow()
                     : SparseRow{n_modes, &numbers[first], basis + std::size_t(column) * n_modes};
  }
  const Epetra_Map &own() const { return own_columns; }
  const Epetra_Map &columns() const { return all_columns; }

private:
  void add_other_ranks(const Epetra_CrsMatrix &A, const Aggregation &aggregates);

  const int n_modes;
  const Epetra_Map own_columns;
  Epetra_Map all_columns;
  std::vector<int> first_column; ///< by column of A; negative: none
  std::vector<int> numbers;      ///< of all columns: 0, 1, 2, ...
  std::vector<double> imported;
  const double *basis;
};

TentativeRows::TentativeRows(const Epetra_CrsMatrix &A, const Aggregation &aggregates)
    : n_modes(aggregates.modes->NumVectors()), own_columns(-1, aggregates.modes->MyLength(), 0, A.Comm()),
      all_columns(own_columns), basis(aggregates.basis.data())
{
  if (A.Importer() != nullptr)
    add_other_ranks(A, aggregates);
  else
    for (const int aggregate : aggregates.of_row)
      first_column.push_back(aggregate < 0 ? -1 : aggregate * n_modes);
  numbers.resize(all_columns.NumMyElements());
  std::iota(numbers.begin(), numbers.end(), 0);
}

void TentativeRows::add_other_ranks(const Epetra_CrsMatrix &A, const Aggregation &aggregates)
{
  Epetra_IntVector of_rows(A.RowMap()), of_columns(A.ColMap());
  Epetra_MultiVector basis_of_rows(A.RowMap(), n_modes), basis_of_columns(A.ColMap(), n_modes);
  for (int row = 0; row < A.NumMyRows(); ++row) {
    const int aggregate = aggregates.of_row[row];
    of_rows[row] = aggregate < 0 ? -1 : own_columns.GID(aggregate * n_modes);
    for (int mode = 0; mode < n_modes; ++mode)
      basis_of_rows[mode][row] = aggregates.basis[std::size_t(row) * n_modes + mode];
  }
  of_columns.Import(of_rows, *A.Importer(), Insert);
  basis_of_columns.Import(basis_of_rows, *A.Importer(), Insert);
  std::set<int> others;
  for (int column = 0; column < A.NumMyCols(); ++column)
    if (of_columns[column] >= 0 && !own_columns.MyGID(of_columns[column]))
      others.insert(of_columns[column]);
  std::vector<int> all(own_columns.MyGlobalElements(),
                       own_columns.MyGlobalElements() + own_columns.NumMyElements());
  for (const int first : others)
    for (int mode = 0; mode < n_modes; ++mode)
      all.push_back(first + mode);
  all_columns = Epetra_Map(-1, static_cast<int>(all.size()), all.data(), 0, A.Comm());
  imported.resize(std::size_t(A.NumMyCols()) * n_modes);
  for (int column = 0; column < A.NumMyCols(); ++column) {
    first_column.push_back(of_columns[column] < 0 ? -1 : all_columns.LID(of_columns[column]));
    for (int mode = 0; mode < n_modes; ++mode)
      imported[std::size_t(column) * n_modes + mode] = basis_of_columns[mode][column];
  }
  basis = imported.data();
}

/// How many rows from @p row on have the same columns.
int rows_alike(const SparseRows &rows, const int row, const int n_rows)
{
  const SparseRow first = rows[row];
  int n = 1;
  for (; n < most_rows && row + n < n_rows; ++n)
    if (const SparseRow other = rows[row + n];
        !std::equal(first.columns, first.columns + first.n, other.columns, other.columns + other.n))
      break;
  return n;
}

/// Calls @p visit(row, sums) with the own rows of A Q: those from a row on that have the same columns in A.
template <typename Rows, typename Visit>
void for_rows_of_product(const SparseRows &rows_of_A, const int n_rows, const Rows &rows_of_Q,
                         const int n_columns, const int block_length, const Visit &visit)
{
  ProductRows sums(n_columns, block_length);
  std::array<double, most_rows> factors{};
  for (int row = 0; row < n_rows; row += sums.n_rows) {
    sums.clear(rows_alike(rows_of_A, row, n_rows));
    const SparseRow entries = rows_of_A[row];
    for (int k = 0; k < entries.n; ++k) {
      bool is_zero = true;
      for (int r = 0; r < sums.n_rows; ++r) {
        factors[r] = rows_of_A[row + r].values[k];
        is_zero = is_zero && factors[r] == 0;
      }
      if (!is_zero)
        sums.add(factors.data(), rows_of_Q[entries.columns[k]]);
    }
    visit(row, sums);
  }
}

/// The column of the diagonal.
int own_column(const Epetra_CrsMatrix &A, const int row)
{
  return A.Importer() == nullptr ? row : A.LCID(A.GRID(row)); // which takes longer
}

/// The columns of A T and T, where a row of T has one block. In a matrix that is made of its graph values are
/// held once; those that are inserted are copied when it is filled.
Epetra_CrsGraph graph_of_product(const Epetra_CrsMatrix &A, const SparseRows &near, const TentativeRows &T,
                                 const int block_length)
{
  std::vector<int> blocks, last_row(T.columns().NumMyElements(), -1), lengths(A.NumMyRows(), 0), columns;
  for (int row = 0; row < A.NumMyRows(); ++row) {
    const SparseRow entries = near[row];
    const std::size_t first_block = blocks.size();
    const auto see = [&](const int column) {
      if (const SparseRow other = T[column]; other.n > 0 && last_row[other.columns[0]] != row) {
        last_row[other.columns[0]] = row;
        blocks.push_back(other.columns[0]);
      }
    };
    for (int k = 0; k < entries.n; ++k)
      see(entries.columns[k]);
    see(own_column(A, row));
    std::sort(blocks.begin() + first_block, blocks.end());
    lengths[row] = (blocks.size() - first_block) * block_length;
  }
  Epetra_CrsGraph graph(Copy, A.RowMap(), T.columns(), lengths.data(), true);
  auto block = blocks.cbegin();
  for (int row = 0; row < A.NumMyRows(); ++row) {
    columns.clear();
    for (; static_cast<int>(columns.size()) < lengths[row]; ++block)
      for (int i = 0; i < block_length; ++i)
        columns.push_back(*block + i);
    graph.InsertMyIndices(row, columns.size(), columns.data());
  }
  graph.FillComplete(T.own(), A.OperatorDomainMap());
  graph.OptimizeStorage();
  return graph;
}

/// Where a block of a sum of p^T q is.
struct BlockPlace
{
  int k;             ///< where its rows begin in p
  std::size_t l;     ///< where its columns begin in the first row of q
  int row;           ///< first one
  std::size_t first; ///< in the entries of the row
  double *entries;
};

DOVETAIL_WIDEST_VECTORS void add_products(const int n_rows, const int length, const SparseRow *const p,
                                          const double *const q, const BlockPlace *const begin,
                                          const BlockPlace *const end)
{
  with_known_number(
      length, [&](const auto n) __attribute__((always_inline)) {
        for (const BlockPlace *place = begin; place < end; ++place)
          for (int r = 0; r < n_rows; ++r)
            for (int i = 0; i < n; ++i)
              add_multiple(p[r].values[place->k + i], q + place->l + r * n, place->entries + i * n, n);
      });
}

/// The blocks of a symmetric matrix on and above the diagonal, as sums.
class BlockSums
{
public:
  /// @param numbers global ones of the rows and columns
  BlockSums(const Epetra_Map &numbers, const int length)
      : numbers(numbers.MyGlobalElements()), length(length), rows(numbers.NumMyElements())
  {
  }

  /// Adds p_r^T q_r for all rows r of @p q.
  void add(const std::array<SparseRow, most_rows> &p, const ProductRows &q);
  /// Calls @p visit(row, column, entries) with the first row and column of each block.
  template <typename Visit>
  void for_blocks(const Visit &visit) const;

private:
  struct Row
  {
    std::vector<int> blocks; ///< first columns
    std::vector<double> entries;
  };
  void find_places(const SparseRow &p, const ProductRows &q);

  const int *const numbers;
  const int length;
  std::vector<Row> rows;                    ///< by first row of a block
  std::vector<int> last_rows, last_columns; ///< of the last sum
  int last_n_rows = 0;                      ///< likewise
  std::vector<BlockPlace> places;           ///< likewise
};

/// The rows of a node have the same ones.
void BlockSums::find_places(const SparseRow &p, const ProductRows &q)
{
  if (last_n_rows == q.n_rows && last_columns == q.blocks &&
      std::equal(last_rows.begin(), last_rows.end(), p.columns, p.columns + p.n))
    return;
  last_n_rows = q.n_rows;
  last_rows.assign(p.columns, p.columns + p.n);
  last_columns = q.blocks;
  places.clear();
  const std::size_t n_entries = length * length;
  for (int k = 0; k < p.n; k += length) {
    Row &row = rows[p.columns[k]];
    for (std::size_t b = 0; b < q.blocks.size(); ++b) {
      if (numbers[p.columns[k]] > numbers[q.blocks[b]])
        continue;
      const auto found = std::find(row.blocks.begin(), row.blocks.end(), q.blocks[b]);
      places.push_back(
          {k, b * q.n_rows * length, p.columns[k], (found - row.blocks.begin()) * n_entries, nullptr});
      if (found == row.blocks.end()) {
        row.blocks.push_back(q.blocks[b]);
        row.entries.resize(row.entries.size() + n_entries, 0.);
      }
    }
  }
  for (BlockPlace &place : places) // which do not move any more
    place.entries = &rows[place.row].entries[place.first];
}

void BlockSums::add(const std::array<SparseRow, most_rows> &p, const ProductRows &q)
{
  for (int begin = 0, end = 0; begin < q.n_rows; begin = end) { // rows of P with the same columns
    const SparseRow &first = p[begin];
    while (end < q.n_rows &&
           std::equal(first.columns, first.columns + first.n, p[end].columns, p[end].columns + p[end].n))
      ++end;
    find_places(first, q);
    add_products(end - begin, length, &p[begin], q.entries.data() + begin * length, places.data(),
                 places.data() + places.size());
  }
}

template <typename Visit>
void BlockSums::for_blocks(const Visit &visit) const
{
  for (unsigned int r = 0; r < rows.size(); ++r)
    for (unsigned int b = 0; b < rows[r].blocks.size(); ++b)
      visit(r, rows[r].blocks[b], &rows[r].entries[b * length * length]);
}

/// With the blocks below the diagonal, too. Rows and columns are those of P that this rank needs.
std::unique_ptr<Epetra_CrsMatrix> make_matrix(const BlockSums &sums, const Epetra_Map &rows,
                                              const Epetra_Map &own, const int length)
{
  std::vector<int> lengths(rows.NumMyElements(), 0), indices(length);
  sums.for_blocks([&](const int row, const int column, const double *) {
    for (int i = 0; i < length; ++i) {
      lengths[row + i] += length;
      lengths[column + i] += row == column ? 0 : length;
    }
  });
  Epetra_CrsGraph graph(Copy, rows, rows, lengths.data(), true);
  const auto insert = [&](const int row, const int column) {
    std::iota(indices.begin(), indices.end(), column);
    for (int i = 0; i < length; ++i)
      graph.InsertMyIndices(row + i, length, indices.data());
  };
  sums.for_blocks([&](const int row, const int column, const double *) {
    insert(row, column);
    if (row != column)
      insert(column, row);
  });
  graph.FillComplete(own, own);
  graph.OptimizeStorage();
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, graph);
  const auto set = [&](const int row, const int column, const auto &entry) {
    for (int i = 0; i < length; ++i) {
      int n = 0, *columns = nullptr;
      double *values = nullptr;
      result->ExtractMyRowView(row + i, n, values, columns);
      double *const block = values + (std::lower_bound(columns, columns + n, column) - columns);
      for (int j = 0; j < length; ++j)
        block[j] = entry(i, j);
    }
  };
  sums.for_blocks([&](const int row, const int column, const double *entries) {
    set(row, column, [&](const int i, const int j) { return entries[i * length + j]; });
    if (row != column)
      set(column, row, [&](const int i, const int j) { return entries[j * length + i]; });
  });
  return result;
}

/// A matrix of the sums of all ranks. A row without entries, of a vector of a basis that is zero, gets one.
std::unique_ptr<Epetra_CrsMatrix> complete(std::unique_ptr<Epetra_CrsMatrix> result, const Epetra_Map &all,
                                           const Epetra_Map &own)
{
  result->FillComplete(own, own);
  if (!all.SameAs(own)) {
    auto sum = std::make_unique<Epetra_CrsMatrix>(Copy, own, result->MaxNumEntries());
    sum->Export(*result, Epetra_Export(all, own), Add);
    sum->FillComplete(own, own);
    result = std::move(sum);
  }
  Epetra_Vector diagonal(own);
  result->ExtractDiagonalCopy(diagonal);
  for (int row = 0; row < diagonal.MyLength(); ++row)
    if (diagonal[row] == 0)
      diagonal[row] = 1;
  result->ReplaceDiagonalValues(diagonal);
  return result;
}

} // namespace

std::unique_ptr<Epetra_CrsMatrix> smooth_bases(const Epetra_CrsMatrix &A, const SparseRows &near,
                                               const Aggregation &aggregates, const double w)
{
  const int length = aggregates.modes->NumVectors();
  const TentativeRows T(A, aggregates);
  Epetra_Vector diagonal(A.RowMap());
  LevelEntries(A).diagonal(diagonal);
  auto P = std::make_unique<Epetra_CrsMatrix>(Copy, graph_of_product(A, near, T, length));
  const int n_columns = T.columns().NumMyElements();
  for_rows_of_product(near, A.NumMyRows(), T, n_columns, length, [&](const int first_row, ProductRows &sums) {
    for (int r = 0; r < sums.n_rows; ++r) {
      const int row = first_row + r;
      const double factor = diagonal[row] > 0 ? -w / diagonal[row] : 0;
      const SparseRow own = T[own_column(A, row)];
      int n = 0, *columns = nullptr;
      double *values = nullptr;
      P->ExtractMyRowView(row, n, values, columns);
      for (int k = 0; k < n; k += length) {
        const double *const block = sums.block(columns[k], r);
        for (int i = 0; i < length; ++i)
          values[k + i] = (block == nullptr ? 0 : factor * block[i]) +
                          (own.n > 0 && own.columns[0] == columns[k] ? own.values[i] : 0);
      }
    }
  });
  P->FillComplete(T.own(), A.OperatorDomainMap());
  return P;
}

Cycle::MakeMatrix sum_coarse_matrix(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &P,
                                    const int block_length)
{
  const auto Q = rows_for_columns(A, P);
  const Epetra_Map all = Q->ColMap(), own = P.DomainMap();
  const SparseRows rows_of_Q(*Q);
  auto sums = std::make_shared<BlockSums>(all, block_length);
  for_rows_of_product(SparseRows(A), A.NumMyRows(), rows_of_Q, Q->NumMyCols(), block_length,
                      [&](const int row, const ProductRows &product) {
                        std::array<SparseRow, most_rows> own_rows;
                        for (int r = 0; r < product.n_rows; ++r)
                          own_rows[r] = rows_of_Q[own_column(A, row + r)];
                        sums->add(own_rows, product);
                      });
  return [sums, all, own, block_length]() mutable {
    auto result = make_matrix(*sums, all, own, block_length);
    sums.reset();
    return complete(std::move(result), all, own);
  };
}

} // namespace dovetail
