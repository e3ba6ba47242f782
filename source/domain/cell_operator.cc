// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_operator.h>

#include <dovetail/domain/edge_lengths.h>
#include <dovetail/domain/sum_factorisation.h>

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_tools.h>
#include <deal.II/fe/fe_values.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <type_traits>
#include <utility>

namespace dovetail {

namespace {

/// The cells of a domain that this rank owns, by batch and lane, and their geometry; shared by copies. With
/// grad phi = J grad phi of the unit cell, dV = |det J|^-1 times the weight of a point.
template <int dim>
class Cells
{
public:
  explicit Cells(const Domain<dim> &domain);

  using Cell = typename dealii::Triangulation<dim>::active_cell_iterator;
  /// Of a batch: J is diagonal and the same at all points, the same at all points, or any.
  enum Kind { cartesian, affine, general };
  static constexpr unsigned int volume = dim * dim, n_entries = volume + 1; ///< J by row, dV

  unsigned int n_batches() const { return n_slots() / Lanes::size; }
  unsigned int n_slots() const { return cells.size(); }
  bool is_filled(const unsigned int slot) const
  {
    return cells[slot].state() == dealii::IteratorState::valid;
  }
  const Cell &cell(const unsigned int slot) const { return cells[slot]; }
  unsigned int slot(const unsigned int active_cell_index) const { return slot_of_cell[active_cell_index]; }
  Kind kind(const unsigned int batch) const
  {
    return batch < first_batch[affine] ? cartesian : batch < first_batch[general] ? affine : general;
  }
  /// [entry], without the weights of the points; of a general batch [entry][point], with them.
  const Lanes *geometry(const unsigned int batch) const
  {
    const std::size_t first = first_batch[general];
    return &entries[batch < first ? batch * n_entries
                                  : (first + (batch - first) * weights.size()) * n_entries];
  }
  /// Whether the cells in two lanes of batches that are not general have the same J.
  bool are_equal(unsigned int slot, unsigned int other) const;

  std::vector<double> weights; ///< by point

private:
  void add(Kind kind, const std::vector<std::pair<Cell, std::vector<double>>> &of_kind);

  std::vector<Cell> cells; ///< by slot
  std::vector<unsigned int> slot_of_cell;
  std::array<unsigned int, 3> first_batch{};
  std::vector<Lanes> entries;
};

template <int dim>
Cells<dim>::Cells(const Domain<dim> &domain)
    : weights(domain.cell_quadrature().get_weights()), slot_of_cell(domain.mesh().n_active_cells())
{
  const double small = 1e-12; // rounding
  const unsigned int n_points = weights.size();
  const dealii::FE_Q<dim> element(1);
  dealii::FEValues<dim> values(domain.mapping(), element, domain.cell_quadrature(),
                               dealii::update_inverse_jacobians | dealii::update_JxW_values);
  std::array<std::vector<std::pair<Cell, std::vector<double>>>, 3> by_kind;
  for (const Cell &cell : domain.mesh().active_cell_iterators()) {
    if (!cell->is_locally_owned())
      continue;
    values.reinit(cell);
    std::vector<double> all(n_entries * n_points);
    for (unsigned int q = 0; q < n_points; ++q) {
      for (unsigned int j = 0; j < dim; ++j)
        for (unsigned int l = 0; l < dim; ++l)
          all[(j * dim + l) * n_points + q] = values.inverse_jacobian(q)[l][j];
      all[volume * n_points + q] = values.JxW(q) / weights[q];
    }
    double size = 0, variation = 0, off_diagonal = 0;
    for (unsigned int e = 0; e < volume; ++e)
      for (unsigned int q = 0; q < n_points; ++q) {
        const double entry = all[e * n_points + q], first = all[e * n_points];
        size = std::max(size, std::abs(entry));
        variation = std::max(variation, std::abs(entry - first));
        off_diagonal = std::max(off_diagonal, e / dim != e % dim ? std::abs(entry) : 0.);
      }
    const Kind kind = variation > small * size ? general : off_diagonal > small * size ? affine : cartesian;
    for (unsigned int e = 0; kind != general && e < n_entries; ++e)
      all[e] = kind == cartesian && e < volume && e / dim != e % dim ? 0 : all[e * n_points];
    for (unsigned int q = 0; kind == general && q < n_points; ++q)
      all[volume * n_points + q] *= weights[q];
    all.resize(kind == general ? all.size() : n_entries);
    all.shrink_to_fit();
    by_kind[kind].emplace_back(cell, std::move(all));
  }
  for (const Kind kind : {cartesian, affine, general}) {
    first_batch[kind] = n_batches();
    add(kind, by_kind[kind]);
  }
}

/// What fills up the last batch has no extent.
template <int dim>
void Cells<dim>::add(const Kind kind, const std::vector<std::pair<Cell, std::vector<double>>> &of_kind)
{
  const std::size_t n = n_entries * (kind == general ? weights.size() : 1);
  for (unsigned int k = 0; k < of_kind.size(); ++k) {
    if (k % Lanes::size == 0)
      entries.resize(entries.size() + n);
    for (std::size_t i = 0; i < n; ++i)
      entries[entries.size() - n + i][k % Lanes::size] = of_kind[k].second[i];
    slot_of_cell[of_kind[k].first->active_cell_index()] = cells.size();
    cells.push_back(of_kind[k].first);
  }
  cells.resize((cells.size() + Lanes::size - 1) / Lanes::size * Lanes::size);
}

template <int dim>
bool Cells<dim>::are_equal(const unsigned int slot, const unsigned int other) const
{
  const double small = 1e-12;
  const Lanes *a = geometry(slot / Lanes::size), *b = geometry(other / Lanes::size);
  double size = 0, difference = 0;
  for (unsigned int e = 0; e < n_entries; ++e) {
    const double mine = a[e][slot % Lanes::size], its = b[e][other % Lanes::size];
    if (e == volume)
      return difference <= small * size && std::abs(mine - its) <= small * std::abs(mine);
    size = std::max(size, std::abs(mine));
    difference = std::max(difference, std::abs(mine - its));
  }
  return false;
}

/// The part of P in one cell, by column.
struct LocalProlongation
{
  struct Entry
  {
    unsigned int column, row;
    double weight;
  };
  std::vector<int> columns; ///< of P, as the rows come upon them, so that most cells have the same entries
  std::vector<Entry> entries;
  std::vector<unsigned int> first_entry; ///< of each column, and one behind the last

  /// @p row_of_P(i) for the @p n unknowns of the cell
  template <typename RowOfP>
  void reinit(unsigned int n, const RowOfP &row_of_P);
  bool has_entries_of(const LocalProlongation &other) const;
};

template <typename RowOfP>
void LocalProlongation::reinit(const unsigned int n, const RowOfP &row_of_P)
{
  columns.clear();
  entries.clear();
  for (unsigned int i = 0; i < n; ++i) {
    const auto row = row_of_P(i);
    for (int k = 0; k < row.n; ++k) {
      const auto place = std::find(columns.begin(), columns.end(), row.columns[k]);
      entries.push_back({static_cast<unsigned int>(place - columns.begin()), i, row.weights[k]});
      if (place == columns.end())
        columns.push_back(row.columns[k]);
    }
  }
  first_entry.assign(columns.size() + 1, 0);
  for (const Entry &entry : entries)
    ++first_entry[entry.column + 1];
  std::partial_sum(first_entry.begin(), first_entry.end(), first_entry.begin());
  std::vector<unsigned int> next(first_entry);
  std::vector<Entry> by_column(entries.size());
  for (const Entry &entry : entries)
    by_column[next[entry.column]++] = entry;
  entries = std::move(by_column);
}

bool LocalProlongation::has_entries_of(const LocalProlongation &other) const
{
  const double rounding = 1e-14;
  return columns.size() == other.columns.size() &&
         std::equal(entries.begin(), entries.end(), other.entries.begin(), other.entries.end(),
                    [rounding](const Entry &a, const Entry &b) {
                      return a.column == b.column && a.row == b.row &&
                             std::abs(a.weight - b.weight) <= rounding;
                    });
}

template <int dim, int n_components>
class CellOperatorOf : public CellOperator<dim>
{
public:
  CellOperatorOf(const Domain<dim> &domain, const Field &field);

  std::unique_ptr<CellOperator<dim>> copy() const override { return std::make_unique<CellOperatorOf>(*this); }
  void for_each_unknown(const std::function<void(dealii::types::global_dof_index)> &visit) const override;
  void number(const std::function<int(dealii::types::global_dof_index)> &index) override;
  void begin_tangent() override { has_any = false; }
  void set_tangent(unsigned int active_cell_index, unsigned int q, double factor,
                   const Response<dim> &response) override;
  void finish_tangent() override;
  void add_tangent(double factor, const CellOperator<dim> &other) override;
  void add_product(const double *x, double *y, const bool of_symmetric_part) const override
  {
    Work<double> work(*this);
    add_product(work, of_symmetric_part, x, y);
  }
  void add_rough_product(const double *x, double *y) const override
  {
    Work<float> work(*this);
    add_product(work, true, x, y);
  }
  void add_diagonal(double *diagonal) const override;
  void add_ones(double *numbers) const override;
  void add_sums_over_cells(const double *x, double *sums) const override;
  std::unique_ptr<CellSolves> solves(const std::vector<bool> &is_held, const double *further, double *taken,
                                     bool in_single_precision) const override;
  void for_each_cell(const typename CellOperator<dim>::Prolongation &P,
                     const std::function<void(const std::vector<int> &columns)> &visit) const override;
  void for_each_restriction(const typename CellOperator<dim>::Prolongation &P,
                            const typename CellOperator<dim>::VisitCell &visit) const override;

private:
  static constexpr unsigned int n_slopes = n_components * dim; ///< of the gradient
  using Array = std::vector<Lanes>;

  /// The product leaves out what gradients of constants are: zero, but those of their roundings are not, and
  /// stiff bodies make them large.
  template <typename Number>
  static constexpr bool is_rough = std::is_same<Number, float>::value;

  /// What products need beside the operator.
  template <typename Number>
  struct Work
  {
    explicit Work(const CellOperatorOf &K)
        : line(K.domain.degree), coefficients(n_components * K.n_nodes),
          state((n_slopes + n_components) * K.n_points)
    {
    }
    /// The same numbers without lanes.
    CellNumbers<Number> numbers(const std::size_t n_points)
    {
      return {dim, n_components, coefficients.data()->values.data(), state[n_slopes * n_points].values.data(),
              state.data()->values.data()};
    }

    const LineTable<Number> line;
    std::vector<LanesOf<Number>> coefficients;             ///< [component][lexicographic node]
    std::vector<LanesOf<Number>> state;                    ///< [slope, then value][point]
    std::array<LanesOf<Number>, n_components> constants{}; ///< that the coefficients lack
    Array T;                                               ///< of a batch of affine cells: [entry]
    unsigned int batch_of_T = dealii::numbers::invalid_unsigned_int;
  };

  // Derivatives at a point of the flux, then of the source if there is one, by the gradient, then by the
  // value. Of A there is the upper triangle if it is symmetric.
  unsigned int at(const unsigned int row, const unsigned int column) const
  {
    return entry_numbers[row * n_state + column];
  }
  void number_entries();
  bool is_symmetric_at(const Response<dim> &response) const;
  void leave_symmetry();
  static bool is_slope(const unsigned int row) { return row < n_slopes; }
  /// Whether two batches that are not general have the same J and dV.
  static bool has_geometry(const Lanes *const J, const Lanes *const other)
  {
    return std::equal(J, J + Cells<dim>::n_entries, other,
                      [](const Lanes &a, const Lanes &b) { return a.values == b.values; });
  }
  Lanes &derivative(const unsigned int batch, const unsigned int entry, const unsigned int q)
  {
    return tangents[(std::size_t(batch) * n_entries + entry) * n_points + q];
  }
  /// Of the i-th unknown of a cell, in the index.
  std::size_t place(const unsigned int slot, const unsigned int i) const
  {
    return (std::size_t(slot / Lanes::size) * n_components * n_nodes + i) * Lanes::size + slot % Lanes::size;
  }
  template <typename Visit>
  void for_each_dof(const Visit &visit) const;
  void make_terms();
  template <typename Number>
  void multiply(Work<Number> &work, unsigned int batch, bool of_symmetric_part) const;
  template <typename Number>
  void add_product(Work<Number> &work, bool of_symmetric_part, const double *x, double *y) const;
  void refer_to_unit_cell(const Lanes *J, std::size_t stride, const Lanes *T, std::size_t stride_of_T,
                          Array &result) const;
  void refer_to_unit_cells();
  const Lanes *in_unit_cells(unsigned int batch, Array &T) const;
  std::vector<Lanes> mean_coefficients(unsigned int batch) const;
  void for_each_node_of(
      unsigned int face,
      const std::function<void(unsigned int node, std::array<unsigned int, dim> of_line)> &visit) const;
  double take_support(const CellSolves &solves, double a, unsigned int face, const int *of_component,
                      const double *further, double *taken) const;
  void expand();
  void find_columns(const typename CellOperator<dim>::Prolongation &P, unsigned int slot,
                    LocalProlongation &local) const;
  void restrict_batch(Work<double> &work, unsigned int batch,
                      const std::array<LocalProlongation, Lanes::size> &P,
                      std::array<dealii::FullMatrix<double>, Lanes::size> &products) const;

  const Domain<dim> &domain;
  const Field field;
  bool is_symmetric, has_values, has_sources; ///< A is; there is V, W or M; W or M
  bool may_lose_symmetry = false;             ///< with k(T), A is symmetric although the tangent is not
  unsigned int n_of_A, n_state, n_rows, n_entries, n_nodes, n_points; ///< n_rows: n_state, or no sources
  std::vector<unsigned int> entry_numbers;
  std::shared_ptr<const Cells<dim>> cells;
  std::vector<unsigned int> hierarchic; ///< number in the domain's element of a lexicographic node
  /// [batch][component][lexicographic node][lane], where a lane without a cell repeats the first one; shared
  /// by copies
  std::shared_ptr<std::vector<int>> index;
  bool has_any = false, is_uniform = true;
  std::vector<double> entries; ///< scratch
  /// Of one point in space, if all have the same: [entry]; else [batch][entry][point] and, once finished, in
  /// unit cells: dV J^T A J, dV J^T V, dV J^T W, dV M.
  Array tangents;
  struct Products ///< of what is not zero
  {
    PointSums in_space, in_unit_cells;
  };
  std::array<Products, 2> products; ///< with K, with its symmetric part
};

template <int dim, int n_components>
CellOperatorOf<dim, n_components>::CellOperatorOf(const Domain<dim> &domain, const Field &field)
    : domain(domain), field(field), is_symmetric(true), has_values(false), has_sources(false),
      n_nodes(domain.layout().n_nodes(field.first_component)), n_points(domain.cell_quadrature().size()),
      cells(std::make_shared<Cells<dim>>(domain)),
      hierarchic(dealii::FETools::lexicographic_to_hierarchic_numbering<dim>(domain.degree)),
      index(std::make_shared<std::vector<int>>())
{
  for (unsigned int f = 0; f < domain.fields().size(); ++f)
    if (domain.fields()[f].name == field.name)
      may_lose_symmetry = !domain.material.is_symmetric(f);
  for (unsigned int c = 0; c < n_components; ++c)
    for (unsigned int d = 0; d < n_components; ++d) {
      const Coupling coupling =
          domain.material.coupling(field.first_component + c, field.first_component + d);
      has_values = has_values || coupling.flux_by_value || coupling.in_source();
      has_sources = has_sources || coupling.in_source();
    }
  has_sources = has_sources || domain.body_force().depends_on_displacement();
  has_values = has_values || has_sources;
  n_state = n_slopes + (has_values ? n_components : 0);
  n_rows = has_sources ? n_state : n_slopes;
  number_entries();
  tangents.resize(n_entries);
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::number_entries()
{
  n_of_A = is_symmetric ? n_slopes * (n_slopes + 1) / 2 : n_slopes * n_slopes;
  n_entries = n_of_A + (n_state - n_slopes) * n_slopes + (n_rows - n_slopes) * n_state;
  entries.resize(n_entries);
  entry_numbers.clear();
  const auto number = [this](const unsigned int row, const unsigned int column) {
    if (is_slope(row) && is_slope(column) && !is_symmetric)
      return row * n_slopes + column;
    if (is_slope(row) && is_slope(column)) {
      const unsigned int i = std::min(row, column), j = std::max(row, column);
      return i * n_slopes - i * (i + 1) / 2 + j;
    }
    if (is_slope(row))
      return n_of_A + row * n_components + (column - n_slopes);
    return n_of_A + n_slopes * n_components + (row - n_slopes) * n_state + column;
  };
  for (unsigned int row = 0; row < n_rows; ++row)
    for (unsigned int column = 0; column < n_state; ++column)
      entry_numbers.push_back(number(row, column));
}

/// Up to rounding.
template <int dim, int n_components>
bool CellOperatorOf<dim, n_components>::is_symmetric_at(const Response<dim> &response) const
{
  const double rounding = 1e-13;
  const unsigned int n = domain.n_components(), first = field.first_component;
  const auto entry = [&](const unsigned int row, const unsigned int column) {
    return response.by_gradient[(first + row / dim) * n + first + column / dim][row % dim][column % dim];
  };
  double largest = 0, difference = 0;
  for (unsigned int row = 0; row < n_slopes; ++row)
    for (unsigned int column = 0; column <= row; ++column) {
      largest = std::max(largest, std::abs(entry(row, column)));
      difference = std::max(difference, std::abs(entry(row, column) - entry(column, row)));
    }
  return difference <= rounding * largest;
}

/// From now on A has all its entries.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::leave_symmetry()
{
  const CellOperatorOf before(*this);
  const std::size_t n = is_uniform ? 1 : n_points;
  is_symmetric = false;
  number_entries();
  const std::size_t n_blocks = tangents.size() / (before.n_entries * n);
  tangents.resize(n_blocks * n_entries * n);
  for (std::size_t block = 0; block < n_blocks; ++block)
    for (unsigned int row = 0; row < n_rows; ++row)
      for (unsigned int column = 0; column < n_state; ++column)
        std::copy_n(&before.tangents[(block * before.n_entries + before.at(row, column)) * n], n,
                    &tangents[(block * n_entries + at(row, column)) * n]);
}

template <int dim, int n_components>
template <typename Visit>
void CellOperatorOf<dim, n_components>::for_each_dof(const Visit &visit) const
{
  std::vector<dealii::types::global_dof_index> dofs;
  for (unsigned int slot = 0; slot < cells->n_slots(); ++slot)
    if (cells->is_filled(slot)) {
      domain.cell_dofs(domain.dof_cell(cells->cell(slot)), dofs);
      for (unsigned int c = 0; c < n_components; ++c)
        for (unsigned int a = 0; a < n_nodes; ++a)
          visit(place(slot, c * n_nodes + a),
                dofs[domain.layout().index(field.first_component + c, hierarchic[a])]);
    }
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::for_each_unknown(
    const std::function<void(dealii::types::global_dof_index)> &visit) const
{
  for_each_dof([&](std::size_t, const auto dof) { visit(dof); });
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::number(
    const std::function<int(dealii::types::global_dof_index)> &index_of)
{
  index->assign(std::size_t(cells->n_slots()) * n_components * n_nodes, -1);
  for_each_dof([&](const std::size_t i, const auto dof) { (*index)[i] = index_of(dof); });
  for (std::size_t i = 0; i < index->size(); ++i)
    if ((*index)[i] < 0)
      (*index)[i] = (*index)[i - i % Lanes::size];
}

/// From now on each point has its own derivatives.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::expand()
{
  const Array uniform(tangents);
  const std::size_t n = std::size_t(cells->n_batches()) * n_entries;
  tangents.clear();
  tangents.reserve(n * n_points);
  for (std::size_t i = 0; i < n; ++i)
    tangents.insert(tangents.end(), n_points, uniform[i % n_entries]);
  is_uniform = false;
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::set_tangent(const unsigned int active_cell_index,
                                                    const unsigned int q, const double factor,
                                                    const Response<dim> &response)
{
  if (may_lose_symmetry && is_symmetric && !is_symmetric_at(response))
    leave_symmetry();
  const unsigned int n = domain.n_components(), first = field.first_component;
  for (unsigned int c = 0; c < n_components; ++c)
    for (unsigned int d = 0; d < n_components; ++d) {
      const unsigned int pair = (first + c) * n + first + d;
      for (unsigned int J = 0; J < dim; ++J)
        for (unsigned int L = 0; L < dim; ++L)
          entries[at(c * dim + J, d * dim + L)] = factor * response.by_gradient[pair][J][L];
      for (unsigned int J = 0; has_values && J < dim; ++J)
        entries[at(c * dim + J, n_slopes + d)] = factor * response.by_value[pair][J];
      for (unsigned int J = 0; has_sources && J < dim; ++J)
        entries[at(n_slopes + c, d * dim + J)] = factor * response.source_by_gradient[pair][J];
      if (has_sources)
        entries[at(n_slopes + c, n_slopes + d)] = factor * response.source_by_value[pair];
    }
  if (is_uniform && !has_any)
    for (unsigned int e = 0; e < n_entries; ++e)
      tangents[e] = Lanes(entries[e]);
  has_any = true;
  bool is_same = is_uniform;
  for (unsigned int e = 0; is_same && e < n_entries; ++e)
    is_same = entries[e] == tangents[e][0];
  if (is_same)
    return;
  if (is_uniform)
    expand();
  const unsigned int slot = cells->slot(active_cell_index);
  for (unsigned int e = 0; e < n_entries; ++e)
    derivative(slot / Lanes::size, e, q)[slot % Lanes::size] = entries[e];
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::finish_tangent()
{
  if (!is_uniform)
    refer_to_unit_cells();
  make_terms();
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::make_terms()
{
  for (const bool of_symmetric_part : {false, true}) {
    Products &all = products[of_symmetric_part];
    all = {};
    const bool is_mean = of_symmetric_part && (!is_symmetric || has_values);
    all.in_unit_cells.factor = all.in_space.factor = is_mean ? 0.5 : 1.;
    for (unsigned int row = 0; row < n_state; ++row) {
      for (unsigned int column = 0; column < n_state; ++column) {
        const auto add = [&](const unsigned int i, const unsigned int j) {
          if (i >= n_rows)
            return;
          all.in_unit_cells.terms.push_back({column, at(i, j)});
          if (!is_uniform || tangents[at(i, j)][0] != 0)
            all.in_space.terms.push_back({column, at(i, j)});
        };
        add(row, column);
        if (is_mean)
          add(column, row);
      }
      all.in_unit_cells.add_row();
      all.in_space.add_row();
    }
  }
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::add_tangent(const double factor, const CellOperator<dim> &other)
{
  const auto &summand = dynamic_cast<const CellOperatorOf &>(other);
  if (is_symmetric && !summand.is_symmetric)
    leave_symmetry();
  if (!is_symmetric && summand.is_symmetric) {
    CellOperatorOf all(summand);
    all.leave_symmetry();
    add_tangent(factor, all);
    return;
  }
  if (is_uniform && !summand.is_uniform) {
    expand();
    refer_to_unit_cells();
  }
  if (!is_uniform && summand.is_uniform) {
    CellOperatorOf expanded(summand);
    expanded.expand();
    expanded.refer_to_unit_cells();
    add_tangent(factor, expanded);
    return;
  }
  for (std::size_t i = 0; i < tangents.size(); ++i)
    tangents[i] += summand.tangents[i] * factor;
  make_terms();
}

/// The derivatives at a point, by the gradient in the unit cell and times dV: dV J^T A J, dV J^T V, dV J^T W,
/// dV M. @p stride of the entries of J, and of T.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::refer_to_unit_cell(const Lanes *const J, const std::size_t stride,
                                                           const Lanes *const T,
                                                           const std::size_t stride_of_T, Array &result) const
{
  const Lanes &dV = J[Cells<dim>::volume * stride];
  std::array<Lanes, (n_slopes + n_components) * (n_slopes + n_components)> half; // T J
  for (unsigned int row = 0; row < n_rows; ++row)
    for (unsigned int column = 0; column < n_state; ++column) {
      Lanes &sum = half[row * n_state + column];
      if (!is_slope(column)) {
        sum = T[at(row, column) * stride_of_T];
        continue;
      }
      const unsigned int first = column - column % dim;
      for (unsigned int j = 0; j < dim; ++j)
        sum += T[at(row, first + j) * stride_of_T] * J[(j * dim + column % dim) * stride];
    }
  result.resize(n_entries);
  for (unsigned int row = 0; row < n_rows; ++row)
    for (unsigned int column = is_symmetric && is_slope(row) ? row : 0; column < n_state; ++column) {
      Lanes sum;
      if (is_slope(row))
        for (unsigned int j = 0; j < dim; ++j)
          sum += half[(row - row % dim + j) * n_state + column] * J[(j * dim + row % dim) * stride];
      else
        sum = half[row * n_state + column];
      result[at(row, column)] = sum * dV;
    }
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::refer_to_unit_cells()
{
  Array at_point;
  for (unsigned int batch = 0; batch < cells->n_batches(); ++batch) {
    const bool is_general = cells->kind(batch) == Cells<dim>::general;
    for (unsigned int q = 0; q < n_points; ++q) {
      refer_to_unit_cell(cells->geometry(batch) + (is_general ? q : 0), is_general ? n_points : 1,
                         &derivative(batch, 0, q), n_points, at_point);
      for (unsigned int e = 0; e < n_entries; ++e)
        derivative(batch, e, q) = is_general ? at_point[e] : at_point[e] * cells->weights[q];
    }
  }
}

/// From coefficients to the products with the functions, there as well.
template <int dim, int n_components>
template <typename Number>
void CellOperatorOf<dim, n_components>::multiply(Work<Number> &work, const unsigned int batch,
                                                 const bool of_symmetric_part) const
{
  const Lanes *const geometry = cells->geometry(batch);
  const Products &sums = products[of_symmetric_part];
  const typename Cells<dim>::Kind kind = cells->kind(batch);
  const bool is_affine = is_uniform && kind != Cells<dim>::general;
  if (is_affine && (work.batch_of_T == dealii::numbers::invalid_unsigned_int ||
                    !has_geometry(geometry, cells->geometry(work.batch_of_T)))) {
    refer_to_unit_cell(geometry, 1, tangents.data(), 1, work.T);
    work.batch_of_T = batch;
  }
  const CellNumbers<Number> numbers = work.numbers(n_points);
  evaluate_in_cells(work.line, numbers);
  for (unsigned int c = 0; has_values && is_rough<Number> && c < n_components; ++c)
    for (unsigned int q = 0; q < n_points; ++q)
      work.state[(n_slopes + c) * n_points + q] += work.constants[c];
  if (!is_uniform)
    multiply_at_points({sums.in_unit_cells, n_points, &tangents[std::size_t(batch) * n_entries * n_points],
                        false, nullptr, nullptr},
                       dim, n_slopes, numbers.gradients);
  else if (is_affine)
    multiply_at_points({kind == Cells<dim>::cartesian ? sums.in_space : sums.in_unit_cells, n_points,
                        work.T.data(), true, cells->weights.data(), nullptr},
                       dim, n_slopes, numbers.gradients);
  else
    multiply_at_points({sums.in_space, n_points, tangents.data(), true, nullptr, geometry}, dim, n_slopes,
                       numbers.gradients);
  integrate_in_cells(work.line, has_sources || (has_values && of_symmetric_part), numbers);
}

template <int dim, int n_components>
template <typename Number>
void CellOperatorOf<dim, n_components>::add_product(Work<Number> &work, const bool of_symmetric_part,
                                                    const double *const x, double *const y) const
{
  for (unsigned int batch = 0; batch < cells->n_batches(); ++batch) {
    const int *const of_batch = index->data() + place(batch * Lanes::size, 0), *next = of_batch;
    std::array<double, Lanes::size> constants{};
    for (unsigned int i = 0; i < work.coefficients.size(); ++i) {
      for (unsigned int lane = 0; is_rough<Number> && i % n_nodes == 0 && lane < Lanes::size; ++lane)
        work.constants[i / n_nodes][lane] = static_cast<Number>(constants[lane] = x[next[lane]]);
      for (unsigned int lane = 0; lane < Lanes::size; ++lane)
        work.coefficients[i][lane] = static_cast<Number>(x[*next++] - constants[lane]);
    }
    multiply(work, batch, of_symmetric_part);
    next = of_batch;
    for (const LanesOf<Number> &number : work.coefficients)
      for (unsigned int lane = 0; lane < Lanes::size; ++lane)
        y[*next++] += static_cast<double>(number[lane]);
  }
}

/// The entries of a batch at its points, in unit cells: [entry][point].
template <int dim, int n_components>
const Lanes *CellOperatorOf<dim, n_components>::in_unit_cells(const unsigned int batch, Array &T) const
{
  if (!is_uniform)
    return &tangents[std::size_t(batch) * n_entries * n_points];
  const bool is_affine = cells->kind(batch) != Cells<dim>::general;
  Array at_point;
  T.resize(n_entries * n_points);
  for (unsigned int q = 0; q < n_points; ++q) {
    if (q == 0 || !is_affine)
      refer_to_unit_cell(cells->geometry(batch) + q, is_affine ? 1 : n_points, tangents.data(), 1, at_point);
    for (unsigned int e = 0; e < n_entries; ++e)
      T[e * n_points + q] = is_affine ? at_point[e] * cells->weights[q] : at_point[e];
  }
  return T.data();
}

/// Sums over the points of products of two polynomials of a node and its slopes, direction by direction.
template <int dim>
class SquaresOfNodes
{
public:
  explicit SquaresOfNodes(unsigned int degree);

  /// += sums of number[point] times the slopes along @p first and @p second of each node, values for dim
  void add(const std::vector<Lanes> &numbers, unsigned int first, unsigned int second,
           std::vector<Lanes> &sums);

private:
  const unsigned int n;
  std::array<std::vector<double>, 3> products; ///< by number of slopes: [node][point]
  std::vector<Lanes> from, to;
};

template <int dim>
SquaresOfNodes<dim>::SquaresOfNodes(const unsigned int degree) : n(degree + 1)
{
  const dealii::QGauss<1> points(n);
  const dealii::FE_Q<1> element(degree);
  const auto node = dealii::FETools::lexicographic_to_hierarchic_numbering<1>(degree);
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int q = 0; q < n; ++q) {
      const double value = element.shape_value(node[i], points.point(q)),
                   slope = element.shape_grad(node[i], points.point(q))[0];
      products[0].push_back(value * value);
      products[1].push_back(value * slope);
      products[2].push_back(slope * slope);
    }
}

template <int dim>
void SquaresOfNodes<dim>::add(const std::vector<Lanes> &numbers, const unsigned int first,
                              const unsigned int second, std::vector<Lanes> &sums)
{
  from = numbers;
  unsigned int stride = 1;
  for (unsigned int k = 0; k < dim; ++k, stride *= n) {
    const std::vector<double> &table = products[(k == first ? 1 : 0) + (k == second ? 1 : 0)];
    to.assign(from.size(), Lanes());
    for (unsigned int j = 0; j < from.size(); ++j) {
      const unsigned int i = j / stride % n, begin = j - i * stride;
      for (unsigned int q = 0; q < n; ++q)
        to[j] += from[begin + q * stride] * table[i * n + q];
    }
    std::swap(from, to);
  }
  for (unsigned int i = 0; i < sums.size(); ++i)
    sums[i] += from[i];
}

/// grad phi . A grad phi + grad phi . (V + W) phi + M phi^2 of the same component.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::add_diagonal(double *diagonal) const
{
  SquaresOfNodes<dim> squares(domain.degree);
  Array T, numbers(n_points);
  std::array<Array, n_components> sums;
  const Lanes *J_of_sums = nullptr; // if other batches may have the same sums
  for (unsigned int batch = 0; batch < cells->n_batches(); ++batch) {
    const bool is_affine = is_uniform && cells->kind(batch) != Cells<dim>::general;
    const Lanes *const J = cells->geometry(batch);
    const bool is_known = is_affine && J_of_sums != nullptr && has_geometry(J, J_of_sums);
    J_of_sums = is_affine ? J : nullptr;
    const Lanes *const of_points = is_known ? nullptr : in_unit_cells(batch, T);
    for (unsigned int c = 0; c < n_components && !is_known; ++c) {
      sums[c].assign(n_nodes, Lanes());
      const auto state = [c](const unsigned int j) { return j < dim ? c * dim + j : n_slopes + c; };
      for (unsigned int j = 0; j <= dim; ++j)
        for (unsigned int l = j; l <= dim; ++l) {
          std::fill(numbers.begin(), numbers.end(), Lanes());
          bool is_there = false;
          for (const bool transposed : {false, true})
            if (const unsigned int row = state(transposed ? l : j), column = state(transposed ? j : l);
                row < n_rows && column < n_state && (j != l || !transposed)) {
              is_there = true;
              for (unsigned int q = 0; q < n_points; ++q)
                numbers[q] += of_points[at(row, column) * n_points + q];
            }
          if (is_there)
            squares.add(numbers, j, l, sums[c]);
        }
    }
    const int *of_batch = index->data() + place(batch * Lanes::size, 0);
    for (const Array &of_component : sums)
      for (const Lanes &sum : of_component)
        for (unsigned int lane = 0; lane < Lanes::size; ++lane)
          diagonal[*of_batch++] += sum[lane];
  }
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::add_ones(double *const numbers) const
{
  for (unsigned int slot = 0; slot < cells->n_slots(); ++slot)
    for (unsigned int i = 0; cells->is_filled(slot) && i < n_components * n_nodes; ++i)
      ++numbers[(*index)[place(slot, i)]];
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::add_sums_over_cells(const double *const x, double *const sums) const
{
  for (unsigned int slot = 0; slot < cells->n_slots(); ++slot)
    if (cells->is_filled(slot)) {
      double sum = 0;
      for (unsigned int i = 0; i < n_components * n_nodes; ++i)
        sum += x[(*index)[place(slot, i)]];
      for (unsigned int i = 0; i < n_components * n_nodes; ++i)
        sums[(*index)[place(slot, i)]] += sum;
    }
}

/// The cells beyond the ends of the lines of a cell.
template <int dim>
std::vector<CellSolves::Line> lines_of(const typename dealii::Triangulation<dim>::cell_iterator &cell)
{
  const auto lengths = edge_lengths<dim>(cell);
  std::vector<CellSolves::Line> lines(dim);
  for (unsigned int face = 0; face < 2 * dim; ++face)
    if (!cell->at_boundary(face)) {
      const unsigned int its_direction = cell->neighbor_face_no(face) / 2;
      lines[face / 2][face % 2].ratio =
          edge_lengths<dim>(cell->neighbor(face))[its_direction] / lengths[face / 2];
    }
  return lines;
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::for_each_node_of(
    const unsigned int face,
    const std::function<void(unsigned int node, std::array<unsigned int, dim> of_line)> &visit) const
{
  const unsigned int n = domain.degree + 1;
  for (unsigned int node = 0; node < n_nodes; ++node) {
    const std::array<unsigned int, 3> all = {{node % n, node / n % n, node / n / n}};
    std::array<unsigned int, dim> of_line;
    std::copy_n(all.begin(), dim, of_line.begin());
    if (of_line[face / 2] == face % 2 * domain.degree)
      visit(node, of_line);
  }
}

/// The stiffness of the end of a line that has a mass matrix of the face without neighbour stand for what
/// others add to it, from the nodes that no other cell has.
template <int dim, int n_components>
double CellOperatorOf<dim, n_components>::take_support(const CellSolves &solves, const double a,
                                                       const unsigned int face,
                                                       const int *const index_of_component,
                                                       const double *const further, double *const taken) const
{
  double sum = 0, sum_of_masses = 0;
  const auto visit_masses = [&](const auto &visit) {
    for_each_node_of(face, [&](const unsigned int node, const auto &of_line) {
      double product = 1;
      bool is_inside = true;
      for (unsigned int k = 0; k < dim; ++k)
        if (k != face / 2) {
          product *= solves.mass_of(of_line[k]);
          is_inside = is_inside && of_line[k] > 0 && of_line[k] < domain.degree;
        }
      visit(index_of_component[node * Lanes::size], product, is_inside);
    });
  };
  visit_masses([&](const int i, const double product, const bool is_inside) {
    sum += is_inside ? further[i] : 0.;
    sum_of_masses += is_inside ? product : 0.;
  });
  const double unit = a * solves.stiffness_of_end(),
               stiffness = std::clamp(sum / sum_of_masses / unit, 0., CellSolves::stiffness_of_held);
  visit_masses([&](const int i, const double product, bool) { taken[i] += stiffness * unit * product; });
  return stiffness;
}

/// [component]: by direction the integral of e . A e over the cells, where e is the gradient of a coordinate
/// of the unit cell, then that of M.
template <int dim, int n_components>
std::vector<Lanes> CellOperatorOf<dim, n_components>::mean_coefficients(const unsigned int batch) const
{
  Array sums(n_components * (dim + 1)), scratch;
  const Lanes *const T = in_unit_cells(batch, scratch);
  for (unsigned int c = 0; c < n_components; ++c)
    for (unsigned int q = 0; q < n_points; ++q) {
      for (unsigned int k = 0; k < dim; ++k)
        sums[c * (dim + 1) + k] += T[at(c * dim + k, c * dim + k) * n_points + q];
      if (has_sources)
        sums[c * (dim + 1) + dim] += T[at(n_slopes + c, n_slopes + c) * n_points + q];
    }
  return sums;
}

/// What a coefficient that is not positive becomes, and m where nothing holds a cell, is a matter of being
/// definite only.
template <int dim, int n_components>
std::unique_ptr<CellSolves>
CellOperatorOf<dim, n_components>::solves(const std::vector<bool> &is_held, const double *const further,
                                          double *const taken, const bool in_single_precision) const
{
  const double smallest = 1e-6;
  const unsigned int n = domain.degree + 1;
  const auto node_inside = [n](const unsigned int face) {
    unsigned int stride = 1, node = 0;
    for (unsigned int d = 0; d < dim; ++d, stride *= n)
      node += stride * (d == face / 2 ? face % 2 * (n - 1) : 1);
    return node;
  };
  auto result =
      in_single_precision
          ? std::unique_ptr<CellSolves>(new CellSolvesIn<float>(dim, n_components, domain.degree, index))
          : std::make_unique<CellSolvesIn<double>>(dim, n_components, domain.degree, index);
  std::vector<Lanes> sums;
  for (unsigned int slot = 0; slot < cells->n_slots(); ++slot) {
    if (slot % Lanes::size == 0)
      sums = mean_coefficients(slot / Lanes::size);
    if (!cells->is_filled(slot))
      continue;
    const auto coefficient = [&](const unsigned int i) { return sums[i][slot % Lanes::size]; };
    double largest = 0;
    for (unsigned int i = 0; i < sums.size(); ++i)
      largest = std::max(largest, coefficient(i));
    const std::vector<CellSolves::Line> lines = lines_of<dim>(cells->cell(slot));
    for (unsigned int c = 0; c < n_components; ++c) {
      const int *const of_component = index->data() + place(slot, c * n_nodes);
      std::vector<CellSolves::Line> supported = lines;
      std::vector<double> a;
      for (unsigned int k = 0; k < dim; ++k)
        a.push_back(std::max(coefficient(c * (dim + 1) + k), smallest * largest));
      bool is_free = true;
      for (unsigned int face = 0; face < 2 * dim; ++face) {
        CellSolves::End &end = supported[face / 2][face % 2];
        if (is_held[of_component[node_inside(face) * Lanes::size]])
          end = {0., CellSolves::stiffness_of_held};
        else if (end.ratio == 0)
          end.stiffness = take_support(*result, a[face / 2], face, of_component, further, taken);
        is_free = is_free && end.ratio == 0 && end.stiffness == 0;
      }
      const double least = is_free ? *std::min_element(a.begin(), a.end()) : 0;
      a.push_back(std::max(coefficient(c * (dim + 1) + dim), least));
      result->set(slot, c, supported, a);
    }
  }
  return result;
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::find_columns(const typename CellOperator<dim>::Prolongation &P,
                                                     const unsigned int slot, LocalProlongation &local) const
{
  local.reinit(n_components * n_nodes, [&](const unsigned int i) { return P((*index)[place(slot, i)]); });
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::for_each_cell(
    const typename CellOperator<dim>::Prolongation &P,
    const std::function<void(const std::vector<int> &columns)> &visit) const
{
  LocalProlongation local;
  for (unsigned int slot = 0; slot < cells->n_slots(); ++slot)
    if (cells->is_filled(slot)) {
      find_columns(P, slot, local);
      visit(local.columns);
    }
}

/// Cells of the same geometry, with the same derivatives everywhere and the same entries of P, are treated
/// once; a few are remembered.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::for_each_restriction(
    const typename CellOperator<dim>::Prolongation &P,
    const typename CellOperator<dim>::VisitCell &visit) const
{
  struct Known
  {
    unsigned int slot;
    LocalProlongation local;
    dealii::FullMatrix<double> product;
  };
  const unsigned int most_known = 8;
  std::vector<Known> all_known;
  Work<double> work(*this);
  std::array<LocalProlongation, Lanes::size> local_P;
  std::array<dealii::FullMatrix<double>, Lanes::size> products;
  for (unsigned int batch = 0; batch < cells->n_batches(); ++batch) {
    const unsigned int first = batch * Lanes::size;
    const bool can_be_known = is_uniform && cells->kind(batch) != Cells<dim>::general;
    std::array<const Known *, Lanes::size> known{};
    bool all_are_known = true;
    for (unsigned int lane = 0; lane < Lanes::size; ++lane)
      if (cells->is_filled(first + lane)) {
        find_columns(P, first + lane, local_P[lane]);
        for (const Known &other : all_known)
          if (can_be_known && known[lane] == nullptr && cells->are_equal(first + lane, other.slot) &&
              local_P[lane].has_entries_of(other.local))
            known[lane] = &other;
        all_are_known = all_are_known && known[lane] != nullptr;
      } else
        local_P[lane] = {};
    if (!all_are_known)
      restrict_batch(work, batch, local_P, products);
    for (unsigned int lane = 0; lane < Lanes::size; ++lane)
      if (cells->is_filled(first + lane))
        visit(local_P[lane].columns, known[lane] != nullptr ? known[lane]->product : products[lane]);
    for (unsigned int lane = 0; can_be_known && lane < Lanes::size && all_known.size() < most_known; ++lane)
      if (cells->is_filled(first + lane) && known[lane] == nullptr &&
          std::none_of(all_known.begin(), all_known.end(), [&](const Known &other) {
            return cells->are_equal(first + lane, other.slot) && local_P[lane].has_entries_of(other.local);
          }))
        all_known.push_back({first + lane, local_P[lane], products[lane]});
  }
}

/// P^T K P of each cell.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::restrict_batch(
    Work<double> &work, const unsigned int batch, const std::array<LocalProlongation, Lanes::size> &P,
    std::array<dealii::FullMatrix<double>, Lanes::size> &products) const
{
  unsigned int n_columns = 0;
  for (unsigned int lane = 0; lane < Lanes::size; ++lane) {
    n_columns = std::max<unsigned int>(n_columns, P[lane].columns.size());
    products[lane].reinit(P[lane].columns.size(), P[lane].columns.size());
  }
  for (unsigned int column = 0; column < n_columns; ++column) {
    std::fill(work.coefficients.begin(), work.coefficients.end(), Lanes());
    for (unsigned int lane = 0; lane < Lanes::size; ++lane)
      if (column < P[lane].columns.size())
        for (unsigned int e = P[lane].first_entry[column]; e < P[lane].first_entry[column + 1]; ++e)
          work.coefficients[P[lane].entries[e].row][lane] = P[lane].entries[e].weight;
    multiply(work, batch, true);
    for (unsigned int lane = 0; lane < Lanes::size; ++lane)
      if (column < P[lane].columns.size())
        for (const auto &entry : P[lane].entries) // of a symmetric matrix, where they lie side by side
          products[lane](column, entry.column) += entry.weight * work.coefficients[entry.row][lane];
  }
}

} // namespace

template <int dim>
std::string CellOperator<dim>::objection(const Domain<dim> &domain, const Field &field)
{
  if (domain.has_simplices())
    return "the domain " + domain.name + " has " + (dim == 2 ? "triangles" : "tetrahedra");
  if (!field.is_continuous || field.relative_degree != 0 ||
      (field.n_components != 1 && field.n_components != dim))
    return "the element of the field is not that of the domain " + domain.name;
  return "";
}

template <int dim>
std::unique_ptr<CellOperator<dim>> CellOperator<dim>::make(const Domain<dim> &domain, const Field &field)
{
  if (field.n_components == 1)
    return std::make_unique<CellOperatorOf<dim, 1>>(domain, field);
  return std::make_unique<CellOperatorOf<dim, dim>>(domain, field);
}

template class CellOperator<2>;
template class CellOperator<3>;

} // namespace dovetail
