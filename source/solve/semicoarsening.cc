// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "semicoarsening.h"

#include "smoothed_aggregation.h"

#include <deal.II/base/exceptions.h>

#include <EpetraExt_MatrixMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_Map.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

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

/// Calls @p action(column, value) for the entries of an own row that are not zero.
template <typename Action>
void for_entries(const Epetra_CrsMatrix &A, const int row, const Action &action)
{
  int n = 0, *columns = nullptr;
  double *values = nullptr;
  A.ExtractMyRowView(row, n, values, columns);
  for (int k = 0; k < n; ++k)
    if (values[k] != 0)
      action(columns[k], values[k]);
}

/// By column what is known by row.
Epetra_MultiVector of_columns(const Epetra_CrsMatrix &A, const Epetra_MultiVector &of_rows)
{
  Epetra_MultiVector result(A.ColMap(), of_rows.NumVectors());
  if (A.Importer() == nullptr)
    result = of_rows;
  else
    result.Import(of_rows, *A.Importer(), Insert);
  return result;
}

/// The nodes that a matrix refers to: the own ones, and after them those of other ranks.
struct SeenNodes
{
  SeenNodes(const Epetra_CrsMatrix &A, const LevelNodes &own);

  std::vector<unsigned int> of_column; ///< of A
  std::vector<unsigned int> body, n_rows;
  std::vector<std::array<double, 3>> position;

private:
  void add(unsigned int its_body, const std::array<double, 3> &its_position);
};

/// By row the position of its node, and its body.
Epetra_MultiVector places_of_rows(const LevelNodes &nodes, const Epetra_BlockMap &rows)
{
  const std::vector<unsigned int> node = node_of_rows(nodes);
  Epetra_MultiVector places(rows, 4);
  for (unsigned int row = 0; row < node.size(); ++row) {
    for (unsigned int d = 0; d < 3; ++d)
      places[d][row] = nodes.position[node[row]][d];
    places[3][row] = nodes.body[node[row]];
  }
  return places;
}

/// The nodes where @p import brings their rows.
LevelNodes imported_nodes(const LevelNodes &nodes, const Epetra_Import &import)
{
  const auto known = imported(places_of_rows(nodes, import.SourceMap()), import);
  std::vector<GroupFacts::Place> places(known->MyLength());
  for (unsigned int row = 0; row < places.size(); ++row) {
    places[row].block = static_cast<unsigned int>((*known)[3][row]);
    places[row].position = {{(*known)[0][row], (*known)[1][row], (*known)[2][row]}};
  }
  return nodes_of_rows(places);
}

SeenNodes::SeenNodes(const Epetra_CrsMatrix &A, const LevelNodes &own)
{
  const std::vector<unsigned int> node = node_of_rows(own);
  const Epetra_MultiVector known = of_columns(A, places_of_rows(own, A.OperatorDomainMap()));
  for (unsigned int i = 0; i < own.size(); ++i)
    add(own.body[i], own.position[i]);
  for (int column = 0; column < A.NumMyCols(); ++column) {
    const int row = A.LRID(A.GCID(column)); // -1 on another rank
    const std::array<double, 3> its_position = {{known[0][column], known[1][column], known[2][column]}};
    const auto its_body = static_cast<unsigned int>(known[3][column]);
    if (row < 0 && (body.size() == own.size() || position.back() != its_position || body.back() != its_body))
      add(its_body, its_position);
    of_column.push_back(row < 0 ? body.size() - 1 : node[row]);
    ++n_rows[of_column.back()];
  }
}

void SeenNodes::add(const unsigned int its_body, const std::array<double, 3> &its_position)
{
  body.push_back(its_body);
  position.push_back(its_position);
  n_rows.push_back(0);
}

/// By own node the nodes that are seen.
NodeGraph graph_of(const Epetra_CrsMatrix &A, const LevelNodes &nodes, const SeenNodes &seen)
{
  NodeGraph graph(nodes.size());
  for (unsigned int n = 0; n < nodes.size(); ++n) {
    for (int row = nodes.first_row[n]; row < nodes.first_row[n + 1]; ++row)
      for_entries(A, row, [&](const int column, double) {
        if (seen.of_column[column] != n)
          graph[n].push_back(seen.of_column[column]);
      });
    std::sort(graph[n].begin(), graph[n].end());
    graph[n].erase(std::unique(graph[n].begin(), graph[n].end()), graph[n].end());
  }
  return graph;
}

/// Without the nodes of other ranks.
NodeGraph own_part(NodeGraph graph)
{
  for (auto &neighbours : graph)
    neighbours.erase(std::lower_bound(neighbours.begin(), neighbours.end(), graph.size()), neighbours.end());
  return graph;
}

/// Of each seen node: the distance to the node next to it in its body, with which it is coupled.
std::vector<double> shortest_couplings(const Epetra_CrsMatrix &A, const LevelNodes &nodes,
                                       const SeenNodes &seen, const NodeGraph &graph)
{
  std::vector<double> shortest(seen.body.size(), std::numeric_limits<double>::infinity());
  for (unsigned int i = 0; i < nodes.size(); ++i)
    for (const unsigned int j : graph[i])
      if (seen.body[j] == seen.body[i])
        shortest[i] = std::min(shortest[i], distance(seen.position[i], seen.position[j]));
  Epetra_MultiVector of_rows(A.OperatorDomainMap(), 1);
  for (unsigned int i = 0; i < nodes.size(); ++i)
    std::fill(of_rows[0] + nodes.first_row[i], of_rows[0] + nodes.first_row[i + 1], shortest[i]);
  const Epetra_MultiVector known = of_columns(A, of_rows);
  for (int column = 0; column < A.NumMyCols(); ++column)
    shortest[seen.of_column[column]] = known[0][column];
  return shortest;
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
        for_entries(A, row, [&](const int column, double) {
          is_coupled = is_coupled || A.GCID(column) != A.GRID(row);
        });
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

/// A_near.
std::unique_ptr<Epetra_CrsMatrix> without_far_couplings(const Epetra_CrsMatrix &A, const LevelNodes &nodes,
                                                        const Couplings &couplings)
{
  const std::vector<unsigned int> node = node_of_rows(nodes);
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, A.RowMap(), A.ColMap(), 0);
  std::vector<double> values;
  std::vector<int> columns;
  for (int row = 0; row < A.NumMyRows(); ++row) {
    const std::vector<unsigned int> &near = couplings.near[node[row]];
    columns.clear();
    values.clear();
    for_entries(A, row, [&](const int column, const double value) {
      const unsigned int other = couplings.node_of_column[column];
      if (other == node[row] || std::binary_search(near.begin(), near.end(), other)) {
        columns.push_back(column);
        values.push_back(value);
      }
    });
    result->InsertMyValues(row, columns.size(), values.data(), columns.data());
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

/// A row d with a given product d B, for any d the least one.
class LeastRow
{
public:
  /// @param modes the rows of B, by mode
  explicit LeastRow(std::vector<std::vector<double>> modes);
  /// Adds d to @p row, where d B = @p product.
  void add(double *row, const std::vector<double> &product) const;

private:
  struct Step
  {
    unsigned int mode;
    std::vector<double> parts; ///< of the mode along the directions before
    double length;
  };
  std::vector<Step> steps;
  std::vector<std::vector<double>> directions; ///< orthonormal
};

LeastRow::LeastRow(std::vector<std::vector<double>> modes)
{
  const double least = 1e-5;
  const auto product = [](const auto &a, const auto &b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.);
  };
  for (unsigned int mode = 0; mode < modes.size(); ++mode) {
    std::vector<double> &v = modes[mode];
    Step step{mode, std::vector<double>(directions.size(), 0.), std::sqrt(product(v, v))};
    const double before = step.length;
    for (unsigned int pass = 0; pass < 2; ++pass)
      for (unsigned int k = 0; k < directions.size(); ++k) {
        const double part = product(v, directions[k]);
        step.parts[k] += part;
        for (unsigned int i = 0; i < v.size(); ++i)
          v[i] -= part * directions[k][i];
      }
    step.length = std::sqrt(product(v, v));
    if (!(step.length > least * before))
      continue;
    for (double &x : v)
      x /= step.length;
    directions.push_back(std::move(v));
    steps.push_back(std::move(step));
  }
}

void LeastRow::add(double *const row, const std::vector<double> &product) const
{
  std::vector<double> along;
  for (const Step &step : steps) {
    along.push_back(
        (product[step.mode] - std::inner_product(along.begin(), along.end(), step.parts.begin(), 0.)) /
        step.length);
    const std::vector<double> &direction = directions[along.size() - 1];
    for (unsigned int i = 0; i < direction.size(); ++i)
      row[i] += along.back() * direction[i];
  }
}

/// Adds the least entries within the pattern of P with which P @p coarse_modes = @p modes.
void fit(Epetra_CrsMatrix &P, const Epetra_MultiVector &coarse_modes, const Epetra_MultiVector &modes)
{
  const int n_modes = modes.NumVectors();
  Epetra_MultiVector missing(modes), of_columns(P.ColMap(), n_modes);
  P.Multiply(false, coarse_modes, missing);
  missing.Update(1., modes, -1.);
  of_columns.Import(coarse_modes, Epetra_Import(P.ColMap(), coarse_modes.Map()), Insert);
  std::unique_ptr<LeastRow> least;
  std::vector<int> last_columns; // which rows of a node share
  std::vector<double> product(n_modes);
  for (int row = 0; row < P.NumMyRows(); ++row) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    P.ExtractMyRowView(row, n, values, columns);
    if (!least || !std::equal(columns, columns + n, last_columns.begin(), last_columns.end())) {
      last_columns.assign(columns, columns + n);
      std::vector<std::vector<double>> in_row(n_modes, std::vector<double>(n));
      for (int mode = 0; mode < n_modes; ++mode)
        for (int k = 0; k < n; ++k)
          in_row[mode][k] = of_columns[mode][columns[k]];
      least = std::make_unique<LeastRow>(std::move(in_row));
    }
    for (int mode = 0; mode < n_modes; ++mode)
      product[mode] = missing[mode][row];
    least->add(values, product);
  }
}

/// (I - w D^-1 A_near) T + F
std::unique_ptr<Epetra_CrsMatrix> smoothed(const Coarse &coarse, const Epetra_CrsMatrix &A_near,
                                           const Epetra_MultiVector &modes)
{
  const Epetra_CrsMatrix &T = *coarse.T;
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
  fit(*sum, *coarse.modes, modes);
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

Couplings::Couplings(const Epetra_CrsMatrix &A, const LevelNodes &nodes) : near(nodes.size())
{
  const double largest_ratio = 2;
  SeenNodes seen(A, nodes);
  all = graph_of(A, nodes, seen);
  const std::vector<double> shortest = shortest_couplings(A, nodes, seen, all);
  std::array<double, 3> counts{}, sums{}; // of nodes that see a far one, of all, and of rows together
  for (unsigned int i = 0; i < nodes.size(); ++i) {
    counts[2] += nodes.first_row[i + 1] - nodes.first_row[i];
    bool sees_far = false;
    for (const unsigned int j : all[i]) {
      if (seen.body[i] != seen.body[j])
        continue;
      const bool is_near =
          distance(seen.position[i], seen.position[j]) <= largest_ratio * std::max(shortest[i], shortest[j]);
      sees_far = sees_far || !is_near;
      if (is_near) {
        near[i].push_back(j);
        counts[2] += seen.n_rows[j];
      }
    }
    counts[0] += sees_far ? 1 : 0;
  }
  counts[1] = nodes.size();
  A.Comm().SumAll(counts.data(), sums.data(), counts.size());
  share_of_far = sums[1] > 0 ? sums[0] / sums[1] : 0;
  rows_together = sums[1] > 0 ? sums[2] / sums[1] : 0;
  node_of_column = std::move(seen.of_column);
}

bool are_mostly_stretched(const Epetra_CrsMatrix &A, const LevelNodes &nodes)
{
  const unsigned int every = 16; // node
  const double least_ratio = 5;
  const std::vector<unsigned int> node = node_of_rows(nodes);
  std::array<int, 2> counts{}, sums{}; // of stretched nodes, and of all
  for (unsigned int i = 0; i < nodes.size(); i += every) {
    double shortest = std::numeric_limits<double>::infinity(), longest = 0;
    for_entries(A, nodes.first_row[i], [&](const int column, double) {
      const int row = A.Importer() == nullptr ? column : A.LRID(A.GCID(column));
      if (row < 0 || node[row] == i || nodes.body[node[row]] != nodes.body[i])
        return;
      const double its_distance = distance(nodes.position[i], nodes.position[node[row]]);
      shortest = std::min(shortest, its_distance);
      longest = std::max(longest, its_distance);
    });
    counts[0] += longest > least_ratio * shortest ? 1 : 0;
    counts[1] += longest > 0 ? 1 : 0;
  }
  A.Comm().SumAll(counts.data(), sums.data(), counts.size());
  return 4 * sums[0] > sums[1];
}

namespace {

bool are_stretched(const Epetra_CrsMatrix &A, const LevelNodes &nodes, const int n_modes,
                   const Semicoarsen when)
{
  const double least_share = 0.1, largest_cheap = 0.55;
  const Couplings couplings(A, nodes);
  const bool is_cheap = n_modes < largest_cheap * couplings.rows_together;
  return couplings.share_of_far > least_share && (is_cheap || when == Semicoarsen::if_stretched);
}

} // namespace

std::unique_ptr<Cycle> make_cycle(Cycle::Finest finest, std::shared_ptr<const Epetra_MultiVector> modes,
                                  std::vector<GroupFacts::Place> places, const Semicoarsen when,
                                  const Cycle::MakeSmoother &make_smoother,
                                  const Cycle::MakeSmoother &if_semicoarsened)
{
  const Epetra_CrsMatrix &A = finest.matrix();
  int has_places = places.size() == static_cast<unsigned int>(A.NumMyRows()), all_have = 0;
  A.Comm().MinAll(&has_places, &all_have, 1);
  if (all_have != 0) {
    LevelNodes nodes = nodes_of_rows(places);
    places = std::vector<GroupFacts::Place>(); // = {} would keep the memory
    if (when == Semicoarsen::always || are_stretched(A, nodes, modes->NumVectors(), when))
      return std::make_unique<Semicoarsening>(std::move(finest), *modes, std::move(nodes), if_semicoarsened);
  }
  return std::make_unique<SmoothedAggregation>(std::move(finest), std::move(modes), make_smoother);
}

/// Coarsening along short couplings leaves less to the smoothers.
std::unique_ptr<Cycle> make_cycle_with_factorisations(Cycle::Finest A,
                                                      std::shared_ptr<const Epetra_MultiVector> modes,
                                                      std::vector<GroupFacts::Place> places,
                                                      const Semicoarsen when)
{
  const auto with_steps = [](const ChebyshevSmoother::Range range) {
    return [range](const LevelEntries &level, double) {
      return ChebyshevSmoother::with_factorisation(level, range);
    };
  };
  return make_cycle(std::move(A), std::move(modes), std::move(places), when, with_steps({4, 40}),
                    with_steps({3, 25}));
}

Semicoarsening::Semicoarsening(Finest A, const Epetra_MultiVector &given_modes, LevelNodes nodes,
                               const MakeSmoother &make_smoother)
    : Cycle(std::move(A))
{
  const Epetra_MultiVector *modes = &given_modes;
  std::unique_ptr<Epetra_MultiVector> owned_modes;
  while (coarsest().NumGlobalRows() > largest_coarse) {
    const Epetra_CrsMatrix &matrix = coarsest();
    const Couplings couplings(matrix, nodes);
    const Aggregates aggregates(own_part(couplings.near), couplings.all);
    Coarse coarse = make_coarse(matrix, nodes, *modes, aggregates);
    if (coarse.T->NumGlobalCols() > largest_growth * matrix.NumGlobalRows())
      break;
    auto P = smoothed(coarse, *without_far_couplings(matrix, nodes, couplings), *modes);
    auto next = restrict_matrix(matrix, *P);
    add_level(make_smoother, std::move(P), [&next]() { return std::move(next); });
    owned_modes = std::move(coarse.modes);
    nodes = std::move(coarse.nodes);
    if (const Epetra_Import *const gather = gather_coarsest()) {
      owned_modes = imported(*owned_modes, *gather);
      nodes = imported_nodes(nodes, *gather);
    }
    modes = owned_modes.get();
  }
  factorise_coarsest();
}

} // namespace dovetail
