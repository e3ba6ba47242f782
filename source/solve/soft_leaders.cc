// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "soft_leaders.h"

#include "factors.h"

#include <EpetraExt_MatrixMatrix.h>
#include <EpetraExt_Transpose_RowMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_Map.h>
#include <Epetra_Vector.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace dovetail {

namespace {

const double least_contrast = 30;

bool is_contrast_large(const std::vector<double> &stiffness, const Epetra_Comm &communicator)
{
  double largest = 0, minus_smallest = std::numeric_limits<double>::lowest();
  for (const double value : stiffness) {
    largest = std::max(largest, value);
    minus_smallest = std::max(minus_smallest, -value);
  }
  const std::array<double, 2> mine = {{largest, minus_smallest}};
  std::array<double, 2> extremes{};
  communicator.MaxAll(const_cast<double *>(mine.data()), extremes.data(), extremes.size());
  return extremes[0] > -least_contrast * extremes[1];
}

/// P: the sums of those rows that follow rows of much softer bodies.
std::unique_ptr<Epetra_CrsMatrix> make_followers(const Epetra_Map &rows, const RowSums &sums,
                                                 const std::vector<double> &stiffness)
{
  Epetra_CrsMatrix all(Copy, rows, 0);
  for (unsigned int row = 0; row < sums.size(); ++row)
    for (unsigned int k = 0; k < sums[row].n; ++k)
      if (const int column = sums[row].columns[k]; column != rows.GID(row))
        all.InsertGlobalValues(rows.GID(row), 1, &sums[row].weights[k], &column);
  all.FillComplete(rows, rows);
  Epetra_Vector of_rows(rows), of_columns(all.ColMap());
  std::copy(stiffness.begin(), stiffness.end(), of_rows.Values());
  of_columns.Import(of_rows, Epetra_Import(all.ColMap(), rows), Insert);

  auto P = std::make_unique<Epetra_CrsMatrix>(Copy, rows, 0);
  for (unsigned int row = 0; row < sums.size(); ++row) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    all.ExtractMyRowView(row, n, values, columns);
    const bool follows_softer = std::any_of(columns, columns + n, [&](const int column) {
      return of_rows[row] > least_contrast * of_columns[column];
    });
    for (int k = 0; follows_softer && k < n; ++k) {
      const int column = all.GCID(columns[k]);
      P->InsertGlobalValues(rows.GID(row), 1, &values[k], &column);
    }
  }
  P->FillComplete(rows, rows);
  return P;
}

/// P^T without small weights, with sums of one (of absolute values) in each row.
std::unique_ptr<Epetra_CrsMatrix> make_reverse(const Epetra_CrsMatrix &P)
{
  const double least_share = 0.2;
  EpetraExt::RowMatrix_Transpose transposer;
  const auto &transposed = dynamic_cast<Epetra_CrsMatrix &>(transposer(const_cast<Epetra_CrsMatrix &>(P)));
  auto Q = std::make_unique<Epetra_CrsMatrix>(Copy, P.RowMap(), 0);
  for (int row = 0; row < transposed.NumMyRows(); ++row) {
    int n = 0, *columns = nullptr;
    double *values = nullptr, largest = 0, sum = 0;
    transposed.ExtractMyRowView(row, n, values, columns);
    for (int k = 0; k < n; ++k)
      largest = std::max(largest, std::abs(values[k]));
    const auto is_small = [&](const int k) { return !(std::abs(values[k]) > least_share * largest); };
    for (int k = 0; k < n; ++k)
      sum += is_small(k) ? 0 : std::abs(values[k]);
    for (int k = 0; k < n; ++k)
      if (!is_small(k)) {
        const int column = transposed.GCID(columns[k]);
        const double weight = values[k] / sum;
        Q->InsertGlobalValues(P.GRID(row), 1, &weight, &column);
      }
  }
  Q->FillComplete(P.RowMap(), P.RowMap());
  return Q;
}

/// Of rows that neither lead nor follow: their sums, in which a follower is P Q y, not y. It is not the same
/// for a rotation, which the cells beside the face would resist. Rows without followers may be left out.
std::unique_ptr<Epetra_CrsMatrix> sums_with_followers(const RowSums &sums, const Epetra_CrsMatrix &P,
                                                      const Epetra_CrsMatrix &Q)
{
  const Epetra_Map &rows = P.RowMap();
  Epetra_CrsMatrix PQ(Copy, rows, 0), values(Copy, rows, 0), near(Copy, rows, 0);
  EpetraExt::MatrixMatrix::Multiply(P, false, Q, false, PQ);
  std::vector<int> columns;
  for (int row = 0; row < rows.NumMyElements(); ++row) {
    const int itself = rows.GID(row);
    if (P.NumMyEntries(row) == 0) {
      const double one = 1;
      values.InsertGlobalValues(itself, 1, &one, &itself);
      const RowSums::Row sum = sums[row];
      columns.assign(sum.columns, sum.columns + sum.n);
      const auto may_follow = [&](const int column) {
        return !rows.MyGID(column) || P.NumMyEntries(rows.LID(column)) > 0;
      };
      if (Q.NumMyEntries(row) == 0 && std::any_of(columns.begin(), columns.end(), may_follow))
        near.InsertGlobalValues(itself, sum.n, sum.weights, columns.data());
      continue;
    }
    int n = 0, *local = nullptr;
    double *weights = nullptr;
    PQ.ExtractMyRowView(row, n, weights, local);
    columns.resize(n);
    std::transform(local, local + n, columns.begin(), [&PQ](const int column) { return PQ.GCID(column); });
    values.InsertGlobalValues(itself, n, weights, columns.data());
  }
  values.FillComplete(rows, rows);
  near.FillComplete(rows, rows);
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, rows, 0);
  EpetraExt::MatrixMatrix::Multiply(near, false, values, false, *result);
  return result;
}

class LeadersFirst : public Smoother
{
public:
  LeadersFirst(const LevelOperator &A, const std::vector<int> &leaders, std::unique_ptr<Smoother> other);
  void smooth(double *x, const double *b, bool starts_from_zero) const override;

private:
  void solve_for_leaders(double *x, const double *b, bool is_zero) const;

  const LevelOperator &A;
  const std::vector<int> leaders; ///< own rows
  std::unique_ptr<Smoother> other;
  std::vector<std::pair<int, double>> alone; ///< row and reciprocal of its entry, without another smoother
  std::unique_ptr<Factors> factors;
};

LeadersFirst::LeadersFirst(const LevelOperator &A, const std::vector<int> &leaders,
                           std::unique_ptr<Smoother> other)
    : A(A), leaders(leaders), other(std::move(other))
{
  const Epetra_Map of_leaders(-1, static_cast<int>(leaders.size()), 0, A.rows().Comm());
  std::vector<int> number(A.rows().NumMyElements(), -1);
  for (unsigned int i = 0; i < leaders.size(); ++i)
    number[leaders[i]] = of_leaders.GID(i);
  const Prolongation injection(A.rows(), of_leaders,
                               [&](const int row, std::vector<int> &columns, std::vector<double> &weights) {
                                 columns.assign(number[row] < 0 ? 0 : 1, number[row]);
                                 weights.assign(columns.size(), 1.);
                               });
  factors = std::make_unique<Factors>(A.restricted(injection));
  if (!this->other) {
    Epetra_Vector diagonal(A.rows());
    A.diagonal(diagonal);
    for (int row = 0; row < diagonal.MyLength(); ++row)
      if (A.is_condensed(row))
        alone.emplace_back(row, diagonal[row] > 0 ? 1 / diagonal[row] : 0);
  }
}

void LeadersFirst::smooth(double *x, const double *b, const bool starts_from_zero) const
{
  if (starts_from_zero) {
    std::fill(x, x + A.rows().NumMyElements(), 0.);
    for (const auto &[row, inverse] : alone)
      x[row] = inverse * b[row];
    solve_for_leaders(x, b, true);
  }
  if (other)
    other->smooth(x, b, false);
  if (!starts_from_zero)
    solve_for_leaders(x, b, false);
}

void LeadersFirst::solve_for_leaders(double *x, const double *b, const bool is_zero) const
{
  Epetra_Vector residual(A.rows(), false);
  if (!is_zero)
    A.vmult(residual, Epetra_Vector(View, A.rows(), x));
  std::vector<double> r(leaders.size()), z(leaders.size());
  for (unsigned int i = 0; i < leaders.size(); ++i)
    r[i] = b[leaders[i]] - (is_zero ? 0 : residual[leaders[i]]);
  factors->solve(z.data(), r.data());
  for (unsigned int i = 0; i < leaders.size(); ++i)
    x[leaders[i]] += z[i];
}

} // namespace

std::unique_ptr<SoftLeaders> SoftLeaders::find(const GroupFacts &facts, const Epetra_Map &rows,
                                               const RowSums *linear_part)
{
  const int most_leaders = 50000;
  const double largest_ratio = 1; // of followers to leaders: on a finer side hardly a P u_s is zero
  if (!facts.linear_part || !facts.stiffness_of_row || facts.n_blocks < 2) // one body is as stiff as itself
    return nullptr;
  const std::vector<double> stiffness = facts.stiffness_of_row();
  if (!is_contrast_large(stiffness, rows.Comm()))
    return nullptr;
  const RowSums sums = linear_part != nullptr ? *linear_part : facts.linear_part();
  auto result = std::make_unique<SoftLeaders>();
  result->P = make_followers(rows, sums, stiffness);
  if (result->P->NumGlobalNonzeros() == 0)
    return nullptr;
  result->Q = make_reverse(*result->P);
  std::array<int, 2> counts{}, sums_of_counts{}; // of leaders and followers
  GroupFacts::Sum sum;
  const auto others = sums_with_followers(sums, *result->P, *result->Q);
  const auto append = [&sum](const Epetra_CrsMatrix &matrix, const int row) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    matrix.ExtractMyRowView(row, n, values, columns);
    for (int k = 0; k < n; ++k)
      sum.emplace_back(matrix.GCID(columns[k]), values[k]);
  };
  for (int row = 0; row < rows.NumMyElements(); ++row) {
    const bool leads = result->Q->NumMyEntries(row) > 0, follows = result->P->NumMyEntries(row) > 0;
    sum.clear();
    append(leads ? *result->Q : *others, row);
    if (leads)
      result->leaders.push_back(row);
    if (follows)
      ++counts[1];
    if (follows && !leads)
      sum.emplace_back(rows.GID(row), 1.);
    if (!follows && sum.empty())
      for (unsigned int k = 0; k < sums[row].n; ++k)
        sum.emplace_back(sums[row].columns[k], sums[row].weights[k]);
    result->reversed.add_row(sum);
  }
  counts[0] = result->leaders.size();
  rows.Comm().SumAll(counts.data(), sums_of_counts.data(), counts.size());
  const bool is_useful =
      sums_of_counts[1] < largest_ratio * sums_of_counts[0] && sums_of_counts[0] <= most_leaders;
  return is_useful ? std::move(result) : nullptr;
}

/// P Q y = u_d in the sense of least squares, by conjugate gradients from y = u_d.
std::unique_ptr<Epetra_MultiVector> SoftLeaders::reversed_modes(const Epetra_MultiVector &modes) const
{
  const unsigned int most_steps = 200;
  const double tolerance = 1e-8;
  auto result = std::make_unique<Epetra_MultiVector>(modes);
  Epetra_Vector of_leaders(modes.Map()), r(of_leaders), s(of_leaders), p(of_leaders), q(of_leaders);
  const auto product = [&](const Epetra_Vector &x, Epetra_Vector &y) {
    Q->Multiply(false, x, of_leaders);
    P->Multiply(false, of_leaders, y);
  };
  for (int mode = 0; mode < modes.NumVectors(); ++mode) {
    Epetra_Vector y(View, *result, mode);
    product(y, r);
    for (int row = 0; row < modes.MyLength(); ++row)
      r[row] = P->NumMyEntries(row) > 0 ? y[row] - r[row] : 0;
    double first = 0, last = 0;
    for (unsigned int step = 0; step < most_steps; ++step) {
      P->Multiply(true, r, of_leaders);
      Q->Multiply(true, of_leaders, s);
      double now = 0, length = 0;
      s.Dot(s, &now);
      first = step == 0 ? now : first;
      if (!(now > tolerance * tolerance * first))
        break;
      p.Update(1., s, step == 0 ? 0 : now / last);
      last = now;
      product(p, q);
      q.Dot(q, &length);
      y.Update(now / length, p, 1.);
      r.Update(-now / length, q, 1.);
    }
  }
  return result;
}

std::unique_ptr<DegreeCoarsening> SoftLeaders::coarsen(const LevelOperator &A, const GroupFacts &facts,
                                                       const DegreeCoarsening::MakeModes &make_modes,
                                                       std::unique_ptr<Smoother> other,
                                                       const DegreeCoarsening::MakeCoarse &make_coarse) const
{
  return std::make_unique<DegreeCoarsening>(
      A, RowSums(reversed),
      [&](const Epetra_Map &map, const Selection *rows) {
        return DegreeCoarsening::select(*reversed_modes(*make_modes(A.rows(), nullptr)), map, *rows);
      },
      facts, std::make_unique<LeadersFirst>(A, leaders, std::move(other)), make_coarse);
}

std::unique_ptr<DegreeCoarsening> coarsen_degree(const LevelOperator &A, const GroupFacts &facts,
                                                 const DegreeCoarsening::MakeModes &make_modes,
                                                 std::unique_ptr<Smoother> smoother,
                                                 const DegreeCoarsening::MakeCoarse &make_coarse)
{
  RowSums sums = facts.linear_part();
  if (const auto leaders = SoftLeaders::find(facts, A.rows(), &sums))
    return leaders->coarsen(A, facts, make_modes, std::move(smoother), make_coarse);
  return std::make_unique<DegreeCoarsening>(A, std::move(sums), make_modes, facts, std::move(smoother),
                                            make_coarse);
}

} // namespace dovetail
