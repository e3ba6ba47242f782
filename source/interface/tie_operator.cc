// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/tie_operator.h>
#include <dovetail/widest_vectors.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

namespace dovetail {

template <int dim>
bool TieOperator<dim>::is_possible(const Interface<dim> &interface, const TiedField &field)
{
  return interface.tie().parts().point_terms != nullptr && field.names[0] == field.names[1] &&
         (field.n_components == 1 || field.n_components == dim);
}

template <int dim>
TieOperator<dim>::TieOperator(const Interface<dim> &interface, const TiedField &field)
    : interface(&interface), field(&field), n_components(field.n_components)
{
}

template <int dim>
const LeadingUnknowns &TieOperator<dim>::leading(const unsigned int group) const
{
  const LeadingUnknowns *given =
      interface->tie().parts().point_terms->leading_unknowns(*interface, interface->pairing().groups[group]);
  return given == nullptr ? interface->all_unknowns() : *given;
}

template <int dim>
void TieOperator<dim>::for_each_unknown(
    const std::function<void(dealii::types::global_dof_index)> &visit) const
{
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &group : interface->pairing().groups) {
    interface->group_dofs(group, dofs);
    for (const unsigned int side : {0u, 1u}) {
      const unsigned int first = first_unknown(side);
      for (unsigned int i = first; i < first + n_unknowns(side); ++i)
        visit(dofs[i]);
    }
  }
}

template <int dim>
void TieOperator<dim>::number(const std::function<int(dealii::types::global_dof_index)> &index)
{
  find_nodes(index);
  find_blocks();
}

/// A line of nodes has one leading node, also where several cells share it.
template <int dim>
void TieOperator<dim>::find_nodes(const std::function<int(dealii::types::global_dof_index)> &index)
{
  std::map<std::vector<int>, unsigned int> number; // by the index of the first component
  std::vector<dealii::types::global_dof_index> dofs;
  nodes.clear();
  nodes_of_group.clear();
  for (unsigned int g = 0; g < interface->pairing().groups.size(); ++g) {
    const LeadingUnknowns &of_group = leading(g);
    interface->group_dofs(interface->pairing().groups[g], dofs);
    nodes_of_group.emplace_back();
    for (const unsigned int side : {0u, 1u}) {
      const unsigned int first = first_unknown(side), place = first_position(side),
                         n_nodes = field->n_nodes[side];
      const std::vector<unsigned int> &leaders = of_group.nodes[side][place];
      std::vector<std::vector<unsigned int>> led(leaders.size());
      for (unsigned int i = 0; i < leaders.size(); ++i)
        led[i].push_back(leaders[i]);
      for (unsigned int a = 0; a < n_nodes; ++a)
        if (const unsigned int i = of_group.leader[first + a] - of_group.first[side][place]; leaders[i] != a)
          led[i].push_back(a);
      for (const std::vector<unsigned int> &line : led) {
        std::vector<int> key;
        for (const unsigned int a : line)
          key.push_back(index(dofs[first + a]));
        const auto [known, is_new] = number.try_emplace(key, nodes.size());
        nodes_of_group.back().push_back(known->second);
        if (!is_new)
          continue;
        nodes.emplace_back();
        for (const unsigned int a : line) {
          nodes.back().factors.push_back(of_group.factor[first + a]);
          for (unsigned int c = 0; c < n_components; ++c)
            nodes.back().index.push_back(index(dofs[first + c * n_nodes + a]));
        }
      }
    }
  }
  summands.clear();
  for (unsigned int node = 0; node < nodes.size(); ++node)
    for (unsigned int k = 0; k < nodes[node].factors.size(); ++k)
      for (unsigned int c = 0; c < n_components; ++c)
        summands.push_back({nodes[node].index[k * n_components + c], node, c, nodes[node].factors[k]});
  std::sort(summands.begin(), summands.end(), [](const Summand &a, const Summand &b) {
    return std::tie(a.index, a.node, a.component) < std::tie(b.index, b.node, b.component);
  });
}

/// Two nodes couple as in BlockSystem::add_pattern: if one of them enters the jump, unless the tie couples
/// more.
template <int dim>
void TieOperator<dim>::find_blocks()
{
  const PointTerms<dim> &terms = *interface->tie().parts().point_terms;
  const bool by_flux = terms.couples_fluxes(), by_inside = terms.couples_insides(*interface);
  std::vector<std::vector<bool>> jumps; // by group, each of its nodes
  std::vector<std::vector<std::pair<unsigned int, unsigned int>>> places(nodes.size()); // in which groups
  for (unsigned int g = 0; g < nodes_of_group.size(); ++g) {
    const LeadingUnknowns &of_group = leading(g);
    const std::vector<bool> in_jump = interface->unknowns_in_jump(interface->pairing().groups[g]);
    jumps.emplace_back(nodes_of_group[g].size(), by_flux);
    for (const unsigned int side : {0u, 1u}) {
      const unsigned int first = first_unknown(side), place = first_position(side),
                         n = of_group.nodes[side][place].size(),
                         before = side == 0 ? 0 : of_group.nodes[0][first_position(0)].size();
      for (unsigned int i = first; i < first + n_unknowns(side); ++i)
        if (in_jump[i])
          jumps[g][before + (of_group.leader[i] - of_group.first[side][place]) % n] = true;
    }
    for (unsigned int i = 0; i < nodes_of_group[g].size(); ++i)
      places[nodes_of_group[g][i]].emplace_back(g, i);
  }
  first_block.assign(1, 0);
  column.clear();
  std::vector<unsigned int> last_row(nodes.size(), dealii::numbers::invalid_unsigned_int); // with this column
  for (unsigned int row = 0; row < nodes.size(); ++row) {
    for (const auto &[g, i] : places[row]) {
      const unsigned int n_source = leading(g).nodes[0][first_position(0)].size();
      for (unsigned int j = 0; j < nodes_of_group[g].size(); ++j)
        if (const unsigned int other = nodes_of_group[g][j];
            other >= row && last_row[other] != row &&
            (jumps[g][i] || jumps[g][j] || (by_inside && (i < n_source) == (j < n_source)))) {
          last_row[other] = row;
          column.push_back(other);
        }
    }
    std::sort(column.begin() + first_block.back(), column.end());
    first_block.push_back(column.size());
  }
  column.shrink_to_fit();
  begin_tangent();
}

template <int dim>
unsigned int TieOperator<dim>::position(const unsigned int row, const unsigned int wanted) const
{
  const auto begin = column.begin() + first_block[row], end = column.begin() + first_block[row + 1],
             found = std::lower_bound(begin, end, wanted);
  return found == end || *found != wanted ? column.size() : found - column.begin();
}

/// The entry of two leading unknowns; 0 if there is none.
template <int dim>
double TieOperator<dim>::entry(const unsigned int row, const unsigned int c, const unsigned int other,
                               const unsigned int d) const
{
  const unsigned int k = position(std::min(row, other), std::max(row, other)), n = n_components;
  if (k == column.size())
    return 0;
  return row <= other ? upper[(k * n + c) * n + d] : lower_entry(k, d, c);
}

template <int dim>
void TieOperator<dim>::begin_tangent()
{
  upper.assign(column.size() * n_components * n_components + 1, 0.); // vectors read one number too many
  lower = upper;
}

template <int dim>
void TieOperator<dim>::add(const unsigned int group, const dealii::FullMatrix<double> &T)
{
  const LeadingUnknowns &of_group = leading(group);
  const std::vector<unsigned int> &own = nodes_of_group[group];
  const std::array<unsigned int, 2> place = {{first_position(0), first_position(1)}};
  const unsigned int n = n_components, n_source = of_group.nodes[0][place[0]].size();
  const auto unknown = [&](const unsigned int i, const unsigned int c) {
    const unsigned int side = i < n_source ? 0 : 1;
    return of_group.first[side][place[side] + c] + i - side * n_source;
  };
  position_of.resize(nodes.size());
  for (unsigned int i = 0; i < own.size(); ++i) {
    for (const unsigned int node : own)
      position_of[node] = column.size();
    for (unsigned int k = first_block[own[i]]; k < first_block[own[i] + 1]; ++k)
      position_of[column[k]] = k;
    for (unsigned int j = 0; j < own.size(); ++j) {
      if (own[j] < own[i])
        continue;
      const unsigned int k = position_of[own[j]];
      for (unsigned int c = 0; c < n; ++c)
        for (unsigned int d = 0; d < n; ++d) {
          const double value = T(unknown(i, c), unknown(j, d)),
                       mirrored = own[i] == own[j] ? T(unknown(i, d), unknown(j, c))
                                                   : T(unknown(j, d), unknown(i, c));
          AssertThrow(k < column.size() || (value == 0 && mirrored == 0),
                      dealii::ExcMessage("a tie couples nodes that it has not named"));
          if (k < column.size()) {
            upper[(k * n + c) * n + d] += value;
            lower[(k * n + c) * n + d] += mirrored;
          }
        }
    }
  }
}

template <int dim>
void TieOperator<dim>::clear_own_entries(dealii::FullMatrix<double> &of_all) const
{
  for (const unsigned int row_side : {0u, 1u})
    for (const unsigned int side : {0u, 1u})
      for (unsigned int i = 0; i < n_unknowns(row_side); ++i)
        std::fill_n(&of_all(first_unknown(row_side) + i, first_unknown(side)), n_unknowns(side), 0.);
}

template <int dim>
void TieOperator<dim>::finish_tangent()
{
  double largest = 0, difference = 0;
  for (std::size_t i = 0; i < lower.size(); ++i) {
    largest = std::max({largest, std::abs(upper[i]), std::abs(lower[i])});
    difference = std::max(difference, std::abs(upper[i] - lower[i]));
  }
  if (difference <= 1e-13 * largest)
    lower = std::vector<double>();
  keeps_translations = !nodes.empty() && has_rows_of_zero_sum();
}

/// Whether S does not resist what moves all unknowns alike.
template <int dim>
bool TieOperator<dim>::has_rows_of_zero_sum() const
{
  const double rounding = 1e-13;
  const unsigned int n = n_components;
  std::vector<double> sums(nodes.size() * n * n, 0.), sizes(nodes.size(), 0.), share;
  for (const Node &node : nodes)
    share.push_back(std::accumulate(node.factors.begin(), node.factors.end(), 0.));
  const auto add = [&](const unsigned int row, const unsigned int c, const unsigned int d,
                       const double value) {
    sums[(row * n + c) * n + d] += value;
    sizes[row] += std::abs(value);
  };
  for (unsigned int row = 0; row < nodes.size(); ++row)
    for (unsigned int k = first_block[row]; k < first_block[row + 1]; ++k)
      for (unsigned int c = 0; c < n; ++c)
        for (unsigned int d = 0; d < n; ++d) {
          add(row, c, d, share[column[k]] * upper[(k * n + c) * n + d]);
          if (column[k] != row)
            add(column[k], d, c, share[row] * lower_entry(k, c, d));
        }
  for (unsigned int row = 0; row < nodes.size(); ++row)
    for (unsigned int e = row * n * n; e < (row + 1) * n * n; ++e)
      if (!(std::abs(sums[e]) <= rounding * sizes[row]))
        return false;
  return true;
}

template <int dim>
void TieOperator<dim>::add_tangent(const double factor, const TieOperator &other)
{
  if (lower.empty())
    lower = upper;
  for (std::size_t i = 0; i < upper.size(); ++i) {
    upper[i] += factor * other.upper[i];
    lower[i] += factor * (other.lower.empty() ? other.upper : other.lower)[i];
  }
  finish_tangent();
}

namespace {

/// Square blocks on and above the diagonal, row by row.
struct UpperBlocks
{
  unsigned int n_rows;
  const unsigned int *first, *column; ///< of each row; of each block
  const double *above, *below;        ///< below: the transposed of those across the diagonal
  bool is_mean;                       ///< the mean of both counts
};

/// y += T x with vectors in which each node has the same number of places, the first n of which count.
template <int n, int places>
DOVETAIL_PART_OF_CALLER void add_product_of_blocks(const UpperBlocks &T, const double *const __restrict__ x,
                                                   double *const __restrict__ y)
{
  const double *above = T.above, *below = T.below;
  double mean[n * n + places] = {};
  for (unsigned int i = 0; i < T.n_rows; ++i) {
    double products[n][places] = {}; // by place of the columns
    for (unsigned int k = T.first[i]; k < T.first[i + 1]; ++k, above += n * n, below += n * n) {
      const unsigned int j = T.column[k];
      for (int e = 0; T.is_mean && e < n * n; ++e)
        mean[e] = (above[e] + below[e]) / 2;
      const double *const __restrict__ a = T.is_mean ? mean : above;
      const double *const __restrict__ b = T.is_mean ? mean : below;
      const double *const __restrict__ x_j = x + std::size_t(j) * places;
      for (int c = 0; c < n; ++c)
        for (int d = 0; d < places; ++d)
          products[c][d] += a[c * n + d] * x_j[d];
      if (j == i)
        continue;
      double y_j[places] = {};
      for (int c = 0; c < n; ++c)
        for (int d = 0; d < places; ++d)
          y_j[d] += b[c * n + d] * x[std::size_t(i) * places + c];
      for (int d = 0; d < places; ++d)
        y[std::size_t(j) * places + d] += y_j[d];
    }
    for (int c = 0; c < n; ++c)
      for (int d = 0; d < n; ++d)
        y[std::size_t(i) * places + c] += products[c][d];
  }
}

constexpr int places_of_three = 4; ///< as many as fit in a vector of the processor

DOVETAIL_WIDEST_VECTORS void add_product_of_three(const UpperBlocks &T, const double *const x,
                                                  double *const y)
{
  add_product_of_blocks<3, places_of_three>(T, x, y);
}

} // namespace

/// Each block counts twice, above and below the diagonal. A tie does not resist what moves both sides alike,
/// but what rounding leaves of a sum of large values would, more than a soft body that holds a stiff one. So
/// values count from those of one node.
template <int dim>
template <int n>
void TieOperator<dim>::multiply(const double *x, double *y, const bool of_symmetric_part) const
{
  constexpr int places = n == 3 ? places_of_three : n;
  std::vector<double> of_nodes(nodes.size() * places, 0.), sums(nodes.size() * places, 0.);
  std::array<double, n> origin{};
  const bool is_exact = !of_symmetric_part || lower.empty(); // else columns of S need not add up to zero
  for (unsigned int c = 0; c < n && keeps_translations && is_exact; ++c)
    origin[c] = x[nodes[0].index[c]];
  for (unsigned int i = 0; i < nodes.size(); ++i)
    for (unsigned int k = 0; k < nodes[i].factors.size(); ++k)
      for (unsigned int c = 0; c < n; ++c)
        of_nodes[i * places + c] += nodes[i].factors[k] * (x[nodes[i].index[k * n + c]] - origin[c]);
  const UpperBlocks T = {static_cast<unsigned int>(nodes.size()),
                         first_block.data(),
                         column.data(),
                         upper.data(),
                         lower.empty() ? upper.data() : lower.data(),
                         of_symmetric_part && !lower.empty()};
  if constexpr (n == 3)
    add_product_of_three(T, of_nodes.data(), sums.data());
  else
    add_product_of_blocks<n, places>(T, of_nodes.data(), sums.data());
  for (unsigned int i = 0; i < nodes.size(); ++i)
    for (unsigned int k = 0; k < nodes[i].factors.size(); ++k)
      for (unsigned int c = 0; c < n; ++c)
        y[nodes[i].index[k * n + c]] += nodes[i].factors[k] * sums[i * places + c];
}

template <int dim>
void TieOperator<dim>::add_product(const double *x, double *y, const bool of_symmetric_part) const
{
  if (n_components == 1)
    multiply<1>(x, y, of_symmetric_part);
  else
    multiply<dim>(x, y, of_symmetric_part);
}

template <int dim>
void TieOperator<dim>::add_diagonal(double *diagonal) const
{
  for (auto begin = summands.begin(); begin != summands.end();) {
    const auto end = std::find_if(begin, summands.end(),
                                  [&](const Summand &summand) { return summand.index != begin->index; });
    for (auto a = begin; a != end; ++a)
      for (auto b = begin; b != end; ++b)
        diagonal[begin->index] += a->factor * b->factor * entry(a->node, a->component, b->node, b->component);
    begin = end;
  }
}

namespace {

using SparseRow = std::vector<std::pair<unsigned int, double>>; ///< columns and entries

/// Sums of sparse rows.
class SparseSum
{
public:
  explicit SparseSum(const unsigned int n_columns) : value(n_columns, 0.), is_there(n_columns, false) {}

  void add(const double factor, const SparseRow &row)
  {
    for (const auto &[j, entry] : row) {
      if (!is_there[j]) {
        is_there[j] = true;
        columns.push_back(j);
      }
      value[j] += factor * entry;
    }
  }
  /// And begin anew.
  SparseRow take()
  {
    std::sort(columns.begin(), columns.end());
    SparseRow row;
    for (const unsigned int j : columns) {
      row.emplace_back(j, value[j]);
      value[j] = 0;
      is_there[j] = false;
    }
    columns.clear();
    return row;
  }

private:
  std::vector<double> value;
  std::vector<bool> is_there;
  std::vector<unsigned int> columns;
};

/// Of each node the nodes before it that have a block with it, and these blocks.
std::vector<std::vector<std::pair<unsigned int, unsigned int>>>
blocks_before(const std::vector<unsigned int> &first_block, const std::vector<unsigned int> &column)
{
  std::vector<std::vector<std::pair<unsigned int, unsigned int>>> result(first_block.size() - 1);
  for (unsigned int node = 0; node < result.size(); ++node)
    for (unsigned int k = first_block[node]; k < first_block[node + 1]; ++k)
      if (column[k] != node)
        result[column[k]].emplace_back(node, k);
  return result;
}

} // namespace

/// (G P)^T T (G P): a function of degree one has few unknowns at a leading node.
template <int dim>
typename TieOperator<dim>::Restriction
TieOperator<dim>::restricted(const typename CellOperator<dim>::Prolongation &P) const
{
  const unsigned int n = n_components;
  Restriction result;
  for (const Summand &summand : summands) {
    const auto row = P(summand.index);
    result.rows.insert(result.rows.end(), row.columns, row.columns + row.n);
  }
  std::sort(result.rows.begin(), result.rows.end());
  result.rows.erase(std::unique(result.rows.begin(), result.rows.end()), result.rows.end());
  const unsigned int n_coarse = result.rows.size();

  SparseSum sum(n_coarse);
  std::vector<SparseRow> GP, TGP, GP_transposed(n_coarse);
  for (unsigned int node = 0; node < nodes.size(); ++node)
    for (unsigned int c = 0; c < n; ++c) {
      SparseRow of_column;
      for (unsigned int k = 0; k < nodes[node].factors.size(); ++k) {
        const auto row = P(nodes[node].index[k * n + c]);
        of_column.clear();
        for (int j = 0; j < row.n; ++j)
          of_column.emplace_back(std::lower_bound(result.rows.begin(), result.rows.end(), row.columns[j]) -
                                     result.rows.begin(),
                                 row.weights[j]);
        sum.add(nodes[node].factors[k], of_column);
      }
      GP.push_back(sum.take());
      for (const auto &[j, weight] : GP.back())
        GP_transposed[j].emplace_back(GP.size() - 1, weight);
    }
  const auto before = blocks_before(first_block, column);
  for (unsigned int node = 0; node < nodes.size(); ++node)
    for (unsigned int c = 0; c < n; ++c) {
      const auto add = [&](const unsigned int k, const unsigned int other, const bool is_before) {
        for (unsigned int d = 0; d < n; ++d) {
          const unsigned int i = is_before ? d : c, j = is_before ? c : d;
          const double value = (upper[(k * n + i) * n + j] + lower_entry(k, i, j)) / 2;
          if (value != 0)
            sum.add(value, GP[other * n + d]);
        }
      };
      for (const auto &[other, k] : before[node])
        add(k, other, true);
      for (unsigned int k = first_block[node]; k < first_block[node + 1]; ++k)
        add(k, column[k], false);
      TGP.push_back(sum.take());
    }
  result.columns.resize(n_coarse);
  result.values.resize(n_coarse);
  for (unsigned int i = 0; i < n_coarse; ++i) {
    for (const auto &[row, weight] : GP_transposed[i])
      sum.add(weight, TGP[row]);
    for (const auto &[j, value] : sum.take()) {
      result.columns[i].push_back(result.rows[j]);
      result.values[i].push_back(value);
    }
  }
  return result;
}

template class TieOperator<2>;
template class TieOperator<3>;

} // namespace dovetail
