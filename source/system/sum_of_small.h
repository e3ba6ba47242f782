// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The matrix of functions of degree one, cell by cell.

#pragma once

#include <deal.II/base/mpi.h>
#include <deal.II/lac/full_matrix.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>

#include <map>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

namespace dovetail {

/// A sum of small matrices, of which each has the rows and columns of a few unknowns: first the unknowns of
/// all of them, then the entries. Of rows of other ranks, the parts of this rank are sent there.
class SumOfSmall
{
public:
  /// @param own the unknowns of this rank
  /// @param globals global numbers of unknowns by number, the own ones first
  SumOfSmall(const Epetra_Map &own, const std::vector<int> &globals);

  int number(int global);                    ///< also of an unknown that is new
  void meet(const std::vector<int> &numbers) ///< of the unknowns of a small matrix
  {
    unknowns.insert(unknowns.end(), numbers.begin(), numbers.end());
    first_unknown.push_back(unknowns.size());
  }
  /// Of entries beside those of small matrices; by reference until allocate().
  void meet(const int row, const std::vector<int> &columns) { further[row].push_back(&columns); }
  void allocate(); ///< all have been met; collective
  void add(const std::vector<int> &numbers, const dealii::FullMatrix<double> &entries);
  void add(int row, const std::vector<int> &columns, const double *entries);
  std::unique_ptr<Epetra_CrsMatrix> finish(); ///< with what other ranks have added; collective

private:
  struct Row
  {
    int number, rank;          ///< the rank that owns it, or that sends a part of it
    std::vector<int> columns;  ///< numbers
    std::vector<double> parts; ///< of the entries, if another rank owns it
  };

  void sort_by_row();
  void find_columns(int row);
  void exchange_columns();
  Epetra_Map place_columns(std::vector<int> &lengths);
  void make_matrix();
  MPI_Comm communicator() const;
  void sort(const std::vector<int> &numbers);
  template <typename Entry>
  void add_sorted(int row, const Entry &entry);
  template <typename Entry>
  void add_row(int row, const std::vector<int> &numbers, const Entry &entry);

  const Epetra_Map own;
  std::vector<int> globals;
  std::unordered_map<int, int> others; ///< numbers of unknowns of other ranks
  std::vector<std::size_t> first_unknown = {0};
  std::vector<int> unknowns;                                    ///< of all small matrices
  std::vector<std::size_t> first_matrix;                        ///< by row
  std::vector<unsigned int> matrices;                           ///< row by row
  std::map<int, std::vector<const std::vector<int> *>> further; ///< columns by row
  std::vector<int> columns, last_row;                           ///< of a row; by column
  std::vector<int> place;                                       ///< in the order of the columns, by number
  std::vector<Row> of_others, from_others;                      ///< all that this rank knows; own ones
  std::unique_ptr<Epetra_CrsMatrix> sum;
  std::vector<std::pair<int, unsigned int>> order; ///< of places that are added
};

} // namespace dovetail
