// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "degree_coarsening.h"
#include "semicoarsening.h"

#include <dovetail/solve/free_memory.h>
#include <dovetail/solve/rows_of_other_ranks.h>

#include <Epetra_Map.h>

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>
#include <vector>

namespace dovetail {

DegreeCoarsening::DegreeCoarsening(const LevelOperator &A, RowSums &&sums, const MakeModes &make_modes,
                                   const GroupFacts &facts, std::unique_ptr<Smoother> given_smoother,
                                   const MakeCoarse &make_coarse)
    : A(A), smoother(std::move(given_smoother))
{
  give_back_freed_memory();
  prolongation = make_prolongation(std::move(sums));
  if (prolongation->domain().NumGlobalElements() == 0) // all vertices are prescribed
    return;
  auto modes = make_modes(prolongation->domain(), &coarse_rows);
  std::vector<GroupFacts::Place> places = facts.known_places(&coarse_rows);
  coarse_rows = Selection(); // = {} would keep the memory
  give_back_freed_memory();
  auto A_1 = A.restricted(*prolongation);
  give_back_freed_memory();
  coarse = make_coarse(std::move(A_1), std::move(modes), std::move(places));
}

std::unique_ptr<Epetra_MultiVector> DegreeCoarsening::select(const Epetra_MultiVector &modes,
                                                             const Epetra_Map &map, const Selection &rows)
{
  auto result = std::make_unique<Epetra_MultiVector>(map, modes.NumVectors());
  for (unsigned int i = 0; i < rows.size(); ++i)
    for (int mode = 0; mode < modes.NumVectors(); ++mode)
      (*result)[mode][i] = modes[mode][rows[i]];
  return result;
}

std::unique_ptr<Cycle> DegreeCoarsening::make_usual_coarse(Cycle::Finest A_1,
                                                           std::shared_ptr<const Epetra_MultiVector> modes,
                                                           std::vector<GroupFacts::Place> places)
{
  return make_cycle_with_factorisations(std::move(A_1), std::move(modes), std::move(places),
                                        Semicoarsen::if_cheap, false); // costs little beside the rows of A
}

/// What functions of degree one leave reaches the further down the higher the degree is. Solves in cells see
/// all functions of the degree.
std::unique_ptr<ChebyshevSmoother> DegreeCoarsening::usual_smoother(const LevelOperator &A,
                                                                    const unsigned int degree)
{
  if (auto M = A.approximation())
    return ChebyshevSmoother::with_approximation(A, std::move(M), {std::max(3u, degree), 7. * degree + 1});
  return ChebyshevSmoother::with_diagonal(A, {degree + 1, 12.5 * degree - 10});
}

namespace {

/// Rows as sums of unknowns of the coarse matrix: in the sums that are given, rows that are sums themselves
/// are replaced, also those of other ranks. Own rows of this kind are remembered.
class FinalSums
{
public:
  using Sum = GroupFacts::Sum;

  /// @param number of own rows that are unknowns of the coarse matrix, others are negative. Collective.
  FinalSums(const RowSums &sums, const Epetra_Map &rows, const std::vector<int> &number);
  /// Numbers of unknowns of the coarse matrix and weights. Until the next call.
  const Sum &operator[](int row);

private:
  /// What is not known yet of a row of another rank: in place of its number.
  static int unknown(const int row) { return -1 - row; }

  int code(const int column) const ///< the number of an unknown, or unknown(column)
  {
    const int own = rows.LID(column);
    return own >= 0 && number[own] >= 0 ? number[own] : unknown(column);
  }
  void get_other_ranks();
  void expand(int row);
  void add(int code, double weight, std::map<int, double> &sum);

  const RowSums &sums;
  const Epetra_Map &rows;
  const std::vector<int> &number;
  std::vector<bool> is_done;
  std::unordered_map<int, Sum> replaced, of_others; ///< by own row, by global row
  Sum result;
};

FinalSums::FinalSums(const RowSums &sums, const Epetra_Map &rows, const std::vector<int> &number)
    : sums(sums), rows(rows), number(number), is_done(sums.size())
{
  if (rows.Comm().NumProc() > 1)
    get_other_ranks();
}

void FinalSums::get_other_ranks()
{
  std::set<int> missing;
  for (unsigned int row = 0; row < sums.size(); ++row)
    for (unsigned int k = 0; k < sums[row].n; ++k)
      if (const int column = sums[row].columns[k]; !rows.MyGID(column))
        missing.insert(column);
  const auto is_any_missing = [&]() {
    int here = missing.empty() ? 0 : 1, anywhere = 0;
    rows.Comm().MaxAll(&here, &anywhere, 1);
    return anywhere != 0;
  };
  while (is_any_missing()) {
    const std::vector<int> wanted(missing.begin(), missing.end());
    const auto received = rows_of_other_ranks(
        rows, wanted, [this](const int row, std::vector<int> &columns, std::vector<double> &weights) {
          columns.clear();
          weights.clear();
          for (const auto &[column, weight] : (*this)[row]) {
            columns.push_back(column);
            weights.push_back(weight);
          }
        });
    for (unsigned int i = 0; i < wanted.size(); ++i) {
      Sum &sum = of_others[wanted[i]]; // a fixed value has none
      for (unsigned int k = 0; k < received[i].columns.size(); ++k)
        sum.emplace_back(received[i].columns[k], received[i].values[k]);
    }
    missing.clear();
    for (const auto &of_row : received)
      for (const int column : of_row.columns)
        if (column < 0 && !rows.MyGID(unknown(column)) && of_others.count(unknown(column)) == 0)
          missing.insert(unknown(column));
  }
  replaced.clear();
  is_done.assign(sums.size(), false);
}

const FinalSums::Sum &FinalSums::operator[](const int row)
{
  expand(row);
  if (const auto found = replaced.find(row); found != replaced.end())
    return found->second;
  result.clear();
  const RowSums::Row sum = sums[row];
  for (unsigned int k = 0; k < sum.n; ++k)
    result.emplace_back(code(sum.columns[k]), sum.weights[k]);
  return result;
}

void FinalSums::expand(const int row)
{
  if (is_done[row] || number[row] >= 0)
    return;
  is_done[row] = true;
  const RowSums::Row given = sums[row];
  const bool is_final = std::all_of(given.columns, given.columns + given.n,
                                    [this](const int column) { return code(column) >= 0; });
  if (is_final)
    return;
  std::map<int, double> sum;
  for (unsigned int k = 0; k < given.n; ++k)
    add(code(given.columns[k]), given.weights[k], sum);
  replaced[row].assign(sum.begin(), sum.end());
}

void FinalSums::add(const int code, const double weight, std::map<int, double> &sum)
{
  const auto add_all = [&](const Sum &others) {
    for (const auto &[column, its_weight] : others)
      add(column, weight * its_weight, sum);
  };
  if (code >= 0)
    sum[code] += weight;
  else if (const int own = rows.LID(unknown(code)); own >= 0)
    add_all(Sum((*this)[own]));
  else if (const auto found = of_others.find(unknown(code)); found != of_others.end())
    add_all(found->second);
  else
    sum[code] += weight;
}

} // namespace

/// P.
std::unique_ptr<Prolongation> DegreeCoarsening::make_prolongation(RowSums &&given_sums)
{
  const RowSums sums = std::move(given_sums);
  for (unsigned int row = 0; row < sums.size(); ++row)
    if (sums.is_only(row, A.rows().GID(row)))
      coarse_rows.push_back(row);
  const Epetra_Map coarse(-1, static_cast<int>(coarse_rows.size()), 0, A.rows().Comm());
  std::vector<int> number(sums.size(), -1);
  for (unsigned int i = 0; i < coarse_rows.size(); ++i)
    number[coarse_rows[i]] = coarse.GID(i);
  FinalSums final_sums(sums, A.rows(), number);
  // a condensed unknown is alone in its row of the matrix, and found afterwards from those it follows
  return std::make_unique<Prolongation>(
      A.rows(), coarse, [&](const int row, std::vector<int> &columns, std::vector<double> &weights) {
        columns.clear();
        weights.clear();
        if (A.is_condensed(row))
          return;
        for (const auto &[column, weight] : final_sums[row])
          if (weight != 0) {
            columns.push_back(column);
            weights.push_back(weight);
          }
      });
}

void DegreeCoarsening::vmult(Epetra_Vector &x, const Epetra_Vector &b) const
{
  smoother->smooth(x.Values(), b.Values(), true);
  if (coarse)
    correct(x, b);
  smoother->smooth(x.Values(), b.Values(), false);
}

/// By the functions of degree one.
void DegreeCoarsening::correct(Epetra_Vector &x, const Epetra_Vector &b) const
{
  Epetra_Vector residual(A.rows(), false), coarse_b(prolongation->domain(), false),
      coarse_x(prolongation->domain());
  A.vmult(residual, x);
  residual.Update(1., b, -1.);
  prolongation->multiply_transposed(coarse_b, residual);
  coarse->vmult(coarse_x, coarse_b);
  prolongation->multiply(residual, coarse_x);
  x.Update(1., residual, 1.);
}

} // namespace dovetail
