// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "aggregate_products.h"

#include <dovetail/solve/rows_of_other_ranks.h>
#include <dovetail/widest_vectors.h>

#include <deal.II/base/mpi.h>

#include <boost/serialization/utility.hpp>
#include <boost/serialization/vector.hpp>

#include <Epetra_CrsGraph.h>
#include <Epetra_IntVector.h>
#include <Epetra_Map.h>
#include <Epetra_MpiComm.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <map>
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

/// The rows of P for the columns of A. Those of this rank are P itself, and those of other ranks are
/// imported. The columns are those of P, and after them those that only other ranks' rows have. The columns
/// of an aggregate follow each other.
class ProlongationRows
{
public:
  ProlongationRows(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &P, int block_length);

  SparseRow operator[](const int column_of_A) const
  {
    if (place.empty())
      return own[column_of_A];
    const int k = place[column_of_A];
    if (k >= 0)
      return own[k];
    const std::size_t first = begin[-k - 1];
    return {static_cast<int>(begin[-k] - first), &columns[first], &values[first]};
  }
  const std::vector<int> &global_columns() const { return globals; }

private:
  void import_rows(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &P, int block_length);

  const SparseRows own;
  std::vector<int> globals;
  std::vector<int> place;         ///< by column of A: own row, or -1 - number of an imported row; empty: own
  std::vector<std::size_t> begin; ///< of the imported rows
  std::vector<int> columns;
  std::vector<double> values;
};

ProlongationRows::ProlongationRows(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &P,
                                   const int block_length)
    : own(P), globals(P.ColMap().MyGlobalElements(), P.ColMap().MyGlobalElements() + P.NumMyCols())
{
  if (A.Importer() != nullptr)
    import_rows(A, P, block_length);
}

void ProlongationRows::import_rows(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &P,
                                   const int block_length)
{
  std::vector<int> others;
  for (int column = 0; column < A.NumMyCols(); ++column) {
    place.push_back(A.LRID(A.GCID(column)));
    if (place.back() < 0) {
      others.push_back(A.GCID(column));
      place.back() = -static_cast<int>(others.size());
    }
  }
  std::map<int, int> further; // numbers of columns that P does not have here
  begin.push_back(0);
  const auto read = [&](const int row, std::vector<int> &numbers, std::vector<double> &weights) {
    const SparseRow own_row = own[row];
    weights.assign(own_row.values, own_row.values + own_row.n);
    numbers.clear();
    for (int k = 0; k < own_row.n; ++k)
      numbers.push_back(P.GCID(own_row.columns[k]));
  };
  for (const auto &[indices, entries] : rows_of_other_ranks(P.RowMap(), others, read)) {
    for (unsigned int k = 0; k < indices.size(); k += block_length) {
      int first = P.LCID(indices[k]);
      if (first < 0) {
        first = further.emplace(indices[k], globals.size()).first->second;
        if (first == static_cast<int>(globals.size()))
          globals.insert(globals.end(), indices.begin() + k, indices.begin() + k + block_length);
      }
      for (int i = 0; i < block_length; ++i)
        columns.push_back(first + i);
    }
    values.insert(values.end(), entries.begin(), entries.end());
    begin.push_back(values.size());
  }
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

/// The columns of A T and T, where a row of T has one block. In a matrix that is made of its graph values are
/// held once; those that are inserted are copied when it is filled.
Epetra_CrsGraph graph_of_product(const Epetra_CrsMatrix &A, const SparseRows &near, const TentativeRows &T,
                                 const std::vector<int> &own_columns, const int block_length)
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
    see(own_columns[row]);
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
  BlockSums(const std::vector<int> &numbers, const int length)
      : numbers(numbers), length(length), rows(numbers.size())
  {
  }

  /// Adds p_r^T q_r for all rows r of @p q.
  void add(const std::array<SparseRow, most_rows> &p, const ProductRows &q);
  /// Calls @p visit(row, column, entries) with the first row and column of each block.
  template <typename Visit>
  void for_blocks(const Visit &visit) const;
  /// Adds what the sums of other ranks have in the rows and columns of this one, which are the first of the
  /// numbers. What is in none of these does not count any more. Collective.
  void add_other_ranks(const Epetra_Map &own);
  const std::vector<int> &global_numbers() const { return numbers; }

private:
  /// Of blocks one after the other: global numbers of first rows and columns, and entries.
  using Message = std::pair<std::vector<int>, std::vector<double>>;

  struct Row
  {
    std::vector<int> blocks; ///< first columns
    std::vector<double> entries;
  };
  void find_places(const SparseRow &p, const ProductRows &q);
  std::map<unsigned int, Message> messages(const Epetra_Map &own) const;
  std::size_t place_of_block(int row, int column);

  std::vector<int> numbers;
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
  for (int k = 0; k < p.n; k += length) {
    for (std::size_t b = 0; b < q.blocks.size(); ++b) {
      if (numbers[p.columns[k]] > numbers[q.blocks[b]])
        continue;
      places.push_back(
          {k, b * q.n_rows * length, p.columns[k], place_of_block(p.columns[k], q.blocks[b]), nullptr});
    }
  }
  for (BlockPlace &place : places) // which do not move any more
    place.entries = &rows[place.row].entries[place.first];
}

/// In the entries of the row.
std::size_t BlockSums::place_of_block(const int row, const int column)
{
  Row &sums = rows[row];
  const auto found = std::find(sums.blocks.begin(), sums.blocks.end(), column);
  const std::size_t place = (found - sums.blocks.begin()) * static_cast<std::size_t>(length * length);
  if (found == sums.blocks.end()) {
    sums.blocks.push_back(column);
    sums.entries.resize(place + length * length, 0.);
  }
  return place;
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

/// To the ranks that own the rows or the columns of blocks.
std::map<unsigned int, BlockSums::Message> BlockSums::messages(const Epetra_Map &own) const
{
  const int n_own = own.NumMyElements(), n_others = numbers.size() - n_own, this_rank = own.Comm().MyPID();
  std::vector<int> rank(n_others), local(n_others);
  own.RemoteIDList(n_others, numbers.data() + n_own, rank.data(), local.data());
  const auto rank_of = [&](const int number) { return number < n_own ? this_rank : rank[number - n_own]; };
  std::map<unsigned int, Message> result;
  for_blocks([&](const int row, const int column, const double *const entries) {
    const int of_row = rank_of(row), of_column = rank_of(column);
    const auto send = [&](const int receiver) {
      auto &[places, values] = result[receiver];
      places.insert(places.end(), {numbers[row], numbers[column]});
      values.insert(values.end(), entries, entries + length * length);
    };
    if (of_row != this_rank)
      send(of_row);
    if (of_column != this_rank && of_column != of_row)
      send(of_column);
  });
  return result;
}

void BlockSums::add_other_ranks(const Epetra_Map &own)
{
  const int n_own = own.NumMyElements();
  std::map<int, int> others; // by global number
  for (int k = n_own; k < static_cast<int>(numbers.size()); k += length)
    others.emplace(numbers[k], k);
  const auto number = [&](const int global) {
    if (const int here = own.LID(global); here >= 0)
      return here;
    const auto [found, is_new] = others.emplace(global, numbers.size());
    for (int i = 0; is_new && i < length; ++i)
      numbers.push_back(global + i);
    rows.resize(numbers.size());
    return found->second;
  };
  const MPI_Comm communicator = dynamic_cast<const Epetra_MpiComm &>(own.Comm()).Comm();
  for (const auto &received : dealii::Utilities::MPI::some_to_some(communicator, messages(own))) {
    const auto &[places, values] = received.second;
    for (std::size_t b = 0; 2 * b < places.size(); ++b) {
      const int row = number(places[2 * b]), column = number(places[2 * b + 1]);
      const std::size_t place = place_of_block(row, column);
      for (int k = 0; k < length * length; ++k)
        rows[row].entries[place + k] += values[b * length * length + k];
    }
  }
}

/// Of the rows of this rank, with the blocks below the diagonal, too.
/// @param number of the columns by that of the sums: first those of this rank
std::unique_ptr<Epetra_CrsMatrix> make_matrix(const BlockSums &sums, const Epetra_Map &own,
                                              const Epetra_Map &columns, const std::vector<int> &number,
                                              const int length)
{
  const int n_own = own.NumMyElements();
  std::vector<int> lengths(n_own, 0), indices(length);
  const auto for_all = [&](const auto &visit) { // by number of a row and a column, and as they are summed
    sums.for_blocks([&](const int row, const int column, const double *const entries) {
      if (row < n_own)
        visit(row, number[column], [&](const int i, const int j) { return entries[i * length + j]; });
      if (row != column && column < n_own)
        visit(column, number[row], [&](const int i, const int j) { return entries[j * length + i]; });
    });
  };
  for_all([&](const int row, int, const auto &) {
    for (int i = 0; i < length; ++i)
      lengths[row + i] += length;
  });
  Epetra_CrsGraph graph(Copy, own, columns, lengths.data(), true);
  for_all([&](const int row, const int column, const auto &) {
    std::iota(indices.begin(), indices.end(), column);
    for (int i = 0; i < length; ++i)
      graph.InsertMyIndices(row + i, length, indices.data());
  });
  graph.FillComplete(own, own);
  graph.OptimizeStorage();
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, graph);
  for_all([&](const int row, const int column, const auto &entry) {
    for (int i = 0; i < length; ++i) {
      int n = 0, *columns_of_row = nullptr;
      double *values = nullptr;
      result->ExtractMyRowView(row + i, n, values, columns_of_row);
      double *const block =
          values + (std::lower_bound(columns_of_row, columns_of_row + n, column) - columns_of_row);
      for (int j = 0; j < length; ++j)
        block[j] = entry(i, j);
    }
  });
  result->FillComplete(own, own);
  return result;
}

/// Of the sums of all ranks. Columns of other ranks are in ascending order.
std::unique_ptr<Epetra_CrsMatrix> make_matrix(BlockSums &sums, const Epetra_Map &own, const int length)
{
  const int n_own = own.NumMyElements();
  std::vector<int> number(n_own);
  std::iota(number.begin(), number.end(), 0);
  if (own.Comm().NumProc() == 1)
    return make_matrix(sums, own, own, number, length);
  sums.add_other_ranks(own);
  const std::vector<int> &globals = sums.global_numbers();
  std::map<int, int> others; // that rows of this rank need, by global number
  sums.for_blocks([&](const int row, const int column, const double *) {
    for (const auto &[here, other] : {std::make_pair(row, column), std::make_pair(column, row)})
      if (here < n_own && other >= n_own)
        others.emplace(globals[other], other);
  });
  std::vector<int> all(own.MyGlobalElements(), own.MyGlobalElements() + n_own);
  number.resize(globals.size(), -1);
  for (const auto &[global, k] : others) {
    number[k] = all.size();
    for (int i = 0; i < length; ++i)
      all.push_back(global + i);
  }
  const Epetra_Map columns(-1, static_cast<int>(all.size()), all.data(), 0, own.Comm());
  return make_matrix(sums, own, columns, number, length);
}

/// A row without entries, of a vector of a basis that is zero, gets one.
void complete_diagonal(Epetra_CrsMatrix &A)
{
  Epetra_Vector diagonal(A.RowMap());
  LevelEntries(A).diagonal(diagonal);
  for (int row = 0; row < diagonal.MyLength(); ++row)
    if (diagonal[row] == 0)
      diagonal[row] = 1;
  A.ReplaceDiagonalValues(diagonal);
}

} // namespace

std::unique_ptr<Epetra_CrsMatrix> smooth_bases(const Epetra_CrsMatrix &A, const SparseRows &near,
                                               const Aggregation &aggregates, const double w)
{
  const int length = aggregates.modes->NumVectors();
  const TentativeRows T(A, aggregates);
  Epetra_Vector diagonal(A.RowMap());
  LevelEntries(A).diagonal(diagonal);
  const std::vector<int> own_columns = columns_of_rows(A);
  auto P = std::make_unique<Epetra_CrsMatrix>(Copy, graph_of_product(A, near, T, own_columns, length));
  const int n_columns = T.columns().NumMyElements();
  for_rows_of_product(near, A.NumMyRows(), T, n_columns, length, [&](const int first_row, ProductRows &sums) {
    for (int r = 0; r < sums.n_rows; ++r) {
      const int row = first_row + r;
      const double factor = diagonal[row] > 0 ? -w / diagonal[row] : 0;
      const SparseRow own = T[own_columns[row]];
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
  const ProlongationRows rows_of_P(A, P, block_length);
  const Epetra_Map own = P.DomainMap();
  auto sums = std::make_shared<BlockSums>(rows_of_P.global_columns(), block_length);
  const std::vector<int> own_columns = columns_of_rows(A);
  for_rows_of_product(SparseRows(A), A.NumMyRows(), rows_of_P, rows_of_P.global_columns().size(),
                      block_length, [&](const int row, const ProductRows &product) {
                        std::array<SparseRow, most_rows> own_rows;
                        for (int r = 0; r < product.n_rows; ++r)
                          own_rows[r] = rows_of_P[own_columns[row + r]];
                        sums->add(own_rows, product);
                      });
  return [sums, own, block_length]() mutable {
    auto result = make_matrix(*sums, own, block_length);
    sums.reset();
    complete_diagonal(*result);
    return result;
  };
}

} // namespace dovetail
