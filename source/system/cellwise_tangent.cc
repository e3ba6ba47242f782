// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "sum_of_small.h"

#include <dovetail/domain/edge_lengths.h>
#include <dovetail/solve/free_memory.h>
#include <dovetail/solve/prolongation.h>
#include <dovetail/solve/rows_of_other_ranks.h>
#include <dovetail/system/cellwise_tangent.h>

#include <deal.II/base/mpi.h>

#include <EpetraExt_MatrixMatrix.h>
#include <Epetra_MpiComm.h>

#include <boost/serialization/set.hpp>
#include <boost/serialization/utility.hpp>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace dovetail {

template <int dim>
CellwiseTangent<dim>::CellwiseTangent(const Model<dim> &model, const RowNumbering &rows,
                                      const std::vector<FieldOfTie> &given_ties)
    : model(model), rows(rows), place_of_block(model.numbering->blocks().size(), -1)
{
  for (unsigned int i = 0; i < rows.blocks().size(); ++i) {
    const Block &block = model.numbering->blocks()[rows.blocks()[i]];
    const Domain<dim> &domain = *model.domains[block.domain_index];
    place_of_block[rows.blocks()[i]] = i;
    operators[block.domain_index] = CellOperator<dim>::make(domain, domain.fields()[block.field_index]);
  }
  for (const auto &[interface, field] : given_ties)
    ties.emplace_back(*interface, *field);
  collect_columns();
}

template <int dim>
CellwiseTangent<dim>::CellwiseTangent(const CellwiseTangent &other, const std::vector<int> &followers,
                                      const Epetra_CrsMatrix &weights)
    : model(other.model), rows(other.rows), ties(other.ties), place_of_block(other.place_of_block),
      own_rows(other.own_rows), columns(other.columns), import(other.import), exchange(other.exchange),
      constrained(other.constrained), follow(other.follow), is_condensed(other.is_condensed),
      block_pairs(other.block_pairs)
{
  for (const auto &[d, cells] : other.operators)
    operators.emplace(d, cells);
  add_followers(followers, weights);
  find_diagonal();
}

template <int dim>
std::shared_ptr<PartOperator> CellwiseTangent<dim>::with_followers(const std::vector<int> &followers,
                                                                   const Epetra_CrsMatrix &weights) const
{
  return std::shared_ptr<PartOperator>(new CellwiseTangent(*this, followers, weights));
}

template <int dim>
std::shared_ptr<PartOperator> CellwiseTangent<dim>::copy() const
{
  return std::shared_ptr<PartOperator>(new CellwiseTangent(*this));
}

template <int dim>
void CellwiseTangent<dim>::add(const double factor, const PartOperator &other)
{
  for (auto &[d, cells] : operators)
    cells->add_tangent(factor, *dynamic_cast<const CellwiseTangent &>(other).operators.at(d));
  for (unsigned int i = 0; i < ties.size(); ++i)
    ties[i].add_tangent(factor, dynamic_cast<const CellwiseTangent &>(other).ties[i]);
  find_diagonal();
}

template <int dim>
int CellwiseTangent<dim>::row(const dealii::types::global_dof_index dof) const
{
  const unsigned int b = model.numbering->block_of(dof);
  return rows.row(place_of_block[b], dof - model.numbering->blocks()[b].begin);
}

template <int dim>
void CellwiseTangent<dim>::collect_columns()
{
  const Epetra_MpiComm communicator(model.communicator);
  own_rows = std::make_shared<Epetra_Map>(-1, static_cast<int>(rows.n_local()), 0, communicator);
  std::set<int> others;
  const auto collect = [&](const auto dof) {
    if (const int global = row(dof); !own_rows->MyGID(global))
      others.insert(global);
  };
  for (const auto &[d, cells] : operators)
    cells->for_each_unknown(collect);
  for (const auto &tie : ties)
    tie.for_each_unknown(collect);
  if (communicator.NumProc() == 1)
    columns = own_rows; // of consecutive numbers, which takes no memory
  else {
    std::vector<int> all(own_rows->MyGlobalElements(),
                         own_rows->MyGlobalElements() + own_rows->NumMyElements());
    all.insert(all.end(), others.begin(), others.end());
    columns = std::make_shared<Epetra_Map>(-1, static_cast<int>(all.size()), all.data(), 0, communicator);
  }
  import = std::make_shared<Epetra_Import>(*columns, *own_rows);
  exchange = std::make_shared<ColumnExchange>(*own_rows, std::vector<int>(others.begin(), others.end()));
  for (auto &[d, cells] : operators)
    cells->number([&](const auto dof) { return columns->LID(row(dof)); });
  for (auto &tie : ties)
    tie.number([&](const auto dof) { return columns->LID(row(dof)); });
}

template <int dim>
void CellwiseTangent<dim>::begin(const dealii::AffineConstraints<double> &constraints)
{
  make_constraint_matrix(constraints);
  for (auto &[d, cells] : operators)
    cells->begin_tangent();
  for (auto &tie : ties)
    tie.begin_tangent();
}

template <int dim>
void CellwiseTangent<dim>::make_constraint_matrix(const dealii::AffineConstraints<double> &constraints)
{
  constrained.clear();
  is_condensed.assign(rows.n_local(), false);
  std::vector<int> global_rows;
  std::vector<std::vector<int>> followed;
  std::vector<std::vector<double>> weights;
  std::set<std::pair<unsigned int, unsigned int>> own_pairs;
  for (const unsigned int b : rows.blocks()) {
    const Block &block = model.numbering->blocks()[b];
    for (const auto i : block.owned)
      if (const auto *entries = constraints.get_constraint_entries(block.begin + i);
          constraints.is_constrained(block.begin + i)) {
        global_rows.push_back(row(block.begin + i));
        constrained.push_back(own_rows->LID(global_rows.back()));
        is_condensed[constrained.back()] = true;
        followed.emplace_back();
        weights.emplace_back();
        for (unsigned int k = 0; entries != nullptr && k < entries->size(); ++k) {
          followed.back().push_back(row((*entries)[k].first));
          weights.back().push_back((*entries)[k].second);
          const unsigned int other = model.numbering->block_of((*entries)[k].first);
          if (other != b)
            own_pairs.insert({{b, other}, {other, b}});
        }
      }
  }
  for (const auto &tie : ties) {
    std::array<std::vector<unsigned int>, 2> blocks; // of each side
    for (const unsigned int side : {source, destination})
      for (const unsigned int b : rows.blocks())
        if (model.domains[model.numbering->blocks()[b].domain_index].get() == tie.tied().sides[side].domain)
          blocks[side].push_back(b);
    for (const unsigned int b : blocks[source])
      for (const unsigned int other : blocks[destination])
        if (b != other)
          own_pairs.insert({{b, other}, {other, b}});
  }
  block_pairs.clear();
  for (const auto &of_rank : dealii::Utilities::MPI::all_gather(model.communicator, own_pairs))
    block_pairs.insert(of_rank.begin(), of_rank.end());
  const Epetra_Map map(-1, static_cast<int>(global_rows.size()), global_rows.data(), 0, own_rows->Comm());
  follow = std::make_shared<Epetra_CrsMatrix>(Copy, map, 0);
  for (unsigned int k = 0; k < global_rows.size(); ++k)
    follow->InsertGlobalValues(global_rows[k], followed[k].size(), weights[k].data(), followed[k].data());
  follow->FillComplete(*own_rows, map);
}

/// What followed one of them so far follows what that follows.
template <int dim>
void CellwiseTangent<dim>::add_followers(const std::vector<int> &followers, const Epetra_CrsMatrix &weights)
{
  Epetra_CrsMatrix Z(Copy, *own_rows, 0), before(Copy, follow->RowMap(), 0);
  std::vector<int> followed, global_rows;
  std::vector<double> values;
  for (unsigned int k = 0; k < followers.size(); ++k) {
    read_row(weights, k, followed, values);
    Z.InsertGlobalValues(own_rows->GID(followers[k]), followed.size(), values.data(), followed.data());
    is_condensed[followers[k]] = true;
  }
  const double one = 1;
  for (int row = 0; row < own_rows->NumMyElements(); ++row)
    if (const int itself = own_rows->GID(row); !is_condensed[row])
      Z.InsertGlobalValues(itself, 1, &one, &itself);
  Z.FillComplete(*own_rows, *own_rows);
  if (follow->NumGlobalNonzeros() > 0)
    EpetraExt::MatrixMatrix::Multiply(*follow, false, Z, false, before, false);
  before.FillComplete(*own_rows, follow->RowMap());

  const unsigned int n_before = constrained.size();
  constrained.insert(constrained.end(), followers.begin(), followers.end());
  for (const int row : constrained)
    global_rows.push_back(own_rows->GID(row));
  const Epetra_Map map(-1, static_cast<int>(global_rows.size()), global_rows.data(), 0, own_rows->Comm());
  follow = std::make_shared<Epetra_CrsMatrix>(Copy, map, 0);
  for (unsigned int k = 0; k < global_rows.size(); ++k) {
    k < n_before ? read_row(before, k, followed, values) : read_row(weights, k - n_before, followed, values);
    follow->InsertGlobalValues(global_rows[k], followed.size(), values.data(), followed.data());
  }
  follow->FillComplete(*own_rows, map);
}

/// y += K x for all unknowns of the cells of this rank, as if there were no constraints.
template <int dim>
void CellwiseTangent<dim>::multiply_here(const Kind kind, const double *const x, double *const y) const
{
  for (const auto &[d, cells] : operators)
    if (kind == rough)
      cells->add_rough_product(x, y);
    else
      cells->add_product(x, y, kind == symmetric);
  for (const auto &tie : ties)
    tie.add_product(x, y, kind != exact);
}

template <int dim>
void CellwiseTangent<dim>::multiply_cells(const Kind kind, const Epetra_Vector &all_values,
                                          Epetra_Vector &y) const
{
  if (own_rows->Comm().NumProc() == 1) {
    multiply_here(kind, all_values.Values(), y.Values());
    return;
  }
  std::vector<double> buffer, sums(y.Values(), y.Values() + y.MyLength());
  sums.resize(exchange->n_columns()); // own rows are the first of the columns
  multiply_here(kind, exchange->of_columns(all_values, buffer), sums.data());
  exchange->add_up(sums, y);
}

/// y = C^T y, where the rows of unknowns that follow others become @p replacement, or zero.
template <int dim>
void CellwiseTangent<dim>::condense(Epetra_Vector &y, const Epetra_CrsMatrix &weights,
                                    const std::vector<double> &replacement) const
{
  if (follow->NumGlobalRows() == 0)
    return;
  Epetra_Vector of_constrained(weights.RangeMap(), false);
  for (unsigned int k = 0; k < constrained.size(); ++k) {
    of_constrained[k] = y[constrained[k]];
    y[constrained[k]] = replacement.empty() ? 0 : replacement[k];
  }
  if (weights.NumGlobalNonzeros() == 0) // all of them are prescribed
    return;
  if (own_rows->Comm().NumProc() > 1) {
    Epetra_Vector of_followed(*own_rows, false);
    weights.Multiply(true, of_constrained, of_followed);
    y.Update(1., of_followed, 1.);
    return;
  }
  Epetra_Vector of_followed(weights.ColMap());
  for (int k = 0; k < weights.NumMyRows(); ++k) {
    int n = 0, *local = nullptr;
    double *values = nullptr;
    weights.ExtractMyRowView(k, n, values, local);
    for (int i = 0; i < n; ++i)
      of_followed[local[i]] += values[i] * of_constrained[k];
  }
  for (int column = 0; column < of_followed.MyLength(); ++column)
    y[own_rows->LID(weights.GCID(column))] += of_followed[column];
}

template <int dim>
void CellwiseTangent<dim>::add_product(const double factor, const Epetra_Vector &x, Epetra_Vector &y,
                                       const bool of_symmetric_part) const
{
  const Kind kind = of_symmetric_part ? symmetric : exact;
  if (factor == 1) {
    add_product(kind, x, y);
    return;
  }
  Epetra_Vector product(*own_rows);
  add_product(kind, x, product);
  y.Update(factor, product, 1.);
}

template <int dim>
void CellwiseTangent<dim>::add_product(const Kind kind, const Epetra_Vector &x, Epetra_Vector &y) const
{
  if (!follow)
    return;
  if (follow->NumGlobalRows() == 0) {
    multiply_cells(kind, x, y);
    return;
  }
  Epetra_Vector all(x), of_constrained(follow->RangeMap());
  std::vector<double> before;
  follow->Multiply(false, x, of_constrained);
  for (unsigned int k = 0; k < constrained.size(); ++k) {
    all[constrained[k]] = of_constrained[k];
    before.push_back(y[constrained[k]]);
    y[constrained[k]] = 0;
  }
  multiply_cells(kind, all, y);
  condense(y, *follow, before);
}

template <int dim>
void CellwiseTangent<dim>::subtract_moves(const dealii::AffineConstraints<double> &constraints,
                                          dealii::TrilinosWrappers::MPI::BlockVector &b) const
{
  Epetra_Vector values(*own_rows), own(*own_rows);
  for (const unsigned int number : rows.blocks()) {
    const Block &block = model.numbering->blocks()[number];
    for (const auto i : block.owned)
      if (constraints.is_constrained(block.begin + i))
        values[own_rows->LID(row(block.begin + i))] = constraints.get_inhomogeneity(block.begin + i);
  }
  Epetra_Vector product(*own_rows);
  multiply_cells(exact, values, product);
  condense(product, *follow, {});
  rows.gather(b, own.Values());
  own.Update(-1., product, 1.);
  rows.scatter(own.Values(), b);
}

template <int dim>
void CellwiseTangent<dim>::finish()
{
  for (const auto &[d, cells] : operators)
    cells->finish_tangent();
  for (auto &tie : ties)
    tie.finish_tangent();
  find_diagonal();
}

namespace {

/// With @p change of each entry.
Epetra_CrsMatrix changed(const Epetra_CrsMatrix &matrix, double (*const change)(double))
{
  Epetra_CrsMatrix result(matrix);
  for (int k = 0; k < result.NumMyRows(); ++k) {
    int n = 0;
    double *values = nullptr;
    result.ExtractMyRowView(k, n, values);
    std::transform(values, values + n, values, change);
  }
  return result;
}

} // namespace

/// As if no product of two unknowns that one follows counted: near enough for a smoother.
template <int dim>
void CellwiseTangent<dim>::find_diagonal()
{
  Epetra_Vector of_cells(*columns), own(*own_rows);
  for (const auto &[d, cells] : operators)
    cells->add_diagonal(of_cells.Values());
  for (const auto &tie : ties)
    tie.add_diagonal(of_cells.Values());
  own.Export(of_cells, *import, Add);
  diagonal.assign(own.Values(), own.Values() + own.MyLength());
  condense(own, changed(*follow, [](const double w) { return w * w; }), {});
  other_diagonal.clear();
  for (unsigned int i = 0; i < diagonal.size(); ++i)
    if (own[i] != diagonal[i]) {
      other_diagonal.emplace_back(i, diagonal[i]);
      diagonal[i] = own[i];
    }
}

template <int dim>
void CellwiseTangent<dim>::add_diagonal(Epetra_Vector &values) const
{
  for (unsigned int i = 0; i < diagonal.size(); ++i)
    values[i] += diagonal[i];
}

template <int dim>
std::vector<double> CellwiseTangent<dim>::uncondensed_diagonal() const
{
  std::vector<double> of_K = diagonal;
  for (const auto &[i, value] : other_diagonal)
    of_K[i] = value;
  return of_K;
}

template <int dim>
void CellwiseTangent<dim>::add_uncondensed_diagonal(Epetra_Vector &values) const
{
  const std::vector<double> of_K = uncondensed_diagonal();
  for (unsigned int i = 0; i < of_K.size(); ++i)
    values[i] += of_K[i];
}

/// (|K_ii| sum of |K_jj| x_j^2)^(1/2) over the unknowns j of the cells of i. K_ij^2 <= K_ii K_jj where K is
/// positive, but most entries of a row are far smaller: the sum of |K_ij x_j| is a half of that, about.
template <int dim>
void CellwiseTangent<dim>::add_sizes_of_products(const Epetra_Vector &x, Epetra_Vector &sizes) const
{
  if (!follow)
    return;
  const std::vector<double> of_K = uncondensed_diagonal();
  Epetra_Vector squares(x), of_constrained(follow->RangeMap()), all(*columns), of_cells(*columns),
      sums(*own_rows);
  follow->Multiply(false, x, of_constrained);
  for (unsigned int k = 0; k < constrained.size(); ++k)
    squares[constrained[k]] = of_constrained[k];
  for (unsigned int i = 0; i < of_K.size(); ++i)
    squares[i] *= std::abs(of_K[i]) * squares[i];
  all.Import(squares, *import, Insert);
  for (const auto &[d, cells] : operators)
    cells->add_sums_over_cells(all.Values(), of_cells.Values());
  sums.Export(of_cells, *import, Add);
  for (unsigned int i = 0; i < of_K.size(); ++i)
    sums[i] = std::sqrt(std::abs(of_K[i]) * sums[i]);
  condense(sums, changed(*follow, std::abs), {});
  sizes.Update(1., sums, 1.);
}

namespace {

/// W (sum of solves in cells) W, and a diagonal matrix where W = 0.
class CellwiseApproximation : public Approximation
{
public:
  /// @param solves by indices of the columns
  CellwiseApproximation(std::shared_ptr<const Epetra_Map> own_rows,
                        std::shared_ptr<const ColumnExchange> exchange,
                        std::vector<std::unique_ptr<CellSolves>> solves, std::vector<double> weights,
                        std::vector<double> inverse)
      : own_rows(std::move(own_rows)), exchange(std::move(exchange)), solves(std::move(solves)),
        weights(std::move(weights)), inverse(std::move(inverse))
  {
  }

  void vmult(double *z, const double *r) const override;

private:
  std::shared_ptr<const Epetra_Map> own_rows;
  std::shared_ptr<const ColumnExchange> exchange;
  std::vector<std::unique_ptr<CellSolves>> solves;
  std::vector<double> weights, inverse; ///< by own row
};

void CellwiseApproximation::vmult(double *const z, const double *const r) const
{
  Epetra_Vector weighted(*own_rows, false), sum(*own_rows);
  for (unsigned int i = 0; i < weights.size(); ++i)
    weighted[i] = weights[i] * r[i];
  if (own_rows->Comm().NumProc() == 1)
    for (const auto &of_domain : solves)
      of_domain->add_solutions(weighted.Values(), sum.Values());
  else {
    std::vector<double> buffer, solutions(exchange->n_columns(), 0.);
    const double *const of_columns = exchange->of_columns(weighted, buffer);
    for (const auto &of_domain : solves)
      of_domain->add_solutions(of_columns, solutions.data());
    exchange->add_up(solutions, sum);
  }
  for (unsigned int i = 0; i < weights.size(); ++i)
    z[i] = weights[i] * sum[i] + inverse[i] * r[i];
}

/// Whether functions of A_1 do not keep their degree along some long edges beside solves in cells.
template <int dim>
bool leaves_long_edges(const Domain<dim> &domain, const MPI_Comm communicator)
{
  bool here = false;
  for (const auto &cell : domain.mesh().active_cell_iterators())
    if (cell->is_locally_owned()) {
      const auto lengths = edge_lengths<dim>(cell);
      const double shortest = *std::min_element(lengths.begin(), lengths.end());
      for (const double length : lengths)
        here = here ||
               (length > smallest_stretch * shortest && length <= smallest_stretch_beside_solves * shortest);
    }
  return dealii::Utilities::MPI::max(here ? 1 : 0, communicator) > 0;
}

} // namespace

/// An unknown that n cells have gets weights whose squares are 1/n, times the share of the solves in the
/// diagonal: what followers add to it would make eigenvalues large.
template <int dim>
std::unique_ptr<Approximation>
CellwiseTangent<dim>::cellwise_approximation(const Epetra_Vector &all_diagonal,
                                             const bool in_single_precision) const
{
  Epetra_Vector ones(*columns), of_cells(*columns), n_cells(*own_rows), own(*own_rows), further(all_diagonal),
      of_solves(*own_rows), held(*own_rows), all_held(*columns), all_further(*columns), taken(*columns);
  std::vector<const CellOperator<dim> *> stretched;
  for (const auto &[d, cells] : operators)
    if (leaves_long_edges(*model.domains[d], model.communicator)) {
      stretched.push_back(cells.get());
      cells->add_ones(ones.Values());
      cells->add_diagonal(of_cells.Values());
    }
  if (stretched.empty())
    return nullptr;
  n_cells.Export(ones, *import, Add);
  own.Export(of_cells, *import, Add);
  further.Update(-1., own, 1.);
  for (unsigned int i = 0; i < is_condensed.size(); ++i)
    held[i] = is_condensed[i] || n_cells[i] == 0 || !(own[i] > 0 && all_diagonal[i] > 0) ? 1 : 0;
  all_held.Import(held, *import, Insert);
  all_further.Import(further, *import, Insert);
  std::vector<bool> is_held;
  for (int i = 0; i < all_held.MyLength(); ++i)
    is_held.push_back(all_held[i] != 0);
  std::vector<std::unique_ptr<CellSolves>> solves;
  for (const CellOperator<dim> *const cells : stretched)
    solves.push_back(cells->solves(is_held, all_further.Values(), taken.Values(), in_single_precision));
  of_solves.Export(taken, *import, Add);
  of_solves.Update(1., own, 1.);
  std::vector<double> weights, inverse;
  for (unsigned int i = 0; i < is_condensed.size(); ++i) {
    const double share = std::min(1., of_solves[i] / all_diagonal[i]);
    weights.push_back(held[i] == 0 ? std::sqrt(share / n_cells[i]) : 0.);
    inverse.push_back(held[i] != 0 && all_diagonal[i] > 0 ? 1 / all_diagonal[i] : 0.);
  }
  return std::make_unique<CellwiseApproximation>(own_rows, exchange, std::move(solves), std::move(weights),
                                                 std::move(inverse));
}

namespace {

/// The rows of C P at all unknowns of the cells of this rank, some of which are of others. Their columns are
/// those of P, and after them those that only rows of other ranks have.
class CompleteRows
{
public:
  /// @param unknowns the own ones first
  /// @param constrained the unknowns of the rows of @p follow. Collective.
  CompleteRows(const Prolongation &P, const Epetra_Map &unknowns, const Epetra_CrsMatrix &follow,
               const std::vector<int> &constrained);

  /// Until the next call.
  Prolongation::Row operator[](const int unknown)
  {
    if (unknown < P.rows().NumMyElements() && !is_constrained[unknown])
      return rows_of_P[unknown];
    const auto &[columns, weights] = further.at(unknown);
    return {static_cast<int>(columns.size()), columns.data(), weights.data()};
  }
  const std::vector<int> &global_columns() const { return globals; }

private:
  std::vector<RowOfOtherRank> of_other_ranks(const std::vector<int> &wanted);
  void find_following_rows(const Epetra_CrsMatrix &follow, const std::vector<int> &constrained);

  const Prolongation &P;
  Prolongation::Rows rows_of_P;
  std::vector<bool> is_constrained;
  std::vector<int> globals;            ///< of the columns
  std::unordered_map<int, int> others; ///< numbers of those that P does not have, by global number
  std::unordered_map<int, RowOfOtherRank> further; ///< by unknown, also those that follow others
};

CompleteRows::CompleteRows(const Prolongation &P, const Epetra_Map &unknowns, const Epetra_CrsMatrix &follow,
                           const std::vector<int> &constrained)
    : P(P), rows_of_P(P), is_constrained(P.rows().NumMyElements(), false)
{
  for (unsigned int column = 0; column < P.columns().n_columns(); ++column)
    globals.push_back(P.columns().global(column));
  find_following_rows(follow, constrained);
  if (unknowns.Comm().NumProc() == 1)
    return;
  const int n_own = P.rows().NumMyElements();
  std::vector<int> wanted(unknowns.MyGlobalElements() + n_own,
                          unknowns.MyGlobalElements() + unknowns.NumMyElements());
  auto received = of_other_ranks(wanted);
  for (unsigned int i = 0; i < received.size(); ++i)
    further[n_own + i] = std::move(received[i]);
}

/// Rows of C P, or of P before those of C P are known, with numbers of columns of this rank.
std::vector<RowOfOtherRank> CompleteRows::of_other_ranks(const std::vector<int> &wanted)
{
  auto result = rows_of_other_ranks(P.rows(), wanted, [this](const int own, auto &columns, auto &weights) {
    const Prolongation::Row row = (*this)[own];
    weights.assign(row.weights, row.weights + row.n);
    columns.clear();
    for (int k = 0; k < row.n; ++k)
      columns.push_back(globals[row.columns[k]]);
  });
  for (RowOfOtherRank &row : result)
    for (int &column : row.columns) {
      const int global = column;
      column = P.columns().number(global);
      if (column >= 0)
        continue;
      column = others.emplace(global, globals.size()).first->second;
      if (column == static_cast<int>(globals.size()))
        globals.push_back(global);
    }
  return result;
}

void CompleteRows::find_following_rows(const Epetra_CrsMatrix &follow, const std::vector<int> &constrained)
{
  std::unordered_map<int, RowOfOtherRank> followed; // of other ranks
  if (follow.Comm().NumProc() > 1) {
    std::vector<int> wanted;
    for (int column = 0; column < follow.NumMyCols(); ++column)
      if (!P.rows().MyGID(follow.GCID(column)))
        wanted.push_back(follow.GCID(column));
    auto received = of_other_ranks(wanted);
    for (unsigned int i = 0; i < wanted.size(); ++i)
      followed[wanted[i]] = std::move(received[i]);
  }
  std::map<int, double> sum;
  for (unsigned int k = 0; k < constrained.size(); ++k) {
    int n = 0, *local = nullptr;
    double *values = nullptr;
    follow.ExtractMyRowView(k, n, values, local);
    sum.clear();
    for (int i = 0; i < n; ++i) {
      const int global = follow.GCID(local[i]), own = P.rows().LID(global);
      const auto add = [&](const int length, const int *columns, const double *weights) {
        for (int j = 0; j < length; ++j)
          sum[columns[j]] += values[i] * weights[j];
      };
      if (own >= 0) {
        const Prolongation::Row row = rows_of_P[own];
        add(row.n, row.columns, row.weights);
      } else {
        const RowOfOtherRank &row = followed.at(global);
        add(row.columns.size(), row.columns.data(), row.values.data());
      }
    }
    is_constrained[constrained[k]] = true;
    auto &[columns, weights] = further[constrained[k]];
    for (const auto &[column, weight] : sum) {
      columns.push_back(column);
      weights.push_back(weight);
    }
  }
}

/// A row of entries beside those of small matrices, by the numbers of a SumOfSmall.
struct FurtherRow
{
  int number;
  std::vector<int> columns;
  const double *entries;
};

/// Those of @p matrix, which are referred to.
std::vector<FurtherRow> rows_of(const Epetra_CrsMatrix &matrix, SumOfSmall &sum)
{
  std::vector<FurtherRow> rows;
  for (int i = 0; i < matrix.NumMyRows(); ++i) {
    int n = 0, *local = nullptr;
    double *entries = nullptr;
    matrix.ExtractMyRowView(i, n, entries, local);
    if (n == 0)
      continue;
    rows.push_back({sum.number(matrix.GRID(i)), {}, entries});
    for (int k = 0; k < n; ++k)
      rows.back().columns.push_back(sum.number(matrix.GCID(local[k])));
  }
  return rows;
}

} // namespace

template <int dim>
std::unique_ptr<Epetra_CrsMatrix> CellwiseTangent<dim>::restricted(const Prolongation &P,
                                                                   const Epetra_CrsMatrix &summand) const
{
  CompleteRows all_rows(P, *columns, *follow, constrained);
  const auto row_of_P = [&](const int index) {
    const Prolongation::Row row = all_rows[index];
    return typename CellOperator<dim>::Row{row.n, row.columns, row.weights};
  };
  SumOfSmall sum(P.domain(), all_rows.global_columns());
  for (const auto &[d, cells] : operators)
    cells->for_each_cell(row_of_P, [&](const std::vector<int> &numbers) { sum.meet(numbers); });
  std::vector<FurtherRow> further = rows_of(summand, sum);
  std::vector<typename TieOperator<dim>::Restriction> of_ties;
  for (const auto &tie : ties) {
    of_ties.push_back(tie.restricted(row_of_P));
    for (unsigned int i = 0; i < of_ties.back().rows.size(); ++i)
      further.push_back(
          {of_ties.back().rows[i], std::move(of_ties.back().columns[i]), of_ties.back().values[i].data()});
  }
  for (const FurtherRow &row : further)
    sum.meet(row.number, row.columns);
  give_back_freed_memory();
  sum.allocate();
  for (const auto &[d, cells] : operators)
    cells->for_each_restriction(
        row_of_P, [&](const std::vector<int> &numbers, const auto &product) { sum.add(numbers, product); });
  for (const FurtherRow &row : further)
    sum.add(row.number, row.columns, row.entries);
  return sum.finish();
}

template <int dim>
unsigned int CellwiseTangent<dim>::row_length() const
{
  unsigned int largest = 0;
  for (const auto &[d, cells] : operators)
    largest = std::max(largest, model.domains[d]->dofs_per_cell() * (1u << dim));
  return largest;
}

template class CellwiseTangent<2>;
template class CellwiseTangent<3>;

} // namespace dovetail
