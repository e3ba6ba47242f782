// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_operator.h>

#include <deal.II/base/aligned_vector.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_dgq.h>
#include <deal.II/fe/fe_tools.h>
#include <deal.II/matrix_free/fe_evaluation.h>
#include <deal.II/matrix_free/matrix_free.h>

#include <algorithm>
#include <array>

namespace dovetail {

namespace {

using Lanes = dealii::VectorizedArray<double>;

/// Which cell a batch of the loop has in a lane, and the geometry of all; shared by copies.
template <int dim>
struct Cells
{
  explicit Cells(const Domain<dim> &domain);

  unsigned int n_slots() const { return matrix_free.n_cell_batches() * Lanes::size(); }
  bool is_filled(const unsigned int slot) const
  {
    return slot % Lanes::size() < matrix_free.n_active_entries_per_cell_batch(slot / Lanes::size());
  }
  typename dealii::Triangulation<dim>::active_cell_iterator cell(const unsigned int slot) const
  {
    return matrix_free.get_cell_iterator(slot / Lanes::size(), slot % Lanes::size());
  }

  /// The functions of the domain's element by cell; nothing is shared between cells, and so the numbers of
  /// unknowns are contiguous. Those of the domain itself may belong to any number of fields and ranks.
  dealii::FE_DGQ<dim> element;
  dealii::DoFHandler<dim> nodes;
  dealii::MatrixFree<dim, double> matrix_free;
  std::vector<unsigned int> slot_of_cell; ///< by active cell index
};

template <int dim>
Cells<dim>::Cells(const Domain<dim> &domain) : element(domain.degree), nodes(domain.mesh())
{
  nodes.distribute_dofs(element);
  typename dealii::MatrixFree<dim, double>::AdditionalData data;
  data.tasks_parallel_scheme = dealii::MatrixFree<dim, double>::AdditionalData::none;
  data.mapping_update_flags = dealii::update_gradients | dealii::update_JxW_values;
  dealii::AffineConstraints<double> none;
  none.close();
  matrix_free.reinit(domain.mapping(), nodes, none, dealii::QGauss<1>(domain.degree + 1), data);
  slot_of_cell.assign(domain.mesh().n_active_cells(), dealii::numbers::invalid_unsigned_int);
  for (unsigned int slot = 0; slot < n_slots(); ++slot)
    if (is_filled(slot))
      slot_of_cell[cell(slot)->active_cell_index()] = slot;
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
  void add_product(const double *x, double *y, bool of_symmetric_part) const override;
  void add_diagonal(double *diagonal) const override;
  void for_each_cell(const typename CellOperator<dim>::Prolongation &P,
                     const std::function<void(const std::vector<int> &columns)> &visit) const override;
  void for_each_restriction(const typename CellOperator<dim>::Prolongation &P,
                            const typename CellOperator<dim>::VisitCell &visit) const override;

private:
  static constexpr unsigned int n_slopes = n_components * dim; ///< of the gradient
  using Evaluation = dealii::FEEvaluation<dim, -1, 0, n_components, double>;
  using Gradient = std::array<Lanes, n_slopes>;
  using Value = std::array<Lanes, n_components>;

  // Derivatives at a point: A, the upper triangle of it if it is symmetric, then V, W, M if there are any.
  unsigned int at_A(const unsigned int r, const unsigned int s) const
  {
    if (!is_symmetric)
      return r * n_slopes + s;
    const unsigned int i = std::min(r, s), j = std::max(r, s);
    return i * n_slopes - i * (i + 1) / 2 + j;
  }
  unsigned int at_V(const unsigned int r, const unsigned int d) const
  {
    return n_of_A + r * n_components + d;
  }
  unsigned int at_W(const unsigned int c, const unsigned int s) const
  {
    return n_of_A + n_slopes * n_components + c * n_slopes + s;
  }
  unsigned int at_M(const unsigned int c, const unsigned int d) const
  {
    return n_of_A + 2 * n_slopes * n_components + c * n_components + d;
  }
  const Lanes *derivatives(const unsigned int batch, const unsigned int q) const
  {
    return &tangents[is_uniform ? 0 : (std::size_t(batch) * n_points + q) * n_entries];
  }
  template <typename Visit>
  void for_each_dof(const Visit &visit) const;
  void multiply_at_points(Evaluation &phi, unsigned int batch, bool of_symmetric_part) const;
  void respond(const Lanes *T, bool of_symmetric_part, const Gradient &g, Gradient &flux) const;
  void expand();

  const Domain<dim> &domain;
  const Field field;
  bool is_symmetric, has_values, has_sources; ///< the last two: V, W or M; W or M
  unsigned int n_of_A, n_entries, n_nodes, n_points;
  std::shared_ptr<const Cells<dim>> cells;
  std::vector<unsigned int> hierarchic;    ///< number in the domain's element of a lexicographic node
  std::shared_ptr<std::vector<int>> index; ///< [slot][component][lexicographic node]; shared by copies
  bool has_any = false, is_uniform = true;
  std::vector<double> entries; ///< scratch
  dealii::AlignedVector<Lanes> tangents;
  struct Entry
  {
    unsigned int row, column;
    double value, of_symmetric_part;
  };
  std::vector<Entry> uniform_A; ///< those that are not zero, if all points have the same
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
      is_symmetric = domain.material.is_symmetric(f);
  for (unsigned int c = 0; c < n_components; ++c)
    for (unsigned int d = 0; d < n_components; ++d) {
      const Coupling coupling =
          domain.material.coupling(field.first_component + c, field.first_component + d);
      has_values = has_values || coupling.flux_by_value || coupling.in_source();
      has_sources = has_sources || coupling.in_source();
    }
  has_sources = has_sources || domain.body_force().depends_on_displacement();
  has_values = has_values || has_sources;
  n_of_A = is_symmetric ? n_slopes * (n_slopes + 1) / 2 : n_slopes * n_slopes;
  n_entries = n_of_A + (has_values ? n_components * (2 * n_slopes + n_components) : 0);
  entries.resize(n_entries);
  tangents.resize(n_entries);
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
          visit((slot * n_components + c) * n_nodes + a,
                dofs[domain.layout().index(field.first_component + c, hierarchic[a])]);
    }
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::for_each_unknown(
    const std::function<void(dealii::types::global_dof_index)> &visit) const
{
  for_each_dof([&](unsigned int, const auto dof) { visit(dof); });
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::number(
    const std::function<int(dealii::types::global_dof_index)> &index_of)
{
  index->assign(cells->n_slots() * n_components * n_nodes, -1);
  for_each_dof([&](const unsigned int i, const auto dof) { (*index)[i] = index_of(dof); });
}

/// From now on each point has its own derivatives.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::expand()
{
  const std::vector<Lanes> uniform(tangents.begin(), tangents.begin() + n_entries);
  const std::size_t n = std::size_t(cells->matrix_free.n_cell_batches()) * n_points;
  tangents.resize_fast(n * n_entries);
  for (std::size_t i = 0; i < n; ++i)
    std::copy(uniform.begin(), uniform.end(), tangents.begin() + i * n_entries);
  is_uniform = false;
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::set_tangent(const unsigned int active_cell_index,
                                                    const unsigned int q, const double factor,
                                                    const Response<dim> &response)
{
  const unsigned int n = domain.n_components(), first = field.first_component;
  for (unsigned int c = 0; c < n_components; ++c)
    for (unsigned int d = 0; d < n_components; ++d) {
      const unsigned int pair = (first + c) * n + first + d;
      for (unsigned int J = 0; J < dim; ++J)
        for (unsigned int L = 0; L < dim; ++L)
          entries[at_A(c * dim + J, d * dim + L)] = factor * response.by_gradient[pair][J][L];
      for (unsigned int J = 0; has_values && J < dim; ++J) {
        entries[at_V(c * dim + J, d)] = factor * response.by_value[pair][J];
        entries[at_W(c, d * dim + J)] = factor * response.source_by_gradient[pair][J];
      }
      if (has_values)
        entries[at_M(c, d)] = factor * response.source_by_value[pair];
    }
  if (is_uniform && !has_any)
    std::copy(entries.begin(), entries.end(), tangents.begin());
  has_any = true;
  if (is_uniform && std::equal(entries.begin(), entries.end(), tangents.begin(),
                               [](const double a, const Lanes &b) { return a == b[0]; }))
    return;
  if (is_uniform)
    expand();
  const unsigned int slot = cells->slot_of_cell[active_cell_index];
  Lanes *T = &tangents[(std::size_t(slot / Lanes::size()) * n_points + q) * n_entries];
  for (unsigned int e = 0; e < n_entries; ++e)
    T[e][slot % Lanes::size()] = entries[e];
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::finish_tangent()
{
  uniform_A.clear();
  for (unsigned int r = 0; is_uniform && r < n_slopes; ++r)
    for (unsigned int s = 0; s < n_slopes; ++s) {
      const double value = tangents[at_A(r, s)][0], transposed = tangents[at_A(s, r)][0];
      if (value != 0 || transposed != 0)
        uniform_A.push_back({r, s, value, (value + transposed) / 2});
    }
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::add_tangent(const double factor, const CellOperator<dim> &other)
{
  const auto &summand = dynamic_cast<const CellOperatorOf &>(other);
  if (is_uniform && !summand.is_uniform)
    expand();
  for (std::size_t i = 0; i < tangents.size(); ++i)
    tangents[i] += factor * summand.tangents[summand.is_uniform ? i % n_entries : i];
  finish_tangent();
}

/// flux = A g, or its symmetric part.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::respond(const Lanes *T, const bool of_symmetric_part,
                                                const Gradient &g, Gradient &flux) const
{
  if (is_uniform) {
    flux.fill(Lanes());
    for (const Entry &A : uniform_A)
      flux[A.row] += (of_symmetric_part ? A.of_symmetric_part : A.value) * g[A.column];
    return;
  }
  if (is_symmetric) {
    flux.fill(Lanes());
    for (unsigned int r = 0; r < n_slopes; ++r) {
      flux[r] += *T++ * g[r];
      for (unsigned int s = r + 1; s < n_slopes; ++s, ++T) {
        flux[r] += *T * g[s];
        flux[s] += *T * g[r];
      }
    }
    return;
  }
  for (unsigned int r = 0; r < n_slopes; ++r) {
    flux[r] = Lanes();
    for (unsigned int s = 0; s < n_slopes; ++s)
      flux[r] +=
          (of_symmetric_part ? 0.5 * (T[r * n_slopes + s] + T[s * n_slopes + r]) : T[r * n_slopes + s]) *
          g[s];
  }
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::multiply_at_points(Evaluation &phi, const unsigned int batch,
                                                           const bool of_symmetric_part) const
{
  using Flags = dealii::EvaluationFlags::EvaluationFlags;
  const auto flags = [](const bool with_values) -> Flags {
    return with_values ? dealii::EvaluationFlags::values | dealii::EvaluationFlags::gradients
                       : dealii::EvaluationFlags::gradients;
  };
  const bool tests_values = has_sources || (has_values && of_symmetric_part);
  phi.evaluate(flags(has_values));
  Gradient g, flux;
  Value v, source;
  for (unsigned int q = 0; q < n_points; ++q) {
    const Lanes *T = derivatives(batch, q);
    auto gradient = phi.get_gradient(q);
    for (unsigned int c = 0; c < n_components; ++c)
      for (unsigned int J = 0; J < dim; ++J)
        if constexpr (n_components == 1)
          g[J] = gradient[J];
        else
          g[c * dim + J] = gradient[c][J];
    respond(T, of_symmetric_part, g, flux);
    if (has_values) {
      auto value = phi.get_value(q);
      for (unsigned int c = 0; c < n_components; ++c)
        if constexpr (n_components == 1)
          v[c] = value;
        else
          v[c] = value[c];
      for (unsigned int c = 0; c < n_components; ++c) {
        source[c] = Lanes();
        for (unsigned int d = 0; d < n_components; ++d)
          source[c] += (of_symmetric_part ? 0.5 * (T[at_M(c, d)] + T[at_M(d, c)]) : T[at_M(c, d)]) * v[d];
        for (unsigned int s = 0; s < n_slopes; ++s) {
          const Lanes &V = T[at_V(s, c)], &W = T[at_W(c, s)];
          source[c] += (of_symmetric_part ? 0.5 * (V + W) : W) * g[s];
          flux[s] += (of_symmetric_part ? 0.5 * (V + W) : V) * v[c];
        }
        if constexpr (n_components == 1)
          value = source[c];
        else
          value[c] = source[c];
      }
      if (tests_values)
        phi.submit_value(value, q);
    }
    for (unsigned int c = 0; c < n_components; ++c)
      for (unsigned int J = 0; J < dim; ++J)
        if constexpr (n_components == 1)
          gradient[J] = flux[J];
        else
          gradient[c][J] = flux[c * dim + J];
    phi.submit_gradient(gradient, q);
  }
  phi.integrate(flags(tests_values));
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::add_product(const double *x, double *y,
                                                    const bool of_symmetric_part) const
{
  Evaluation phi(cells->matrix_free);
  const unsigned int n_local = n_components * n_nodes;
  for (unsigned int batch = 0; batch < cells->matrix_free.n_cell_batches(); ++batch) {
    phi.reinit(batch);
    Lanes *local = phi.begin_dof_values();
    const int *of_batch = index->data() + std::size_t(batch) * Lanes::size() * n_local;
    for (unsigned int lane = 0; lane < Lanes::size(); ++lane)
      for (unsigned int i = 0; i < n_local; ++i) {
        const int k = of_batch[lane * n_local + i];
        local[i][lane] = k < 0 ? 0. : x[k];
      }
    multiply_at_points(phi, batch, of_symmetric_part);
    for (unsigned int lane = 0; lane < Lanes::size(); ++lane)
      for (unsigned int i = 0; i < n_local; ++i)
        if (const int k = of_batch[lane * n_local + i]; k >= 0)
          y[k] += local[i][lane];
  }
}

/// In the unit cell: grad phi . M grad phi with M = J^-1 A_cc J^-T, J^-1 (V + W) and M of the same component.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::add_diagonal(double *diagonal) const
{
  const dealii::Quadrature<dim> rule = domain.cell_quadrature();
  std::vector<dealii::Tensor<1, dim>> gradients;
  std::vector<double> values;
  for (unsigned int q = 0; q < n_points; ++q)
    for (unsigned int a = 0; a < n_nodes; ++a) {
      gradients.push_back(domain.scalar_element().shape_grad(hierarchic[a], rule.point(q)));
      values.push_back(domain.scalar_element().shape_value(hierarchic[a], rule.point(q)));
    }
  Evaluation phi(cells->matrix_free);
  std::vector<Lanes> sums(n_components * n_nodes);
  for (unsigned int batch = 0; batch < cells->matrix_free.n_cell_batches(); ++batch) {
    phi.reinit(batch);
    std::fill(sums.begin(), sums.end(), Lanes());
    for (unsigned int q = 0; q < n_points; ++q) {
      const Lanes *T = derivatives(batch, q);
      const dealii::Tensor<2, dim, Lanes> J =
          phi.inverse_jacobian(q); // grad phi = J grad phi of the unit cell
      const Lanes JxW = phi.JxW(q);
      for (unsigned int c = 0; c < n_components; ++c) {
        dealii::Tensor<2, dim, Lanes> A;
        dealii::Tensor<1, dim, Lanes> by_value;
        for (unsigned int j = 0; j < dim; ++j)
          for (unsigned int l = 0; l < dim; ++l)
            A[j][l] = JxW * T[at_A(c * dim + j, c * dim + l)];
        A = transpose(J) * A * J;
        for (unsigned int j = 0; has_values && j < dim; ++j)
          by_value[j] = JxW * (T[at_V(c * dim + j, c)] + T[at_W(c, c * dim + j)]);
        by_value = transpose(J) * by_value;
        const Lanes M = has_values ? JxW * T[at_M(c, c)] : Lanes();
        for (unsigned int a = 0; a < n_nodes; ++a) {
          const dealii::Tensor<1, dim> &g = gradients[q * n_nodes + a];
          Lanes sum = Lanes();
          for (unsigned int j = 0; j < dim; ++j) {
            Lanes row = A[j][0] * g[0];
            for (unsigned int l = 1; l < dim; ++l)
              row += A[j][l] * g[l];
            sum += row * g[j];
          }
          if (has_values) {
            const double phi_a = values[q * n_nodes + a];
            sum += M * phi_a * phi_a;
            for (unsigned int j = 0; j < dim; ++j)
              sum += by_value[j] * (g[j] * phi_a);
          }
          sums[c * n_nodes + a] += sum;
        }
      }
    }
    const int *of_batch = index->data() + std::size_t(batch) * Lanes::size() * sums.size();
    for (unsigned int lane = 0; lane < Lanes::size(); ++lane)
      for (unsigned int i = 0; i < sums.size(); ++i)
        if (const int k = of_batch[lane * sums.size() + i]; k >= 0)
          diagonal[k] += sums[i][lane];
  }
}

/// The part of P in one cell, by column.
struct LocalProlongation
{
  struct Entry
  {
    unsigned int column, row;
    double weight;
  };
  std::vector<int> columns; ///< of P
  std::vector<Entry> entries;
  std::vector<unsigned int> first_entry; ///< of each column, and one behind the last

  /// @p index of the @p n unknowns of the cell
  template <typename Prolongation>
  void reinit(const Prolongation &P, const int *index, unsigned int n);
};

template <typename Prolongation>
void LocalProlongation::reinit(const Prolongation &P, const int *index, const unsigned int n)
{
  columns.clear();
  entries.clear();
  for (unsigned int i = 0; i < n; ++i) {
    const auto row = P(index[i]);
    columns.insert(columns.end(), row.columns, row.columns + row.n);
  }
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  for (unsigned int i = 0; i < n; ++i) {
    const auto row = P(index[i]);
    for (int k = 0; k < row.n; ++k) {
      const auto place = std::lower_bound(columns.begin(), columns.end(), row.columns[k]);
      entries.push_back({static_cast<unsigned int>(place - columns.begin()), i, row.weights[k]});
    }
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry &a, const Entry &b) { return a.column < b.column; });
  first_entry.assign(columns.size() + 1, entries.size());
  for (unsigned int e = entries.size(); e-- > 0;)
    first_entry[entries[e].column] = e;
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::for_each_cell(
    const typename CellOperator<dim>::Prolongation &P,
    const std::function<void(const std::vector<int> &columns)> &visit) const
{
  LocalProlongation local;
  for (unsigned int slot = 0; slot < cells->n_slots(); ++slot)
    if (cells->is_filled(slot)) {
      const unsigned int n_local = n_components * n_nodes;
      local.reinit(P, index->data() + std::size_t(slot) * n_local, n_local);
      visit(local.columns);
    }
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::for_each_restriction(
    const typename CellOperator<dim>::Prolongation &P,
    const typename CellOperator<dim>::VisitCell &visit) const
{
  Evaluation phi(cells->matrix_free);
  const unsigned int n_local = n_components * n_nodes;
  std::array<LocalProlongation, Lanes::size()> local_P;
  std::array<dealii::FullMatrix<double>, Lanes::size()> products;
  for (unsigned int batch = 0; batch < cells->matrix_free.n_cell_batches(); ++batch) {
    phi.reinit(batch);
    const unsigned int n_filled = cells->matrix_free.n_active_entries_per_cell_batch(batch);
    unsigned int n_columns = 0;
    for (unsigned int lane = 0; lane < n_filled; ++lane) {
      local_P[lane].reinit(P, index->data() + (std::size_t(batch) * Lanes::size() + lane) * n_local, n_local);
      n_columns = std::max<unsigned int>(n_columns, local_P[lane].columns.size());
      products[lane].reinit(local_P[lane].columns.size(), local_P[lane].columns.size());
    }
    Lanes *local = phi.begin_dof_values();
    for (unsigned int column = 0; column < n_columns; ++column) {
      std::fill(local, local + n_local, Lanes());
      for (unsigned int lane = 0; lane < n_filled; ++lane)
        if (const LocalProlongation &own = local_P[lane]; column < own.columns.size())
          for (unsigned int e = own.first_entry[column]; e < own.first_entry[column + 1]; ++e)
            local[own.entries[e].row][lane] = own.entries[e].weight;
      multiply_at_points(phi, batch, true);
      for (unsigned int lane = 0; lane < n_filled; ++lane)
        if (column < local_P[lane].columns.size())
          for (const auto &entry : local_P[lane].entries)
            products[lane](entry.column, column) += entry.weight * local[entry.row][lane];
    }
    for (unsigned int lane = 0; lane < n_filled; ++lane)
      visit(local_P[lane].columns, products[lane]);
  }
}

} // namespace

template <int dim>
std::string CellOperator<dim>::objection(const Domain<dim> &domain, const Field &field)
{
  if (domain.has_simplices())
    return "the domain " + domain.name + " has " + (dim == 2 ? "triangles" : "tetrahedra");
  if (domain.degree < 2)
    return "the domain " + domain.name + " has degree 1, where a matrix is faster";
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
