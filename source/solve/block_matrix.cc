// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/block_matrix.h>
#include <dovetail/solve/ghost_exchange.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/affine_constraints.templates.h>

#include <boost/serialization/set.hpp>
#include <boost/serialization/utility.hpp>

#include <Epetra_Import.h>
#include <Epetra_Vector.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dovetail {

namespace {

using Index = BlockMatrix::size_type;

/// What a rank knows of a pair of blocks.
using BlockPairs = std::set<std::pair<unsigned int, unsigned int>>;

/// Those of all ranks.
BlockPairs unite(const BlockPairs &own, const MPI_Comm &communicator)
{
  BlockPairs all;
  for (const BlockPairs &of_rank : dealii::Utilities::MPI::all_gather(communicator, own))
    all.insert(of_rank.begin(), of_rank.end());
  return all;
}

/// BlockIndices::global_to_local for indices most of which lie in the block of the one before.
class BlockSearch
{
public:
  explicit BlockSearch(const dealii::BlockIndices &indices) : indices(indices) {}

  std::pair<unsigned int, Index> operator()(const Index index)
  {
    if (index < begin || index >= end) {
      block = indices.global_to_local(index).first;
      begin = indices.block_start(block);
      end = begin + indices.block_size(block);
    }
    return {block, index - begin};
  }

private:
  const dealii::BlockIndices &indices;
  unsigned int block = 0;
  Index begin = 0, end = 0;
};

/// A row of a Trilinos matrix.
struct RowView
{
  RowView(const Epetra_CrsMatrix &matrix, const int row) { matrix.ExtractMyRowView(row, n, values, columns); }

  int n = 0, *columns = nullptr; ///< local, ascending
  double *values = nullptr;
};

/// As an assignment, but for its search of entries that are on their way to other ranks: there are none since
/// the last compress().
void set_entries(dealii::TrilinosWrappers::SparseMatrix &part, const double value)
{
  const_cast<Epetra_CrsMatrix &>(part.trilinos_matrix()).PutScalar(value);
}

} // namespace

void BlockMatrix::clear()
{
  operators.clear();
  parts.clear();
  numberings.clear();
  columns_of.clear();
  place.clear();
  owned.clear();
  indices = dealii::BlockIndices();
}

void BlockMatrix::reinit(const std::vector<dealii::IndexSet> &owned_sets,
                         const std::vector<unsigned int> &part_of_block,
                         dealii::DynamicSparsityPattern &pattern, const MPI_Comm &communicator)
{
  clear();
  owned = owned_sets;
  std::vector<size_type> sizes;
  std::vector<std::vector<unsigned int>> blocks_of;
  for (unsigned int b = 0; b < owned.size(); ++b) {
    sizes.push_back(owned[b].size());
    blocks_of.resize(std::max<std::size_t>(blocks_of.size(), part_of_block[b] + 1));
    place.push_back({part_of_block[b], static_cast<unsigned int>(blocks_of[part_of_block[b]].size())});
    blocks_of[part_of_block[b]].push_back(b);
  }
  indices.reinit(sizes);
  for (const auto &blocks : blocks_of)
    numberings.emplace_back(owned, blocks, communicator);
  find_blocks(pattern, communicator);
  parts.resize(numberings.size());
  // the only part keeps the order of the system unless several ranks own unknowns of several blocks
  if (parts.size() == 1 &&
      (owned.size() == 1 || dealii::Utilities::MPI::n_mpi_processes(communicator) == 1)) {
    parts[0][0] = std::make_unique<Part>();
    parts[0][0]->reinit(numberings[0].owned(), numberings[0].owned(), pattern, communicator, false);
    pattern.reinit(0, 0);
    return;
  }
  for (unsigned int p = 0; p < parts.size(); ++p) {
    auto patterns = split_rows(p, pattern);
    for (auto &[q, part_pattern] : patterns) {
      parts[p][q] = std::make_unique<Part>();
      parts[p][q]->reinit(numberings[p].owned(), numberings[q].owned(), part_pattern, communicator, false);
      part_pattern.reinit(0, 0);
    }
  }
}

void BlockMatrix::find_blocks(const dealii::DynamicSparsityPattern &pattern, const MPI_Comm &communicator)
{
  BlockPairs pairs;
  for (unsigned int r = 0; r < owned.size(); ++r) {
    pairs.emplace(r, r);
    std::vector<bool> has_column(owned.size(), false);
    BlockSearch find(indices);
    for (const Index index : owned[r]) {
      const Index row = indices.block_start(r) + index;
      const unsigned int n = pattern.row_length(row);
      if (n == 0)
        continue;
      const unsigned int first = find(pattern.column_number(row, 0)).first;
      has_column[first] = true;
      if (find(pattern.column_number(row, n - 1)).first == first) // columns are sorted
        continue;
      for (unsigned int k = 1; k < n; ++k) // an iterator of the pattern takes longer
        has_column[find(pattern.column_number(row, k)).first] = true;
    }
    for (unsigned int c = 0; c < owned.size(); ++c)
      if (has_column[c])
        pairs.emplace(r, c);
  }
  columns_of.resize(owned.size());
  for (const auto &[r, c] : unite(pairs, communicator))
    columns_of[r].insert(c);
}

/// The part of @p pattern in the rows of one part, by the part of the columns; the rows are emptied.
std::map<unsigned int, dealii::DynamicSparsityPattern>
BlockMatrix::split_rows(const unsigned int p, dealii::DynamicSparsityPattern &pattern) const
{
  std::vector<std::pair<Index, Index>> rows; // in the part, in the system
  std::map<unsigned int, std::vector<Index>> columns;
  for (unsigned int i = 0; i < numberings[p].blocks().size(); ++i) {
    const unsigned int b = numberings[p].blocks()[i];
    const Index begin = indices.block_start(b);
    for (const Index row : pattern.row_index_set().get_view(begin, begin + indices.block_size(b)))
      rows.emplace_back(numberings[p].row(i, row), begin + row);
    for (const unsigned int c : columns_of[b])
      columns[part_of(c)];
  }
  std::sort(rows.begin(), rows.end());
  dealii::IndexSet row_set(numberings[p].size());
  for (const auto &row : rows)
    row_set.add_index(row.first);
  row_set.compress();

  std::map<unsigned int, dealii::DynamicSparsityPattern> patterns;
  for (const auto &part_columns : columns)
    patterns.try_emplace(part_columns.first, numberings[p].size(), numberings[part_columns.first].size(),
                         row_set);
  BlockSearch find(indices);
  for (const auto &[row, row_of_system] : rows) {
    const unsigned int n = pattern.row_length(row_of_system);
    for (unsigned int k = 0; k < n; ++k) {
      const auto [block, index] = find(pattern.column_number(row_of_system, k));
      columns[part_of(block)].push_back(numberings[part_of(block)].row(place[block].position, index));
    }
    pattern.clear_row(row_of_system);
    for (auto &[q, part_columns] : columns) {
      if (!std::is_sorted(part_columns.begin(), part_columns.end()))
        std::sort(part_columns.begin(), part_columns.end());
      patterns.at(q).add_entries(row, part_columns.begin(), part_columns.end(), true);
      part_columns.clear();
    }
  }
  return patterns;
}

BlockMatrix &BlockMatrix::operator=(const double zero)
{
  for (const auto &part_row : parts)
    for (const auto &[column, part] : part_row)
      set_entries(*part, zero);
  return *this;
}

void BlockMatrix::set_zero(const std::vector<bool> &rows)
{
  for (unsigned int p = 0; p < parts.size(); ++p)
    if (rows[numberings[p].blocks()[0]])
      for (const auto &[column, part] : parts[p])
        set_entries(*part, 0);
}

void BlockMatrix::copy_from(const BlockMatrix &other)
{
  clear();
  indices = other.indices;
  owned = other.owned;
  place = other.place;
  columns_of = other.columns_of;
  numberings = other.numberings;
  parts.resize(other.parts.size());
  for (unsigned int p = 0; p < parts.size(); ++p)
    for (const auto &[q, part] : other.parts[p]) {
      parts[p][q] = std::make_unique<Part>();
      parts[p][q]->copy_from(*part);
    }
  for (const auto &[p, summand] : other.operators)
    operators[p] = summand->copy();
}

void BlockMatrix::add(const double factor, const BlockMatrix &other)
{
  for (unsigned int p = 0; p < parts.size(); ++p)
    for (const auto &[q, part] : parts[p])
      part->add(factor, other.part(p, q));
  for (const auto &[p, summand] : operators)
    summand->add(factor, *other.part_operator(p));
}

void BlockMatrix::add(const size_type row, const size_type n, const size_type *columns, const double *values,
                      const bool, const bool)
{
  const auto [row_block, row_in_block] = indices.global_to_local(row);
  const auto [p, i] = place[row_block];
  const Index row_in_part = numberings[p].row(i, row_in_block);
  for (size_type k = 0, end = 0; k < n; k = end) {
    part_columns.clear();
    unsigned int q = 0;
    while (end < n) {
      const unsigned int block = indices.global_to_local(columns[end]).first;
      if (end > k && part_of(block) != q)
        break;
      q = part_of(block);
      const size_type begin_of_block = indices.block_start(block),
                      end_of_block = begin_of_block + indices.block_size(block);
      for (; end < n && columns[end] >= begin_of_block && columns[end] < end_of_block; ++end)
        part_columns.push_back(numberings[q].row(place[block].position, columns[end] - begin_of_block));
    }
    Part &part = *parts[p].at(q);
    if (const int own_row = part.trilinos_matrix().LRID(static_cast<int>(row_in_part)); own_row >= 0)
      add_to_own_row(part.trilinos_matrix(), own_row, values + k);
    else
      part.add(row_in_part, end - k, part_columns.data(), values + k, true, false); // zeros may have no entry
  }
}

/// Values for part_columns. Columns that follow one another in the sum mostly do so in the row.
void BlockMatrix::add_to_own_row(const Epetra_CrsMatrix &matrix, const int row, const double *values) const
{
  const RowView view(matrix, row);
  const Epetra_Map &column_map = matrix.ColMap();
  const int *const end = view.columns + view.n, *next = view.columns;
  for (unsigned int k = 0; k < part_columns.size(); ++k) {
    const int column = column_map.LID(static_cast<int>(part_columns[k]));
    if (next == end || *next != column)
      next = std::lower_bound(next == end || *next > column ? view.columns : next, end, column);
    const bool exists = next != end && *next == column;
    AssertThrow(exists || values[k] == 0,
                dealii::ExcMessage("a sum has a term that is not in the pattern of the matrix"));
    if (!exists) // a cell's tangent in a field that has no entries
      continue;
    view.values[next - view.columns] += values[k];
    ++next;
  }
}

void BlockMatrix::add(const size_type row, const size_type column, const double value)
{
  add(row, 1, &column, &value, false, true);
}

void BlockMatrix::compress(const dealii::VectorOperation::values operation)
{
  for (const auto &part_row : parts)
    for (const auto &[column, part] : part_row)
      part->compress(operation);
}

/// y += factor K_pq x_q
void BlockMatrix::add_product(const unsigned int p, const unsigned int q, const double factor,
                              const Vector &x, Vector &y) const
{
  const Epetra_CrsMatrix &matrix = part(p, q).trilinos_matrix();
  Epetra_Vector part_x(matrix.DomainMap()), product(matrix.RangeMap()), part_y(matrix.RangeMap());
  numberings[q].gather(x, part_x.Values());
  numberings[p].gather(y, part_y.Values());
  matrix.Multiply(false, part_x, product);
  part_y.Update(factor, product, 1.);
  if (const PartOperator *summand = part_operator(p); summand != nullptr && p == q)
    summand->add_product(factor, part_x, part_y, false);
  numberings[p].scatter(part_y.Values(), y);
}

void BlockMatrix::vmult(Vector &destination, const Vector &source) const
{
  destination = 0;
  for (unsigned int p = 0; p < parts.size(); ++p)
    for (const auto &part_column : parts[p])
      add_product(p, part_column.first, 1., source, destination);
}

void BlockMatrix::subtract_product(const std::vector<unsigned int> &rows,
                                   const std::vector<unsigned int> &columns, const Vector &x, Vector &y) const
{
  const auto parts_of = [this](const std::vector<unsigned int> &blocks) {
    std::set<unsigned int> all;
    std::size_t n_blocks = 0;
    for (const unsigned int b : blocks)
      if (all.insert(part_of(b)).second)
        n_blocks += numberings[part_of(b)].blocks().size();
    AssertThrow(n_blocks == blocks.size(), dealii::ExcMessage("some blocks of a part are missing"));
    return all;
  };
  for (const unsigned int p : parts_of(rows))
    for (const unsigned int q : parts_of(columns))
      if (has_part(p, q))
        add_product(p, q, -1., x, y);
}

void BlockMatrix::for_each_product(const Vector &x, const VisitProduct &visit) const
{
  for (unsigned int p = 0; p < parts.size(); ++p)
    for (const auto &part_column : parts[p])
      visit_products(p, part_column.first, x, visit);
  for (const auto &with_operator : operators)
    visit_operator(with_operator.first, x, visit);
}

/// Block by block, if they are coupled.
void BlockMatrix::visit_operator(const unsigned int p, const Vector &x, const VisitProduct &visit) const
{
  const Epetra_Map &map = part(p, p).trilinos_matrix().DomainMap();
  const PartOperator &summand = *operators.at(p);
  const auto &blocks = numberings[p].blocks();
  Epetra_Vector own(map), y(map);
  const bool couples = !summand.coupled_blocks().empty();
  for (unsigned int j = 0; j < (couples ? blocks.size() : 1); ++j) {
    numberings[p].gather(x, own.Values());
    for (unsigned int row = 0; couples && row < numberings[p].n_local(); ++row)
      if (row < numberings[p].first_local_of(j) || row >= numberings[p].first_local_of(j + 1))
        own[row] = 0;
    y.PutScalar(0.);
    summand.add_product(1., own, y, false);
    for (unsigned int i = 0; i < blocks.size(); ++i) {
      Vector::BlockType product(owned[blocks[i]], get_mpi_communicator());
      std::copy(y.Values() + numberings[p].first_local_of(i),
                y.Values() + numberings[p].first_local_of(i + 1), product.trilinos_vector()[0]);
      visit(blocks[i], blocks[couples ? j : i], product);
    }
  }
}

Epetra_Vector BlockMatrix::ghosted(const unsigned int p, const unsigned int q, const Vector &x) const
{
  const Epetra_CrsMatrix &matrix = part(p, q).trilinos_matrix();
  Epetra_Vector own(matrix.DomainMap()), result(matrix.ColMap());
  numberings[q].gather(x, own.Values());
  if (matrix.Importer() != nullptr)
    result.Import(own, *matrix.Importer(), Insert);
  else
    result = own;
  return result;
}

std::vector<double> BlockMatrix::sizes_of_products(const Vector &x) const
{
  std::vector<double> sizes(owned.size(), 0.);
  for (unsigned int p = 0; p < parts.size(); ++p) {
    const Epetra_Map &map = part(p, p).trilinos_matrix().DomainMap();
    Epetra_Vector sums(map);
    if (const PartOperator *const summand = part_operator(p)) {
      Epetra_Vector own(map);
      numberings[p].gather(x, own.Values());
      summand->add_sizes_of_products(own, sums);
    }
    for (const auto &[q, entries] : parts[p]) {
      const Epetra_Vector factors = ghosted(p, q, x);
      for (int row = 0; row < sums.MyLength(); ++row) {
        const RowView view(entries->trilinos_matrix(), row);
        for (int k = 0; k < view.n; ++k)
          sums[row] += std::abs(view.values[k] * factors[view.columns[k]]);
      }
    }
    for (unsigned int i = 0; i < numberings[p].blocks().size(); ++i) {
      const double *const first = sums.Values() + numberings[p].first_local_of(i),
                          *const end = sums.Values() + numberings[p].first_local_of(i + 1);
      sizes[numberings[p].blocks()[i]] = std::inner_product(first, end, first, 0.);
    }
  }
  dealii::Utilities::MPI::sum(sizes, get_mpi_communicator(), sizes);
  std::transform(sizes.begin(), sizes.end(), sizes.begin(),
                 [](const double square) { return std::sqrt(square); });
  return sizes;
}

/// Of the blocks of a pair of parts, in one pass through each row.
void BlockMatrix::visit_products(const unsigned int p, const unsigned int q, const Vector &x,
                                 const VisitProduct &visit) const
{
  const Epetra_CrsMatrix &matrix = part(p, q).trilinos_matrix();
  if (matrix.NumGlobalNonzeros64() == 0) // all of it is products of an operator
    return;
  if (numberings[p].blocks().size() == 1 && numberings[q].blocks().size() == 1) { // one pair
    const unsigned int r = numberings[p].blocks()[0], c = numberings[q].blocks()[0];
    Vector::BlockType product(owned[r], get_mpi_communicator());
    const Epetra_Vector own(View, matrix.DomainMap(), x.block(c).trilinos_vector()[0]);
    Epetra_Vector result(View, matrix.RangeMap(), product.trilinos_vector()[0]);
    matrix.Multiply(false, own, result);
    visit(r, c, product);
    return;
  }
  const Epetra_Vector factors = ghosted(p, q, x);
  std::vector<unsigned int> block_of_column;
  for (int k = 0; k < matrix.NumMyCols(); ++k)
    block_of_column.push_back(numberings[q].unknown(matrix.GCID(k)).first);

  std::vector<double *> sums(numberings[q].blocks().size());
  for (unsigned int i = 0; i < numberings[p].blocks().size(); ++i) {
    const unsigned int r = numberings[p].blocks()[i];
    std::map<unsigned int, Vector::BlockType> products;
    for (const unsigned int c : columns_of[r])
      if (part_of(c) == q) {
        products[c].reinit(x.block(r));
        sums[place[c].position] = products[c].trilinos_vector()[0];
      }
    const unsigned int first = numberings[p].first_local_of(i), end = numberings[p].first_local_of(i + 1);
    for (unsigned int row = first; row < end; ++row) {
      const RowView view(matrix, row);
      for (int k = 0; k < view.n; ++k)
        sums[block_of_column[view.columns[k]]][row - first] += view.values[k] * factors[view.columns[k]];
    }
    for (const auto &[c, product] : products)
      visit(r, c, product);
  }
}

void BlockMatrix::extract_row(const size_type row, std::vector<size_type> &columns,
                              std::vector<double> &values) const
{
  const auto [block, index] = indices.global_to_local(row);
  const auto [p, i] = place[block];
  AssertThrow(part_operator(p) == nullptr, dealii::ExcMessage("this part of the matrix has no entries"));
  columns.clear();
  values.clear();
  for (const auto &[q, part] : parts[p]) {
    const Epetra_CrsMatrix &matrix = part->trilinos_matrix();
    const RowView view(matrix, matrix.LRID(static_cast<int>(numberings[p].row(i, index))));
    for (int k = 0; k < view.n; ++k) {
      const auto [j, column] = numberings[q].unknown(matrix.GCID(view.columns[k]));
      columns.push_back(indices.block_start(numberings[q].blocks()[j]) + column);
    }
    values.insert(values.end(), view.values, view.values + view.n);
  }
}

std::vector<double> BlockMatrix::diagonal(const unsigned int block) const
{
  return diagonal(block, &PartOperator::add_diagonal);
}

std::vector<double> BlockMatrix::uncondensed_diagonal(const unsigned int block) const
{
  return diagonal(block, &PartOperator::add_uncondensed_diagonal);
}

std::vector<double> BlockMatrix::diagonal(const unsigned int block, const AddDiagonal of_operator) const
{
  const auto [p, i] = place[block];
  const Epetra_CrsMatrix &matrix = part(p, p).trilinos_matrix();
  std::vector<double> values;
  for (unsigned int row = numberings[p].first_local_of(i); row < numberings[p].first_local_of(i + 1); ++row) {
    const RowView view(matrix, row);
    const int column = matrix.LCID(matrix.GRID(row)),
              *entry = std::lower_bound(view.columns, view.columns + view.n, column);
    const bool exists = entry != view.columns + view.n && *entry == column;
    values.push_back(exists ? view.values[entry - view.columns] : 0.);
  }
  if (const PartOperator *summand = part_operator(p)) {
    Epetra_Vector all(matrix.DomainMap());
    (summand->*of_operator)(all);
    for (unsigned int k = 0; k < values.size(); ++k)
      values[k] += all[numberings[p].first_local_of(i) + k];
  }
  return values;
}

double BlockMatrix::el(const size_type row, const size_type column) const
{
  std::vector<size_type> columns;
  std::vector<double> values;
  extract_row(row, columns, values);
  const auto entry = std::find(columns.begin(), columns.end(), column);
  return entry == columns.end() ? 0. : values[entry - columns.begin()];
}

namespace {

/// The unknowns of a local matrix that are columns of one part.
struct PartColumns
{
  struct Column
  {
    int number;         ///< in the rows that this rank owns; negative: they have none
    unsigned int local; ///< in the local matrix
  };
  std::vector<Column> columns; ///< ascending

  PartColumns(const BlockMatrix &matrix, const unsigned int p, const unsigned int q,
              const std::vector<std::pair<unsigned int, Index>> &rows)
  {
    const Epetra_Map &map = matrix.part(p, q).trilinos_matrix().ColMap();
    for (unsigned int k = 0; k < rows.size(); ++k)
      if (rows[k].first == q)
        columns.push_back({map.LID(static_cast<int>(rows[k].second)), k});
    std::sort(columns.begin(), columns.end(),
              [](const Column &a, const Column &b) { return a.number < b.number; });
  }

  /// The positions in the row before are tried first: the unknowns at a node have the same columns.
  void add(const Epetra_CrsMatrix &matrix, const int row, const double *values)
  {
    const RowView view(matrix, row);
    positions.resize(columns.size(), 0);
    int next = 0;
    for (unsigned int k = 0; k < columns.size(); ++k) {
      const auto [number, local] = columns[k];
      int &position = positions[k];
      if (position >= view.n || view.columns[position] != number)
        position = next < view.n && view.columns[next] == number
                       ? next
                       : std::lower_bound(view.columns, view.columns + view.n, number) - view.columns;
      const bool exists = position < view.n && view.columns[position] == number;
      AssertThrow(exists || values[local] == 0,
                  dealii::ExcMessage("a sum has a term that is not in the pattern of the matrix"));
      if (exists) {
        view.values[position] += values[local];
        next = position + 1;
      }
    }
  }

private:
  std::vector<int> positions;
};

/// Rows of one part that this rank owns, and columns of one part. The places of columns are looked up once.
void add_own_rows(const unsigned int p, const unsigned int q,
                  const std::vector<std::pair<unsigned int, Index>> &rows,
                  const dealii::FullMatrix<double> &local_matrix, const BlockMatrix &matrix)
{
  const Epetra_CrsMatrix &part = matrix.part(p, q).trilinos_matrix();
  PartColumns columns(matrix, p, q, rows);
  std::vector<std::pair<int, unsigned int>> own_rows; // in the part, in the local matrix
  for (unsigned int i = 0; i < rows.size(); ++i)
    if (rows[i].first == p)
      own_rows.emplace_back(part.LRID(static_cast<int>(rows[i].second)), i);
  std::sort(own_rows.begin(), own_rows.end());
  for (const auto &[row, i] : own_rows)
    columns.add(part, row, &local_matrix(i, 0));
}

/// The part of each unknown, and its row there; nothing if a constraint or a part without entries needs the
/// general way, or another rank owns one.
bool find_rows(const dealii::AffineConstraints<double> &constraints, const std::vector<Index> &dofs,
               const BlockMatrix &matrix, std::vector<std::pair<unsigned int, Index>> &rows)
{
  BlockSearch find(matrix.get_row_indices());
  rows.clear();
  for (const Index dof : dofs) {
    if (constraints.is_constrained(dof))
      return false;
    const auto [block, index] = find(dof);
    if (!matrix.owned_unknowns()[block].is_element(index))
      return false;
    const unsigned int part = matrix.part_of(block);
    const RowNumbering &numbering = matrix.numbering(part);
    const auto &blocks = numbering.blocks();
    rows.emplace_back(part,
                      numbering.row(std::find(blocks.begin(), blocks.end(), block) - blocks.begin(), index));
  }
  return std::all_of(rows.begin(), rows.end(), [&](const auto &a) { // most have the part of the first one
    return a.first == rows[0].first || std::all_of(rows.begin(), rows.end(), [&](const auto &b) {
             return matrix.has_part(a.first, b.first) && matrix.has_part(b.first, a.first);
           });
  });
}

} // namespace

template <typename Rows>
void distribute_local_to_global(const dealii::AffineConstraints<double> &constraints,
                                const dealii::FullMatrix<double> &local_matrix,
                                const dealii::Vector<double> &local_vector, const std::vector<Index> &dofs,
                                BlockMatrix &matrix, Rows &vector)
{
  thread_local std::vector<std::pair<unsigned int, Index>> rows;
  if (!find_rows(constraints, dofs, matrix, rows)) {
    constraints.distribute_local_to_global(local_matrix, local_vector, dofs, matrix, vector);
    return;
  }
  std::set<unsigned int> parts;
  for (const auto &row : rows)
    parts.insert(row.first);
  for (const unsigned int p : parts)
    for (const unsigned int q : parts)
      add_own_rows(p, q, rows, local_matrix, matrix);
  for (unsigned int i = 0; i < dofs.size(); ++i)
    vector(dofs[i]) += local_vector[i];
}

template void distribute_local_to_global(const dealii::AffineConstraints<double> &,
                                         const dealii::FullMatrix<double> &, const dealii::Vector<double> &,
                                         const std::vector<Index> &, BlockMatrix &, BlockMatrix::Vector &);
template void distribute_local_to_global(const dealii::AffineConstraints<double> &,
                                         const dealii::FullMatrix<double> &, const dealii::Vector<double> &,
                                         const std::vector<Index> &, BlockMatrix &, SharedSums &);

} // namespace dovetail
