// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "semicoarsening.h"

#include <deal.II/base/exceptions.h>
#include <deal.II/lac/full_matrix.h>

#include <EpetraExt_MatrixMatrix.h>
#include <Epetra_Map.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace dovetail {

namespace {

const unsigned int none = std::numeric_limits<unsigned int>::max();

double distance(const std::array<double, 3> &a, const std::array<double, 3> &b)
{
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

std::vector<unsigned int> node_of_rows(const LevelNodes &nodes)
{
  std::vector<unsigned int> node(nodes.first_row.back());
  for (unsigned int n = 0; n < nodes.size(); ++n)
    std::fill(node.begin() + nodes.first_row[n], node.begin() + nodes.first_row[n + 1], n);
  return node;
}

/// Calls @p action(column, value) for the entries of an own row that are not zero; column: the own row of the
/// same number, or -1.
template <typename Action>
void for_entries(const Epetra_CrsMatrix &A, const int row, const Action &action)
{
  int n = 0, *columns = nullptr;
  double *values = nullptr;
  A.ExtractMyRowView(row, n, values, columns);
  for (int k = 0; k < n; ++k)
    if (values[k] != 0)
      action(A.Importer() == nullptr ? columns[k] : A.LRID(A.GCID(columns[k])), values[k], k);
}

NodeGraph graph_of(const Epetra_CrsMatrix &A, const LevelNodes &nodes)
{
  const std::vector<unsigned int> node = node_of_rows(nodes);
  NodeGraph graph(nodes.size());
  for (unsigned int n = 0; n < nodes.size(); ++n) {
    for (int row = nodes.first_row[n]; row < nodes.first_row[n + 1]; ++row)
      for_entries(A, row, [&](const int column, double, int) {
        if (column >= 0 && node[column] != n)
          graph[n].push_back(node[column]);
      });
    std::sort(graph[n].begin(), graph[n].end());
    graph[n].erase(std::unique(graph[n].begin(), graph[n].end()), graph[n].end());
  }
  return graph;
}

/// By node the aggregate that it belongs to, or none if nothing is coupled with it; and the root of each.
struct Aggregates
{
  explicit Aggregates(const NodeGraph &near, const NodeGraph &all);

  std::vector<unsigned int> of_node, root;

private:
  void begin(unsigned int node, const NodeGraph &near);
};

void Aggregates::begin(const unsigned int node, const NodeGraph &near)
{
  of_node[node] = root.size();
  for (const unsigned int neighbour : near[node])
    if (of_node[neighbour] == none)
      of_node[neighbour] = root.size();
  root.push_back(node);
}

/// Neighbourhoods that are free; then what is left joins the aggregate next to it of which it sees most.
Aggregates::Aggregates(const NodeGraph &near, const NodeGraph &all) : of_node(near.size(), none)
{
  for (unsigned int node = 0; node < near.size(); ++node)
    if (of_node[node] == none && !near[node].empty() &&
        std::all_of(near[node].begin(), near[node].end(),
                    [this](const auto j) { return of_node[j] == none; }))
      begin(node, near);
  const std::vector<unsigned int> first = of_node;
  std::vector<unsigned int> seen(root.size(), 0);
  for (unsigned int node = 0; node < near.size(); ++node)
    if (of_node[node] == none) {
      for (const unsigned int neighbour : near[node])
        if (const unsigned int aggregate = first[neighbour]; aggregate != none)
          if (++seen[aggregate]; of_node[node] == none || seen[aggregate] > seen[of_node[node]])
            of_node[node] = aggregate;
      for (const unsigned int neighbour : near[node])
        if (first[neighbour] != none)
          seen[first[neighbour]] = 0;
    }
  for (unsigned int node = 0; node < near.size(); ++node)
    if (of_node[node] == none && !all[node].empty())
      begin(node, near);
}

/// What an aggregate adds to T: an orthonormal basis of the modes on its rows, and what the modes are in it.
struct Basis
{
  std::vector<std::vector<double>> columns;      ///< [column][row of the aggregate]
  std::vector<std::vector<double>> coefficients; ///< [column][mode]
};

Basis make_basis(const std::vector<int> &rows, const Epetra_MultiVector &modes)
{
  const double least = 1e-7;
  Basis basis;
  for (int mode = 0; mode < modes.NumVectors(); ++mode) {
    std::vector<double> v(rows.size());
    for (unsigned int i = 0; i < rows.size(); ++i)
      v[i] = modes[mode][rows[i]];
    const auto norm = [&v]() { return std::sqrt(std::inner_product(v.begin(), v.end(), v.begin(), 0.)); };
    const double before = norm();
    if (before == 0)
      continue;
    for (unsigned int pass = 0; pass < 2; ++pass)
      for (unsigned int k = 0; k < basis.columns.size(); ++k) {
        const auto &q = basis.columns[k];
        const double part = std::inner_product(v.begin(), v.end(), q.begin(), 0.);
        basis.coefficients[k][mode] += part;
        for (unsigned int i = 0; i < v.size(); ++i)
          v[i] -= part * q[i];
      }
    const double after = norm();
    if (after <= least * before)
      continue;
    for (double &x : v)
      x /= after;
    basis.columns.push_back(v);
    basis.coefficients.emplace_back(modes.NumVectors(), 0.);
    basis.coefficients.back()[mode] = after;
  }
  return basis;
}

/// T, and the nodes and modes of the coarse level.
struct Coarse
{
  std::unique_ptr<Epetra_CrsMatrix> T;
  LevelNodes nodes;
  std::unique_ptr<Epetra_MultiVector> modes;
};

std::vector<std::vector<int>> rows_of_aggregates(const Epetra_CrsMatrix &A, const LevelNodes &nodes,
                                                 const Aggregates &aggregates)
{
  std::vector<std::vector<int>> rows(aggregates.root.size());
  for (unsigned int node = 0; node < nodes.size(); ++node)
    if (aggregates.of_node[node] != none)
      for (int row = nodes.first_row[node]; row < nodes.first_row[node + 1]; ++row) {
        bool is_coupled = false; // or prescribed
        for_entries(A, row, [&](const int column, double, int) { is_coupled = is_coupled || column != row; });
        if (is_coupled)
          rows[aggregates.of_node[node]].push_back(row);
      }
  return rows;
}

Coarse make_coarse(const Epetra_CrsMatrix &A, const LevelNodes &nodes, const Epetra_MultiVector &modes,
                   const Aggregates &aggregates)
{
  const std::vector<std::vector<int>> rows = rows_of_aggregates(A, nodes, aggregates);
  Coarse coarse;
  std::vector<Basis> bases;
  coarse.nodes.first_row = {0};
  for (unsigned int i = 0; i < rows.size(); ++i) {
    bases.push_back(make_basis(rows[i], modes));
    coarse.nodes.first_row.push_back(coarse.nodes.first_row.back() + bases[i].columns.size());
    coarse.nodes.body.push_back(nodes.body[aggregates.root[i]]);
  }
  coarse.nodes.position.resize(rows.size());
  std::vector<unsigned int> n_nodes(rows.size(), 0);
  for (unsigned int node = 0; node < nodes.size(); ++node)
    if (const unsigned int i = aggregates.of_node[node]; i != none) {
      const double weight = 1. / ++n_nodes[i];
      for (unsigned int d = 0; d < 3; ++d)
        coarse.nodes.position[i][d] += weight * (nodes.position[node][d] - coarse.nodes.position[i][d]);
    }

  const Epetra_Map coarse_rows(-1, coarse.nodes.first_row.back(), 0, A.Comm());
  coarse.modes = std::make_unique<Epetra_MultiVector>(coarse_rows, modes.NumVectors());
  std::vector<std::vector<std::pair<int, double>>> entries(A.NumMyRows());
  for (unsigned int i = 0; i < rows.size(); ++i)
    for (unsigned int k = 0; k < bases[i].columns.size(); ++k) {
      const int column = coarse.nodes.first_row[i] + k;
      for (int mode = 0; mode < modes.NumVectors(); ++mode)
        (*coarse.modes)[mode][column] = bases[i].coefficients[k][mode];
      for (unsigned int r = 0; r < rows[i].size(); ++r)
        if (bases[i].columns[k][r] != 0)
          entries[rows[i][r]].emplace_back(coarse_rows.GID(column), bases[i].columns[k][r]);
    }
  coarse.T = std::make_unique<Epetra_CrsMatrix>(Copy, A.RowMap(), modes.NumVectors());
  for (int row = 0; row < A.NumMyRows(); ++row)
    for (const auto &[column, value] : entries[row])
      coarse.T->InsertGlobalValues(A.GRID(row), 1, &value, &column);
  coarse.T->FillComplete(coarse_rows, A.OperatorDomainMap());
  return coarse;
}

/// The near-null space at a node.
dealii::FullMatrix<double> modes_at(const LevelNodes &nodes, const unsigned int node,
                                    const Epetra_MultiVector &modes)
{
  const int first = nodes.first_row[node], n = nodes.first_row[node + 1] - first;
  dealii::FullMatrix<double> B(n, modes.NumVectors());
  for (int i = 0; i < n; ++i)
    for (int mode = 0; mode < modes.NumVectors(); ++mode)
      B(i, mode) = modes[mode][first + i];
  return B;
}

/// M with x_j = M x_i for x in the near-null space: on the finest level, for translations.
dealii::FullMatrix<double> motion(const LevelNodes &nodes, const unsigned int i, const unsigned int j,
                                  const Epetra_MultiVector &modes, const bool is_finest)
{
  const int n_i = nodes.first_row[i + 1] - nodes.first_row[i],
            n_j = nodes.first_row[j + 1] - nodes.first_row[j];
  dealii::FullMatrix<double> M(n_j, n_i);
  if (is_finest) {
    for (int k = 0; k < std::min(n_i, n_j); ++k)
      M(k, k) = 1;
    return M;
  }
  const dealii::FullMatrix<double> B_i = modes_at(nodes, i, modes), B_j = modes_at(nodes, j, modes);
  dealii::FullMatrix<double> square(n_i, n_i), product(n_j, n_i);
  B_i.mTmult(square, B_i);
  B_j.mTmult(product, B_i);
  square.gauss_jordan();
  product.mmult(M, square);
  return M;
}

/// A_near, on the pattern of A.
std::unique_ptr<Epetra_CrsMatrix> without_far_couplings(const Epetra_CrsMatrix &A, const LevelNodes &nodes,
                                                        const Couplings &couplings,
                                                        const Epetra_MultiVector &modes, const bool is_finest)
{
  const std::vector<unsigned int> node = node_of_rows(nodes);
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, A.RowMap(), A.ColMap(), 0);
  std::vector<double> values;
  std::vector<int> columns, position_of(A.NumMyCols(), -1);
  for (unsigned int i = 0; i < nodes.size(); ++i) {
    std::vector<dealii::FullMatrix<double>> M(couplings.all[i].size());
    const auto number_of = [&](const unsigned int j) {
      return std::lower_bound(couplings.all[i].begin(), couplings.all[i].end(), j) - couplings.all[i].begin();
    };
    const auto is_far = [&](const unsigned int j) {
      return j != i && !std::binary_search(couplings.near[i].begin(), couplings.near[i].end(), j);
    };
    const int first = nodes.first_row[i], n_rows = nodes.first_row[i + 1] - first;
    for (int row = first; row < first + n_rows; ++row) {
      columns.clear();
      values.clear();
      std::vector<double> added(n_rows, 0.);
      int n = 0, *own_columns = nullptr;
      double *own_values = nullptr;
      A.ExtractMyRowView(row, n, own_values, own_columns);
      for_entries(A, row, [&](const int column, const double value, const int k) {
        if (column < 0 || !is_far(node[column])) {
          columns.push_back(own_columns[k]);
          values.push_back(value);
          return;
        }
        const unsigned int j = node[column];
        auto &motion_of_j = M[number_of(j)];
        if (motion_of_j.m() == 0)
          motion_of_j = motion(nodes, i, j, modes, is_finest);
        for (int c = 0; c < n_rows; ++c)
          added[c] += value * motion_of_j(column - nodes.first_row[j], c);
      });
      for (int c = 0; c < n_rows; ++c)
        if (added[c] != 0) {
          const int column = A.LCID(A.GRID(first + c));
          const auto place = std::find(columns.begin(), columns.end(), column);
          if (place == columns.end()) {
            columns.push_back(column);
            values.push_back(added[c]);
          } else
            values[place - columns.begin()] += added[c];
        }
      result->InsertMyValues(row, columns.size(), values.data(), columns.data());
    }
  }
  result->FillComplete(A.OperatorDomainMap(), A.OperatorRangeMap());
  return result;
}

/// The largest eigenvalue of D^-1 A, from below.
double largest_eigenvalue(const Epetra_CrsMatrix &A, const Epetra_Vector &inverse_diagonal)
{
  const unsigned int n_steps = 10;
  Epetra_Vector x(A.OperatorDomainMap()), y(A.OperatorDomainMap());
  for (int i = 0; i < x.MyLength(); ++i)
    x[i] = std::sin(1e4 * (1 + x.Map().GID(i) % 1009));
  double norm = 1;
  for (unsigned int step = 0; step < n_steps; ++step) {
    x.Norm2(&norm);
    x.Scale(1 / norm);
    A.Multiply(false, x, y);
    x.Multiply(1., inverse_diagonal, y, 0.);
  }
  x.Norm2(&norm);
  return norm;
}

/// (I - w D^-1 A_near) T
std::unique_ptr<Epetra_CrsMatrix> smoothed(const Epetra_CrsMatrix &T, const Epetra_CrsMatrix &A_near)
{
  Epetra_Vector inverse(A_near.RowMap());
  A_near.ExtractDiagonalCopy(inverse);
  for (int i = 0; i < inverse.MyLength(); ++i)
    inverse[i] = inverse[i] > 0 ? 1 / inverse[i] : 0;
  const double damping = 1 / largest_eigenvalue(A_near, inverse); // 4/3 of it, with a margin
  auto P = std::make_unique<Epetra_CrsMatrix>(Copy, T.RowMap(), 0);
  EpetraExt::MatrixMatrix::Multiply(A_near, false, T, false, *P, false);
  P->FillComplete(T.OperatorDomainMap(), T.OperatorRangeMap());
  inverse.Scale(-damping);
  P->LeftScale(inverse);
  auto sum = std::make_unique<Epetra_CrsMatrix>(Copy, T.RowMap(), 0);
  Epetra_CrsMatrix *raw = sum.get();
  EpetraExt::MatrixMatrix::Add(*P, false, 1., T, false, 1., raw);
  sum->FillComplete(T.OperatorDomainMap(), T.OperatorRangeMap());
  return sum;
}

} // namespace

LevelNodes nodes_of_rows(const std::vector<GroupFacts::Place> &places)
{
  LevelNodes nodes;
  for (unsigned int row = 0; row < places.size(); ++row)
    if (nodes.size() == 0 || places[row].block != nodes.body.back() ||
        places[row].position != nodes.position.back()) {
      nodes.first_row.push_back(row);
      nodes.body.push_back(places[row].block);
      nodes.position.push_back(places[row].position);
    }
  nodes.first_row.push_back(places.size());
  return nodes;
}

Couplings::Couplings(const Epetra_CrsMatrix &A, const LevelNodes &nodes)
    : all(graph_of(A, nodes)), near(nodes.size())
{
  const double largest_ratio = 3;
  std::vector<double> shortest(nodes.size(), std::numeric_limits<double>::infinity());
  for (unsigned int i = 0; i < nodes.size(); ++i)
    for (const unsigned int j : all[i])
      if (nodes.body[j] == nodes.body[i])
        shortest[i] = std::min(shortest[i], distance(nodes.position[i], nodes.position[j]));
  std::array<double, 3> counts{}, sums{}; // of nodes that see a far one, of all, and of rows together
  for (unsigned int i = 0; i < nodes.size(); ++i) {
    counts[2] += nodes.first_row[i + 1] - nodes.first_row[i];
    for (const unsigned int j : all[i])
      if (nodes.body[i] == nodes.body[j] && distance(nodes.position[i], nodes.position[j]) <=
                                                largest_ratio * std::max(shortest[i], shortest[j])) {
        near[i].push_back(j);
        counts[2] += nodes.first_row[j + 1] - nodes.first_row[j];
      }
    counts[0] += near[i].size() < all[i].size();
  }
  counts[1] = nodes.size();
  A.Comm().SumAll(counts.data(), sums.data(), counts.size());
  share_of_far = sums[1] > 0 ? sums[0] / sums[1] : 0;
  rows_together = sums[1] > 0 ? sums[2] / sums[1] : 0;
}

std::unique_ptr<Cycle> make_cycle(const Epetra_CrsMatrix &A, const Epetra_MultiVector &modes,
                                  const std::vector<GroupFacts::Place> &places, const Semicoarsen when,
                                  const Cycle::MakeSmoother &make_smoother)
{
  const double least_share = 0.1, largest_cheap = 0.55;
  int has_places = places.size() == static_cast<unsigned int>(A.NumMyRows()), all_have = 0;
  A.Comm().MinAll(&has_places, &all_have, 1);
  if (all_have != 0) {
    LevelNodes nodes = nodes_of_rows(places);
    const Couplings couplings(A, nodes);
    const bool is_cheap = modes.NumVectors() < largest_cheap * couplings.rows_together;
    if (couplings.share_of_far > least_share && (is_cheap || when == Semicoarsen::if_stretched))
      return std::make_unique<Semicoarsening>(A, modes, std::move(nodes), make_smoother);
  }
  return std::make_unique<SmoothedAggregation>(A, modes, make_smoother);
}

Semicoarsening::Semicoarsening(const Epetra_CrsMatrix &A, const Epetra_MultiVector &given_modes,
                               LevelNodes nodes, const MakeSmoother &make_smoother)
{
  const int largest_coarse = 2000;
  const double largest_growth = 0.9;
  const Epetra_CrsMatrix *matrix = &A;
  const Epetra_MultiVector *modes = &given_modes;
  std::unique_ptr<Epetra_CrsMatrix> owned;
  std::unique_ptr<Epetra_MultiVector> owned_modes;
  while (matrix->NumGlobalRows() > largest_coarse) {
    const Couplings couplings(*matrix, nodes);
    Coarse coarse = make_coarse(*matrix, nodes, *modes, Aggregates(couplings.near, couplings.all));
    if (coarse.T->NumGlobalCols() > largest_growth * matrix->NumGlobalRows())
      break;
    Level level;
    level.P = smoothed(*coarse.T, *without_far_couplings(*matrix, nodes, couplings, *modes, levels.empty()));
    level.smoother = make_smoother(*matrix);
    auto next = MatrixLevel(*matrix).restricted(*level.P);
    level.A = matrix;
    level.owned = std::move(owned);
    levels.push_back(std::move(level));
    owned = std::move(next);
    matrix = owned.get();
    owned_modes = std::move(coarse.modes);
    modes = owned_modes.get();
    nodes = std::move(coarse.nodes);
  }
  coarsest = std::move(owned);
  factors = std::make_unique<Factors>(*matrix);
}

Semicoarsening::~Semicoarsening() = default;

void Semicoarsening::cycle(const unsigned int number, Epetra_Vector &x, const Epetra_Vector &b) const
{
  if (number == levels.size()) {
    factors->solve(x.Values(), b.Values());
    return;
  }
  const Level &level = levels[number];
  level.smoother->smooth(x.Values(), b.Values(), true);
  Epetra_Vector residual(b.Map(), false), coarse_b(level.P->OperatorDomainMap(), false),
      coarse_x(level.P->OperatorDomainMap(), false);
  level.A->Multiply(false, x, residual);
  residual.Update(1., b, -1.);
  level.P->Multiply(true, residual, coarse_b);
  cycle(number + 1, coarse_x, coarse_b);
  level.P->Multiply(false, coarse_x, residual);
  x.Update(1., residual, 1.);
  level.smoother->smooth(x.Values(), b.Values(), false);
}

void Semicoarsening::vmult(Epetra_MultiVector &x, const Epetra_MultiVector &b) const
{
  Epetra_Vector solution(View, x, 0);
  cycle(0, solution, Epetra_Vector(View, b, 0));
}

} // namespace dovetail
