// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "condensed_bodies.h"

#include "aggregate_products.h"
#include "level_operator.h"
#include "rows_of_inverse.h"
#include "soft_leaders.h"

#include <dovetail/solve/rows_of_other_ranks.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/lapack_full_matrix.h>

#include <EpetraExt_MatrixMatrix.h>
#include <Epetra_Comm.h>
#include <Epetra_Import.h>
#include <Epetra_Map.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

bool is_on_all_ranks(const bool condition, const Epetra_Comm &communicator)
{
  int here = condition, everywhere = 0;
  communicator.MinAll(&here, &everywhere, 1);
  return everywhere != 0;
}

/// x.D y = y.D x for two vectors of noise.
bool is_symmetric_matrix(const Epetra_CrsMatrix &D)
{
  const double rounding = 1e-12;
  Epetra_Vector x(D.DomainMap()), y(x), product(x);
  x.SetSeed(1);
  x.Random();
  y.SetSeed(2);
  y.Random();
  double xDy = 0, yDx = 0, size_of_x = 0, size_of_y = 0;
  D.Multiply(false, y, product);
  product.Dot(x, &xDy);
  product.Norm2(&size_of_y);
  D.Multiply(false, x, product);
  product.Dot(y, &yDx);
  x.Norm2(&size_of_x);
  return std::abs(xDy - yDx) <= rounding * size_of_x * size_of_y;
}

/// Adds to the entries w of a row, in proportion to their sizes, what gives it the products @p wanted with
/// the values of some modes at its columns: the smallest change in the norm sum_j dw_j^2 / |w_j|.
/// @param at_column [mode][entry]
void reproduce(const std::vector<double> &wanted, std::vector<std::vector<double>> &at_column, double *w,
               const unsigned int n)
{
  const double shift = 1e-12; // modes may depend on each other here
  const unsigned int n_modes = wanted.size(), n_passes = 2;
  std::vector<double> missing = wanted, sizes(n);
  for (unsigned int j = 0; j < n; ++j)
    sizes[j] = std::abs(w[j]);
  for (unsigned int m = 0; m < n_modes; ++m) {
    double largest = 0;
    for (const double value : at_column[m])
      largest = std::max(largest, std::abs(value));
    const double scale = largest > 0 ? 1 / largest : 0;
    missing[m] *= scale;
    for (double &value : at_column[m])
      value *= scale;
    for (unsigned int j = 0; j < n; ++j)
      missing[m] -= at_column[m][j] * w[j];
  }
  dealii::LAPACKFullMatrix<double> gram(n_modes, n_modes);
  double trace = 0;
  for (unsigned int m = 0; m < n_modes; ++m)
    for (unsigned int l = 0; l <= m; ++l) {
      double sum = 0;
      for (unsigned int j = 0; j < n; ++j)
        sum += sizes[j] * at_column[m][j] * at_column[l][j];
      gram(m, l) = gram(l, m) = sum;
      trace += m == l ? sum : 0;
    }
  if (!(trace > 0))
    return;
  for (unsigned int m = 0; m < n_modes; ++m)
    gram(m, m) += shift * trace;
  gram.set_property(dealii::LAPACKSupport::symmetric);
  gram.compute_cholesky_factorization();
  for (unsigned int pass = 0; pass < n_passes; ++pass) {
    dealii::Vector<double> share(missing.begin(), missing.end());
    gram.solve(share);
    for (unsigned int j = 0; j < n; ++j) {
      double change = 0;
      for (unsigned int m = 0; m < n_modes; ++m)
        change += at_column[m][j] * share[m];
      change *= sizes[j];
      w[j] += change;
      for (unsigned int m = 0; m < n_modes; ++m)
        missing[m] -= at_column[m][j] * change;
    }
  }
}

} // namespace

CondensedBodies::CondensedBodies(const BlockMatrix &matrix, const std::vector<unsigned int> &bodies,
                                 const std::vector<unsigned int> &multipliers, const unsigned int degree,
                                 const std::vector<Follower> &given_followers,
                                 std::function<Modes()> given_modes)
    : block_matrix(matrix), body_operator(matrix, bodies), body_part(matrix.part_of(bodies[0])),
      multiplier_part(matrix.part_of(multipliers[0])), degree(degree), modes(std::move(given_modes)),
      place_of_row(body_operator.numbering().n_local(), -1)
{
  unsigned int n_here = 0;
  for (unsigned int i = 0; i < given_followers.size(); ++i) {
    const auto [row, tie] = given_followers[i];
    n_here = std::max(n_here, tie + 1);
    if (row < 0)
      continue;
    place_of_row[row] = acting.size();
    acting.push_back(i);
    followers.push_back(row);
    tie_of_follower.push_back(tie);
  }
  n_ties = dealii::Utilities::MPI::max(n_here, matrix.get_mpi_communicator());
  find_columns_that_follow();
}

bool CondensedBodies::update(const std::vector<double> &stiffness)
{
  is_outdated = true;
  if (!block_matrix.has_part(multiplier_part, body_part) ||
      !block_matrix.has_part(multiplier_part, multiplier_part))
    return false;
  const Epetra_CrsMatrix &B = block_matrix.part(multiplier_part, body_part).trilinos_matrix(),
                         &minus_C = block_matrix.part(multiplier_part, multiplier_part).trilinos_matrix();
  Epetra_Vector C(minus_C.RowMap());
  minus_C.ExtractDiagonalCopy(C);
  const bool has_C = std::any_of(acting.begin(), acting.end(), [&C](const int i) { return C[i] != 0; });
  if (!is_on_all_ranks(!has_C, B.Comm()) || (has_new_ties(B) && !split(B)) || !factors ||
      !are_enough(stiffness))
    return false;
  GroupVector diagonal_values = vector();
  body_operator.diagonal(diagonal_values);
  const Epetra_Vector diagonal_of_A(View, diagonal_values.trilinos_vector(), 0);
  diagonal_of_A.Norm1(&diagonal_of_followers);
  diagonal_of_followers /= A().NumGlobalRows();
  const double needed = small_weight(diagonal_of_A);
  if (needed != small)
    weights.reset();
  small = needed;
  return true;
}

bool CondensedBodies::has_new_ties(const Epetra_CrsMatrix &B)
{
  std::vector<double> entries;
  const SparseRows rows(B);
  for (const int i : acting) {
    const SparseRow row = rows[i];
    entries.insert(entries.end(), row.values, row.values + row.n);
  }
  const bool is_same = entries == entries_of_B;
  entries_of_B = std::move(entries);
  return !is_on_all_ranks(is_same, B.Comm());
}

/// B = [M D]
bool CondensedBodies::split(const Epetra_CrsMatrix &B)
{
  factors.reset();
  weights.reset();
  const Epetra_Map ties(-1, static_cast<int>(acting.size()), 0, B.Comm());
  Epetra_Vector number_of_row(B.DomainMap()); // of a tie; exact
  number_of_row.PutScalar(-1.);
  for (unsigned int k = 0; k < acting.size(); ++k)
    number_of_row[followers[k]] = ties.GID(k);
  const Epetra_Vector number_of_column = at_columns(B, number_of_row);
  D = std::make_unique<Epetra_CrsMatrix>(Copy, ties, 0);
  M = std::make_unique<Epetra_CrsMatrix>(Copy, ties, 0);
  const double rounding = 1e-10;
  bool has_diagonal = true;
  const SparseRows rows(B);
  for (unsigned int k = 0; k < acting.size(); ++k) {
    const SparseRow row = rows[acting[k]];
    double of_follower = 0, largest = 0;
    for (int j = 0; j < row.n; ++j) {
      const int tie = static_cast<int>(number_of_column[row.columns[j]]), column = B.GCID(row.columns[j]);
      if (row.values[j] != 0 && tie >= 0)
        D->InsertGlobalValues(ties.GID(k), 1, &row.values[j], &tie);
      else if (row.values[j] != 0)
        M->InsertGlobalValues(ties.GID(k), 1, &row.values[j], &column);
      of_follower += tie == ties.GID(k) ? row.values[j] : 0;
      largest = std::max(largest, std::abs(row.values[j]));
    }
    has_diagonal = has_diagonal && std::abs(of_follower) > rounding * largest;
  }
  D->FillComplete(ties, ties);
  M->FillComplete(B.DomainMap(), ties);
  D->OptimizeStorage();
  M->OptimizeStorage();
  if (!is_on_all_ranks(has_diagonal, B.Comm()) || ties.NumGlobalElements() == 0)
    return false;
  try {
    factors = std::make_unique<Factors>(*D, is_symmetric_matrix(*D));
  } catch (const std::exception &) { // on all ranks
    return false;
  }
  return true;
}

bool CondensedBodies::are_enough(const std::vector<double> &stiffness)
{
  Epetra_Vector of_rows(A().RowMap());
  std::copy(stiffness.begin(), stiffness.end(), of_rows.Values());
  const Epetra_Vector of_columns = at_columns(*M, of_rows);
  Epetra_Vector leads(M->ColMap()), leaders(A().RowMap()); // 1 + the tie, 0: none
  std::vector<int> here(n_ties, 0), all(n_ties, 0);        // followers - leaders
  const SparseRows rows(*M);
  for (unsigned int k = 0; k < acting.size(); ++k) {
    const SparseRow row = rows[k];
    bool is_stiff = false;
    for (int j = 0; j < row.n; ++j)
      if (of_rows[followers[k]] > least_contrast * of_columns[row.columns[j]]) {
        is_stiff = true;
        leads[row.columns[j]] = 1 + tie_of_follower[k];
      }
    here[tie_of_follower[k]] += is_stiff ? 1 : 0;
  }
  leaders.Export(leads, Epetra_Import(M->ColMap(), A().RowMap()), AbsMax);
  soft_leaders.clear();
  for (int row = 0; row < leaders.MyLength(); ++row)
    if (leaders[row] > 0) {
      soft_leaders.push_back(row);
      --here[static_cast<int>(leaders[row]) - 1];
    }
  A().Comm().SumAll(here.data(), all.data(), n_ties);
  return std::all_of(all.begin(), all.end(), [](const int more) { return more >= 0; });
}

/// What Z' leaves out, in units of the largest weight of a row. Stiff bodies resist what Z' makes of it, and
/// flat ones resist much else less: the nodes behind their faces follow.
double CondensedBodies::small_weight(const Epetra_Vector &diagonal_of_A) const
{
  const double usual = 1e-2, of_stiff = 3e-3, of_stiff_flat = 1e-4, of_stiff_by_products = 3e-4,
               strong_coupling = 0.3;
  const Epetra_Vector of_columns = at_columns(A(), diagonal_of_A);
  int here[3] = {static_cast<int>(followers.size()), 0, static_cast<int>(soft_leaders.size())}, all[3] = {};
  const SparseRows rows(A());
  for (const int follower : followers) {
    const SparseRow row = rows[follower];
    double strongest = 0;
    for (int k = 0; k < row.n; ++k)
      if (!column_follows[row.columns[k]])
        strongest = std::max(strongest, -row.values[k] / std::sqrt(std::abs(diagonal_of_A[follower] *
                                                                            of_columns[row.columns[k]])));
    here[1] += strongest > strong_coupling ? 1 : 0;
  }
  A().Comm().SumAll(here, all, 3);
  if (all[2] == 0)
    return usual;
  if (has_cells()) // no coupling tells which ones are flat
    return degree == 1 ? of_stiff_by_products : of_stiff_flat;
  return 2 * all[1] > all[0] ? of_stiff_flat : of_stiff;
}

void CondensedBodies::find_columns_that_follow()
{
  Epetra_Vector follows(A().RowMap());
  for (const int row : followers)
    follows[row] = 1;
  const Epetra_Vector of_columns = at_columns(A(), follows);
  for (int column = 0; column < of_columns.MyLength(); ++column)
    column_follows.push_back(of_columns[column] != 0);
}

std::unique_ptr<Epetra_CrsMatrix> CondensedBodies::about_inverse_of_D() const
{
  const Epetra_Map &ties = D->RowMap();
  auto inverse = std::make_unique<Epetra_CrsMatrix>(Copy, ties, 0);
  RowsOfInverse rows(*D, small / 10);
  std::vector<int> columns;
  std::vector<double> values;
  for (int row = 0; row < ties.NumMyElements(); ++row) {
    rows.read(row, columns, values);
    inverse->InsertGlobalValues(ties.GID(row), columns.size(), values.data(), columns.data());
  }
  inverse->FillComplete(ties, ties);
  return inverse;
}

/// -D^-1 M without what is small, but exact for rigid motions.
void CondensedBodies::make_weights() const
{
  const Epetra_Map &ties = D->RowMap();
  Epetra_CrsMatrix product(Copy, ties, 0);
  EpetraExt::MatrixMatrix::Multiply(*about_inverse_of_D(), false, *M, false, product);
  weights = std::make_unique<Epetra_CrsMatrix>(Copy, ties, 0);
  std::vector<int> columns;
  std::vector<double> values;
  for (int tie = 0; tie < ties.NumMyElements(); ++tie) {
    int n = 0, *local = nullptr;
    double *entries = nullptr, largest = 0;
    product.ExtractMyRowView(tie, n, entries, local);
    for (int k = 0; k < n; ++k)
      largest = std::max(largest, std::abs(entries[k]));
    columns.clear();
    values.clear();
    for (int k = 0; k < n; ++k)
      if (std::abs(entries[k]) > small * largest) {
        columns.push_back(product.GCID(local[k]));
        values.push_back(-entries[k]);
      }
    weights->InsertGlobalValues(ties.GID(tie), columns.size(), values.data(), columns.data());
  }
  weights->FillComplete(A().RowMap(), ties);
  weights->OptimizeStorage();
  add_what_is_missing(*weights);
}

void CondensedBodies::add_what_is_missing(Epetra_CrsMatrix &W) const
{
  const Modes motions = modes();
  const unsigned int n_modes = motions.size();
  std::vector<Epetra_Vector> here, wanted;
  for (const std::vector<double> &motion : motions) {
    Epetra_Vector of_rows(A().RowMap()), force(W.RowMap());
    std::copy(motion.begin(), motion.end(), of_rows.Values());
    M->Multiply(false, of_rows, force);
    wanted.emplace_back(W.RowMap());
    factors->solve(wanted.back().Values(), force.Values());
    wanted.back().Scale(-1.);
    here.push_back(at_columns(W, of_rows));
  }
  std::vector<double> products(n_modes);
  std::vector<std::vector<double>> at_column(n_modes);
  for (int row = 0; row < W.NumMyRows(); ++row) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    W.ExtractMyRowView(row, n, values, columns);
    for (unsigned int m = 0; m < n_modes; ++m) {
      products[m] = wanted[m][row];
      at_column[m].clear();
      for (int k = 0; k < n; ++k)
        at_column[m].push_back(here[m][columns[k]]);
    }
    reproduce(products, at_column, values, n);
  }
}

RowSums CondensedBodies::with_followers(const RowSums &sums) const
{
  if (!weights)
    make_weights();
  std::vector<int> columns;
  std::vector<double> values;
  return sums.replaced([&](const unsigned int row, auto &entries) {
    if (place_of_row[row] < 0)
      return false;
    read_row(*weights, place_of_row[row], columns, values);
    entries.clear();
    for (unsigned int k = 0; k < columns.size(); ++k)
      entries.emplace_back(columns[k], values[k]);
    return true;
  });
}

/// What Z'^T A Z' has of the rows that follow and of the columns that do.
std::unique_ptr<Epetra_CrsMatrix> CondensedBodies::sum_of_followers() const
{
  const SparseRows rows(A());
  Epetra_Vector column_of_follower(A().ColMap()), beside_follower(A().RowMap());
  for (const int follower : followers)
    for (int k = 0; k < rows[follower].n; ++k)
      column_of_follower[rows[follower].columns[k]] = 1;
  beside_follower.Export(column_of_follower, Epetra_Import(A().ColMap(), A().RowMap()), Add);
  const auto is_concerned = [&](const int row) {
    return beside_follower[row] > 0 || place_of_row[row] >= 0 ||
           std::any_of(rows[row].columns, rows[row].columns + rows[row].n,
                       [&](const int column) { return column_follows[column]; });
  };
  std::vector<int> concerned;
  for (int row = 0; row < A().NumMyRows(); ++row)
    if (is_concerned(row))
      concerned.push_back(A().GRID(row));
  const Epetra_Map few(-1, static_cast<int>(concerned.size()), concerned.data(), 0, A().Comm());
  Epetra_CrsMatrix S(Copy, few, 0), Z(Copy, few, 0);
  std::vector<int> columns;
  std::vector<double> values;
  for (const int global_row : concerned) {
    const int row = A().LRID(global_row), tie = place_of_row[row];
    columns.clear();
    values.clear();
    for (int k = 0; k < rows[row].n; ++k)
      if (tie >= 0 || column_follows[rows[row].columns[k]]) {
        columns.push_back(A().GCID(rows[row].columns[k]));
        values.push_back(rows[row].values[k]);
      }
    S.InsertGlobalValues(global_row, columns.size(), values.data(), columns.data());
    if (tie >= 0)
      read_row(*weights, tie, columns, values);
    else {
      columns.assign(1, global_row);
      values.assign(1, 1.);
    }
    Z.InsertGlobalValues(global_row, columns.size(), values.data(), columns.data());
  }
  S.FillComplete(few, few);
  Z.FillComplete(A().RowMap(), few);
  return restrict_matrix(S, Z);
}

/// The rest of A, and @p others; rows that follow are alone.
std::unique_ptr<Epetra_CrsMatrix> CondensedBodies::sum_with(const Epetra_CrsMatrix &others) const
{
  std::vector<int> global(A().ColMap().MyGlobalElements(), A().ColMap().MyGlobalElements() + A().NumMyCols()),
      column_of_others, lengths;
  for (int column = 0; column < others.NumMyCols(); ++column) {
    const int itself = others.GCID(column), known = A().LCID(itself);
    column_of_others.push_back(known >= 0 ? known : static_cast<int>(global.size()));
    if (known < 0)
      global.push_back(itself);
  }
  const Epetra_Map all_columns(-1, static_cast<int>(global.size()), global.data(), 0, A().Comm());
  for (int row = 0; row < A().NumMyRows(); ++row)
    lengths.push_back(place_of_row[row] >= 0 ? 1 : A().NumMyEntries(row) + others.NumMyEntries(row));
  auto sum = std::make_unique<Epetra_CrsMatrix>(Copy, A().RowMap(), all_columns, lengths.data(), true);
  const SparseRows rows(A());
  const std::vector<int> column_of_row = columns_of_rows(A());
  std::vector<int> place(global.size(), -1), columns;
  std::vector<double> values;
  const auto add = [&](const int column, const double value) {
    if (place[column] < 0) {
      place[column] = columns.size();
      columns.push_back(column);
      values.push_back(value);
    } else
      values[place[column]] += value;
  };
  for (int row = 0; row < A().NumMyRows(); ++row) {
    int n = 0, *columns_there = nullptr;
    double *values_there = nullptr;
    others.ExtractMyRowView(row, n, values_there, columns_there);
    columns.clear();
    values.clear();
    if (place_of_row[row] >= 0)
      add(column_of_row[row], diagonal_of_followers);
    else
      for (int k = 0; k < rows[row].n; ++k)
        if (!column_follows[rows[row].columns[k]])
          add(rows[row].columns[k], rows[row].values[k]);
    for (int k = 0; k < n; ++k)
      add(column_of_others[columns_there[k]], values_there[k]);
    sum->InsertMyValues(row, columns.size(), values.data(), columns.data());
    for (const int column : columns)
      place[column] = -1;
  }
  sum->FillComplete(A().OperatorDomainMap(), A().OperatorRangeMap());
  sum->OptimizeStorage();
  return sum;
}

void CondensedBodies::make_condensed() const
{
  if (!is_outdated)
    return;
  condensed.reset();
  condensed_cells.reset();
  if (!weights)
    make_weights();
  condensed = sum_with(*sum_of_followers());
  if (has_cells())
    condensed_cells = body_operator.cells()->with_followers(followers, *weights);
  is_outdated = false;
}

const Epetra_CrsMatrix *CondensedBodies::entries() const
{
  make_condensed();
  return condensed.get();
}

const PartOperator *CondensedBodies::cells() const
{
  if (has_cells())
    make_condensed();
  return condensed_cells.get();
}

void CondensedBodies::diagonal(GroupVector &destination) const
{
  Epetra_Vector values(View, destination.trilinos_vector(), 0);
  LevelEntries(*entries()).diagonal(values);
  if (const PartOperator *const summand = cells())
    summand->add_diagonal(values);
}

Epetra_Vector CondensedBodies::of_followers(const GroupVector &x) const
{
  Epetra_Vector result(D->RowMap());
  for (unsigned int k = 0; k < followers.size(); ++k)
    result[k] = x.trilinos_vector()[0][followers[k]];
  return result;
}

/// Of a vector of K.
Epetra_Vector CondensedBodies::of_acting(const GroupVector &b) const
{
  Epetra_Vector result(D->RowMap());
  for (unsigned int k = 0; k < acting.size(); ++k)
    result[k] = b.trilinos_vector()[0][place_of_row.size() + acting[k]];
  return result;
}

/// u_d = D^-1 (g - M u); g = 0 if it is nullptr
void CondensedBodies::let_follow(GroupVector &u, const Epetra_Vector *const g) const
{
  Epetra_Vector rest(D->RowMap()), solved(rest);
  M->Multiply(false, Epetra_Vector(View, u.trilinos_vector(), 0), rest);
  rest.Scale(-1.);
  if (g != nullptr)
    rest.Update(1., *g, 1.);
  factors->solve(solved.Values(), rest.Values());
  for (unsigned int k = 0; k < followers.size(); ++k)
    u.trilinos_vector()[0][followers[k]] = solved[k];
}

/// Z^T r, with zeros in the rows that follow
void CondensedBodies::gather_forces(GroupVector &r) const
{
  const Epetra_Vector of_ties = of_followers(r);
  Epetra_Vector solved(D->RowMap()), forces(A().RowMap()), all(View, r.trilinos_vector(), 0);
  factors->solve_transposed(solved.Values(), of_ties.Values());
  M->Multiply(true, solved, forces);
  all.Update(-1., forces, 1.);
  for (const int row : followers)
    all[row] = 0;
}

void CondensedBodies::vmult(GroupVector &destination, const GroupVector &source) const
{
  GroupVector u(source);
  let_follow(u, nullptr);
  body_operator.vmult(destination, u);
  gather_forces(destination);
  for (const int row : followers)
    destination.trilinos_vector()[0][row] = diagonal_of_followers * source.trilinos_vector()[0][row];
}

GroupVector CondensedBodies::right_hand_side(const GroupVector &b) const
{
  GroupVector f = of_bodies(b), u = vector(), product = vector();
  const Epetra_Vector g = of_acting(b);
  let_follow(u, &g);
  body_operator.vmult(product, u);
  f -= product;
  gather_forces(f);
  return f;
}

GroupVector CondensedBodies::solution(const GroupVector &x, const GroupVector &b) const
{
  const Epetra_CrsMatrix &minus_C = block_matrix.part(multiplier_part, multiplier_part).trilinos_matrix();
  GroupVector u(x), rest = of_bodies(b), product = vector(), result(b);
  const Epetra_Vector g = of_acting(b);
  let_follow(u, &g);
  body_operator.vmult(product, u);
  rest -= product;
  Epetra_Vector lambda(g), diagonal_of_dropped(minus_C.RowMap());
  factors->solve_transposed(lambda.Values(), of_followers(rest).Values());
  balance_leaders(lambda, rest);
  minus_C.ExtractDiagonalCopy(diagonal_of_dropped);
  double *const all = result.trilinos_vector()[0], *const multipliers = all + place_of_row.size();
  std::copy(u.trilinos_vector()[0], u.trilinos_vector()[0] + place_of_row.size(), all);
  for (int i = 0; i < diagonal_of_dropped.MyLength(); ++i) // b remains there
    multipliers[i] = diagonal_of_dropped[i] != 0 ? multipliers[i] / diagonal_of_dropped[i] : 0;
  for (unsigned int k = 0; k < acting.size(); ++k)
    multipliers[acting[k]] = lambda[k];
  return result;
}

/// What rounding leaves of the forces of stiff bodies, which lambda balances, may be far more than the forces
/// of soft ones. It is left to the stiff bodies: lambda += diag(D)^-1 M y, with y such that nothing is left
/// of @p rest, f - A u, in the rows that these bodies follow.
void CondensedBodies::balance_leaders(Epetra_Vector &lambda, const GroupVector &rest) const
{
  const unsigned int most_steps = 100;
  const double tolerance = 1e-10;
  int n_here = soft_leaders.size(), n = 0;
  A().Comm().SumAll(&n_here, &n, 1);
  if (n == 0)
    return;
  const Epetra_Map &bodies = A().RowMap();
  Epetra_Vector forces(bodies), r(bodies), p(bodies), q(bodies), y(bodies), of_ties(lambda), of_D(lambda);
  D->ExtractDiagonalCopy(of_D);
  const auto find_multipliers = [&](const Epetra_Vector &leaders) {
    M->Multiply(false, leaders, of_ties);
    of_ties.ReciprocalMultiply(1., of_D, of_ties, 0.);
  };
  M->Multiply(true, lambda, forces);
  for (const int row : soft_leaders)
    p[row] = r[row] = rest.trilinos_vector()[0][row] - forces[row];
  double square = 0, product = 0;
  r.Dot(r, &square);
  const double first = square;
  for (unsigned int step = 0; step < most_steps && square > tolerance * tolerance * first; ++step) {
    find_multipliers(p);
    M->Multiply(true, of_ties, forces);
    for (const int row : soft_leaders)
      q[row] = forces[row];
    p.Dot(q, &product);
    if (!(product > 0))
      break;
    const double length = square / product, last = square;
    y.Update(length, p, 1.);
    r.Update(-length, q, 1.);
    r.Dot(r, &square);
    p.Update(1., r, square / last);
  }
  if (!(square < first))
    return;
  find_multipliers(y);
  lambda.Update(1., of_ties, 1.);
}

GroupVector CondensedBodies::of_bodies(const GroupVector &b) const
{
  GroupVector result = vector();
  const double *const given = b.trilinos_vector()[0];
  std::copy(given, given + place_of_row.size(), result.trilinos_vector()[0]);
  return result;
}

} // namespace dovetail
