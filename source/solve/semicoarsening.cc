// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "semicoarsening.h"

#include "aggregate_products.h"
#include "level_operator.h"
#include "smoothed_aggregation.h"

#include <dovetail/solve/free_memory.h>

#include <deal.II/base/exceptions.h>
#include <deal.II/base/symmetric_tensor.h>

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
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return std::sqrt(x * x + y * y + z * z); // faster than std::hypot
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
  const Epetra_MultiVector known = at_columns(A, places_of_rows(own, A.OperatorDomainMap()));
  for (unsigned int i = 0; i < own.size(); ++i)
    add(own.body[i], own.position[i]);
  for (int column = 0; column < A.NumMyCols(); ++column) {
    const int row = A.Importer() == nullptr ? column : A.LRID(A.GCID(column)); // -1 on another rank
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
  std::vector<unsigned int> found, last_from(seen.body.size(), none);
  for (unsigned int n = 0; n < nodes.size(); ++n) {
    last_from[n] = n;
    found.clear();
    for (int row = nodes.first_row[n]; row < nodes.first_row[n + 1]; ++row)
      for_entries(A, row, [&](const int column, double) {
        const unsigned int other = seen.of_column[column];
        if (last_from[other] != n)
          found.push_back(other);
        last_from[other] = n;
      });
    std::sort(found.begin(), found.end());
    graph[n] = found;
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
  const Epetra_MultiVector known = at_columns(A, of_rows);
  for (int column = 0; column < A.NumMyCols(); ++column)
    shortest[seen.of_column[column]] = known[0][column];
  return shortest;
}

/// Of nodes that short couplings connect: half of the lengths of these couplings, and the shortest one of all
/// others in the body.
struct Lengths
{
  double half_of_near = 0, shortest_far = std::numeric_limits<double>::infinity();
};

/// By node how many nodes of this rank its line has: those that short couplings connect with it, if they
/// connect none of them with more than two others. 0 if they do, if there are no short couplings, or if the
/// line is much longer than the nodes beside it are far: bodies that are as slender bend along their lines,
/// with too little resistance of single ones.
std::vector<unsigned int> lengths_of_lines(const NodeGraph &near, const std::vector<Lengths> &lengths)
{
  const double largest_ratio = 5;
  std::vector<unsigned int> n_nodes(near.size(), 0), together;
  std::vector<bool> is_seen(near.size(), false);
  for (unsigned int node = 0; node < near.size(); ++node) {
    if (is_seen[node] || near[node].empty())
      continue;
    together = {node};
    is_seen[node] = true;
    bool is_line = true;
    double length = 0, width = 0;
    for (unsigned int i = 0; i < together.size(); ++i) {
      is_line = is_line && near[together[i]].size() <= 2;
      length += lengths[together[i]].half_of_near;
      width += lengths[together[i]].shortest_far;
      for (const unsigned int neighbour : near[together[i]])
        if (neighbour < near.size() && !is_seen[neighbour]) {
          is_seen[neighbour] = true;
          together.push_back(neighbour);
        }
    }
    is_line = is_line && length <= largest_ratio * width / together.size();
    for (const unsigned int i : together)
      n_nodes[i] = is_line ? together.size() : 0;
  }
  return n_nodes;
}

/// By node the aggregate that it belongs to, or none if nothing is coupled with it; and the root of each.
struct Aggregates
{
  /// @param line_length whole lines are aggregates where it is not 0
  Aggregates(const NodeGraph &near, const NodeGraph &all, const std::vector<unsigned int> &line_length);

  std::vector<unsigned int> of_node, root;

private:
  void begin(unsigned int node, const NodeGraph &near);
  void begin_line(unsigned int node, const NodeGraph &near);
};

void Aggregates::begin_line(const unsigned int node, const NodeGraph &near)
{
  std::vector<unsigned int> line = {node};
  of_node[node] = root.size();
  for (unsigned int i = 0; i < line.size(); ++i)
    for (const unsigned int neighbour : near[line[i]])
      if (of_node[neighbour] == none) {
        of_node[neighbour] = root.size();
        line.push_back(neighbour);
      }
  root.push_back(node);
}

void Aggregates::begin(const unsigned int node, const NodeGraph &near)
{
  of_node[node] = root.size();
  for (const unsigned int neighbour : near[node])
    if (of_node[neighbour] == none)
      of_node[neighbour] = root.size();
  root.push_back(node);
}

/// Lines, and neighbourhoods that are free; then what is left joins the aggregate next to it of which it sees
/// most.
Aggregates::Aggregates(const NodeGraph &near, const NodeGraph &all,
                       const std::vector<unsigned int> &line_length)
    : of_node(near.size(), none)
{
  for (unsigned int node = 0; node < near.size(); ++node)
    if (of_node[node] == none && line_length[node] > 0)
      begin_line(node, near);
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

/// By own row its aggregate; none of a row that is not coupled, or prescribed.
std::vector<int> aggregate_of_rows(const Epetra_CrsMatrix &A, const LevelNodes &nodes,
                                   const Aggregates &aggregates)
{
  std::vector<int> result(A.NumMyRows(), -1);
  for (unsigned int node = 0; node < nodes.size(); ++node)
    if (aggregates.of_node[node] != none)
      for (int row = nodes.first_row[node]; row < nodes.first_row[node + 1]; ++row)
        for_entries(A, row, [&](const int column, double) {
          if (A.Importer() == nullptr ? column != row : A.GCID(column) != A.GRID(row))
            result[row] = aggregates.of_node[node];
        });
  return result;
}

/// With as many rows each as there are modes.
LevelNodes coarse_nodes(const LevelNodes &nodes, const Aggregates &aggregates, const int n_modes)
{
  LevelNodes coarse;
  for (unsigned int i = 0; i < aggregates.root.size(); ++i) {
    coarse.first_row.push_back(i * n_modes);
    coarse.body.push_back(nodes.body[aggregates.root[i]]);
  }
  coarse.first_row.push_back(aggregates.root.size() * n_modes);
  coarse.position.resize(aggregates.root.size());
  std::vector<unsigned int> n_nodes(aggregates.root.size(), 0);
  for (unsigned int node = 0; node < nodes.size(); ++node)
    if (const unsigned int i = aggregates.of_node[node]; i != none) {
      const double weight = 1. / ++n_nodes[i];
      for (unsigned int d = 0; d < 3; ++d)
        coarse.position[i][d] += weight * (nodes.position[node][d] - coarse.position[i][d]);
    }
  return coarse;
}

/// How many vectors of all bases are not zero. Collective.
int size_of_basis(const Aggregation &aggregation)
{
  const Epetra_MultiVector &modes = *aggregation.modes;
  int here = 0, everywhere = 0;
  for (int row = 0; row < modes.MyLength(); ++row)
    here += modes[row % modes.NumVectors()][row] != 0 ? 1 : 0;
  modes.Comm().SumAll(&here, &everywhere, 1);
  return everywhere;
}

/// The rows of A_near, which has the columns of A.
class NearEntries
{
public:
  NearEntries(const Epetra_CrsMatrix &A, const LevelNodes &nodes, const Couplings &couplings);

  SparseRows rows() const { return {begin.data(), columns.data(), values.data()}; }
  /// Of D^-1 A_near, from below, where D = diag(A). Collective.
  double largest_eigenvalue(const Epetra_CrsMatrix &A) const;

private:
  std::vector<int> begin, columns;
  std::vector<double> values;
};

NearEntries::NearEntries(const Epetra_CrsMatrix &A, const LevelNodes &nodes, const Couplings &couplings)
{
  const auto for_near = [&](const auto &action, const auto &row_ends) {
    std::vector<unsigned int> near_to(couplings.n_nodes, none); // of each node the last one
    for (unsigned int node = 0; node < nodes.size(); ++node) {
      near_to[node] = node;
      for (const unsigned int other : couplings.near[node])
        near_to[other] = node;
      for (int row = nodes.first_row[node]; row < nodes.first_row[node + 1]; ++row) {
        for_entries(A, row, [&](const int column, const double value) {
          if (near_to[couplings.node_of_column[column]] == node)
            action(column, value);
        });
        row_ends();
      }
    }
  };
  begin.reserve(A.NumMyRows() + 1); // two passes, as memory is precious
  begin.push_back(0);
  int n = 0;
  for_near([&n](int, double) { ++n; }, [&]() { begin.push_back(n); });
  columns.reserve(n);
  values.reserve(n);
  for_near(
      [&](const int column, const double value) {
        columns.push_back(column);
        values.push_back(value);
      },
      []() {});
}

double NearEntries::largest_eigenvalue(const Epetra_CrsMatrix &A) const
{
  const unsigned int n_steps = 10;
  Epetra_Vector x(A.OperatorDomainMap()), diagonal(x);
  LevelEntries(A).diagonal(diagonal);
  for (int i = 0; i < x.MyLength(); ++i)
    x[i] = std::sin(1e4 * (1 + x.Map().GID(i) % 1009));
  double norm = 1;
  for (unsigned int step = 0; step < n_steps; ++step) {
    x.Norm2(&norm);
    x.Scale(1 / norm);
    const Epetra_MultiVector known = at_columns(A, x);
    for (int row = 0; row < x.MyLength(); ++row) {
      double sum = 0;
      for (int k = begin[row]; k < begin[row + 1]; ++k)
        sum += values[k] * known[0][columns[k]];
      x[row] = diagonal[row] > 0 ? sum / diagonal[row] : 0;
    }
  }
  x.Norm2(&norm);
  return norm;
}

/// A row d with a given product d B, for any d the least one.
class LeastRow
{
public:
  /// @param modes the rows of B, mode by mode
  void set(std::vector<double> modes, unsigned int number_of_modes);
  /// Adds d to @p row, where d B = @p product.
  void add(double *row, const double *product) const;

private:
  unsigned int n_modes = 0;
  std::vector<double> directions; ///< by mode: orthonormal, or zero if it depends on those before
  std::vector<double> parts;      ///< by mode what it is along the directions, up to its own
  mutable std::vector<double> along;
};

void LeastRow::set(std::vector<double> modes, const unsigned int number_of_modes)
{
  const double least = 1e-5;
  n_modes = number_of_modes;
  directions = std::move(modes);
  parts.assign(n_modes * n_modes, 0.);
  along.resize(n_modes);
  const std::size_t n = directions.size() / n_modes;
  for (unsigned int mode = 0; mode < n_modes; ++mode) {
    double *const v = &directions[mode * n], *const part = &parts[mode * n_modes];
    const auto product = [n, v](const double *const w) { return std::inner_product(v, v + n, w, 0.); };
    const double before = std::sqrt(product(v));
    for (unsigned int pass = 0; pass < 2; ++pass)
      for (unsigned int k = 0; k < mode; ++k) {
        const double *const direction = &directions[k * n];
        const double along_it = product(direction);
        part[k] += along_it;
        for (std::size_t i = 0; i < n; ++i)
          v[i] -= along_it * direction[i];
      }
    const double length = std::sqrt(product(v));
    part[mode] = length > least * before ? length : 0;
    for (std::size_t i = 0; i < n; ++i)
      v[i] = part[mode] > 0 ? v[i] / length : 0;
  }
}

void LeastRow::add(double *const row, const double *const product) const
{
  const std::size_t n = directions.size() / n_modes;
  for (unsigned int mode = 0; mode < n_modes; ++mode) {
    const double *const part = &parts[mode * n_modes], *const direction = &directions[mode * n];
    along[mode] =
        part[mode] > 0
            ? (product[mode] - std::inner_product(part, part + mode, along.begin(), 0.)) / part[mode]
            : 0;
    for (std::size_t i = 0; i < n; ++i)
      row[i] += along[mode] * direction[i];
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
  LeastRow least;
  std::vector<int> last_columns; // which rows of a node share
  std::vector<double> product(n_modes);
  for (int row = 0; row < P.NumMyRows(); ++row) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    P.ExtractMyRowView(row, n, values, columns);
    if (n == 0)
      continue;
    if (!std::equal(columns, columns + n, last_columns.begin(), last_columns.end())) {
      last_columns.assign(columns, columns + n);
      std::vector<double> in_row(static_cast<std::size_t>(n_modes) * n);
      for (int mode = 0; mode < n_modes; ++mode)
        for (int k = 0; k < n; ++k)
          in_row[mode * n + k] = of_columns[mode][columns[k]];
      least.set(std::move(in_row), n_modes);
    }
    for (int mode = 0; mode < n_modes; ++mode)
      product[mode] = missing[mode][row];
    least.add(values, product.data());
  }
}

/// (I - w D^-1 A_near) T + F
std::unique_ptr<Epetra_CrsMatrix> make_prolongation(const Epetra_CrsMatrix &A, const LevelNodes &nodes,
                                                    const Couplings &couplings,
                                                    const Aggregation &aggregation,
                                                    const Epetra_MultiVector &modes)
{
  const NearEntries near(A, nodes, couplings);
  const double w = 1 / near.largest_eigenvalue(A); // 4/3 of it, with a margin
  auto P = smooth_bases(A, near.rows(), aggregation, w);
  fit(*P, *aggregation.modes, modes);
  return P;
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

int number_of_bodies(const std::vector<unsigned int> &body, const Epetra_Comm &ranks)
{
  int here = body.empty() ? 0 : 1 + *std::max_element(body.begin(), body.end()), result = 0;
  ranks.MaxAll(&here, &result, 1);
  return result;
}

Couplings::Couplings(const Epetra_CrsMatrix &A, const LevelNodes &nodes)
    : near(nodes.size()), closest(nodes.size())
{
  const double largest_ratio = 2, ratio_of_closest = 1.2;
  SeenNodes seen(A, nodes);
  all = graph_of(A, nodes, seen);
  const std::vector<double> shortest = shortest_couplings(A, nodes, seen, all);
  std::vector<Lengths> lengths(nodes.size());
  // Of nodes that see a far one, of all, of rows together, of nodes and of rows in lines, of coupled nodes,
  // of the nodes of lines, of rows that are closest.
  std::array<double, 8> counts{}, sums{};
  for (unsigned int i = 0; i < nodes.size(); ++i) {
    counts[2] += nodes.first_row[i + 1] - nodes.first_row[i];
    counts[7] += nodes.first_row[i + 1] - nodes.first_row[i];
    for (const unsigned int j : all[i]) {
      const double its_distance = distance(seen.position[i], seen.position[j]),
                   least = std::max(shortest[i], shortest[j]);
      if (seen.body[i] != seen.body[j])
        continue;
      if (its_distance <= ratio_of_closest * least) {
        closest[i].push_back(j);
        counts[7] += seen.n_rows[j];
      }
      if (its_distance <= largest_ratio * least) {
        near[i].push_back(j);
        counts[2] += seen.n_rows[j];
        lengths[i].half_of_near += its_distance / 2;
      } else
        lengths[i].shortest_far = std::min(lengths[i].shortest_far, its_distance);
    }
    counts[0] += std::isfinite(lengths[i].shortest_far) ? 1 : 0;
  }
  line_length = lengths_of_lines(near, lengths);
  for (unsigned int i = 0; i < nodes.size(); ++i) {
    counts[3] += line_length[i] > 0 ? 1 : 0;
    counts[4] += line_length[i] * (nodes.first_row[i + 1] - nodes.first_row[i]);
    counts[5] += all[i].empty() ? 0 : 1; // it follows others, or is prescribed
    counts[6] += line_length[i];
  }
  counts[1] = nodes.size();
  A.Comm().SumAll(counts.data(), sums.data(), counts.size());
  share_of_far = sums[1] > 0 ? sums[0] / sums[1] : 0;
  share_in_lines = sums[5] > 0 ? sums[3] / sums[5] : 0;
  rows_of_line = sums[3] > 0 ? sums[4] / sums[3] : 0;
  nodes_of_line = sums[3] > 0 ? sums[6] / sums[3] : 0;
  rows_together = sums[1] > 0 ? sums[2] / sums[1] : 0;
  rows_closest = sums[1] > 0 ? sums[7] / sums[1] : 0;
  n_nodes = seen.body.size();
  node_of_column = std::move(seen.of_column);
}

bool Couplings::are_in_lines() const
{
  const double most_nodes = 0.8;
  return share_in_lines > most_nodes;
}

bool Couplings::are_many(const int n_modes) const
{
  const double most = 10, fewest_closest = 4; // rows beside modes
  return rows_together > most * n_modes && rows_closest > fewest_closest * n_modes;
}

bool Couplings::are_in_short_lines() const
{
  const double longest = 3.2; // nodes
  return are_in_lines() && nodes_of_line < longest;
}

namespace {

/// A node, and its couplings with own nodes of its body.
struct Spread
{
  int n = 0;
  dealii::SymmetricTensor<2, 3> squares; ///< sum of d d^T over the distances d

  Spread(const unsigned int node, const std::vector<unsigned int> &others, const LevelNodes &nodes)
  {
    for (const unsigned int other : others)
      if (other < nodes.size() && other != node && nodes.body[other] == nodes.body[node]) {
        dealii::Tensor<1, 3> d;
        for (unsigned int k = 0; k < 3; ++k)
          d[k] = nodes.position[other][k] - nodes.position[node][k];
        squares += dealii::symmetrize(dealii::outer_product(d, d));
        ++n;
      }
  }
};

/// Whether short couplings lead in all directions, at half of the nodes of each body at least, and are not
/// few: nothing has to be left out. In each direction, the mean square of what they have of it is compared
/// with that of all couplings: 0.1 and more where distances are about the same, 1e-4 and less where cells are
/// long. Collective.
bool lead_everywhere(const Couplings &couplings, const LevelNodes &nodes, const Epetra_Comm &ranks)
{
  const double least_reach = 0.02, share_of_nodes = 0.5, share_of_couplings = 0.1;
  const int n_bodies = number_of_bodies(nodes.body, ranks);
  // By body the nodes, and those that reach in all directions; short couplings, and all.
  std::vector<double> counts(2 * n_bodies + 2, 0), sums(counts);
  for (unsigned int node = 0; node < nodes.size(); ++node) {
    const Spread near(node, couplings.near[node], nodes), all(node, couplings.all[node], nodes);
    const double sum = dealii::trace(all.squares);
    if (near.n == 0 || !(sum > 0)) // at the same place
      continue;
    const auto directions = dealii::eigenvectors(all.squares);
    const bool reaches = std::all_of(directions.begin(), directions.end(), [&](const auto &pair) {
      const auto &[square, direction] = pair;
      const bool is_in_plane = square <= 1e-10 * sum;
      return is_in_plane || direction * (near.squares * direction) / near.n > least_reach * square / all.n;
    });
    double *const of_body = &counts[2 * nodes.body[node]];
    of_body[0] += 1;
    of_body[1] += reaches ? 1 : 0;
    counts[2 * n_bodies] += near.n;
    counts[2 * n_bodies + 1] += all.n;
  }
  ranks.SumAll(counts.data(), sums.data(), counts.size());
  bool result = sums[2 * n_bodies] > share_of_couplings * sums[2 * n_bodies + 1];
  for (int body = 0; body < n_bodies; ++body)
    result = result && sums[2 * body + 1] >= share_of_nodes * sums[2 * body];
  return result;
}

} // namespace

bool are_all_known(const std::vector<GroupFacts::Place> &places, const Epetra_CrsMatrix &A)
{
  int here = places.size() == static_cast<unsigned int>(A.NumMyRows()), everywhere = 0;
  A.Comm().MinAll(&here, &everywhere, 1);
  return everywhere != 0;
}

bool are_mostly_stretched(const Epetra_CrsMatrix &A, const LevelNodes &nodes)
{
  const unsigned int every = 16;  // node
  const double least_ratio = 2.8; // 1.7 in cubes
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

const double largest_cheap = 0.55;        // modes beside the rows that are together
const double growth_of_short_lines = 0.7; // as largest_growth: a mode less costs more than it saves

/// Mean of all nodes: how many modes are not zero there. A body may have modes for itself. Collective.
double modes_of_nodes(const Epetra_MultiVector &modes, const LevelNodes &nodes)
{
  std::array<double, 2> counts{}, sums{}; // of modes that are not zero at a node, and of nodes
  for (unsigned int i = 0; i < nodes.size(); ++i)
    for (int mode = 0; mode < modes.NumVectors(); ++mode)
      counts[0] += std::any_of(modes[mode] + nodes.first_row[i], modes[mode] + nodes.first_row[i + 1],
                               [](const double value) { return value != 0; })
                       ? 1
                       : 0;
  counts[1] = nodes.size();
  modes.Comm().SumAll(counts.data(), sums.data(), counts.size());
  return sums[0] / std::max(sums[1], 1.);
}

/// Those of each body that are not zero there, side by side with those of the others: an aggregate has nodes
/// of one body. Collective.
std::unique_ptr<Epetra_MultiVector> modes_side_by_side(const Epetra_MultiVector &modes,
                                                       const LevelNodes &nodes)
{
  const int n_modes = modes.NumVectors();
  const auto visit = [&](const auto &action) { // the entries that are not zero, and where their body begins
    for (unsigned int node = 0; node < nodes.size(); ++node)
      for (int row = nodes.first_row[node]; row < nodes.first_row[node + 1]; ++row)
        for (int mode = 0; mode < n_modes; ++mode)
          if (modes[mode][row] != 0)
            action(row, mode, nodes.body[node] * n_modes);
  };
  std::vector<int> is_here(number_of_bodies(nodes.body, modes.Comm()) * n_modes, 0), place(is_here);
  visit([&](int, const int mode, const int first) { is_here[first + mode] = 1; });
  modes.Comm().MaxAll(is_here.data(), place.data(), place.size());
  int n_places = 1;
  for (auto first = place.begin(); first != place.end(); first += n_modes) {
    std::partial_sum(first, first + n_modes, first);
    n_places = std::max(n_places, *(first + n_modes - 1));
  }
  auto result = std::make_unique<Epetra_MultiVector>(modes.Map(), n_places);
  visit([&](const int row, const int mode, const int first) {
    (*result)[place[first + mode] - 1][row] = modes[mode][row];
  });
  return result;
}

bool are_stretched(const Epetra_CrsMatrix &A, const LevelNodes &nodes, const Epetra_MultiVector &modes,
                   const Semicoarsen when)
{
  const double least_share = 0.1;
  const Couplings couplings(A, nodes);
  const double n_modes = modes_of_nodes(modes, nodes);
  const bool are_few = A.NumGlobalRows() <= Semicoarsening::largest_of_lines(A.Comm()),
             is_cheap =
                 n_modes < largest_cheap * couplings.rows_together ||
                 (couplings.are_in_lines() && (are_few || n_modes < largest_cheap * couplings.rows_of_line));
  return couplings.share_of_far > least_share && (is_cheap || when == Semicoarsen::if_stretched);
}

} // namespace

std::unique_ptr<Cycle> make_cycle(Cycle::Finest finest, std::shared_ptr<const Epetra_MultiVector> modes,
                                  std::vector<GroupFacts::Place> places, const Semicoarsen when,
                                  const Cycle::MakeSmoother &make_smoother,
                                  const Cycle::MakeSmoother &if_semicoarsened,
                                  const Semicoarsening::Lines lines)
{
  const Epetra_CrsMatrix &A = finest.matrix();
  if (are_all_known(places, A)) {
    LevelNodes nodes = nodes_of_rows(places);
    places = std::vector<GroupFacts::Place>(); // = {} would keep the memory
    if (when == Semicoarsen::always || are_stretched(A, nodes, *modes, when))
      return std::make_unique<Semicoarsening>(std::move(finest), *modes, std::move(nodes), if_semicoarsened,
                                              lines);
  }
  return std::make_unique<SmoothedAggregation>(std::move(finest), std::move(modes), make_smoother);
}

/// Coarsening along short couplings leaves less to the smoothers, the less the more unknowns the next level
/// keeps.
std::unique_ptr<Cycle> make_cycle_with_factorisations(Cycle::Finest A,
                                                      std::shared_ptr<const Epetra_MultiVector> modes,
                                                      std::vector<GroupFacts::Place> places,
                                                      const Semicoarsen when, const bool is_finest,
                                                      const Semicoarsening::Lines lines)
{
  const double large_share = 1. / 3, small_share = 1. / 5;
  const int n_of_finest = is_finest ? A.matrix().NumGlobalRows() : 0;
  const auto usual = [](const LevelEntries &level, const Cycle::LevelFacts &) {
    return ChebyshevSmoother::with_factorisation(level, {4});
  };
  const auto if_semicoarsened = [=](const LevelEntries &level, const Cycle::LevelFacts &facts) {
    const bool is_rich = level.rows().NumGlobalElements() == n_of_finest && facts.share_of_next > large_share;
    const unsigned int n_steps = is_rich ? 1 : facts.share_of_next > small_share ? 3 : 5;
    return ChebyshevSmoother::with_factorisation(level, {n_steps});
  };
  return make_cycle(std::move(A), std::move(modes), std::move(places), when, usual, if_semicoarsened, lines);
}

std::unique_ptr<Cycle> make_cycle_of_whole_lines(Cycle::Finest A_1,
                                                 std::shared_ptr<const Epetra_MultiVector> modes,
                                                 std::vector<GroupFacts::Place> places)
{
  return make_cycle_with_factorisations(std::move(A_1), std::move(modes), std::move(places),
                                        Semicoarsen::if_cheap, false, Semicoarsening::Lines::whole);
}

std::unique_ptr<Cycle> make_cycle_within_bodies(Cycle::Finest A,
                                                std::shared_ptr<const Epetra_MultiVector> modes,
                                                std::vector<GroupFacts::Place> places)
{
  const auto make_smoother = [](const LevelEntries &level, const Cycle::LevelFacts &facts) {
    return ChebyshevSmoother::with_diagonal(level, {4, 20}, facts.known_eigenvalue);
  };
  return make_cycle(std::move(A), std::move(modes), std::move(places), Semicoarsen::always, make_smoother,
                    make_smoother, Semicoarsening::Lines::in_parts);
}

bool has_mixed_bodies(const GroupFacts &facts, const double contrast)
{
  return facts.n_blocks > 2 && facts.contrast && facts.contrast() > contrast;
}

/// A stack of twelve plates with as many unknowns takes 20 kB for each of them.
int Semicoarsening::largest_of_lines(const Epetra_Comm &ranks)
{
  const double most = 300000, fewest = 100000, KiB_of_row = 20;
  double that_fit = std::min(most, 1024 * free_memory() / KiB_of_row), least = most;
  ranks.MinAll(&that_fit, &least, 1);
  return static_cast<int>(std::max(least, fewest));
}

Semicoarsening::Semicoarsening(Finest A, const Epetra_MultiVector &given_modes, LevelNodes nodes,
                               const MakeSmoother &make_smoother, const Lines lines)
    : Cycle(std::move(A))
{
  std::unique_ptr<Epetra_MultiVector> modes = modes_side_by_side(given_modes, nodes);
  int largest = largest_coarse;
  const int most_of_lines = largest_of_lines(coarsest().Comm());
  int n_unknowns = coarsest().NumGlobalRows(); // without the rows of vectors of bases that are zero
  bool has_long_cells = false;                 // this level or one above
  while (n_unknowns > largest) {
    const Epetra_CrsMatrix &matrix = coarsest();
    Couplings couplings(matrix, nodes);
    const bool leads_everywhere = lead_everywhere(couplings, nodes, matrix.Comm());
    has_long_cells = has_long_cells || !leads_everywhere;
    const bool are_means = lines == Lines::whole && n_levels() == 0 && modes->NumVectors() == 1;
    const bool are_short = couplings.are_in_short_lines() && n_unknowns <= most_of_lines;
    const bool are_whole = are_means || are_short ||
                           (lines != Lines::in_parts &&
                            modes_of_nodes(*modes, nodes) >= largest_cheap * couplings.rows_together);
    const bool has_whole_lines = are_whole && couplings.are_in_lines(),
               takes_closest = has_long_cells && !has_whole_lines && couplings.are_many(modes->NumVectors()),
               is_filtered = takes_closest || !leads_everywhere;
    if (has_whole_lines)
      largest = most_of_lines;
    else
      couplings.line_length.assign(nodes.size(), 0);
    const Aggregates aggregates(own_part(takes_closest ? couplings.closest : couplings.near), couplings.all,
                                couplings.line_length);
    Aggregation aggregation = make_bases(aggregate_of_rows(matrix, nodes, aggregates),
                                         static_cast<int>(aggregates.root.size()), *modes);
    const int n_coarse = size_of_basis(aggregation);
    if (n_coarse > (are_short ? growth_of_short_lines : largest_growth) * n_unknowns)
      break;
    const double share_of_next = double(n_coarse) / n_unknowns;
    n_unknowns = n_coarse;
    if (modes->NumVectors() > 1)
      largest = std::max<int>(largest, largest_of_vectors);
    const double eigenvalue = is_filtered ? 0 : largest_eigenvalue_with_diagonal(LevelEntries(matrix));
    auto P = is_filtered ? make_prolongation(matrix, nodes, couplings, aggregation, *modes)
                         : smooth_bases(matrix, SparseRows(matrix), aggregation, 4. / 3 / eigenvalue);
    round_to_single_precision(*P);
    const MakeMatrix make_next = sum_coarse_matrix(matrix, *P, modes->NumVectors());
    add_level(make_smoother, std::move(P), make_next, {eigenvalue, share_of_next});
    nodes = coarse_nodes(nodes, aggregates, modes->NumVectors());
    modes = std::move(aggregation.modes);
    if (const Epetra_Import *const gather = gather_coarsest()) {
      modes = imported(*modes, *gather);
      nodes = imported_nodes(nodes, *gather);
    }
  }
  factorise_coarsest(nodes.first_row);
}

} // namespace dovetail
