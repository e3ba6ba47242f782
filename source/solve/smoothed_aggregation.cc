// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "smoothed_aggregation.h"

#include "aggregation.h"

#include <dovetail/solve/free_memory.h>

#include <deal.II/base/exceptions.h>

#include <Epetra_CrsGraph.h>
#include <Epetra_Export.h>
#include <Epetra_Import.h>
#include <Epetra_IntVector.h>
#include <Epetra_Map.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

namespace dovetail {

namespace {

/// Whether the rows of @p n components of a vector field follow each other, node by node: row i sees no
/// translation but that of component i % n. Each set of modes begins with the translations.
bool are_rows_by_node(const Epetra_MultiVector &modes, const int n)
{
  const int n_of_set = n * (n + 1) / 2; // with rotations
  int here = modes.NumVectors() % n_of_set == 0 && modes.MyLength() % n == 0;
  for (int mode = 0; here && mode < modes.NumVectors(); ++mode)
    for (int row = 0; mode % n_of_set < n && row < modes.MyLength(); ++row)
      here = here && (mode % n_of_set == row % n || modes[mode][row] == 0);
  int everywhere = 0;
  modes.Comm().MinAll(&here, &everywhere, 1);
  return everywhere != 0;
}

/// For aggregates that do not cut nodes.
int rows_per_node(const Epetra_MultiVector &modes)
{
  for (const int n : {3, 2})
    if (are_rows_by_node(modes, n))
      return n;
  return 1;
}

/// The entries of a row.
struct SparseRow
{
  int n = 0;
  const int *columns = nullptr;
  const double *values = nullptr;
};

/// Of a matrix that is complete.
class SparseRows
{
public:
  explicit SparseRows(const Epetra_CrsMatrix &A)
  {
    const int error = A.ExtractCrsDataPointers(begin, columns, values);
    AssertThrow(error == 0, dealii::ExcMessage("The rows of a matrix do not follow each other in memory."));
  }

  SparseRow operator[](const int row) const
  {
    return {begin[row + 1] - begin[row], columns + begin[row], values + begin[row]};
  }

private:
  int *begin = nullptr, *columns = nullptr;
  double *values = nullptr;
};

/// y += a x
template <typename Length>
inline void add_multiple(const double a, const double *DEAL_II_RESTRICT x, double *DEAL_II_RESTRICT y,
                         const Length length)
{
  for (int k = 0; k < length; ++k)
    y[k] += a * x[k];
}

/// A sum of sparse rows whose entries come in blocks of the same length.
class RowSum
{
public:
  RowSum(const unsigned int n_columns, const int length) : length(length), position(n_columns, none) {}

  void clear();
  /// Adds @p factor times a row whose blocks begin at columns that are multiples of their length.
  void add(double factor, const SparseRow &row);

  unsigned int place_of(const int first_column) const { return position[first_column]; } ///< in the entries

  std::vector<int> blocks; ///< first columns
  std::vector<double> entries;

private:
  static constexpr unsigned int none = std::numeric_limits<unsigned int>::max();
  const int length;
  std::vector<unsigned int> position; ///< by first column, in the entries
};

void RowSum::clear()
{
  for (const int column : blocks)
    position[column] = none;
  blocks.clear();
  entries.clear();
}

void RowSum::add(const double factor, const SparseRow &row)
{
  with_known_number(length, [&](const auto n) {
    for (int k = 0; k < row.n; k += n) {
      Assert(row.columns[k + n - 1] == row.columns[k] + n - 1, dealii::ExcInternalError());
      unsigned int &first = position[row.columns[k]];
      if (first == none) {
        first = entries.size();
        blocks.push_back(row.columns[k]);
        for (int i = 0; i < n; ++i)
          entries.push_back(0);
      }
      add_multiple(factor, row.values + k, &entries[first], n);
    }
  });
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

/// Calls @p visit(row, sum) with the own rows of A Q.
/// @pre A has a diagonal
template <typename Rows, typename Visit>
void for_rows_of_product(const Epetra_CrsMatrix &A, const Rows &rows_of_Q, const int n_columns,
                         const int block_length, const Visit &visit)
{
  const SparseRows rows_of_A(A);
  RowSum sum(n_columns, block_length);
  for (int row = 0; row < A.NumMyRows(); ++row) {
    sum.clear();
    const SparseRow entries = rows_of_A[row];
    for (int k = 0; k < entries.n; ++k)
      if (entries.values[k] != 0)
        sum.add(entries.values[k], rows_of_Q[entries.columns[k]]);
    visit(row, sum);
  }
}

/// The column of the diagonal.
int own_column(const Epetra_CrsMatrix &A, const int row)
{
  return A.Importer() == nullptr ? row : A.LCID(A.GRID(row)); // which takes longer
}

/// The columns of A T, where a row of T has one block. In a matrix that is made of its graph values are held
/// once; those that are inserted are copied when it is filled.
Epetra_CrsGraph graph_of_product(const Epetra_CrsMatrix &A, const TentativeRows &T, const int block_length)
{
  const SparseRows rows_of_A(A);
  std::vector<int> blocks, last_row(T.columns().NumMyElements(), -1), lengths(A.NumMyRows(), 0), columns;
  for (int row = 0; row < A.NumMyRows(); ++row) {
    const SparseRow entries = rows_of_A[row];
    const std::size_t first_block = blocks.size();
    for (int k = 0; k < entries.n; ++k)
      if (const SparseRow other = T[entries.columns[k]];
          entries.values[k] != 0 && other.n > 0 && last_row[other.columns[0]] != row) {
        last_row[other.columns[0]] = row;
        blocks.push_back(other.columns[0]);
      }
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

/// (I - w D^-1 A) T
std::unique_ptr<Epetra_CrsMatrix> smooth_tentative(const Epetra_CrsMatrix &A, const TentativeRows &T,
                                                   const int block_length, const double w)
{
  Epetra_Vector diagonal(A.RowMap());
  LevelEntries(A).diagonal(diagonal);
  auto P = std::make_unique<Epetra_CrsMatrix>(Copy, graph_of_product(A, T, block_length));
  for_rows_of_product(A, T, T.columns().NumMyElements(), block_length, [&](const int row, RowSum &sum) {
    const double factor = diagonal[row] > 0 ? -w / diagonal[row] : 0;
    for (double &entry : sum.entries)
      entry *= factor;
    sum.add(1., T[own_column(A, row)]);
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    P->ExtractMyRowView(row, n, values, columns);
    for (int k = 0; k < n; k += block_length)
      std::copy_n(&sum.entries[sum.place_of(columns[k])], block_length, values + k);
  });
  P->FillComplete(T.own(), A.OperatorDomainMap());
  return P;
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

  /// Adds p^T q.
  void add(const SparseRow &p, const RowSum &q);
  /// Calls @p visit(row, column, entries) with the first row and column of each block.
  template <typename Visit>
  void for_blocks(const Visit &visit) const;

private:
  struct Row
  {
    std::vector<int> blocks; ///< first columns
    std::vector<double> entries;
  };
  struct Place ///< of a block of a sum
  {
    int k;             ///< where its rows begin in p
    std::size_t l;     ///< where its columns begin in q
    int row;           ///< first one
    std::size_t first; ///< in the entries of the row
  };
  void find_places(const SparseRow &p, const RowSum &q);

  const int *const numbers;
  const int length;
  std::vector<Row> rows;                    ///< by first row of a block
  std::vector<int> last_rows, last_columns; ///< of the last sum
  std::vector<Place> places;                ///< likewise
};

/// The rows of a node have the same ones.
void BlockSums::find_places(const SparseRow &p, const RowSum &q)
{
  if (std::equal(last_rows.begin(), last_rows.end(), p.columns, p.columns + p.n) && last_columns == q.blocks)
    return;
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
      places.push_back({k, b * length, p.columns[k], (found - row.blocks.begin()) * n_entries});
      if (found == row.blocks.end()) {
        row.blocks.push_back(q.blocks[b]);
        row.entries.resize(row.entries.size() + n_entries, 0.);
      }
    }
  }
}

void BlockSums::add(const SparseRow &p, const RowSum &q)
{
  find_places(p, q);
  with_known_number(length, [&](const auto n) {
    for (const Place &place : places)
      for (int i = 0; i < n; ++i)
        add_multiple(p.values[place.k + i], &q.entries[place.l],
                     &rows[place.row].entries[place.first + i * n], n);
  });
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

/// Sums P^T A P now, and makes the matrix when neither A nor P is needed any more.
Cycle::MakeMatrix sum_coarse_matrix(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &P,
                                    const int block_length)
{
  const auto Q = rows_for_columns(A, P);
  const Epetra_Map all = Q->ColMap(), own = P.DomainMap();
  const SparseRows rows_of_Q(*Q);
  auto sums = std::make_shared<BlockSums>(all, block_length);
  for_rows_of_product(A, rows_of_Q, Q->NumMyCols(), block_length, [&](const int row, const RowSum &sum) {
    sums->add(rows_of_Q[own_column(A, row)], sum);
  });
  return [sums, all, own, block_length]() mutable {
    auto result = make_matrix(*sums, all, own, block_length);
    sums.reset();
    return complete(std::move(result), all, own);
  };
}

} // namespace

std::unique_ptr<Epetra_MultiVector> make_modes(const GroupFacts &facts, const Epetra_Map &map,
                                               const Selection *rows)
{
  const auto near_null_space = facts.near_null_space(rows);
  auto modes = std::make_unique<Epetra_MultiVector>(map, near_null_space.size());
  for (unsigned int mode = 0; mode < near_null_space.size(); ++mode)
    std::copy(near_null_space[mode].begin(), near_null_space[mode].end(), (*modes)[mode]);
  return modes;
}

SmoothedAggregation::SmoothedAggregation(Finest A, std::shared_ptr<const Epetra_MultiVector> modes,
                                         const MakeSmoother &make_smoother)
    : Cycle(std::move(A))
{
  const int n_modes = modes->NumVectors();
  Aggregation aggregates;
  while (coarsest().NumGlobalRows() > largest_coarse) {
    const Epetra_CrsMatrix &matrix = coarsest();
    aggregates = n_levels() == 0 ? make_aggregation(matrix, *modes, rows_per_node(*modes))
                                 : make_aggregation(matrix, *aggregates.modes, n_modes);
    modes.reset();
    give_back_freed_memory();
    const int n_coarse = aggregates.modes->GlobalLength();
    if (n_coarse == 0 || n_coarse > largest_growth * matrix.NumGlobalRows())
      break;
    const double eigenvalue = largest_eigenvalue_with_diagonal(LevelEntries(matrix));
    auto P = smooth_tentative(matrix, TentativeRows(matrix, aggregates), n_modes, 4. / 3 / eigenvalue);
    aggregates.basis = std::vector<double>(); // = {} would keep the memory
    give_back_freed_memory();
    const MakeMatrix make_coarse = sum_coarse_matrix(matrix, *P, n_modes);
    add_level(make_smoother, std::move(P), make_coarse, eigenvalue);
    if (const Epetra_Import *const gather = gather_coarsest())
      aggregates.modes = imported(*aggregates.modes, *gather);
  }
  factorise_coarsest();
}

} // namespace dovetail
