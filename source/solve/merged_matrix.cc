// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "merged_matrix.h"

#include "level_operator.h"

#include <deal.II/base/mpi.h>

#include <Epetra_Import.h>
#include <Epetra_Map.h>
#include <Epetra_MpiComm.h>
#include <Epetra_Vector.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

MergedMatrix::MergedMatrix(const BlockMatrix &matrix, const std::vector<unsigned int> &blocks)
    : block_matrix(matrix), rows(matrix.owned_unknowns(), blocks, matrix.get_mpi_communicator())
{
  for (unsigned int i = 0; i < blocks.size();) {
    parts.push_back({matrix.part_of(blocks[i]), i, rows.first_local_of(i)});
    for (const unsigned int b : matrix.numbering(parts.back().number).blocks()) {
      AssertThrow(i < blocks.size() && blocks[i] == b, dealii::ExcMessage("the blocks are no whole parts"));
      ++i;
    }
  }
}

void MergedMatrix::update()
{
  has_values = false;
  motions.reset();
}

template <typename Visit>
void MergedMatrix::for_each_pair(const Visit &visit) const
{
  for (const Part &p : parts)
    for (const Part &q : parts)
      if (block_matrix.has_part(p.number, q.number))
        visit(p, q, block_matrix.part(p.number, q.number).trilinos_matrix());
}

const PartOperator *MergedMatrix::cells() const
{
  return parts.size() == 1 ? cells_of(parts[0]) : nullptr;
}

bool MergedMatrix::has_products() const
{
  return std::any_of(parts.begin(), parts.end(), [this](const Part &p) { return cells_of(p) != nullptr; });
}

const Epetra_CrsMatrix *MergedMatrix::entries() const
{
  return cells() == nullptr ? matrix()
                            : &block_matrix.part(parts[0].number, parts[0].number).trilinos_matrix();
}

const Epetra_CrsMatrix *MergedMatrix::matrix() const
{
  if (has_products())
    return nullptr;
  if (parts.size() == 1)
    return &block_matrix.part(parts[0].number, parts[0].number).trilinos_matrix();
  if (!has_values)
    merge();
  return merged.get();
}

void MergedMatrix::merge() const
{
  if (!merged) {
    std::vector<int> row_lengths(rows.n_local(), 0);
    for_each_pair([&](const Part &p, const Part &, const Epetra_CrsMatrix &matrix) {
      for (int row = 0; row < matrix.NumMyRows(); ++row)
        row_lengths[p.first_local + row] += matrix.NumMyEntries(row);
    });
    const Epetra_MpiComm communicator(block_matrix.get_mpi_communicator());
    const Epetra_Map map(-1, static_cast<int>(rows.n_local()), 0, communicator);
    merged = std::make_unique<Epetra_CrsMatrix>(Copy, map, row_lengths.data(), true);
  }
  for_each_pair([&](const Part &p, const Part &q, const Epetra_CrsMatrix &from) { copy(p, q, from); });
  merged->FillComplete();
  merged->OptimizeStorage();
  has_values = true;
}

void MergedMatrix::copy(const Part &row_part, const Part &column_part, const Epetra_CrsMatrix &from) const
{
  std::vector<int> column_of, columns; // of each local column
  for (int k = 0; k < from.NumMyCols(); ++k) {
    const auto [j, index] = block_matrix.numbering(column_part.number).unknown(from.GCID(k));
    column_of.push_back(rows.row(column_part.first_block + j, index));
  }
  for (int row = 0; row < from.NumMyRows(); ++row) {
    int n = 0, *local = nullptr;
    double *values = nullptr;
    from.ExtractMyRowView(row, n, values, local);
    columns.clear();
    for (int k = 0; k < n; ++k)
      columns.push_back(column_of[local[k]]);
    const int merged_row = merged->GRID(row_part.first_local + row);
    if (merged->Filled())
      merged->ReplaceGlobalValues(merged_row, n, values, columns.data());
    else
      merged->InsertGlobalValues(merged_row, n, values, columns.data());
  }
}

std::pair<double, double> MergedMatrix::largest_row() const
{
  std::vector<double> sums(rows.n_local(), 0.), lengths(rows.n_local(), 0.);
  for_each_pair([&](const Part &p, const Part &, const Epetra_CrsMatrix &matrix) {
    for (int row = 0; row < matrix.NumMyRows(); ++row) {
      int n = 0;
      double *values = nullptr;
      matrix.ExtractMyRowView(row, n, values);
      lengths[p.first_local + row] += n;
      for (int k = 0; k < n; ++k)
        sums[p.first_local + row] += std::abs(values[k]);
    }
  });
  for (unsigned int i = 0; i < parts.size(); ++i)
    if (const PartOperator *const summand = cells_of(parts[i])) {
      // no row is longer than its length^(1/2) times the largest entry of the diagonal
      GroupVector diagonal_of_all = vector();
      diagonal(diagonal_of_all);
      const double length = summand->row_length();
      const unsigned int end = i + 1 < parts.size() ? parts[i + 1].first_local : sums.size();
      for (unsigned int row = parts[i].first_local; row < end; ++row) {
        sums[row] = std::sqrt(length) * std::abs(diagonal_of_all.trilinos_vector()[0][row]);
        lengths[row] += length;
      }
    }
  const auto largest = [&](const std::vector<double> &of_rows) {
    double own = 0;
    for (const double of_row : of_rows)
      own = std::max(own, of_row);
    return dealii::Utilities::MPI::max(own, block_matrix.get_mpi_communicator());
  };
  return {largest(sums), largest(lengths)};
}

GroupVector MergedMatrix::rounding_of_product(const GroupVector &x) const
{
  GroupVector sizes = vector(), sums = vector();
  sizes.trilinos_vector().Abs(x.trilinos_vector());
  for_each_pair([&](const Part &p, const Part &q, const Epetra_CrsMatrix &matrix) {
    const Epetra_Vector own(View, matrix.DomainMap(), sizes.trilinos_vector()[0] + q.first_local);
    Epetra_Vector seen(matrix.ColMap());
    if (matrix.Importer() == nullptr)
      seen = own;
    else
      seen.Import(own, *matrix.Importer(), Insert);
    for (int row = 0; row < matrix.NumMyRows(); ++row) {
      int n = 0, *columns = nullptr;
      double *values = nullptr;
      matrix.ExtractMyRowView(row, n, values, columns);
      for (int k = 0; k < n; ++k)
        sums.trilinos_vector()[0][p.first_local + row] += std::abs(values[k]) * seen[columns[k]];
    }
  });
  for (const Part &p : parts)
    if (const PartOperator *const summand = cells_of(p)) {
      const Epetra_Map &map = block_matrix.part(p.number, p.number).trilinos_matrix().RowMap();
      const Epetra_Vector own(View, map, x.trilinos_vector()[0] + p.first_local);
      Epetra_Vector all(View, map, sums.trilinos_vector()[0] + p.first_local);
      summand->add_sizes_of_products(own, all);
    }
  sums *= std::numeric_limits<double>::epsilon() / 2;
  return sums;
}

void MergedMatrix::gather(const BlockVector &from, GroupVector &to) const
{
  rows.gather(from, to.trilinos_vector()[0]);
}

void MergedMatrix::scatter(const GroupVector &from, BlockVector &to) const
{
  rows.scatter(from.trilinos_vector()[0], to);
}

GroupVector MergedMatrix::vector() const
{
  return GroupVector(rows.owned(), block_matrix.get_mpi_communicator());
}

void MergedMatrix::vmult(GroupVector &destination, const GroupVector &source) const
{
  if (parts.size() == 1) {
    const Epetra_Vector x(View, entries()->DomainMap(), source.trilinos_vector()[0]);
    Epetra_Vector y(View, entries()->RangeMap(), destination.trilinos_vector()[0]);
    const PartOperator *const summand = cells();
    if (!motions)
      motions = summand == nullptr && make_motions ? make_motions(*entries()) : nullptr;
    if (*motions)
      (*motions)->multiply(x, y);
    else
      entries()->Multiply(false, x, y);
    if (summand != nullptr)
      summand->add_product(1., x, y, false);
    return;
  }
  destination = 0;
  for_each_pair([&](const Part &p, const Part &q, const Epetra_CrsMatrix &matrix) {
    const Epetra_Vector x(View, matrix.DomainMap(), source.trilinos_vector()[0] + q.first_local);
    Epetra_Vector y(View, matrix.RangeMap(), destination.trilinos_vector()[0] + p.first_local),
        product(matrix.RangeMap());
    matrix.Multiply(false, x, product);
    y.Update(1., product, 1.);
    if (const PartOperator *const summand = p.number == q.number ? cells_of(p) : nullptr)
      summand->add_product(1., x, y, false);
  });
}

void MergedMatrix::diagonal(GroupVector &destination) const
{
  for (const Part &p : parts) {
    const Epetra_CrsMatrix &matrix = block_matrix.part(p.number, p.number).trilinos_matrix();
    Epetra_Vector values(View, matrix.RowMap(), destination.trilinos_vector()[0] + p.first_local);
    LevelEntries(matrix).diagonal(values);
    if (const PartOperator *const summand = cells_of(p))
      summand->add_diagonal(values);
  }
}

} // namespace dovetail
