// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "soft_leaders.h"

#include "factors.h"
#include "mesh_coarsening.h"
#include "semicoarsening.h"

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

double contrast(const std::vector<double> &stiffness, const Epetra_Comm &communicator)
{
  double largest = 0, minus_smallest = std::numeric_limits<double>::lowest();
  for (const double value : stiffness) {
    largest = std::max(largest, value);
    minus_smallest = std::max(minus_smallest, -value);
  }
  const std::array<double, 2> mine = {{largest, minus_smallest}};
  std::array<double, 2> extremes{};
  communicator.MaxAll(const_cast<double *>(mine.data()), extremes.data(), extremes.size());
  return extremes[0] / std::abs(extremes[1]); // infinite beside a body without stiffness
}

/// The rows that follow rows of much softer bodies: u_d = P u_s + R u_r.
struct Followers
{
  std::unique_ptr<Epetra_CrsMatrix> P, R;
};

Followers make_followers(const Epetra_Map &rows, const RowSums &sums, const std::vector<double> &stiffness)
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

  Followers result{std::make_unique<Epetra_CrsMatrix>(Copy, rows, 0),
                   std::make_unique<Epetra_CrsMatrix>(Copy, rows, 0)};
  for (unsigned int row = 0; row < sums.size(); ++row) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    all.ExtractMyRowView(row, n, values, columns);
    const auto is_softer = [&](const int column) {
      return of_rows[row] > least_contrast * of_columns[column];
    };
    const bool follows_softer = std::any_of(columns, columns + n, is_softer);
    for (int k = 0; follows_softer && k < n; ++k) {
      const int column = all.GCID(columns[k]);
      Epetra_CrsMatrix &matrix = is_softer(columns[k]) ? *result.P : *result.R;
      matrix.InsertGlobalValues(rows.GID(row), 1, &values[k], &column);
    }
  }
  result.P->FillComplete(rows, rows);
  result.R->FillComplete(rows, rows);
  return result;
}

/// P^T without small weights, with sums of one in each row, so that constants stay. Weights below zero, which
/// dual functions on triangles have, count only if a row has hardly others, as if they were above.
std::unique_ptr<Epetra_CrsMatrix> make_reverse(const Epetra_CrsMatrix &P)
{
  const double least_share = 0.2;
  EpetraExt::RowMatrix_Transpose transposer;
  const auto &transposed = dynamic_cast<Epetra_CrsMatrix &>(transposer(const_cast<Epetra_CrsMatrix &>(P)));
  auto Q = std::make_unique<Epetra_CrsMatrix>(Copy, P.RowMap(), 0);
  for (int row = 0; row < transposed.NumMyRows(); ++row) {
    int n = 0, *columns = nullptr;
    double *values = nullptr, above = 0, below = 0, sum = 0;
    transposed.ExtractMyRowView(row, n, values, columns);
    for (int k = 0; k < n; ++k) {
      above = std::max(above, values[k]);
      below = std::max(below, -values[k]);
    }
    const double sign = above > least_share * below ? 1 : -1,
                 least = least_share * (sign > 0 ? above : below);
    const auto is_small = [&](const int k) { return !(sign * values[k] > least); };
    for (int k = 0; k < n; ++k)
      sum += is_small(k) ? 0 : values[k];
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

/// Of rows that neither lead nor follow: their sums, in which a follower is P Q y + R u_r, not y. It is not
/// the same for a rotation, which the cells beside the face would resist. Rows without followers may be left
/// out.
std::unique_ptr<Epetra_CrsMatrix> sums_with_followers(const RowSums &sums, const Epetra_CrsMatrix &P,
                                                      const Epetra_CrsMatrix &R, const Epetra_CrsMatrix &Q)
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
    R.ExtractMyRowView(row, n, weights, local);
    columns.resize(n);
    std::transform(local, local + n, columns.begin(), [&R](const int column) { return R.GCID(column); });
    values.InsertGlobalValues(itself, n, weights, columns.data());
  }
  values.FillComplete(rows, rows);
  near.FillComplete(rows, rows);
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, rows, 0);
  EpetraExt::MatrixMatrix::Multiply(near, false, values, false, *result);
  return result;
}

/// What is a sum of some columns, exactly; before and after another smoother.
class ExactFirst : public Smoother
{
public:
  ExactFirst(const LevelOperator &A, const Epetra_Map &columns, const Prolongation::ReadRow &part,
             std::unique_ptr<Smoother> other);
  void smooth(double *x, const double *b, bool starts_from_zero) const override;

private:
  void solve_exactly(double *x, const double *b, bool is_zero) const;

  const LevelOperator &A;
  const Prolongation part;
  std::unique_ptr<Smoother> other;
  std::vector<std::pair<int, double>> alone; ///< row and reciprocal of its entry, without another smoother
  const Factors factors;
};

ExactFirst::ExactFirst(const LevelOperator &A, const Epetra_Map &columns, const Prolongation::ReadRow &read,
                       std::unique_ptr<Smoother> other)
    : A(A), part(A.rows(), columns, read), other(std::move(other)), factors(A.restricted(part))
{
  if (!this->other) {
    Epetra_Vector diagonal(A.rows());
    A.diagonal(diagonal);
    for (int row = 0; row < diagonal.MyLength(); ++row)
      if (A.is_condensed(row))
        alone.emplace_back(row, diagonal[row] > 0 ? 1 / diagonal[row] : 0);
  }
}

void ExactFirst::smooth(double *x, const double *b, const bool starts_from_zero) const
{
  if (starts_from_zero) {
    std::fill(x, x + A.rows().NumMyElements(), 0.);
    for (const auto &[row, inverse] : alone)
      x[row] = inverse * b[row];
    solve_exactly(x, b, true);
  }
  if (other)
    other->smooth(x, b, false);
  if (!starts_from_zero)
    solve_exactly(x, b, false);
}

void ExactFirst::solve_exactly(double *x, const double *b, const bool is_zero) const
{
  Epetra_Vector residual(A.rows(), false), solution(View, A.rows(), x), r(part.domain(), false),
      z(part.domain());
  if (is_zero)
    std::copy(b, b + residual.MyLength(), residual.Values());
  else {
    A.vmult(residual, solution);
    for (int row = 0; row < residual.MyLength(); ++row)
      residual[row] = b[row] - residual[row];
  }
  part.multiply_transposed(r, residual);
  factors.solve(z.Values(), r.Values());
  part.multiply(residual, z);
  solution.Update(1., residual, 1.);
}

} // namespace

SoftLeaders::Found SoftLeaders::find(const GroupFacts &facts, const Epetra_Map &rows,
                                     const RowSums *linear_part)
{
  const int most_leaders = 50000;
  const double least_of_means = 200; // with 100, parts of lines serve better
  if (!facts.linear_part || !facts.stiffness_of_row || facts.n_blocks < 2) // one body is as stiff as itself
    return {};
  const std::vector<double> stiffness = facts.stiffness_of_row();
  const double largest_contrast = contrast(stiffness, rows.Comm());
  if (!(largest_contrast > least_contrast))
    return {};
  const RowSums sums = linear_part != nullptr ? *linear_part : facts.linear_part();
  auto result = std::make_unique<SoftLeaders>();
  Followers followers = make_followers(rows, sums, stiffness);
  result->P = std::move(followers.P);
  result->R = std::move(followers.R);
  if (result->P->NumGlobalNonzeros() == 0)
    return {};
  result->Q = make_reverse(*result->P);
  const int n_followers = result->reverse(rows, sums);
  int n_here = result->leaders.size(), n_leaders = 0;
  rows.Comm().SumAll(&n_here, &n_leaders, 1);
  result->is_reversed = n_followers < n_leaders; // on a finer side hardly a P u_s is zero
  Found found;
  found.are_means = n_followers > n_leaders && largest_contrast > least_of_means;
  if (n_leaders > most_leaders ||
      (!result->is_reversed && !has_mixed_bodies(facts, GroupFacts::large_contrast)))
    return found;
  if (!result->is_reversed)
    result->sums = sums;
  result->find_following_bodies(facts, rows);
  found.leaders = std::move(result);
  return found;
}

/// The sums in which the leaders follow, and the leaders. @return the number of followers of all ranks
int SoftLeaders::reverse(const Epetra_Map &rows, const RowSums &given)
{
  int n_here = 0, n_followers = 0;
  GroupFacts::Sum sum;
  const auto others = sums_with_followers(given, *P, *R, *Q);
  const auto append = [&sum](const Epetra_CrsMatrix &matrix, const int row) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    matrix.ExtractMyRowView(row, n, values, columns);
    for (int k = 0; k < n; ++k)
      sum.emplace_back(matrix.GCID(columns[k]), values[k]);
  };
  for (int row = 0; row < rows.NumMyElements(); ++row) {
    const bool leads = Q->NumMyEntries(row) > 0, follows = P->NumMyEntries(row) > 0;
    sum.clear();
    append(leads ? *Q : *others, row);
    if (leads)
      leaders.push_back(row);
    if (follows)
      ++n_here;
    if (follows && !leads)
      sum.emplace_back(rows.GID(row), 1.);
    if (!follows && sum.empty())
      for (unsigned int k = 0; k < given[row].n; ++k)
        sum.emplace_back(given[row].columns[k], given[row].weights[k]);
    sums.add_row(sum);
  }
  rows.Comm().SumAll(&n_here, &n_followers, 1);
  return n_followers;
}

/// Of a group whose places are not known, all bodies count as one.
void SoftLeaders::find_following_bodies(const GroupFacts &facts, const Epetra_Map &rows)
{
  const auto places = facts.known_places();
  body.assign(rows.NumMyElements(), 0);
  for (unsigned int row = 0; row < places.size(); ++row)
    body[row] = places[row].block;
  std::vector<int> follows_here(number_of_bodies(body, rows.Comm()), 0);
  for (unsigned int row = 0; row < body.size(); ++row)
    if (P->NumMyEntries(row) > 0)
      follows_here[body[row]] = 1;
  follows.resize(follows_here.size());
  rows.Comm().MaxAll(follows_here.data(), follows.data(), follows.size());
}

/// P Q y = u_d - R u_r in the sense of least squares, by conjugate gradients from y = u_d.
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
    Epetra_Vector y(View, *result, mode), others(modes.Map());
    R->Multiply(false, Epetra_Vector(View, modes, mode), others);
    product(y, r);
    for (int row = 0; row < modes.MyLength(); ++row)
      r[row] = P->NumMyEntries(row) > 0 ? y[row] - others[row] - r[row] : 0;
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

/// The leaders, and after those of the first rank the motions of each body that follows.
std::unique_ptr<Smoother> SoftLeaders::exact_first(const LevelOperator &A, const Epetra_MultiVector &modes,
                                                   std::unique_ptr<Smoother> other) const
{
  const int fewest_rows = 4; // motions of less may depend on each other
  const Epetra_Comm &communicator = A.rows().Comm();
  const int n_modes = modes.NumVectors();
  std::vector<int> here(follows.size() * n_modes, 0), number(here);
  const auto moves = [&](const int row, const int mode) {
    return follows[body[row]] != 0 && modes[mode][row] != 0 && !A.is_condensed(row);
  };
  for (int row = 0; row < modes.MyLength(); ++row)
    for (int mode = 0; mode < n_modes; ++mode)
      if (moves(row, mode))
        ++here[body[row] * n_modes + mode];
  communicator.SumAll(here.data(), number.data(), here.size());
  int n_motions = 0, n_first = leaders.size();
  for (int &n : number)
    n = n >= fewest_rows ? n_motions++ : -1;
  communicator.Broadcast(&n_first, 1, 0);
  const int n_own = static_cast<int>(leaders.size()) + (communicator.MyPID() == 0 ? n_motions : 0);
  const Epetra_Map columns(-1, n_own, 0, communicator);
  std::vector<int> of_leader(A.rows().NumMyElements(), -1);
  for (unsigned int i = 0; i < leaders.size(); ++i)
    of_leader[leaders[i]] = columns.GID(i);
  const auto read = [&](const int row, std::vector<int> &of_row, std::vector<double> &weights) {
    of_row.assign(of_leader[row] < 0 ? 0 : 1, of_leader[row]);
    weights.assign(of_row.size(), 1.);
    for (int mode = 0; of_leader[row] < 0 && mode < n_modes; ++mode)
      if (const int motion = moves(row, mode) ? number[body[row] * n_modes + mode] : -1; motion >= 0) {
        of_row.push_back(n_first + motion);
        weights.push_back(modes[mode][row]);
      }
  };
  return std::make_unique<ExactFirst>(A, columns, read, std::move(other));
}

std::unique_ptr<DegreeCoarsening> SoftLeaders::coarsen(const LevelOperator &A, const GroupFacts &facts,
                                                       const DegreeCoarsening::MakeModes &make_modes,
                                                       std::unique_ptr<Smoother> other,
                                                       const DegreeCoarsening::MakeCoarse &make_coarse) const
{
  return std::make_unique<DegreeCoarsening>(
      A, RowSums(sums),
      [&](const Epetra_Map &map, const Selection *rows) {
        return is_reversed ? select_rows(*reversed_modes(*make_modes(A.rows(), nullptr)), map, *rows)
                           : make_modes(map, rows);
      },
      facts, exact_first(A, *make_modes(A.rows(), nullptr), std::move(other)), make_coarse);
}

std::unique_ptr<DegreeCoarsening> coarsen_degree(const LevelOperator &A, const GroupFacts &facts,
                                                 const DegreeCoarsening::MakeModes &make_modes,
                                                 std::unique_ptr<Smoother> smoother, CoarseSolve &coarse)
{
  RowSums sums = facts.linear_part();
  const auto [leaders, are_means] = SoftLeaders::find(facts, A.rows(), &sums);
  if (coarse == CoarseSolve::by_levels && leaders && has_mixed_bodies(facts, GroupFacts::large_contrast))
    coarse = CoarseSolve::within_bodies;
  DegreeCoarsening::MakeCoarse make_coarse = DegreeCoarsening::make_usual_coarse;
  if (coarse == CoarseSolve::by_factors)
    make_coarse = [](Cycle::Finest A_1, const auto &, const std::vector<GroupFacts::Place> &places) {
      return std::make_unique<FactorisedCycle>(std::move(A_1), nodes_of_rows(places).first_row);
    };
  else if (coarse == CoarseSolve::within_bodies)
    make_coarse = make_cycle_within_bodies;
  else if (are_means)
    make_coarse = make_cycle_of_whole_lines;
  else if (has_mixed_bodies(facts, GroupFacts::small_contrast))
    make_coarse = [&coarse](Cycle::Finest A_1, auto modes, auto places) {
      if (!are_all_known(places, A_1.matrix()) || are_mostly_stretched(A_1.matrix(), nodes_of_rows(places)))
        return DegreeCoarsening::make_usual_coarse(std::move(A_1), std::move(modes), std::move(places));
      coarse = CoarseSolve::within_bodies;
      return make_cycle_within_bodies(std::move(A_1), std::move(modes), std::move(places));
    };
  if (leaders)
    return leaders->coarsen(A, facts, make_modes, std::move(smoother), make_coarse);
  const bool has_levels = facts.mesh_levels && coarse != CoarseSolve::by_factors;
  const MeshLevels levels = has_levels ? facts.mesh_levels(false) : MeshLevels();
  return std::make_unique<DegreeCoarsening>(A, std::move(sums), make_modes, facts, std::move(smoother),
                                            make_coarse, has_levels ? &levels : nullptr);
}

} // namespace dovetail
